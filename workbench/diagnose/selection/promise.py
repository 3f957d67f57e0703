"""What a candidate promises on a balance, before any whole fit of it."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from workbench.diagnose.residuals.fit import STEP, Fit
from workbench.diagnose.residuals.unknowns import unknown

SHARES = (1.0, 0.6, 0.3)
"""Of a Gauss-Newton step, at which a candidate's promise is looked at: a long step of a logarithm goes too far."""


def promise(before: Fit, names: Sequence[str], bounds: Mapping[str, tuple[float, float]]) -> float:
    """Residual rms (floors) after one Gauss-Newton step of a fit that also frees `names`: what a candidate promises."""
    balance, values = before.balance, before.values
    added = [unknown(name, values, bounds, balance.scales) for name in names if name not in before.names]
    kept = [replace(u, start=values[u.name]) if u.logarithmic else u for u in before.unknowns]
    x = [0.0 if u.logarithmic else values[u.name] / u.size for u in kept]
    start = np.array(x + [float(np.clip(u.first, u.low, u.high)) for u in added])

    def residual(point: np.ndarray) -> np.ndarray:
        moved = {u.name: u.value(float(place)) for u, place in zip([*kept, *added], point, strict=True)}
        return np.nan_to_num(balance.stacked({**values, **moved}), nan=1e6)

    base, columns = residual(start), []
    for i in range(len(kept), start.size):
        moved = start.copy()
        moved[i] += STEP * max(1.0, abs(start[i]))
        columns.append((residual(moved) - base) / (moved[i] - start[i]))
    jacobian = np.column_stack([before.jacobian, *columns])
    step = np.linalg.lstsq(jacobian, -base, rcond=1e-10)[0]
    low = np.array([u.low for u in [*kept, *added]])
    high = np.array([u.high for u in [*kept, *added]])
    reached = [residual(np.clip(start + share * step, low, high)) for share in SHARES]
    return float(np.sqrt(min(np.mean(left**2) for left in (base, *reached))))
