"""A figure of matplotlib as a page draws it anew, to hover over and to zoom into: the same numbers, the same looks.

What comes out is plain data, which `page.js` hands to Bokeh: panels in the places of the figure's axes, each with its
axes, marks (lines, points, areas, boxes, spans, words) and legend.
"""

from collections.abc import Iterable, Sequence
from typing import Any

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.container import Container
from matplotlib.figure import Figure
from matplotlib.legend import Legend
from matplotlib.lines import Line2D
from matplotlib.ticker import (
    FixedLocator,
    LogFormatter,
    LogFormatterMathtext,
    LogFormatterSciNotation,
    NullFormatter,
    ScalarFormatter,
)

from workbench.publish.page.looks import NotLiveError, looks_of
from workbench.publish.page.marks import SCALES, content_of, marks_of, notes_of, placed, plain_text
from workbench.publish.style import PlainTicks

PER_INCH = 96
"""Pixels of a page."""

WIDER = 1.3
"""A panel on a page than on paper, at most."""

NUMBERED = (ScalarFormatter, LogFormatter, LogFormatterMathtext, LogFormatterSciNotation, NullFormatter)
"""Labels of ticks that are numbers: the page finds its own, as it does for `PlainTicks`."""


def live(figure: Figure) -> dict[str, Any] | None:
    """The figure as data, or None where it has something that the page cannot draw: then its picture stands there."""
    panels = [axes for axes in figure.axes if axes.get_visible() and axes.get_label() != "<colorbar>"]
    if _has_more(figure, panels):
        return None
    artists = [artist for axes in panels for artist in content_of(axes)]
    numbers = {id(artist): number for number, artist in enumerate(artists)}
    try:
        return {
            "title": plain_text(figure.get_suptitle()),
            "width": round(float(figure.get_size_inches()[0]) * PER_INCH * WIDER),
            "panels": [_panel(axes, figure, panels, numbers) for axes in panels],
            "legend": [entry for legend in figure.legends for entry in _legend(legend, panels, numbers)],
        }
    except NotLiveError:
        return None


def _has_more(figure: Figure, panels: Sequence[Axes]) -> bool:
    """Whether a figure has something beside plain panels, each in a place of its own, and a title."""
    places = [str(axes.get_subplotspec() or axes.get_position().bounds) for axes in panels]
    beside = [text.get_text() for text in figure.texts if text.get_text() not in ("", figure.get_suptitle())]
    others = [*figure.lines, *figure.patches, *figure.images, *figure.artists, *figure.subfigs, *beside]
    within = [each for axes in panels for each in (*axes.child_axes, *axes.tables, *axes.artists)]
    titles = [sum(bool(axes.get_title(loc=place)) for place in ("left", "center", "right")) for axes in panels]
    plain = all(axes.name == "rectilinear" for axes in panels)
    return bool(others or within or len(set(places)) < len(places) or max(titles, default=0) > 1 or not plain)


def _panel(axes: Axes, figure: Figure, panels: Sequence[Axes], numbers: dict[int, int]) -> dict[str, Any]:
    legend = axes.get_legend()
    height = axes.get_window_extent().height / figure.get_dpi()
    return {
        "title": plain_text(axes.get_title() or axes.get_title(loc="left") or axes.get_title(loc="right")),
        "place": _place(axes),
        "height": round(height * PER_INCH),
        "x": _axis(axes.xaxis, axes.get_xscale(), axes.get_xlim(), panels),
        "y": _axis(axes.yaxis, axes.get_yscale(), axes.get_ylim(), panels),
        "marks": [
            {"id": numbers[id(artist)], **mark} for artist in content_of(axes) for mark in marks_of(artist, axes)
        ],
        "notes": notes_of(axes),
        "legend": [] if legend is None else _legend(legend, [axes], numbers),
    }


def _place(axes: Axes) -> list[int]:
    """The columns of its grid from the first to before the last, and how many there are."""
    spec = axes.get_subplotspec()
    if spec is None:
        return [0, 1, 1]
    return [spec.colspan.start, spec.colspan.stop, spec.get_gridspec().ncols]


def _axis(axis: Axis, scale: str, ends: tuple[float, float], panels: Sequence[Axes]) -> dict[str, Any]:
    axes = axis.axes
    name, shared = ("x", axes.get_shared_x_axes()) if axis is axes.xaxis else ("y", axes.get_shared_y_axes())
    alike = [i for i, other in enumerate(panels) if other is axes or shared.joined(other, axes)]
    labels = [axis.get_label_text(), *(getattr(panels[i], f"{name}axis").get_label_text() for i in alike)]
    return {
        "label": plain_text(next((label for label in labels if label), "")),
        "scale": scale if scale in SCALES else "linear",
        "range": placed(ends, axis).tolist(),
        "shared": alike[0],
        "ticks": _ticks(axis, ends),
    }


def _ticks(axis: Axis, ends: tuple[float, float]) -> list[tuple[float, str]]:
    """Ticks that were chosen, or have words instead of numbers; none of other axes."""
    formatter = axis.get_major_formatter()
    locator = axis.get_major_locator()
    numbered = isinstance(locator, PlainTicks) or type(formatter) in NUMBERED
    if numbered and axis.get_scale() in SCALES and not isinstance(locator, FixedLocator):
        return []
    values = [float(value) for value in axis.get_majorticklocs() if min(ends) <= value <= max(ends)]
    return list(zip(placed(values, axis).tolist(), map(plain_text, formatter.format_ticks(values)), strict=True))


def _legend(legend: Legend, panels: Sequence[Axes], numbers: dict[int, int]) -> list[dict[str, Any]]:
    """What each entry is called and looks like, and the marks that it stands for."""
    named = [pair for axes in panels for pair in _named(axes)]
    entries = []
    for handle, text in zip(legend.legend_handles, legend.get_texts(), strict=True):
        label = text.get_text()
        artists = [artist for name, artist in named if name == label and id(artist) in numbers]
        artists += [other for artist in artists for other in _without_name(artist) if id(other) in numbers]
        lines = [artist for artist in artists if isinstance(artist, Line2D)]  # of points with bars, that has the marker
        marks = sorted({numbers[id(artist)] for artist in artists})
        entries.append({"label": plain_text(label), "marks": marks, **looks_of(lines[0] if lines else handle)})
    return entries


def _without_name(artist: Any) -> list[Line2D]:
    """Lines without a label that belong to one with a label: in its panel, of its colour, where no other has that."""
    if not isinstance(artist, Line2D) or artist.axes is None:
        return []
    alike = [line for line in artist.axes.lines if line.get_color() == artist.get_color() and line is not artist]
    named = [line for line in alike if not str(line.get_label()).startswith("_")]
    return [] if named else alike


def _named(axes: Axes) -> list[tuple[str, Any]]:
    """What in a panel has a label: its artists, and the parts of its containers."""
    named = [(str(artist.get_label()), artist) for artist in content_of(axes)]
    for container in axes.containers:
        named += [(str(container.get_label()), artist) for artist in _parts(container)]
    return named


def _parts(container: Container) -> Iterable[Any]:
    for part in container:
        if isinstance(part, tuple):
            yield from part
        elif part is not None:
            yield part
