"""What all figures of a diagnosis share: colours of before and after, panels, one legend."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from types import MappingProxyType
from typing import Any, Literal

import numpy as np
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.legend_handler import HandlerTuple

from workbench.publish.style import COLOURS

BEFORE, AFTER = COLOURS[1], COLOURS[0]

WIDE = 9.0
"""Inches of a figure with two columns."""

HEIGHT = 2.0
"""Inches of one of many panels."""

FLOOR: dict[str, Any] = {"color": "#999999", "alpha": 0.35, "linewidth": 0.0, "zorder": 1.0}
"""The noise floor: a grey band under the curves."""


@dataclass(frozen=True)
class Side:
    """One of two models that are drawn: the fitted baseline, or what came of the diagnosis; and what it is called."""

    key: Literal["before", "after"]
    label: str

    @property
    def colour(self) -> str:
        """Of its curves, in every figure."""
        return BEFORE if self.key == "before" else AFTER


def panels_of(rows: int, columns: int, title: str, *, share_y: bool = False) -> tuple[Figure, np.ndarray]:
    """A figure with a title and a grid of panels (`Axes`), shape (rows, columns)."""
    figure = Figure(figsize=(WIDE, HEIGHT * rows + 0.8))
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, figure.subplots(rows, columns, squeeze=False, sharey=share_y)


def legend(figure: Figure, *panels: Axes, more: Mapping[str, Sequence[Artist]] = MappingProxyType({})) -> None:
    """One legend for all panels, under them, of what these have, and of `more`, by label, beside each other."""
    drawn: dict[str, Any] = {}
    for axes in panels:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            drawn.setdefault(label, handle)
    drawn |= {label: tuple(handles) for label, handles in more.items()}
    figure.legend(
        list(drawn.values()),
        list(drawn),
        loc="outside lower center",
        ncols=2 if len(drawn) > 3 else 3,
        handler_map={tuple: HandlerTuple(ndivide=None)},
    )
