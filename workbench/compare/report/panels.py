"""What the figures of a comparison have in common: a panel a machine, axes of errors, points with intervals."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.compare.candidates import MM, Candidate, Cell
from workbench.compare.intervals import Interval
from workbench.compare.result import Comparison
from workbench.compare.schema import ComparisonTable
from workbench.publish.style import plain_numbers
from workbench.publish.words import plain_name

PANEL = (4.6, 3.3)
"""Width and height of a panel (inches)."""

HIGHEST = 100.0
"""What errs more than this many times the best of its panel is cut off: it is no rival, and would flatten the rest."""

OTHERS = "#b8b8b8"
"""The colour of all that is not named: many candidates stay legible."""

BEHIND = 1.8
"""Where these lie: behind the curves that are named."""

P = TypeVar("P")

Candidates = Mapping[Cell, Sequence[Candidate]]


@dataclass(frozen=True)
class Style:
    """How points with intervals are drawn."""

    color: str
    marker: str
    line: str = "none"
    size: float | None = None


@dataclass(frozen=True)
class ErrorAxis:
    """The axis of errors (mm) of a panel: its title and label, below which errors are not told apart, and its top."""

    title: str
    label: str
    floor: float
    top: float


@dataclass(frozen=True)
class Bar:
    """An error (mm) with its interval, at a place on the other axis."""

    place: float
    error: Interval


def candidates_of(comparison: Comparison) -> dict[Cell, list[Candidate]]:
    """The candidates of the search, with the flaws that some show only where they were measured for the verdict."""
    flaws = {
        (cell, *measured.key): measured.flaw
        for cell, verdict in comparison.verdicts.items()
        for measured in verdict.candidates
    }
    return {
        cell: [replace(each, flaw=each.flaw or flaws.get((cell, *each.key), "")) for each in candidates]
        for cell, candidates in comparison.candidates.items()
    }


def _rows(cells: Candidates, made: Callable[[Cell, Sequence[Candidate]], P]) -> list[list[P | None]]:
    """The panels of a scenario: a row a reference, a column a machine; None where there is no such cell."""
    references, machines = (list(dict.fromkeys(cell[i] for cell in cells)) for i in (2, 0))
    by_place = {(cell.reference, cell.machine): made(cell, candidates) for cell, candidates in cells.items()}
    return [[by_place.get((reference, machine)) for machine in machines] for reference in references]


def shown(table: ComparisonTable, error: float) -> float:
    """An error (m) as drawn, in mm: none lies below the middle of the band of those that are not told apart."""
    return float(np.maximum(error, 0.5 * table.negligible) * MM)


def bar_of(table: ComparisonTable, candidate: Candidate, place: float) -> Bar:
    """The mean error of a candidate with its interval, as drawn."""
    size = candidate.mean_error(table.probability)
    return Bar(place, Interval(shown(table, size.mean), shown(table, size.low), shown(table, size.high)))


def error_axis(table: ComparisonTable, cell: Cell, candidates: Sequence[Candidate]) -> ErrorAxis:
    """An axis that always shows the band of what is not told apart, and so magnifies no noise."""
    floor = table.negligible * MM
    sizes = [each.errors.mean() * MM for each in candidates if not each.flaw] or [floor]
    steps = bool(candidates) and candidates[0].error_column != "rms_error_m"
    return ErrorAxis(
        title=", ".join(filter(None, (plain_name(cell.machine), plain_name(cell.reference)))),
        label="largest error at rest (mm)" if steps else "rms error (mm)",
        floor=floor,
        top=min(max(sizes), HIGHEST * max(min(sizes), floor)),
    )


def grid(rows: int, columns: int, title: str) -> tuple[Figure, list[Axes]]:
    """A figure of panels."""
    width, height = PANEL
    figure = Figure(figsize=(width * max(columns, 1.4), height * rows + 0.5))
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, list(figure.subplots(rows, columns, squeeze=False).ravel())


def drawn(
    title: str,
    cells: Candidates,
    made: Callable[[Cell, Sequence[Candidate]], P],
    draw: Callable[[Axes, P], ErrorAxis],
) -> Figure:
    """A figure of the panels that are `made` of cells; `draw` returns the axis of errors of what it drew."""
    rows = _rows(cells, made)
    figure, panels = grid(len(rows), len(rows[0]), title)
    for axes, panel in zip(panels, (each for row in rows for each in row), strict=True):
        if panel is None:
            axes.set_visible(False)
            continue
        scale = draw(axes, panel)
        axes.set_title(scale.title)
        _scale(axes, scale)
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2, fontsize="x-small")
    return figure


def _scale(axes: Axes, scale: ErrorAxis) -> None:
    """A logarithmic axis for errors, with plain numbers."""
    axes.set_yscale("log")
    axes.set_ylim(scale.floor / 3.0, max(3.0 * scale.floor, 3.0 * scale.top))
    axes.axhspan(scale.floor / 3.0, scale.floor, color="#e4e4e4", zorder=0)
    plain_numbers(axes.yaxis)
    axes.set_ylabel(scale.label)


def draw_others(axes: Axes, x: Sequence[float], errors: Sequence[float], size: float, line: str) -> None:
    """Errors (mm) of all that is not named: small points, `line` between them."""
    axes.plot(x, errors, linestyle=line, marker=".", color=OTHERS, linewidth=0.8, markersize=size, zorder=BEHIND)


def draw_bars(axes: Axes, bars: Sequence[Bar], style: Style, label: str) -> None:
    """Mean errors with their intervals over the plant samples."""
    mean, low, high = (np.array([getattr(bar.error, end) for bar in bars]) for end in ("mean", "low", "high"))
    axes.errorbar(
        [bar.place for bar in bars],
        mean,
        yerr=[mean - low, high - mean],
        capsize=2.5,
        zorder=2.5,
        color=style.color,
        marker=style.marker,
        linestyle=style.line,
        markersize=style.size,
        label=label,
    )
