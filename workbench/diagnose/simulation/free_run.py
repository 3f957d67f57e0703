"""Errors of a free run: the plant from end to end of its records, driven by the measured input alone."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.simulation.fits import begun
from workbench.diagnose.simulation.shooting import Shooting

SETTLED = 20
"""Samples at the beginning that a free run's error leaves out."""


@dataclass(frozen=True)
class FreeRunErrors:
    """Rms of measured less simulated position (m) and load pressure (Pa); None where the plant diverges, or where not
    both pressures are measured. `shown` is what the sensors would have shown along the first record, NaN where it
    diverges.
    """

    position: float | None = None
    load_pressure: float | None = None
    shown: Mapping[str, np.ndarray] = field(default_factory=dict)


def free_run(whole: Shooting, motions: Sequence[Motion], values: Values) -> FreeRunErrors:
    """Errors over all records, which a plant with these values begins where it suits it best."""
    how = begun(whole, motions, values)
    simulated = [how.simulated(motion, values) for motion in motions]
    positions, pressures = list[np.ndarray](), list[np.ndarray]()
    for motion, shown in zip(motions, simulated, strict=True):
        known = motion.record.valid & how.tells(motion)
        errors = {name: np.where(known, motion.measured[name] - own, 0.0)[SETTLED:] for name, own in shown.items()}
        positions.append(errors["position"])
        if "pressure_1" in errors and "pressure_2" in errors:
            pressures.append(errors["pressure_1"] - errors["pressure_2"])
    rms = [float(np.sqrt(np.mean(np.concatenate(parts) ** 2))) for parts in (positions, pressures) if parts]
    if not np.all(np.isfinite(rms)):
        return FreeRunErrors(shown=simulated[0])
    return FreeRunErrors(rms[0], rms[1] if pressures else None, simulated[0])
