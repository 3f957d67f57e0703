"""How what is drawn in a panel of matplotlib looks, as data: strokes, markers, fields, and the entries of a legend."""

from typing import Any, TypeAlias

import numpy as np
from matplotlib.collections import LineCollection, PathCollection, PolyCollection
from matplotlib.colors import to_hex, to_rgba
from matplotlib.lines import Line2D
from matplotlib.patches import Patch

PIXELS = 96.0 / 72.0
"""Of a point."""

MARKERS = {
    "o": "circle",
    ".": "circle",
    "s": "square",
    "^": "triangle",
    "v": "inverted_triangle",
    "D": "diamond",
    "P": "plus",
    "+": "cross",
    "x": "x",
    "*": "star",
    "_": "dash",
    "|": "dash",
    "<": "triangle",
    ">": "triangle",
}
"""Bokeh's name for each of matplotlib's markers that are used here."""

ANGLES = {"|": 0.5 * np.pi, "<": 0.5 * np.pi, ">": -0.5 * np.pi}
"""By which those are turned that Bokeh has in another direction (rad, to the left)."""

UNFILLED = ("x", "cross", "dash")

Mark: TypeAlias = dict[str, Any]


class NotLiveError(Exception):
    """A figure has something that the page cannot draw."""


def looks_of(handle: Any) -> Mark:
    """How an entry of a legend looks: a stroke, a marker, a field."""
    if isinstance(handle, Line2D):
        return {"line": stroke_of(handle), "marker": marker_of(handle)}
    if isinstance(handle, Patch):
        fill = handle.get_facecolor() if handle.get_fill() else handle.get_edgecolor()
        return {"fill": colour_of(fill), "alpha": alpha_of(fill), "hollow": not handle.get_fill()}
    if isinstance(handle, PolyCollection | PathCollection):
        return {"fill": colour_of(handle.get_facecolor()[0]), "alpha": alpha_of(handle.get_facecolor()[0])}
    if isinstance(handle, LineCollection):
        return {"line": strokes_of(handle), "marker": None}
    raise NotLiveError


def colour_of(colour: Any) -> str:
    """A colour of matplotlib as #rrggbb."""
    return to_hex(colour, keep_alpha=False)


def alpha_of(colour: Any) -> float:
    """How opaque a colour is, from 0 to 1."""
    return round(float(to_rgba(colour)[3]), 3)


def _dash(pattern: Any) -> list[int]:
    """Lengths of dashes and gaps in pixels, from matplotlib's offset and lengths in points; none of a solid line."""
    parts = pattern[1]
    return [] if parts is None else [max(1, round(part * PIXELS)) for part in parts]


def stroke_of(line: Line2D) -> Mark | None:
    """How the line itself is drawn; None where there are points alone."""
    if line.get_linestyle() in ("None", "none", " ", "") or line.get_alpha() == 0.0 or line.get_color() == "none":
        return None
    pattern: Any = line._dash_pattern if line.is_dashed() else (0.0, None)  # type: ignore[attr-defined]
    return {
        "color": colour_of(line.get_color()),
        "alpha": alpha_of(to_rgba(line.get_color(), line.get_alpha())),
        "width": round(float(line.get_linewidth()) * PIXELS, 2),
        "dash": _dash(pattern),
    }


def marker_of(line: Line2D) -> Mark | None:
    """The marker of a line's points; None where it has none.

    Raises:
        NotLiveError: the page has no such marker, or not all points have one.
    """
    kind = line.get_marker()
    if kind is None or (isinstance(kind, str) and kind in ("None", "none", " ", "")):
        return None
    if not isinstance(kind, str) or kind not in MARKERS or line.get_markevery() is not None:
        raise NotLiveError
    name = MARKERS[kind]
    edge, face = line.get_markeredgecolor(), line.get_markerfacecolor()
    hollow = face in ("none", "None") or name in UNFILLED
    return {
        "kind": name,
        "color": colour_of(edge),
        "fill": None if hollow else colour_of(face),
        "angle": ANGLES.get(kind, 0.0),
        "size": round(float(line.get_markersize()) * PIXELS * (0.5 if kind == "." else 1.0), 2),
    }


def strokes_of(lines: LineCollection) -> Mark:
    """How segments of one colour are drawn.

    Raises:
        NotLiveError: they have several.
    """
    if len(np.unique(lines.get_color(), axis=0)) != 1:
        raise NotLiveError
    pattern: Any = lines.get_linestyle()[0]
    return {
        "color": colour_of(lines.get_color()[0]),
        "alpha": alpha_of(lines.get_color()[0]),
        "width": round(float(np.atleast_1d(lines.get_linewidth())[0]) * PIXELS, 2),
        "dash": _dash(pattern),
    }


def fill_of(colour: Any) -> Mark:
    """How a field is filled."""
    return {"color": colour_of(colour), "alpha": alpha_of(colour)}
