"""What the figures of a decision have in common: one panel with a title, words of its axes, which errors are known."""

import math

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.decide.candidate import CandidateResult
from workbench.decide.report.names import ERRORS, percent
from workbench.decide.result import Decision


def is_known(row: CandidateResult) -> bool:
    """Whether enough runs complete for an error and a power."""
    return math.isfinite(row.error) and math.isfinite(row.mean_power)


def panel(width: float, height: float, title: str) -> tuple[Figure, Axes]:
    """A figure (inches) of one panel."""
    figure = Figure(figsize=(width, height))
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, figure.subplots()


def error_label(decision: Decision) -> str:
    """The words of an axis of errors."""
    quantile = f", {percent(decision.table)} quantile" if decision.plan.several else ""
    return f"{ERRORS[decision.table.figure]}{quantile} (mm)"
