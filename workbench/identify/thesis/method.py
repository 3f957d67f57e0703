"""The thesis's identification of friction (Owen 2001, 4.3 to 4.6), step by step, on arrays.

Positions are averaged over 10 samples (100 Hz at 1 kHz) and differentiated by a non-causal FIR filter of order 16; the
velocity is averaged over 10 again (10 Hz). The 10 Hz data above 0.6 mm/s give the static parameters of each direction,
the 100 Hz data up to that speed the bristle's. The same functions serve pure rotation: torque K_t i over the radius as
the force, surface speed R omega as the velocity.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.optimize import curve_fit, nnls

from workbench.errors import UserError
from workbench.records.friction import SLIDING, Slow

DAMPING_RATIO = 0.9
"""zeta in the first value of sigma1, thesis (4.14)."""

LEAST_STATIC = 0.1
"""N. Less static friction is none."""

FEWEST_AT_REST = 10
"""Samples before the first sliding from which the bristle is judged."""

VISIBLE = 3.0
"""A Stribeck friction that at `SLIDING` is less than so many times the data's scatter is not seen in them."""

SMALLEST = 1e-6
"""A value at its bound of 0 is told from 0 by no more (SI)."""

STATIC = ("coulomb", "stribeck", "viscous", "stribeck_velocity")


def steady(
    velocity: np.ndarray, coulomb: float, stribeck: float, viscous: float, stribeck_velocity: float
) -> np.ndarray:
    """F = a0 + a1 exp(-(v/v_s)^2) + a2 v (N) at `velocity` >= 0 (m/s). Thesis (4.7)."""
    return np.asarray(coulomb + stribeck * np.exp(-((velocity / stribeck_velocity) ** 2)) + viscous * velocity)


def static_parameters(data: Slow) -> dict[str, float]:
    """a0, a1, a2 and v_s by nonlinear least squares of (4.7) on the data above `SLIDING`; none below 0. Thesis (4.8).

    The start is taken from the data: a line through the upper half of the speeds, and what stands above it. Where the
    Stribeck friction is not `VISIBLE`, the data are a line, fitted as such: it is 0, and its velocity NaN.

    Raises:
        UserError: too few samples slide.
    """
    moving = np.isfinite(data.velocity) & np.isfinite(data.force) & (data.velocity > SLIDING)
    v, f = data.velocity[moving], data.force[moving]
    if v.size < 3 * len(STATIC):
        raise UserError(
            f"{v.size} samples at 10 Hz slide faster than {1e3 * SLIDING:g} mm/s in this direction, expected at least "
            f"{3 * len(STATIC)}; take a longer record"
        )
    upper = v >= np.median(v)
    slope, level = np.polyfit(v[upper], f[upper], 1)
    start = np.array([max(level, 1.0), max(float(np.max(f)) - level, 1.0), max(slope, 1.0), 0.25 * np.max(v)])
    bounds = ([0.0, 0.0, 0.0, 0.1 * SLIDING], [np.inf, np.inf, np.inf, 2.0 * np.max(v)])
    fitted, _ = curve_fit(steady, v, f, np.clip(start, bounds[0], bounds[1]), bounds=bounds, x_scale=start)
    fitted = np.where(fitted < SMALLEST, 0.0, fitted)
    values = dict(zip(STATIC, fitted.tolist(), strict=True))
    scatter = float(np.std(f - steady(v, *fitted)))
    if values["stribeck"] * np.exp(-((SLIDING / values["stribeck_velocity"]) ** 2)) < VISIBLE * scatter:
        coulomb, viscous = nnls(np.column_stack([np.ones(v.size), v]), f)[0].tolist()
        return {"coulomb": coulomb, "stribeck": 0.0, "viscous": viscous, "stribeck_velocity": float("nan")}
    return values


def dynamic_parameters(data: Slow, static_level: float, mass: float) -> dict[str, float]:
    """sigma0 and sigma1 from the data at the start of a record, until it first slides.

        dz/dt = v - |v| F / (a0 + a1), integrated by Euler's rule for z;  sigma0 = F / z      (4.11), (4.12)
        sigma1 = 2 * 0.9 sqrt(sigma0 M), a2 being negligible near rest                        (4.14)
        both refined by a curve fit of F = sigma0 z + sigma1 dz/dt                            (4.3) without a2 v

    F / z is taken as the slope of F over z through 0; data with F above the static level are left out. With z and dz/dt
    known the curve fit is linear. Where it leaves a value that is not positive, the data say nothing of it, and both
    first values stay. `static_level` is a0 + a1 (N), `mass` M (kg).

    Raises:
        UserError: the record does not begin at rest, or there is no static friction.
    """
    if static_level < LEAST_STATIC:
        raise UserError("there is no static friction at the bound of 0 N, and so no bristle to find")
    known = np.isfinite(data.velocity) & np.isfinite(data.force)
    first = int(np.argmax(known))
    sliding = known & (data.velocity > SLIDING)
    last = int(np.argmax(sliding)) if np.any(sliding) else data.velocity.size
    resting = known[first:last]
    v, f = data.velocity[first:last][resting], data.force[first:last][resting]
    if v.size < FEWEST_AT_REST:
        raise UserError("the record slides from its beginning: the bristle's parameters need a start from rest")
    rate = v - np.abs(v) * f / static_level
    z = np.concatenate([[0.0], np.cumsum(rate[:-1] * data.sample_time)])
    below = f <= static_level
    v, f, z, rate = v[below], f[below], z[below], rate[below]
    if not np.any(z):
        raise UserError("no sample before sliding has a friction below the static one: there is no bristle to find")
    stiffness = float(np.sum(f * z) / np.sum(z * z))
    if stiffness <= 0.0:
        raise UserError("friction falls as the bristle bends: its stiffness would be negative")
    damping = damping_rule(stiffness, mass)
    refined = np.linalg.lstsq(np.column_stack([z, rate]), f, rcond=None)[0]
    if np.all(refined > 0.0):
        stiffness, damping = refined.tolist()
    return {"bristle_stiffness": stiffness, "bristle_damping": damping}


def damping_rule(stiffness: float, mass: float) -> float:
    """sigma1 = 2 * 0.9 sqrt(sigma0 M) (N s/m). Thesis (4.14)."""
    return 2.0 * DAMPING_RATIO * float(np.sqrt(stiffness * mass))


@dataclass(frozen=True)
class Estimate:
    """Mean and standard deviation over repeats (NaN for one), as the thesis's tables show them."""

    value: float
    std: float
    count: int

    @property
    def std_of_repeats(self) -> float | None:
        """The deviation; None of one record alone."""
        return self.std if self.count > 1 else None

    def to_json(self) -> dict[str, object]:
        """As identified.json holds it."""
        return {"mean": self.value, "std": self.std_of_repeats, "repeats": self.count}


UNKNOWN = 0.5
"""Relative standard deviation from which a parameter counts as not identified, as in a fit by simulation."""


def doubt(estimate: Estimate) -> str:
    """Why an estimate says nothing of its parameter; empty where it does."""
    value, std = abs(estimate.value), estimate.std
    if value == 0.0:
        return "none is seen, the fit is at its bound of 0"
    if estimate.count > 1 and std > UNKNOWN * value:
        return f"the standard deviation over the records is {100.0 * std / value:.0f} % of its value"
    return ""


def over_repeats(repeats: Sequence[Mapping[str, float]]) -> dict[str, Estimate]:
    """Mean and standard deviation of each parameter over the records that give it."""
    names = dict.fromkeys(name for record in repeats for name in record)
    result = {}
    for name in names:
        values = np.array([record[name] for record in repeats if np.isfinite(record.get(name, np.nan))])
        if values.size:
            std = float(np.std(values, ddof=1)) if values.size > 1 else float("nan")
            result[name] = Estimate(float(np.mean(values)), std, values.size)
    return result
