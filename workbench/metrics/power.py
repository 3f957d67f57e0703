"""What a run costs: powers and command; and how the rod moves meanwhile: jerk, and the time it is stuck."""

from collections.abc import Mapping

import numpy as np

from workbench.metrics.tracking import root_mean_square
from workbench.simulation.run import STUCK_SPEED

POWERS = ("hydraulic_power", "supply_power", "rotation_power", "motor_electric_power")
"""Signals of a plant in W whose means are columns, with `_W` behind their name."""


def mean_powers(signals: Mapping[str, np.ndarray], samples: slice) -> dict[str, float]:
    """Means (W) of those of `POWERS` that the plant has, and what they add up to, by column.

    total = hydraulic + rotary (thesis 4.19), the hydraulic power alone where the plant does not rotate; paid = supply +
    motor's terminals, the supply alone where nothing rotates.
    """
    means = {f"{name}_W": float(np.mean(signals[name][samples])) for name in POWERS if name in signals}
    if "hydraulic_power_W" in means:
        means["total_power_W"] = means["hydraulic_power_W"] + means.get("rotation_power_W", 0.0)
    if "supply_power_W" in means:
        means["paid_power_W"] = means["supply_power_W"] + means.get("motor_electric_power_W", 0.0)
    return means


def control_effort(command: np.ndarray, unit: str) -> float | None:
    """Root mean square of the realised command (V); None for a command that is no voltage."""
    return root_mean_square(command) if unit == "V" else None


def jerk_rms(time: np.ndarray, acceleration: np.ndarray) -> float | None:
    """Root mean square (m/s^3) of the central differences of acceleration (m/s^2); None below three samples."""
    if time.size < 3:
        return None
    return root_mean_square((acceleration[2:] - acceleration[:-2]) / (time[2:] - time[:-2]))


def stuck_fraction(velocity: np.ndarray) -> float:
    """Share of the samples with |velocity| (m/s) below `STUCK_SPEED`, 0.1 mm/s."""
    return float(np.mean(np.abs(velocity) < STUCK_SPEED))
