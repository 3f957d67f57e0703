"""The search for gains from one seed: everywhere, then along the constraints, then on plant samples.

1. everywhere: the given starts, then optuna's TPE sampler. Margins come first; a point that does not keep them is
   not run.
2. along the constraints: COBYQA (`workbench.tune.refine`) on the declared machine, from the best and from others
   that lie apart from it, until its share of the trials is spent.
3. on plant samples, where there are any: COBYQA again, from the best of the declared machine.

A search depends on nothing but its seed. What was tried is kept by its point, so that one that was killed goes the same
way again without running anything twice.
"""

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Literal
from warnings import catch_warnings, simplefilter

import numpy as np
import optuna
from optuna.distributions import BaseDistribution, FloatDistribution
from optuna.samplers import TPESampler
from optuna.trial import FrozenTrial, TrialState, create_trial

from workbench.tune.evaluator import SEARCHED, Evaluator
from workbench.tune.objective import Score
from workbench.tune.refine import descend
from workbench.tune.space import Dimension, Point
from workbench.tune.trials import ON_DRAWS, Trial, key_of

BATCH = 4
"""Points that the sampler is asked for at once."""

STARTUP = 12
"""Points at random before the sampler learns."""

EVERYWHERE, ON_SAMPLES = 0.3, 0.4
"""Shares of the trials of the first and of the last stage; the second has the rest."""

FIRST_RADIUS, NEXT_RADIUS = 0.1, 0.03
"""Of a descent from a point of another stage, and from one where a descent has ended; shares of the ranges."""

APART = 0.15
"""Share of the ranges by which another start of a descent is away from those before."""

NO_GAIN = 1e-4
"""A descent from the best that gains less than this share is the last."""

Level = Literal["screened", "declared", "draws"]
Keep = Callable[[str, Trial], None]


class Search:
    """One search. `known` are trials of it that were run before, by `key_of`; `keep` is told of every new one,
    `made` that there is one more."""

    def __init__(
        self, evaluator: Evaluator, seed: int, known: Mapping[str, Trial], keep: Keep, made: Callable[[], None]
    ) -> None:
        self.evaluator, self.seed = evaluator, seed
        self.dimensions = evaluator.task.dimensions
        self.trials: list[Trial] = []
        self._known, self._keep, self._made = dict(known), keep, made
        self._by_key: dict[str, Trial] = {}

    def run(self, starts: Sequence[Point]) -> list[Trial]:
        """All trials, in order: at most as many as [tune] allows."""
        table = self.evaluator.objective.table
        whole = max(table.trials, 1)
        fewest = 2 * len(self.dimensions) + 3  # of which COBYQA makes something
        last = round(ON_SAMPLES * whole) if table.draws else 0
        first = max(round(EVERYWHERE * whole), min(len(starts), whole - last), 1)
        if whole - last - first < fewest:
            first = whole - last
        self._everywhere(starts, first)
        self._along(whole - last)
        if table.draws:
            self._on_samples(whole, fewest)
        return self.trials

    # --- the stages ---

    def _everywhere(self, starts: Sequence[Point], count: int) -> None:
        distributions = {
            each.name: FloatDistribution(each.low, each.high, log=each.logarithmic) for each in self.dimensions
        }
        asked = 0
        while asked < count:
            numbers = range(asked, min(asked + BATCH, count))
            for point in _asked(self.trials, numbers, self.dimensions, distributions, starts, self.seed):
                self._tried(point, "screened")
            asked = numbers.stop

    def _along(self, until: int) -> None:
        """Descents on the declared machine, from the best, then from starts apart, until so many trials are made."""
        sources = sorted(self.trials, key=_rank)
        used: list[np.ndarray] = []
        while len(self.trials) < until:
            place = next((i for i, each in enumerate(sources) if each.feasible and self._is_apart(each, used)), None)
            if not used:
                place = 0
            before, made = self._best("declared"), len(self.trials)
            start = sources.pop(place) if place is not None else self._least()
            radius = FIRST_RADIUS if place is not None else NEXT_RADIUS
            used.append(self._shares(start.point))
            self._descend(start.point, "declared", radius, until - len(self.trials))
            after = self._best("declared")
            used.append(self._shares(self._least().point))
            if place is None and (after > before * (1.0 - NO_GAIN) or len(self.trials) == made):
                return

    def _on_samples(self, until: int, fewest: int) -> None:
        """On the plant samples: a descent, or where that has too few trials the best of the declared one."""
        if until - len(self.trials) < fewest:
            for each in sorted(self.trials, key=_rank)[: until - len(self.trials)]:
                self._tried(each.point, "draws")
            return
        self._descend(self._least().point, "draws", FIRST_RADIUS, until - len(self.trials))

    def _descend(self, start: Point, level: Level, radius: float, count: int) -> None:
        def tried(shares: np.ndarray) -> tuple[float, Mapping[str, float]]:
            point = {each.name: each.at(float(share)) for each, share in zip(self.dimensions, shares, strict=True)}
            trial = self._tried(point, level)
            return trial.value, trial.violations

        descend(tried, self._shares(start), radius, count)

    # --- trials ---

    def _tried(self, point: Point, level: Level) -> Trial:
        """The trial of a point: known, or run now."""
        draws = self.evaluator.objective.table.draws if level == "draws" else 0
        key = key_of(point, draws, level)
        alike = self._by_key.get(key) or self._by_key.get(key_of(point, draws, "screened"))
        if alike is not None and (key in self._by_key or alike.feasible):
            return alike
        best = self._best(level)
        trial = self._known.get(key) or self._run(point, level, draws, key)
        if self._wants_rest(trial, best):
            trial = self._rested(trial, key)
        self._by_key[key] = trial
        self.trials.append(trial)
        self._made()
        return trial

    def _run(self, point: Point, level: Level, draws: int, key: str) -> Trial:
        judge = {
            "screened": self.evaluator.screened,
            "declared": self.evaluator.declared,
            "draws": self.evaluator.on_draws,
        }
        trial = _trial(point, judge[level](point), draws, self.seed)
        self._keep(key, trial)
        return trial

    def _wants_rest(self, trial: Trial, best: float) -> bool:
        """Whether a trial would be the best, and has not been seen to rest on the draws."""
        table = self.evaluator.objective.table
        unseen = ON_DRAWS not in trial.violations
        return bool(trial.draws) and table.constraints.limit_cycle and unseen and trial.feasible and trial.value < best

    def _rested(self, trial: Trial, key: str) -> Trial:
        table = self.evaluator.objective.table
        share = self.evaluator.hunting(trial.point, range(table.draws), SEARCHED)
        beyond = {**trial.violations, ON_DRAWS: share - (1.0 - table.quantile) - 1e-9}
        trial = Trial(**{**vars(trial), "violations": beyond})
        self._keep(key, trial)
        return trial

    def _best(self, level: Level) -> float:
        draws = self.evaluator.objective.table.draws if level == "draws" else 0
        return min((each.value for each in self.trials if each.draws == draws and each.feasible), default=math.inf)

    def _least(self) -> Trial:
        """The best trial on the declared machine; where none keeps the constraints the one that is nearest to it."""
        return min((each for each in self.trials if not each.draws), key=_rank)

    def _shares(self, point: Point) -> np.ndarray:
        return np.array([each.share(point[each.name]) for each in self.dimensions])

    def _is_apart(self, trial: Trial, used: Sequence[np.ndarray]) -> bool:
        own = self._shares(trial.point)
        return all(float(np.max(np.abs(own - other))) >= APART for other in used)


def _rank(trial: Trial) -> tuple[float, float]:
    """Trials in order: by how far they are beyond their constraints, then by value."""
    return sum(max(beyond, 0.0) for beyond in trial.violations.values()), trial.value


def _trial(point: Point, score: Score, draws: int, seed: int) -> Trial:
    return Trial(
        point=dict(point),
        value=score.value,
        nominal=score.nominal,
        violations=dict(score.violations),
        gain_margin_dB=score.margins.gain_dB,
        phase_margin_deg=score.margins.phase_deg,
        stable=score.margins.stable,
        draws=draws,
        seed=seed,
    )


def _asked(
    done: Sequence[Trial],
    numbers: range,
    dimensions: Sequence[Dimension],
    distributions: Mapping[str, FloatDistribution],
    starts: Sequence[Point],
    seed: int,
) -> list[dict[str, float]]:
    """The points of these numbers; the sampler knows the trials that are `done`, and what it has just asked for."""
    points = []
    optuna.logging.set_verbosity(optuna.logging.ERROR)
    with catch_warnings():
        simplefilter("ignore", optuna.exceptions.ExperimentalWarning)
        memory = optuna.create_study()
        memory.add_trials([as_optuna(each, distributions) for each in done])
        for number in numbers:
            own = int(np.random.default_rng([seed, number]).integers(2**31))
            memory.sampler = TPESampler(seed=own, n_startup_trials=STARTUP, multivariate=True)
            if number < len(starts):
                memory.enqueue_trial(dict(starts[number]))
            asked = memory.ask(dict(distributions)).params
            points.append({each.name: each.shortened(asked[each.name]) for each in dimensions})
    return points


def distributions_of(dimensions: Sequence[Dimension]) -> dict[str, FloatDistribution]:
    """What is tuned as optuna knows it."""
    return {each.name: FloatDistribution(each.low, each.high, log=each.logarithmic) for each in dimensions}


def as_optuna(trial: Trial, distributions: Mapping[str, BaseDistribution]) -> FrozenTrial:
    """A trial as optuna knows them."""
    return create_trial(
        state=TrialState.COMPLETE,
        value=trial.value,
        params=dict(trial.point),
        distributions=dict(distributions),
        constraints=dict(trial.violations),
    )
