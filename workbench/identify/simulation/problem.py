"""The least-squares problem of a fit by simulation: scaled unknowns, weighted errors, their derivatives.

Derivatives are differences of the compiled simulator. Measured on the thesis's run of 35 s and six friction parameters
(benchmarks/identification_derivatives.py): central differences with a relative step of 1e-2 take 0.8 s with fixed steps
of 0.1 ms (0.2 s with error control) and agree with exact sensitivities to 8e-5; the exact ones, by CasADi's derivatives
of the same equations folded over the samples, take 2.6 s.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from plants.axis import LINEAR
from plants.equation import NEGATIVE, fields
from workbench.errors import UserError
from workbench.fitting.replay import Observed, observe
from workbench.identify.simulation.nuisance import columns
from workbench.parameters.sets import EITHER_SIGN, MAY_BE_ZERO
from workbench.progress import Progress, silent
from workbench.records.experiment import Experiment
from workbench.records.reading import Record

WIDEST = 100.0
"""A parameter without bounds of its own stays within this factor of its declared value."""

SHIFT = 0.5
"""Share of its declared value from which on the unknown of a parameter that may be far below it is a logarithm."""

MAY_VANISH = frozenset({"dead_band", "command_delay", "axis_time_constant"})
"""Parameters that a machine may have or not: 0, or less than its records show, is as good a value as any."""

STEP = 1e-2
"""Relative step of differences: one-sided far from the optimum, central near it. A smaller one would divide the
integrator's own error, which then looks like information about parameters that have hardly any effect."""

DIVERGED = 1e6
"""Weighted error of a sample that a diverged simulation does not reach, of either sign in turn: no error of a sensor
explains it.
"""

KEPT = 200
"""Simulations that are kept; of many records some of each."""

TYPICAL = {
    "coulomb": 100.0,
    "stribeck": 100.0,
    "viscous": 1e3,
    "load_force": 100.0,
    "valve_overlap": 1e-5,
    "leakage_coefficient": 1e-13,
    "command_delay": 0.05,
    "drift_velocity": 1e-3,
}
"""Scales (SI) of parameters whose declared value is 0, of an axis that goes straight."""


NONE: Mapping[str, float] = MappingProxyType({})
"""No parameters."""


def _plain(name: str) -> str:
    return name.removesuffix(f"_{NEGATIVE}")


@dataclass
class Problem:
    """Stacked errors of all outputs of all records over unknowns theta = log(p / p0), or (p - p0) / scale where p0 = 0.

    Of what may vanish theta = log((p / p0 + s) / (1 + s)), which is a line near 0.
    The sensors' systematic errors are linear: at every theta they are solved for exactly, which takes them out of the
    search (variable projection, Golub and Pereyra 1973).
    """

    experiment: Experiment
    observed: Sequence[Observed]
    free: list[str]
    start: dict[str, float]
    weights: np.ndarray
    measured: np.ndarray
    nuisance: np.ndarray
    sensors: list[str]
    evaluations: int = 0
    idle: dict[bytes, frozenset[str]] = field(default_factory=dict)
    """Of each kind of record, the parameters of friction that change nothing in it, such as those of the other
    direction. Where a dead band is what keeps a plant from moving, that changes with the band."""
    known: dict[tuple[bytes, tuple[tuple[str, float], ...]], list[np.ndarray]] = field(default_factory=dict)
    held: dict[str, float] = field(default_factory=dict)
    """Parameters (SI) that a fit has driven to their bounds and that stay there."""
    progress: Progress = silent
    """Told, in words, how far the fit is."""

    @property
    def axis(self) -> str:
        """Unit of the positions of the plant, "m" or "rad"."""
        return self.experiment.plant.axis

    def logarithmic(self, name: str) -> bool:
        """Whether the unknown is a logarithm."""
        return self.start[name] > 0.0 and _plain(name) not in EITHER_SIGN

    def scale(self, name: str) -> float:
        """Unit (SI) of an unknown that is no logarithm."""
        return abs(self.start[name]) or (TYPICAL.get(_plain(name), 1.0) if self.axis == LINEAR else 1.0)

    def value(self, name: str, theta: float) -> float:
        """A parameter (SI) from its unknown."""
        start, shift = self.start[name], self.shift(name)
        if self.logarithmic(name):
            return max(start * ((1.0 + shift) * float(np.exp(theta)) - shift), 0.0)
        return start + theta * self.scale(name)

    def slope(self, name: str, theta: float) -> float:
        """Derivative of the parameter by its unknown."""
        if self.logarithmic(name):
            return self.value(name, theta) + self.shift(name) * self.start[name]
        return self.scale(name)

    def unknown(self, name: str, value: float) -> float:
        """The unknown of a parameter (SI): the inverse of `value`."""
        start, shift = self.start[name], self.shift(name)
        if self.logarithmic(name):
            return float(np.log((value / start + shift) / (1.0 + shift)))
        return (value - start) / self.scale(name)

    def relative(self, name: str, theta: float, deviation: float) -> float:
        """The deviation of an unknown as a share of the parameter, found or declared, whichever is the larger."""
        size = max(abs(self.value(name, theta)), self.scale(name))
        return abs(self.slope(name, theta)) * deviation / size

    def shift(self, name: str) -> float:
        """s of an unknown that is a logarithm: see above."""
        return SHIFT if _plain(name) in MAY_VANISH else 0.0

    def least(self, name: str) -> float:
        """The value (SI) below which a fit does not look where the experiment sets no bound."""
        if not self.logarithmic(name):
            return -np.inf if _plain(name) in EITHER_SIGN else 0.0
        vanishes = _plain(name) in MAY_VANISH and _plain(name) in MAY_BE_ZERO
        return 0.0 if vanishes else self.start[name] / WIDEST

    def limits(self) -> tuple[np.ndarray, np.ndarray]:
        """Bounds of the unknowns."""
        limits = []
        for name in self.free:
            low, high = self.experiment.bounds.get(name, (-np.inf, np.inf))
            if low <= 0.0 and _plain(name) not in EITHER_SIGN:
                low = self.least(name)
            if self.logarithmic(name) and not np.isfinite(high):
                high = self.start[name] * WIDEST
            limits.append((self.unknown(name, low), self.unknown(name, high)))
        array = np.array(limits).reshape(-1, 2)
        return array[:, 0], array[:, 1]

    def series(self) -> list[tuple[Observed, str, slice]]:
        """Where each output of each record stands in the stack."""
        series, first = [], 0
        for item in self.observed:
            for name, values in item.measured.items():
                series.append((item, name, slice(first, first + values.size)))
                first += values.size
        return series

    def _outputs(self, item: Observed, several: Sequence[dict[str, float]]) -> list[list[np.ndarray]]:
        """Predictions of a record for each of several changes; the same numbers where all that matters to it is the
        same.
        """
        idle = self.idle.get(item.key, frozenset())
        keys = [(item.key, tuple(each for each in changes.items() if each[0] not in idle)) for changes in several]
        missing = {key: changes for key, changes in zip(keys, several, strict=True) if key not in self.known}
        found = {key: self.known[key] for key in keys if key in self.known}
        predicted = item.predicted_each(self.experiment, list(missing.values()))
        for key, one in zip(missing, predicted, strict=True):
            if len(self.known) > max(KEPT, 20 * len(self.observed)):
                self.known.clear()
            self.evaluations += 1
            self.progress(f"fit of {len(self.free)} parameters: {self.evaluations} simulations")
            found[key] = self.known[key] = [
                np.full(values.size, np.nan) if one is None else one[name] for name, values in item.measured.items()
            ]
        return [found[key] for key in keys]

    def changes(self, theta: np.ndarray) -> dict[str, float]:
        """Every parameter (SI) that is not as declared."""
        own = {name: self.value(name, x) for name, x in zip(self.free, theta.tolist(), strict=True)}
        return {**self.held, **own}

    def simulated(self, theta: np.ndarray, others: Mapping[str, float] = NONE) -> np.ndarray:
        """Stacked predictions (SI), also with `others` of the parameters changed; NaN where the plant diverges."""
        return self._simulated_each([{**self.changes(theta), **others}])[0]

    def _simulated_each(self, several: Sequence[dict[str, float]]) -> list[np.ndarray]:
        outputs = [self._outputs(item, several) for item in self.observed]
        return [np.concatenate([part for parts in each for part in parts]) for each in zip(*outputs, strict=True)]

    def errors(self, theta: np.ndarray, others: Mapping[str, float] = NONE) -> np.ndarray:
        """Weighted measured - simulated, 0 over gaps; `DIVERGED`, or less that, where the plant diverges."""
        return self._errors_of(self.simulated(theta, others))

    def _errors_of(self, simulated: np.ndarray) -> np.ndarray:
        difference = (self.measured - simulated) * self.weights
        difference[~np.isfinite(self.measured)] = 0.0
        return np.where(np.isfinite(difference), difference, np.resize((DIVERGED, -DIVERGED), difference.size))

    def jacobian(self, theta: np.ndarray, *, rough: bool = False) -> np.ndarray:
        """d errors / d theta, shape (samples, free): central differences, or rough, one-sided ones."""
        ways, backs = np.eye(theta.size), np.minimum(STEP, theta - self.limits()[0])
        moved = [*(theta + STEP * ways), *([] if rough else theta - backs[:, None] * ways)]
        base, *found = map(self._errors_of, self._simulated_each([self.changes(at) for at in (theta, *moved)]))
        ahead, behind = found[: theta.size], [base] * theta.size if rough else found[theta.size :]
        steps = np.full(theta.size, STEP) if rough else STEP + backs
        slopes = [(one - other) / step for one, other, step in zip(ahead, behind, steps.tolist(), strict=True)]
        jacobian = np.column_stack(slopes) if slopes else np.zeros((base.size, 0))
        if not self.idle and self.experiment.plant.friction:
            for item in self.observed:
                rows = np.concatenate([np.arange(p.start, p.stop) for other, _, p in self.series() if other is item])
                moved = np.any(jacobian[rows] != 0.0, axis=0)
                self.idle[item.key] = frozenset(name for name, any_ in zip(self.free, moved, strict=True) if not any_)
        return jacobian

    def forget(self) -> None:
        """Nothing of what was simulated holds any longer, nor what had no effect on it."""
        self.known.clear()
        self.idle.clear()

    def refine(self) -> None:
        """Simulate with half the step from now on."""
        self.observed = [
            replace(item, integrators=(item.integrators[0].finer(), *item.integrators)) for item in self.observed
        ]
        self.forget()

    def with_command_held(self) -> "Problem":
        """The same with the command held from sample to sample."""
        observed = [observe(item.of, self.experiment, held=True) for item in self.observed]
        return replace(self, observed=observed, known={}, idle={})

    def describe_sensors(self, theta: np.ndarray) -> None:
        """Columns of the sensors' errors about the outputs simulated at `theta`.

        Raises:
            UserError: the plant diverges there.
        """
        if not self.can_be(theta):
            raise UserError(
                f"{self.experiment.path}: plant {self.experiment.plant.name} with these parameters diverges on the "
                "records; start from others with [plant.set]"
            )
        self.nuisance, self.sensors = columns(self.observed, self.simulated(theta), self.experiment.accuracies)

    def can_be(self, theta: np.ndarray) -> bool:
        """Whether no output diverges, simulated at `theta` from now on."""
        self.forget()
        return bool(np.all(np.isfinite(self.simulated(theta))))

    @property
    def weighted_nuisance(self) -> np.ndarray:
        """The sensors' columns, weighted, 0 over gaps."""
        return np.where(np.isfinite(self.measured), self.weights, 0.0)[:, None] * self.nuisance

    def projector(self) -> np.ndarray:
        """Orthonormal columns Q over errors and priors: what the sensors explain of an error r is Q Q' r."""
        nuisance = self.weighted_nuisance
        return np.asarray(np.linalg.qr(np.vstack([nuisance, np.eye(nuisance.shape[1])]))[0])

    def left(self, theta: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Weighted errors without what the sensors explain, and the sensors' numbers in standard deviations."""
        return self.without_sensors(self.errors(theta))

    def without_sensors(self, errors: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The same of any weighted errors."""
        nuisance = self.weighted_nuisance
        normal = nuisance.T @ nuisance + np.eye(nuisance.shape[1])
        numbers = np.linalg.solve(normal, nuisance.T @ errors)
        return errors - nuisance @ numbers, numbers


def projected(q: np.ndarray, values: np.ndarray) -> np.ndarray:
    """(I - Q Q') of errors, or of the columns of a Jacobian, with zeros in the place of the priors' own errors."""
    size = values.shape[0]
    whole = -q @ (q[:size].T @ values)
    whole[:size] += values
    return np.asarray(whole)


def make_problem(experiment: Experiment, observed: Sequence[Observed], free: Sequence[str]) -> Problem:
    """The problem at its start, weighted by each output's own noise.

    Raises:
        UserError: a free parameter without a declared value, or a plant that diverges on the records.
    """
    start: dict[str, float] = {}
    defaults = {item.name: item.default for item in fields(experiment.plant.Parameters)}
    for name in free:
        value = experiment.values.get(name, experiment.values.get(_plain(name), defaults.get(name)))
        if value is None:
            raise UserError(f"{experiment.path}: {name} is free and has no declared value; set it in [plant.set]")
        start[name] = value
    stack = [values for item in observed for values in item.measured.values()]
    noises = _noises(observed)
    weights = [
        np.full(values.size, 1.0 / noises[item.of, name]) for item in observed for name, values in item.measured.items()
    ]
    measured = np.concatenate(stack)
    problem = Problem(
        experiment, observed, list(free), start, np.concatenate(weights), measured, np.zeros((measured.size, 0)), []
    )
    problem.describe_sensors(np.zeros(len(start)))
    return problem


def _noises(observed: Sequence[Observed]) -> dict[tuple[Record, str], float]:
    """The noise of each output of each record, over all of its windows."""
    squares: dict[tuple[Record, str], list[float]] = {}
    for item in observed:
        for name, values in item.measured.items():
            squares.setdefault((item.of, name), []).append(noise_of(values) ** 2)
    return {key: float(np.sqrt(np.mean(each))) for key, each in squares.items()}


def noise_of(values: np.ndarray) -> float:
    """Standard deviation of the noise of a series, from its second differences, which a slow signal lacks."""
    second = np.diff(values, 2)
    second = second[np.isfinite(second)]
    return max(float(np.sqrt(np.mean(second**2) / 6.0)), 1e-9 * float(np.nanmax(np.abs(values))), 1e-12)
