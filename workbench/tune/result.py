"""The result of a tuning: of each controller its gains, and what they reach beside those of the study."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from workbench.metrics.statistics import quantile, quantile_interval
from workbench.study.study import Study
from workbench.tune.classic import StartingPoint
from workbench.tune.objective import Score, finite
from workbench.tune.schema import tune_table
from workbench.tune.space import Point
from workbench.tune.task import Task, in_user_units
from workbench.tune.trials import Trial, identity_of

TUNED = "tuned"
"""The outcome of a controller with gains that keep all constraints."""


@dataclass(frozen=True)
class Quantile:
    """A quantile over draws, with the interval in which that of all machines is; `high` is infinite where so few draws
    do not bound it.
    """

    value: float
    low: float
    high: float
    draws: int

    def to_json(self) -> dict[str, float | int | None]:
        """As JSON holds it: what is infinite is None."""
        return {"value": finite(self.value), "low": finite(self.low), "high": finite(self.high), "draws": self.draws}


@dataclass(frozen=True, eq=False)
class ControllerTuning:
    """What became of one controller at one place. `best` is None where no trial keeps the constraints.

    `start` is the score of the study's own gains on the declared machine. `trials` are those of all seeds, in order;
    `number` is that of the best. `seeds` holds the best objective that each seed found, None where it found no gains.
    `on_searched` and `on_fresh` hold the quantiles of the "start" and of the "tuned" gains.
    """

    task: Task
    trials: Sequence[Trial]
    start: Score
    best: Point | None
    score: Score | None
    number: int
    seeds: Mapping[int, float | None]
    on_searched: Mapping[str, Quantile]
    on_fresh: Mapping[str, Quantile]

    @property
    def seeds_differ(self) -> float | None:
        """By which share the best objective of the worst seed is above that of the best; None of a single seed.

        Infinite where a seed found no gains, or where the best is 0 and another is not.
        """
        values = list(self.seeds.values())
        known = [value for value in values if value is not None]
        if len(values) < 2 or not known:
            return None
        if len(known) < len(values):
            return float("inf")
        low, high = min(known), max(known)
        return 0.0 if low == high else high / low - 1.0 if low else float("inf")

    def to_json(self) -> dict[str, object]:
        """What was reached, as JSON holds it: what is infinite is None, settings stand with their units."""
        return {
            "controller": self.task.name,
            **self.task.at,
            "outcome": TUNED if self.score is not None else infeasible(self),
            "settings": None if self.best is None else dict(in_user_units(self.task, self.best)),
            "before": self.start.to_json(),
            "after": None if self.score is None else self.score.to_json(),
            "on_searched_draws": {when: each.to_json() for when, each in self.on_searched.items()},
            "on_fresh_draws": {when: each.to_json() for when, each in self.on_fresh.items()},
            "trials": len(self.trials),
            "objective_of_each_seed": {str(seed): finite(value) for seed, value in self.seeds.items()},
        }


def interval(values: Sequence[float], share: float) -> Quantile:
    """A quantile of draws with its interval."""
    return Quantile(quantile(values, share), *quantile_interval(values, share), len(values))


def infeasible(tuned: ControllerTuning) -> str:
    """Which constraint all trials fail, and how near the nearest comes; else how many fail which."""
    broken = Counter(name for trial in tuned.trials for name, beyond in trial.violations.items() if beyond > 0.0)
    if not broken:
        return "every trial that keeps the constraints fails on too many of the drawn machines"
    many, name = len(tuned.trials), max(broken, key=lambda each: broken[each])
    if broken[name] < many:
        told = ", ".join(f"{each} in {count}" for each, count in broken.most_common())
        return f"no trial keeps all constraints; of {many} trials broken: {told}"
    closest = min(
        (trial for trial in tuned.trials if name in trial.violations), key=lambda trial: trial.violations[name]
    )
    asked = tune_table(tuned.task.study).constraints
    reached = {
        "gain margin": f"{closest.gain_margin_dB:.1f} dB, {asked.gain_margin_dB:g} dB are asked for",
        "phase margin": f"{closest.phase_margin_deg:.1f} deg, {asked.phase_margin_deg:g} deg are asked for",
        "saturation": f"{closest.violations[name] + asked.saturated:.0%} of the time at the limit, "
        f"{asked.saturated:.0%} are allowed",
    }
    if "margin" in name and not closest.stable:
        reached[name] = "a loop that is not stable"
    nearest = f"; the nearest has {reached[name]}" if name in reached else ""
    return f"no trial keeps all constraints; most often broken: {name}, in {broken[name]} of {many} trials{nearest}"


@dataclass(frozen=True)
class ClassicTuning:
    """A classic tuning, and its score by the same objective."""

    point: StartingPoint
    score: Score


@dataclass(frozen=True, eq=False)
class Tuning:
    """What became of all controllers of a study, and classic tunings of a PID beside them."""

    study: Study
    tuned: Sequence[ControllerTuning]
    classics: Sequence[ClassicTuning]

    def to_json(self) -> dict[str, object]:
        """How it was made, and under `tunings` what each controller reached, as JSON holds it."""
        return {**self.provenance, "tunings": [each.to_json() for each in self.tuned]}

    @property
    def provenance(self) -> dict[str, object]:
        """How it was made, as JSON holds it: all that the gains depend on."""
        table, uncertainty = tune_table(self.study), self.study.file.uncertainty
        controllers = list(dict.fromkeys(each.task.name for each in self.tuned))
        seeds: dict[str, object] = {"search": list(range(table.seed, table.seed + table.seeds))}
        return {
            "title": self.study.file.title,
            **identity_of(self.study, controllers),
            "controllers": controllers,
            "trials": table.trials,
            "seeds": seeds if uncertainty is None else {**seeds, "draws": uncertainty.seed},
        }
