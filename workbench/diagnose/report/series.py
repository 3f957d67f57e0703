"""Residuals of a diagnosis as figures show them: before and after, over time or a signal, and how white they are."""

import functools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from plants.effects.registry import effects
from workbench.diagnose.residuals.balance import SIMULATION, Balance
from workbench.diagnose.residuals.motion import THINNED, Motion, signals_of
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.result import Diagnosis
from workbench.diagnose.selection.unexplained import bins_of
from workbench.publish.along import SHOWN
from workbench.toml.units import factor

FEWEST = 8
"""Values in a bin that is shown: the mean of fewer says little."""

LONGEST_LAG = 1.0
"""s of the autocorrelation that is shown."""

LEAST_LAGS = 20
"""Lags of it at least, of a slow record."""


@dataclass(frozen=True, eq=False)
class Part:
    """One residual of a balance on one record, in `unit`: time (s), before and after, NaN where it is not known.

    `moving` is True where the contact is known to slide; `number` counts the balance's residuals: a flow has two.
    """

    label: str
    use: str
    number: int
    motion: Motion
    time: np.ndarray
    before: np.ndarray
    after: np.ndarray
    moving: np.ndarray
    axis: str

    def of(self, side: Literal["before", "after"]) -> np.ndarray:
        """The residual of one side."""
        return self.before if side == "before" else self.after

    def signal(self, name: str) -> np.ndarray | None:
        """A signal at the residual's times, as it is shown; None where it was not measured."""
        values = signals_of(self.motion.thinned).get(name)
        return None if values is None else signals_along(self.axis)[name].scale * values


@dataclass(frozen=True)
class Signal:
    """A signal that a residual may depend on, in words, with what SI values are to be multiplied with."""

    label: str
    scale: float


_ELSE: Mapping[str, Signal] = {
    "load_pressure": Signal("load pressure (kPa)", 1e-3),
    "pressure_1": Signal("pressure 1 (kPa)", 1e-3),
    "pressure_2": Signal("pressure 2 (kPa)", 1e-3),
    "valve_voltage": Signal("valve voltage (V)", 1.0),
    "command": Signal("command (as recorded)", 1.0),
    "rotation_angle": Signal("angle (rad)", 1.0),
    "time": Signal("time (s)", 1.0),
}


@functools.cache
def signals_along(axis: str) -> Mapping[str, Signal]:
    """By name, of plants along that axis."""
    shown = SHOWN[axis]
    return {
        "position": Signal(f"position ({shown.unit})", shown.factor),
        "velocity": Signal(f"velocity ({shown.speed_unit})", shown.factor),
        "acceleration": Signal(f"acceleration ({axis}/s^2)", 1.0),
        **_ELSE,
    }


ALWAYS = ("position", "velocity", "load_pressure", "valve_voltage", "rotation_angle", "time")
"""Signals that are always shown where they were measured."""


def shown_signals(diagnosis: Diagnosis, balance: Balance, part: "Part") -> list[str]:
    """The signals over which a balance is shown: the usual ones, those on which what was found acts, and those on which
    depends what is not explained.
    """
    wanted = set(ALWAYS)
    if part.signal("load_pressure") is None:
        wanted |= {"pressure_1", "pressure_2"}
    for effect in diagnosis.effects:
        wanted |= set(effects()[effect.name].acts_on)
    if diagnosis.unexplained is not None and diagnosis.unexplained.balance == balance.name:
        wanted |= set(diagnosis.unexplained.dependence.signals)
    return [name for name in signals_along(balance.axis) if name in wanted and part.signal(name) is not None]


NOISE = "standard deviations of the sensors' noise"


def title_of(balance: Balance) -> str:
    """What a balance is called at the top of a figure."""
    return "Simulated plant" if balance.name == SIMULATION else f"{words_of(balance).capitalize()} balance"


def words_of(balance: Balance) -> str:
    """What a balance is called: on an axis that turns that of forces is one of torques."""
    return SHOWN[balance.axis].said(balance.name)


def unit_of(balance: Balance) -> str:
    """The unit in which a balance is shown."""
    return {"m^3/s": "cm^3/s", "1": NOISE}.get(balance.unit, balance.unit)


def scale_of(balance: Balance) -> float:
    """What to multiply a balance's residual over its floor with."""
    return balance.floor * (1.0 if balance.unit == "1" else factor(balance.unit, unit_of(balance)))


def parts_of(diagnosis: Diagnosis, balance: Balance) -> list[Part]:
    """Every residual of a balance on every record, the fit's first."""
    parts = []
    for use, motions in (("fit", balance.motions), ("held-out", diagnosis.held_out)):
        for motion in motions:
            thin, label = motion.thinned, motion.record.label
            moving = ~thin.resting if balance.contact else np.ones(thin.time.size, dtype=bool)
            sides = [_residuals(balance, motion, values) for values in (diagnosis.baseline, diagnosis.corrected)]
            for number, (before, after) in enumerate(zip(*sides, strict=True)):
                parts.append(Part(label, use, number, motion, thin.time, before, after, moving, balance.axis))
    return parts


def _residuals(balance: Balance, motion: Motion, values: Values) -> list[np.ndarray]:
    scale = factor(balance.unit, unit_of(balance))
    return [np.where(balance.known(motion), scale * residual, np.nan) for residual in balance.residuals(motion, values)]


def is_changed(parts: Sequence[Part]) -> bool:
    """Whether what was found changes the residual at all."""
    return not all(np.allclose(part.before, part.after, rtol=1e-9, equal_nan=True) for part in parts)


def binned(signal: np.ndarray, residual: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Mean signal, mean residual and its standard deviation in bins of equal count; what is NaN is left out."""
    known = np.isfinite(signal) & np.isfinite(residual)
    signal, residual = signal[known], residual[known]
    if signal.size < FEWEST:
        return np.zeros(0), np.zeros(0), np.zeros(0)
    place = bins_of(signal)
    rows = [
        (np.mean(signal[place == i]), np.mean(residual[place == i]), np.std(residual[place == i]))
        for i in range(int(np.max(place)) + 1)
        if np.sum(place == i) >= FEWEST
    ]
    centre, mean, spread = np.array(rows).reshape(-1, 3).T
    return centre, mean, spread


def autocorrelation(series: Sequence[np.ndarray], step: float = THINNED) -> tuple[np.ndarray, np.ndarray, float]:
    """Lags (s), autocorrelation over all series, and what white noise of that many values keeps to in 95 %.

    Values that are NaN take no part: of each lag it is the correlation of the pairs that are there, 1 at most. A series
    is sampled every `step` (s).
    """
    series = [values for values in series if np.isfinite(values).any()]
    shortest = min(values.size for values in series)
    count = min(max(round(LONGEST_LAG / step), LEAST_LAGS), shortest // 2)
    filled = [np.where(np.isfinite(values), values - np.nanmean(values), 0.0) for values in series]
    known = [np.isfinite(values).astype(float) for values in series]
    squares = [values**2 for values in filled]
    correlation = np.zeros(count + 1)
    for lag in range(count + 1):
        early, late = _lagged(squares, known, lag), _lagged(known, squares, lag)
        correlation[lag] = _lagged(filled, filled, lag) / max(np.sqrt(early * late), 1e-300)
    total = sum(float(np.sum(values)) for values in known)
    return step * np.arange(count + 1), correlation, 1.96 / np.sqrt(max(total, 1.0))


def _lagged(series: Sequence[np.ndarray], others: Sequence[np.ndarray], lag: int) -> float:
    """Sum of the products of values with those of the others `lag` samples later."""
    pairs = zip(series, others, strict=True)
    return sum(float(values[: values.size - lag] @ other[lag:]) for values, other in pairs)
