"""Polish of a controller's settings: local descent along the exact gradient of the closed loop, within bounds.

    problem = PolishProblem(cases, controller, settings, belief, {"kp": Bound(50.0, 2000.0, logarithmic=True)})
    polished = polish(problem)               # settings, objective before and after, why it stopped

The objective is J = sum over the cases of scale_i rms_i, with rms_i the root of the mean square (m) of reference -
position over the case's window and scale_i (1/m) its weight over its yardstick. It is that of ideal sensors and of
fixed steps: whoever takes the result evaluates it by `workbench.simulation` first.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np
from scipy.optimize import minimize

from controllers.interface import Controller
from controllers.settings import settings_of
from plants.equation import to_array
from workbench.errors import UserError, nearest
from workbench.simulation.simulate import Loop, Setup
from workbench.tune.sensitivity import ClosedLoop, closed_loop

DIFFERENCE = 1e-4
"""Step of the central differences of the gains by the settings, as a share of the bounds' width."""

FIRST_STEP = 0.1
"""Length of the first step, as a share of the bounds' width: a polish looks around its start."""

SMALLEST_GAIN, SMALLEST_SLOPE = 1e-3, 1e-2
"""It stops where a step gains less than this share of what the first slope promised over `FIRST_STEP`, or where the
slope has fallen to this share of the first one."""

WALL = 10.0
"""What a run that diverges counts, in values of the start."""


class Bound(NamedTuple):
    """Where a setting may go (SI), and whether its logarithm is what is evenly searched."""

    low: float
    high: float
    logarithmic: bool


@dataclass(frozen=True)
class PolishCase:
    """One run, the window of samples `first` to `last` of its error, and what its rms is multiplied by (1/m)."""

    setup: Setup
    first: int
    last: int
    scale: float


@dataclass(frozen=True)
class PolishProblem:
    """What is polished: a controller's `settings`, those of them that `bounds` names, over the cases.

    The controllers of the cases' setups do not matter: `controller` takes their place.
    """

    cases: tuple[PolishCase, ...]
    controller: Controller
    settings: Any
    belief: Any
    bounds: Mapping[str, Bound]


@dataclass(frozen=True)
class Polished:
    """The best settings met, never worse in the objective than the start, and why the search ended."""

    settings: Any
    start_value: float
    value: float
    gradient_evaluations: int
    reason: str


class _SpentError(Exception):
    """No evaluation is left."""


def polish(problem: PolishProblem, evaluations: int = 15) -> Polished:
    """Descend from the problem's settings with at most `evaluations` values and gradients (L-BFGS-B).

    Raises:
        UserError: a case that has no gradient, an unknown setting, bounds that do not serve, settings that the
            controller refuses.
    """
    search = _Search(problem, evaluations)
    start = point_of(problem)
    value, slope = search(start)
    if not np.isfinite(value):
        return search.ended("the run of the start diverges")
    steepness = float(np.linalg.norm(slope))
    if not np.isfinite(steepness):
        return search.ended("the objective has no gradient at the start")
    if steepness == 0.0:
        return search.ended("no setting moves the objective")
    search.unit, search.first = steepness / FIRST_STEP, (value, slope)
    try:
        result = minimize(
            search.scaled,
            start,
            jac=True,
            method="L-BFGS-B",
            bounds=[(0.0, 1.0)] * start.size,
            options={"ftol": SMALLEST_GAIN * FIRST_STEP**2, "gtol": SMALLEST_SLOPE * FIRST_STEP},
        )
    except _SpentError:
        return search.ended(f"stopped after {evaluations} evaluations, as asked")
    if result.success:
        return search.ended("a further step gains next to nothing")
    return search.ended("no step along the gradient lowers the objective any more")


class _Search:
    """The objective over the unit cube of the bounds; it counts evaluations and keeps the best."""

    def __init__(self, problem: PolishProblem, evaluations: int) -> None:
        _check(problem)
        if evaluations < 1:
            raise UserError(f"{evaluations} evaluations, expected at least 1")
        self.problem = problem
        self.controller = problem.controller
        try:
            if self.controller.choose is not None:
                self.controller = self.controller.choose(problem.settings, problem.belief)
            self.loops = [self._loop(place, case) for place, case in enumerate(problem.cases)]
        except ValueError as error:
            raise UserError(f"{problem.controller.name}: {error}") from None
        self.allowed, self.spent = evaluations, 0
        self.unit = 1.0
        self.first: tuple[float, np.ndarray] | None = None
        self.start_value = self.best_value = np.inf
        self.best = problem.settings

    def _loop(self, place: int, case: PolishCase) -> ClosedLoop:
        gains = self.controller.design(self.problem.settings, self.problem.belief, case.setup.sample_time)
        setup = replace(case.setup, loop=Loop(self.controller, gains))
        try:
            return closed_loop(setup, case.first, case.last)
        except UserError as error:
            raise UserError(f"case {place + 1}: {error}") from None

    def __call__(self, point: np.ndarray) -> tuple[float, np.ndarray]:
        """J and its gradient by the point, which lies in the unit cube; infinity where a run diverges.

        Raises:
            _SpentError: no evaluation is left.
        """
        if self.spent >= self.allowed:
            raise _SpentError
        self.spent += 1
        value, slope = self._evaluate(point)
        if self.spent == 1:
            self.start_value = self.best_value = value
        elif value < self.best_value:
            self.best_value, self.best = value, settings_at(self.problem, point)
        return value, slope

    def scaled(self, point: np.ndarray) -> tuple[float, np.ndarray]:
        """J over `unit`; a wall where a run diverges or no gradient is had."""
        value, slope = self.first or self(point)  # the descent begins where the first evaluation was
        self.first = None
        if not np.all(np.isfinite(slope)):
            return WALL * self.start_value / self.unit, np.zeros_like(point)
        return value / self.unit, slope / self.unit

    def _evaluate(self, point: np.ndarray) -> tuple[float, np.ndarray]:
        total, slope = 0.0, np.zeros_like(point)
        for case, loop in zip(self.problem.cases, self.loops, strict=True):
            try:
                gains, by_point = self._gains(point, case.setup.sample_time)
            except (ValueError, ArithmeticError):  # the controller refuses these settings
                return np.inf, np.full_like(point, np.nan)
            mean_square, by_gains = loop.value_and_gradient(gains)
            rms = np.sqrt(mean_square)
            total += case.scale * rms
            if rms > 0.0:
                slope = slope + case.scale / (2.0 * rms) * (by_gains @ by_point)
        return float(total), slope

    def _gains(self, point: np.ndarray, sample_time: float) -> tuple[np.ndarray, np.ndarray]:
        """The vector of gains at `point`, and its derivatives there, shape (gains, settings)."""

        def gains(at: np.ndarray) -> np.ndarray:
            return to_array(self.controller.design(settings_at(self.problem, at), self.problem.belief, sample_time))

        columns = []
        for i in range(point.size):
            below, above = point.copy(), point.copy()
            below[i], above[i] = max(point[i] - DIFFERENCE, 0.0), min(point[i] + DIFFERENCE, 1.0)
            columns.append((gains(above) - gains(below)) / (above[i] - below[i]))
        return gains(point), np.column_stack(columns)

    def ended(self, reason: str) -> Polished:
        """The best that was met."""
        return Polished(self.best, self.start_value, self.best_value, self.spent, reason)


def settings_at(problem: PolishProblem, point: np.ndarray) -> Any:
    """Settings at a point of the unit cube: 0 the lower bound of each setting, 1 the upper one."""
    values = {}
    for share, (name, bound) in zip(point, problem.bounds.items(), strict=True):
        if bound.logarithmic:
            value = bound.low * (bound.high / bound.low) ** share
        else:
            value = bound.low + share * (bound.high - bound.low)
        values[name] = float(min(max(value, bound.low), bound.high))
    return problem.settings._replace(**values)


def point_of(problem: PolishProblem) -> np.ndarray:
    """The point of the unit cube at which the problem's settings are."""
    shares = []
    for name, bound in problem.bounds.items():
        value = getattr(problem.settings, name)
        if bound.logarithmic:
            shares.append(np.log(value / bound.low) / np.log(bound.high / bound.low))
        else:
            shares.append((value - bound.low) / (bound.high - bound.low))
    return np.clip(np.array(shares), 0.0, 1.0)


def _check(problem: PolishProblem) -> None:
    """Refuses what cannot be polished.

    Raises:
        UserError: no case, an unknown setting or one that is a choice, bounds in disorder or without the start.
    """
    if not problem.cases or not problem.bounds:
        raise UserError("nothing to polish: expected at least one case and one setting with bounds")
    declared = settings_of(problem.controller.Settings)
    numbers = [name for name, item in declared.items() if item.unit]
    for name, bound in problem.bounds.items():
        if name not in numbers:
            raise UserError(f'{problem.controller.name} has no numeric setting "{name}"; {nearest(name, numbers)}')
        value = getattr(problem.settings, name)
        if not bound.low <= value <= bound.high or not bound.low < bound.high:
            raise UserError(f"{name} is {value:g}, expected a value within its bounds {bound.low:g} to {bound.high:g}")
        if bound.logarithmic and bound.low <= 0.0:
            raise UserError(f"{name}: bounds from {bound.low:g} have no logarithm; expected a lower one above 0")
