"""What is drawn in a panel of matplotlib, as data: marks of each artist."""

import re
from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.collections import LineCollection, PolyCollection, QuadMesh
from matplotlib.image import AxesImage
from matplotlib.lines import Line2D
from matplotlib.patches import Polygon, Rectangle
from matplotlib.path import Path
from matplotlib.text import Annotation, Text
from matplotlib.transforms import Transform

from workbench.publish.page.looks import (
    PIXELS,
    Mark,
    NotLiveError,
    alpha_of,
    colour_of,
    fill_of,
    marker_of,
    stroke_of,
    strokes_of,
)
from workbench.publish.page.packed import floats
from workbench.publish.thinning import thinned

ZOOM = 4.0
"""How far a line may be zoomed into before it shows corners that its figure's own pixels hide."""

BUCKETS = 2000
"""Of a line that goes up and down without end, with two points each."""

RAISED = str.maketrans("0123456789+-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻")

SCALES = ("linear", "log")
"""Those that the page has too; along any other, places are told as they lie on paper, beside what they are."""


def plain_text(text: str) -> str:
    """Words without TeX: powers as raised digits."""
    if "$" not in text:
        return text
    raised = re.sub(r"\^\{?([-+0-9]+)\}?", lambda found: found[1].translate(RAISED), text)
    return re.sub(r"\$|\\mathdefault|[{}]", "", raised).replace(r"\times", "×")


def placed(values: Any, axis: Axis) -> np.ndarray:
    """Where values lie along an axis of the page."""
    numbers = np.asarray(values, dtype=float)
    if axis.get_scale() == "log":
        return np.where(numbers > 0.0, numbers, np.nan)
    return numbers if axis.get_scale() in SCALES else np.asarray(axis.get_transform().transform(numbers))


def _to_an_end(values: Any, axis: Axis) -> np.ndarray:
    """The same, of sides of an area: what a logarithmic axis does not reach is at its lower end."""
    low = min(axis.get_view_interval())
    numbers = np.asarray(values, dtype=float)
    return placed(np.maximum(numbers, low) if axis.get_scale() == "log" else numbers, axis)


def _points(x: np.ndarray, y: np.ndarray, axes: Axes) -> Mark:
    """Coordinates of a mark; `said_x` is what x is, where its axis is of a scale that the page lacks."""
    points = {"x": floats(placed(x, axes.xaxis)), "y": floats(placed(y, axes.yaxis))}
    for name, axis, values in (("said_x", axes.xaxis, x), ("said_y", axes.yaxis, y)):
        if axis.get_scale() not in SCALES:
            points[name] = floats(values)
    return points


def content_of(axes: Axes) -> list[Artist]:
    """What is drawn in a panel, from the lowest to what lies on top."""
    artists = [*axes.images, *axes.patches, *axes.collections, *axes.lines, *axes.texts]
    return sorted((artist for artist in artists if artist.get_visible()), key=lambda artist: artist.get_zorder())


def marks_of(artist: Artist, axes: Axes) -> list[Mark]:
    """The marks of an artist.

    Raises:
        NotLiveError: it is of an unknown kind, hatched, turned, on a part of an edge, or elsewhere than at its data.
    """
    make = next((make for kind, make in MAKERS.items() if isinstance(artist, kind)), None)
    if make is None or getattr(artist, "get_hatch", lambda: None)():
        raise NotLiveError
    return make(artist, axes)


def _in_data(transform: Transform, axes: Axes) -> None:
    """Raise NotLiveError where something does not stand at its data."""
    if transform != axes.transData:
        raise NotLiveError


def _number(value: Any) -> float:
    """A place that there is."""
    if not np.isfinite(value):
        raise NotLiveError
    return float(value)


def notes_of(axes: Axes) -> list[str]:
    """What is said of a panel as a whole."""
    return [plain_text(text.get_text()) for text in axes.texts if text.get_visible() and _is_note(text, axes)]


def _line(line: Line2D, axes: Axes) -> list[Mark]:
    """A curve, its points, or a line from edge to edge."""
    over_x, over_y = line.get_transform().contains_branch_seperately(axes.transData)
    label = _label(line)
    if over_x != over_y:
        stroke = stroke_of(line)
        if stroke is None:
            raise NotLiveError  # points along an edge
        edges = axes.get_xaxis_transform() if over_x else axes.get_yaxis_transform()
        across = np.asarray(line.get_ydata() if over_x else line.get_xdata(), dtype=float)
        if line.get_transform() != edges or across.tolist() != [0.0, 1.0]:
            raise NotLiveError
        values, axis = (line.get_xdata(), axes.xaxis) if over_x else (line.get_ydata(), axes.yaxis)
        return [
            {"kind": "span", "along": "height" if over_x else "width", "at": _number(placed(values, axis)[0]), **stroke}
        ]
    _in_data(line.get_transform(), axes)
    x, y = (np.asarray(values, dtype=float) for values in (line.get_xdata(orig=False), line.get_ydata(orig=False)))
    if not x.size:
        return []
    stroke, marker = stroke_of(line), marker_of(line)
    if line.get_drawstyle() == "steps-post":
        x, y = np.repeat(x, 2)[1:], np.repeat(y, 2)[:-1]
    elif line.get_drawstyle() != "default":
        raise NotLiveError
    marks: list[Mark] = []
    if stroke is not None:
        marks.append({"kind": "line", "label": label, **_points(*_simplified(x, y, axes), axes), **stroke})
    if marker is not None:
        marks.append({"kind": "points", "label": label, **_points(x, y, axes), "marker": marker})
    return marks


def _simplified(x: np.ndarray, y: np.ndarray, axes: Axes) -> tuple[np.ndarray, np.ndarray]:
    """The same curve with fewer points: none of it moves by a ninth of a pixel, `ZOOM` times enlarged."""
    pixels = ZOOM * axes.transData.transform(np.column_stack([x, y]))
    path = Path(pixels).cleaned(simplify=True, remove_nans=True)
    codes, corners = np.asarray(path.codes), np.asarray(path.vertices)
    drawn = (codes != Path.STOP) & np.append(True, np.any(np.diff(corners, axis=0) != 0.0, axis=1))
    corners, starts = corners[drawn], np.flatnonzero(codes[drawn] == Path.MOVETO)
    pieces = np.split(corners, starts[1:])
    if len(corners) > 2 * BUCKETS:
        share = BUCKETS / 2.0 / len(corners)
        kept = [thinned(piece[:, 0], piece[:, 1], buckets=max(round(share * len(piece)), 1)) for piece in pieces]
        pieces = [piece[places] for piece, places in zip(pieces, kept, strict=True)]
    gap = np.full((1, 2), np.nan)
    joined = np.concatenate([part for piece in pieces for part in (piece, gap)][:-1] or [gap])
    points = axes.transData.inverted().transform(joined / ZOOM)
    return points[:, 0], points[:, 1]


def _label(artist: Artist) -> str:
    label = str(artist.get_label())
    return "" if label.startswith("_") else plain_text(label)


def _segments(lines: LineCollection, axes: Axes) -> list[Mark]:
    _in_data(lines.get_transform(), axes)
    x: list[float] = []
    y: list[float] = []
    for segment in lines.get_segments():
        x += [*segment[:, 0].tolist(), float("nan")]
        y += [*segment[:, 1].tolist(), float("nan")]
    return [{"kind": "line", "label": "", **_points(np.array(x), np.array(y), axes), **strokes_of(lines)}] if x else []


def _area(polygons: PolyCollection, axes: Axes) -> list[Mark]:
    _in_data(polygons.get_transform(), axes)
    if not len(polygons.get_facecolor()) or np.any(np.asarray(polygons.get_offsets()) != 0.0):
        raise NotLiveError
    marks = []
    for path, colour in zip(polygons.get_paths(), _each(polygons.get_facecolor(), polygons), strict=True):
        points = np.asarray(path.vertices)
        marks.append({"kind": "area", **_corners(points, axes), **fill_of(colour)})
    return marks


def _corners(points: np.ndarray, axes: Axes) -> Mark:
    """The corners of an area."""
    return {"x": floats(_to_an_end(points[:, 0], axes.xaxis)), "y": floats(_to_an_end(points[:, 1], axes.yaxis))}


def _each(colours: Any, collection: PolyCollection) -> list[Any]:
    count = len(collection.get_paths())
    return [colours[i % len(colours)] for i in range(count)]


def _box(box: Rectangle, axes: Axes) -> list[Mark]:
    """A rectangle, or a band from edge to edge."""
    if box.get_angle():
        raise NotLiveError
    over_x, over_y = box.get_data_transform().contains_branch_seperately(axes.transData)
    (left, bottom), width, height = box.get_xy(), box.get_width(), box.get_height()
    edges = {
        (True, True): axes.transData,
        (True, False): axes.get_xaxis_transform(),
        (False, True): axes.get_yaxis_transform(),
    }
    whole = (over_x or (left, width) == (0.0, 1.0)) and (over_y or (bottom, height) == (0.0, 1.0))
    if box.get_data_transform() != edges.get((over_x, over_y)) or not whole:
        raise NotLiveError
    fill = fill_of(box.get_facecolor()) if box.get_fill() else {"color": None, "alpha": 1.0}
    edged = box.get_linewidth() > 0.0 and alpha_of(box.get_edgecolor()) > 0.0
    return [
        {
            "kind": "box",
            "left": _number(_to_an_end(left, axes.xaxis)) if over_x else None,
            "right": _number(_to_an_end(left + width, axes.xaxis)) if over_x else None,
            "bottom": _number(_to_an_end(bottom, axes.yaxis)) if over_y else None,
            "top": _number(_to_an_end(bottom + height, axes.yaxis)) if over_y else None,
            "edge": colour_of(box.get_edgecolor()) if edged and over_x and over_y else None,
            **fill,
        }
    ]


def _shape(patch: Polygon, axes: Axes) -> list[Mark]:
    _in_data(patch.get_data_transform(), axes)
    if not patch.get_fill() or alpha_of(patch.get_facecolor()) == 0.0:
        raise NotLiveError
    points = np.asarray(patch.get_xy())
    return [{"kind": "area", **_corners(points, axes), **fill_of(patch.get_facecolor())}]


def _mesh(mesh: QuadMesh, axes: Axes) -> list[Mark]:
    corners, values = np.asarray(mesh.get_coordinates()), mesh.get_array()
    straight = np.all(corners[:, :, 0] == corners[0, :, 0]) and np.all(corners[:, :, 1] == corners[:, :1, 1])
    if values is None or not straight:
        raise NotLiveError
    return _cells(corners[0, :, 0], corners[:, 0, 1], mesh.to_rgba(values))


def _image(image: AxesImage, axes: Axes) -> list[Mark]:
    values = image.get_array()
    if values is None or values.ndim != 2:
        raise NotLiveError
    left, right, bottom, top = image.get_extent()
    rows, columns = values.shape
    ends = (top, bottom) if image.origin == "upper" else (bottom, top)
    return _cells(np.linspace(left, right, columns + 1), np.linspace(*ends, rows + 1), image.to_rgba(values))


def _cells(x: np.ndarray, y: np.ndarray, colours: np.ndarray) -> list[Mark]:
    """A field of coloured cells."""
    if np.any(np.asarray(colours)[..., 3] < 1.0):
        raise NotLiveError
    left, bottom = np.meshgrid(x[:-1], y[:-1])
    right, top = np.meshgrid(x[1:], y[1:])
    sides = {"left": left, "right": right, "bottom": bottom, "top": top}
    hues = [colour_of(colour) for row in colours for colour in row]
    return [{"kind": "cells", **{name: floats(side.ravel()) for name, side in sides.items()}, "colors": hues}]


def _is_note(text: Text, axes: Axes) -> bool:
    if isinstance(text, Annotation):
        return text.xycoords == "axes fraction"
    return text.get_transform() == axes.transAxes


def _words(text: Text, axes: Axes) -> list[Mark]:
    if _is_note(text, axes) or not text.get_text():
        return []
    if text.get_rotation() or (isinstance(text, Annotation) and text.arrow_patch is not None):
        raise NotLiveError
    offset: Any = (0.0, 0.0)
    if isinstance(text, Annotation):
        if text.xycoords != "data" or text.anncoords not in ("offset points", "data"):
            raise NotLiveError
        x, y = text.xy if text.anncoords == "offset points" else text.xyann
        if text.anncoords == "offset points":
            offset = text.xyann
    else:
        _in_data(text.get_transform(), axes)
        x, y = text.get_position()
    return [
        {
            "kind": "words",
            "x": _number(placed(x, axes.xaxis)),
            "y": _number(placed(y, axes.yaxis)),
            "offset": [float(part) * PIXELS for part in offset],
            "text": plain_text(text.get_text()),
            "size": round(float(text.get_fontsize()) * PIXELS, 1),
            "align": text.get_horizontalalignment(),
            "baseline": {"center": "middle", "center_baseline": "middle", "baseline": "alphabetic"}.get(
                text.get_verticalalignment(), text.get_verticalalignment()
            ),
            "color": colour_of(text.get_color()),
        }
    ]


MAKERS: Mapping[type[Artist], Callable[[Any, Axes], list[Mark]]] = {
    Line2D: _line,
    LineCollection: _segments,
    QuadMesh: _mesh,
    PolyCollection: _area,
    Rectangle: _box,
    Polygon: _shape,
    AxesImage: _image,
    Text: _words,
}
"""By the kind of artist; the first that fits."""
