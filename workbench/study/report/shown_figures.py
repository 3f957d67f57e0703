"""The figures of a case that are shown first, in words and in a reader's units."""

from workbench.metrics.registry import names_along
from workbench.publish.along import SHOWN
from workbench.publish.tables import shown_number

FIGURES = (
    ("phase_lag_deg", "phase lag"),
    ("rms_error_m", "rms error"),
    ("max_error_m", "largest error"),
    ("steady_state_error_m", "steady-state error"),
    ("limit_cycle", "limit cycle"),
    ("limit_cycle_amplitude_m", "limit cycle, peak to peak"),
    ("control_effort_V", "command, rms"),
    ("total_power_W", "power"),
    ("paid_power_W", "power paid"),
)
"""Columns of results.csv, as they are named along an axis that goes straight, and what they are called."""


LEAST = 1e-6
"""mm or deg, below which an error is not told."""


def shown_figure(name: str, value: float, axis: str, digits: int) -> str:
    """One of `FIGURES` (SI) as a reader sees it, without its unit."""
    number = value * shown_unit(name, axis)[1]
    if name.endswith("_m") and 0.0 < abs(number) < LEAST:
        return f"< {LEAST:g}"
    return shown_number(number, digits)


def column_along(name: str, axis: str) -> str:
    """The column of one of `FIGURES` in the results of plants of that axis."""
    return names_along(axis)[name]


def shown_unit(name: str, axis: str) -> tuple[str, float]:
    """The unit in which one of `FIGURES` is shown, and the factor from SI."""
    if name.endswith("_m"):
        return SHOWN[axis].unit, SHOWN[axis].factor
    return {"W": "W", "V": "V", "deg": "deg"}[name.rpartition("_")[2]], 1.0
