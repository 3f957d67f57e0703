"""What the figures of a tuning have in common: panels by controller, colours of before and after."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, Literal

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.publish.pictures import Picture
from workbench.publish.style import COLOURS, LineStyle

BEFORE: LineStyle = {
    "color": COLOURS[1],
    "linestyle": "--",
    "linewidth": 1.1,
    "label": "before (the study's gains)",
}
AFTER: LineStyle = {"color": COLOURS[0], "linestyle": "-", "linewidth": 1.4, "label": "after (tuned)"}
SIDES = {"before": BEFORE, "after": AFTER}

WIDE = 8.0
"""Inches of two panels side by side."""

HEIGHT = 1.9
"""Inches of one of many panels."""


@dataclass(frozen=True, eq=False)
class Pictures:
    """Figures by name, those of all controllers and one of each, and what is said of those that there are not."""

    shared: Mapping[str, Picture]
    own: Mapping[str, Picture]
    missing: Sequence[str]


Shared = Literal["none", "all", "row", "col"]
"""Which panels have one axis."""


def grid(
    rows: int, columns: int, title: str, height: float = HEIGHT, *, sharex: Shared = "none", sharey: Shared = "none"
) -> tuple[Figure, np.ndarray]:
    """A figure of panels."""
    figure = Figure(figsize=(WIDE * columns / 2.0 if columns != 1 else 0.8 * WIDE, height * rows + 0.9))
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, figure.subplots(rows, columns, squeeze=False, sharex=sharex, sharey=sharey)


def small_multiples(
    count: int, title: str, height: float = HEIGHT, *, sharex: Shared = "none", sharey: Shared = "none"
) -> tuple[Figure, list[Axes]]:
    """A panel for each of `count`, two side by side, the place left over empty."""
    columns = min(count, 2)
    figure, panels = grid(-(-count // columns), columns, title, height, sharex=sharex, sharey=sharey)
    axes = list(panels.ravel())
    for left in axes[count:]:
        left.set_visible(False)
    if count > columns and count % columns:
        axes[count - columns].tick_params(labelbottom=True)
    return figure, axes[:count]


def legend(figure: Figure, panels: list[Axes], columns: int = 3) -> None:
    """One legend for all panels, below them."""
    handles: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            handles.setdefault(label, handle)
    if handles:
        figure.legend(list(handles.values()), list(handles), loc="outside lower center", ncols=columns)


def note(axes: Axes, text: str) -> None:
    """Words in the middle of a panel that has nothing to draw."""
    axes.text(0.5, 0.5, text, ha="center", va="center", transform=axes.transAxes, fontsize="small", wrap=True)
