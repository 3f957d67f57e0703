"""A figure drawn again at another width and size of text: panels side by side that would be too narrow go below each
other, headings and legends are broken, and what does not fit beside the curves goes below.

Nothing is scaled: lines and markers keep their weight, text has its true size, ticks are chosen anew. The title of the
figure is left out, since on a page of that kind it is the caption's.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.axis import Axis, Tick
from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.gridspec import GridSpec
from matplotlib.legend import Legend
from matplotlib.path import Path
from matplotlib.text import Text
from matplotlib.textpath import TextPath
from matplotlib.transforms import Bbox, ScaledTranslation

from workbench.publish.page_format import PageFormat
from workbench.publish.style import BASE_POINTS

INCH = 25.4
"""mm."""

LEAST = 6.0
"""Points: no text is smaller."""

NARROW = 2.3
"""Inches that a panel takes at least beside another, with text of 8 pt."""

NARROWEST = 1.7
"""The same where the figure would not fit its page otherwise."""

HIGHEST = 7.6
"""Inches that a figure is high at most before its legends: what a page has beside the caption."""

LEAST_INSIDE = 0.9
"""Inches that a panel has between its labels at least where another stands beside it."""

FLATTEST = 0.7
"""Of its height a panel keeps at least so much where the figure would not fit its page otherwise."""

ROOMY = (0.62, 0.42)
"""Shares of a panel's width and height that a legend inside it takes at most."""


def refit(figure: Figure, page: PageFormat) -> None:
    """Lay a figure out anew for that page; it must not have been saved before, and have a layout engine.

    Args:
        figure: drawn in the program's style at text of `BASE_POINTS`.
        page: width in mm, text in points.
    """
    plan = _planned(figure, page)
    if figure.get_suptitle():
        figure.suptitle("").set_in_layout(False)
    _size_text(figure, page)
    _restack(figure, plan.beside)
    figure.set_size_inches(plan.width, plan.high * plan.rows)
    for legend in [*figure.legends, *(axes.get_legend() for axes in figure.axes)]:
        if legend is not None:
            legend.set_in_layout(False)  # panels get their room first
    headings = [(axes, text, text.get_text()) for axes in figure.axes for text in _headings(axes)]
    for axes, text, said in headings:
        _break(text, said, 65.0 * (plan.high if text is axes.yaxis.label else plan.width / plan.beside))
    figure.draw_without_rendering()
    for axes, text, said in headings:
        panel = axes.get_window_extent()
        _break(text, said, 72.0 / figure.dpi * (panel.height if text is axes.yaxis.label else panel.width))
    _turn_labels(figure)
    _place_legends(figure, plan.width)


@dataclass(frozen=True)
class _Plan:
    """The width of a figure, the height of its panels and of legends below each (inches), and how many stand side by
    side in how many rows.
    """

    width: float
    high: float
    below: float
    beside: int
    rows: int

    @property
    def total(self) -> float:
        """The height of the figure (inches), about."""
        return (self.high + self.below) * self.rows


def _planned(figure: Figure, page: PageFormat) -> _Plan:
    """Panels side by side as many as are not narrow; where the figure is higher than its page then, the first that is
    not: more of them side by side, flatter ones, the width of two columns. None may be.
    """
    width, height = figure.get_size_inches().tolist()
    columns, rows = _grid(figure)
    panels = [axes for axes in _panels(figure) if axes.get_visible()]
    figure.draw_without_rendering()
    beside_it = max(map(_labels_width, panels), default=0.0) * page.points / BASE_POINTS
    plans: list[_Plan] = []
    for inches in (page.width / INCH, *([page.double / INCH] if page.double else [])):
        counted, most = inches * 8.0 / page.points, min(columns, int(inches / (LEAST_INSIDE + beside_it)))
        easily = max(1, min(most, int(counted / NARROW)))
        for beside in range(easily, max(easily, min(most, int(counted / NARROWEST))) + 1):
            share = math.sqrt(inches / beside / (width / columns))
            text = page.points / BASE_POINTS if beside == columns else 0.0
            high = height / rows * min(1.0, max(share, text))
            places = rows if beside == columns else math.ceil(len(panels) / beside)
            below = max(_legend_height(axes, inches / beside - beside_it, page.points) for axes in panels)
            flat = min(high, max(FLATTEST * high, HIGHEST / places - below))
            plans += [_Plan(inches, each, below, beside, places) for each in (high, flat)]
    return next((plan for plan in plans if plan.total <= HIGHEST), min(plans, key=lambda plan: plan.total))


def _labels_width(axes: Axes) -> float:
    """What labels take beside a panel, in inches."""
    panel, labels = axes.get_window_extent(), axes.yaxis.get_tightbbox()
    return (panel.x0 - labels.x0) / axes.figure.dpi if labels is not None else 0.0


def _legend_height(axes: Axes, width: float, points: float) -> float:
    """What a legend that is not in its panel takes below one of that width, about, in inches."""
    legend = axes.get_legend()
    if legend is None or _is_inside(legend.get_window_extent(), axes.get_window_extent()):
        return 0.0
    ratio, room = points / BASE_POINTS, max(72.0 * width - 4.0 * points, points)
    lengths = [ratio * _length(text.get_text(), text.get_fontproperties()) for text in legend.get_texts()]
    return (1.2 * sum(math.ceil(length / room) for length in lengths) + 1.0) * points / 72.0


def _panels(figure: Figure) -> list[Axes]:
    return [axes for axes in figure.axes if axes.get_subplotspec() is not None and axes.get_label() != "<colorbar>"]


def _grid(figure: Figure) -> tuple[int, int]:
    """Columns and rows of a figure's panels."""
    specs = [axes.get_subplotspec() for axes in _panels(figure)]
    grids = [spec.get_gridspec() for spec in specs if spec is not None]
    return (grids[0].ncols, grids[0].nrows) if grids else (1, 1)


def _restack(figure: Figure, beside: int) -> None:
    """Put the visible panels into fewer columns."""
    panels = _panels(figure)
    if beside == _grid(figure)[0]:
        return
    visible = [axes for axes in panels if axes.get_visible()]
    grid = GridSpec(math.ceil(len(visible) / beside), beside, figure=figure)
    _tell_labels(visible)
    for place, axes in enumerate(visible):
        axes.set_subplotspec(grid[place // beside, place % beside])
    for axes in panels:
        if not axes.get_visible():
            axes.remove()


def _tell_labels(panels: list[Axes]) -> None:
    """What neighbours told once is told by each: the labels of shared axes."""
    for axes in panels:
        axes.tick_params(labelleft=True, labelbottom=True)
        for which in ("x", "y"):
            label: Axis = getattr(axes, f"{which}axis")
            siblings = getattr(axes, f"get_shared_{which}_axes")().get_siblings(axes)
            others = [other for other in panels if _place(other)[which == "x"] == _place(axes)[which == "x"]]
            if not label.get_label_text():
                told = [getattr(other, f"{which}axis").get_label_text() for other in [*siblings, *others]]
                label.set_label_text(next(filter(None, told), ""))


def _place(axes: Axes) -> tuple[int, int]:
    """Row and column of a panel."""
    spec = axes.get_subplotspec()
    return (spec.rowspan.start, spec.colspan.start) if spec is not None else (0, 0)


# --- text ---


def _size_text(figure: Figure, page: PageFormat) -> None:
    """Give all text the size that the page asks for, in the proportions that it had."""
    ratio = page.points / BASE_POINTS

    def sized(points: float) -> float:
        return max(LEAST, points * ratio)

    axes_of_all = [axis for axes in figure.axes for axis in (axes.xaxis, axes.yaxis)]
    major = [(axis, _points(axis.get_major_ticks())) for axis in axes_of_all]
    minor = [(axis, _points(axis.get_minor_ticks())) for axis in axes_of_all]
    for text, points in [(text, text.get_fontsize()) for text in figure.findobj(Text) if isinstance(text, Text)]:
        text.set_fontsize(sized(float(points)))
    for axis, points in major:
        axis.set_tick_params(which="major", labelsize=sized(points))
    for axis, points in minor:
        axis.set_tick_params(which="minor", labelsize=sized(points))


def _points(ticks: Sequence[Tick]) -> float:
    """The size of the labels of ticks."""
    return float(ticks[0].label1.get_fontsize()) if ticks else BASE_POINTS


def _headings(axes: Axes) -> list[Text]:
    """The titles of a panel and of its axes, and what is written into it."""
    return [*(text for text in axes.get_children() if isinstance(text, Text)), axes.xaxis.label, axes.yaxis.label]


def _break(text: Text, said: str, room: float) -> None:
    """Have a text say this, broken over lines of `room` points."""
    text.set_text("\n".join(_broken(said, text.get_fontproperties(), room)))


def _broken(said: str, font: FontProperties, room: float) -> list[str]:
    lines: list[str] = []
    for line in said.split("\n"):
        filled = ""
        for word in line.split(" "):
            longer = f"{filled} {word}" if filled else word
            if filled and _length(longer, font) > room:
                lines.append(filled)
                longer = word
            filled = longer
        lines.append(filled)
    return lines


def _length(line: str, font: FontProperties) -> float:
    """How long a line of text is, in points."""
    return _ink(line, font.copy()) if line.strip() else 0.0


@lru_cache(4096)
def _ink(line: str, font: FontProperties) -> float:
    """The width of what is drawn of a line; outlines of letters have a point wherever they are widest."""
    path = TextPath((0.0, 0.0), line, prop=font)
    return float(np.ptp(path.vertices[path.codes != Path.CLOSEPOLY, 0]))


def _turn_labels(figure: Figure) -> None:
    """Turn labels of a horizontal axis that run into each other."""
    figure.draw_without_rendering()
    for axes in figure.axes:
        labels = [label for label in axes.get_xticklabels() if label.get_text() and label.get_visible()]
        boxes = sorted((label.get_window_extent() for label in labels), key=lambda box: box.x0)
        if any(right.x0 < left.x1 + 2.0 for left, right in pairwise(boxes)):
            axes.tick_params(axis="x", labelrotation=90.0)


# --- legends ---


def _place_legends(figure: Figure, width: float) -> None:
    """Break legends to the width of what they belong to, and put those below their panel that hide too much of it."""
    for legend in list(figure.legends):
        _below_figure(figure, legend, 0.96 * width * 72.0)
    figure.draw_without_rendering()
    below: list[tuple[Axes, Legend]] = []
    for axes in figure.axes:
        own = axes.get_legend()
        if own is None:
            continue
        box, panel = own.get_window_extent(), axes.get_window_extent()
        shares = box.width / panel.width, box.height / panel.height
        if any(share > most for share, most in zip(shares, ROOMY, strict=True)) or not _is_inside(box, panel):
            below.append((axes, own))
        else:
            own.set_in_layout(True)
    heights: dict[int, float] = {}
    for axes, legend in below:
        row = _place(axes)[0]
        heights[row] = max(heights.get(row, 0.0), _below_panel(figure, axes, legend))
    figure.set_size_inches(width, figure.get_size_inches()[1] + 0.8 * sum(heights.values()) / figure.dpi)


def _is_inside(box: Bbox, panel: Bbox) -> bool:
    return bool(panel.padded(1.0).contains(box.x0, box.y0) and panel.padded(1.0).contains(box.x1, box.y1))


def _below_figure(figure: Figure, legend: Legend, room: float) -> None:
    handles, labels, settings, height = _anew(legend, room, figure.dpi)
    legend.remove()
    figure.legend(handles, labels, loc="outside lower center", **settings)
    width, high = figure.get_size_inches()
    figure.set_size_inches(width, high + 0.6 * height / figure.dpi)


def _below_panel(figure: Figure, axes: Axes, legend: Legend) -> float:
    """Put a legend below all else that belongs to its panel; returns its height in pixels, about."""
    panel = axes.get_window_extent()
    handles, labels, settings, height = _anew(legend, panel.width * 72.0 / figure.dpi, figure.dpi)
    legend.remove()
    tight = axes.get_tightbbox()
    labels_height = panel.y0 - tight.y0 if tight is not None else 0.0
    down = ScaledTranslation(0.0, -(labels_height / figure.dpi + 4.0 / 72.0), figure.dpi_scale_trans)
    axes.legend(
        handles,
        labels,
        loc="upper center",
        bbox_to_anchor=(0.5, 0.0),
        bbox_transform=axes.transAxes + down,
        borderaxespad=0.0,
        **settings,
    )
    return height


def _anew(legend: Legend, room: float, dpi: float) -> tuple[list[Any], list[str], dict[str, Any], float]:
    """Handles, broken labels and settings of a legend within `room` points, and its height in pixels, about."""
    texts = legend.get_texts()
    font = texts[0].get_fontproperties() if texts else FontProperties()
    points = font.get_size_in_points()
    beside = 3.0 * points
    labels = ["\n".join(_broken(text.get_text(), font, room - beside - points)) for text in texts]
    widest = max((_length(line, font) for label in labels for line in label.split("\n")), default=0.0)
    columns = max(1, min(len(labels), int((room + points) / (widest + beside + points))))
    lines = sum(max(label.count("\n") + 1 for label in labels[i : i + columns]) for i in range(0, len(labels), columns))
    settings = {"ncols": columns, "prop": font, "handlelength": 1.7, "columnspacing": 1.0, "handletextpad": 0.5}
    return list(legend.legend_handles), labels, settings, (1.35 * lines + 1.5) * points * dpi / 72.0
