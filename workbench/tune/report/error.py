"""The figure of tracking errors before and after tuning, over the last period of each case."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes

from workbench.metrics.window import first_sample
from workbench.publish.along import SHOWN, Shown
from workbench.publish.style import figure_style
from workbench.tune.report.panels import SIDES, Picture, grid, legend
from workbench.tune.report.rows import case_labels
from workbench.tune.report.tables import plain
from workbench.tune.report.traces import LOW, Trace, Traced, length_unit, say_failed

SPREAD = 10.0
"""An error before tuning that is this many times larger than that after it is cut off."""


@dataclass(frozen=True, eq=False)
class ErrorPanel:
    """Errors (m) of a controller in a case over its last period, of runs that did not diverge, by when they are.

    `limit` (m) is where the error before tuning is cut off; None where it is not.
    """

    label: str
    errors: Mapping[str, Trace]
    limit: float | None


def error_data(traced: Sequence[Traced]) -> list[list[ErrorPanel]]:
    """The numbers of the figure of these runs: a row a controller, a column a case."""
    labels = case_labels(traced[0].tuned.task.cases)
    return [[_panel(each, number, label) for number, label in enumerate(labels)] for each in traced]


def _panel(traced: Traced, number: int, case_label: str) -> ErrorPanel:
    errors = dict[str, Trace]()
    for when, runs in traced.cases.items():
        case, run = runs[number]
        if run.diverged or run.reference is None:
            continue
        period = case.signal.period if case.signal is not None else None
        begin = case.transient if period is None else max(float(run.time[-1]) - period, 0.0)
        start = first_sample(run.time, begin)
        errors[when] = Trace(run.time[start:], run.signals["error"][start:])
    peaks = {when: float(np.max(np.abs(error.values))) for when, error in errors.items()}
    cut = len(peaks) == len(SIDES) and peaks["before"] > SPREAD * peaks["after"] > 0.0
    label = ", ".join(part for part in (traced.tuned.task.label, plain(case_label)) if part)
    return ErrorPanel(label, errors, SPREAD * peaks["after"] if cut else None)


def error_picture(traced: Sequence[Traced]) -> Picture:
    """Error over the last period of each case, a row a controller, a column a case."""
    data = error_data(traced)
    with figure_style():
        figure, panels = grid(len(data), len(data[0]), "Tracking error over the last period", LOW, sharex="col")
        for axes, panel in zip(panels.ravel(), (panel for row in data for panel in row), strict=True):
            _draw(axes, panel, SHOWN[traced[0].tuned.task.axis])
        for axes in panels[-1]:
            axes.set_xlabel("time (s)")
        legend(figure, list(panels.ravel()))
    cut = any(panel.limit is not None for row in data for panel in row)
    caption = (
        "Reference less true position over the last period of each case, on the declared machine. Each panel has a "
        "scale of its own: it shows where in a period the error arises; the table says which controller has the least."
        + (f" Errors before tuning above {SPREAD:g} times those after it are cut off." if cut else "")
    )
    return Picture(figure, caption)


def _draw(axes: Axes, panel: ErrorPanel, along: Shown) -> None:
    scale, unit = length_unit(panel.errors.values(), along)
    for when, error in panel.errors.items():
        axes.plot(error.time, scale * error.values, **SIDES[when])
    axes.set_title(panel.label, fontsize="small")
    axes.set_ylabel(f"error ({unit})")
    if not panel.errors:
        say_failed(axes)
    if panel.limit is not None:
        axes.set_ylim(-scale * panel.limit, scale * panel.limit)
