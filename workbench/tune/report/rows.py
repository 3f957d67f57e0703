"""What became of each controller of a tuning, as numbers: the rows of results.csv, and what tables and words take."""

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Literal, Protocol

from workbench.linear.open_loop import Margins
from workbench.metrics.registry import names_along
from workbench.study.resolve import ParsedCase
from workbench.tune.objective import RunMetrics, Score
from workbench.tune.result import TUNED, ControllerTuning, Quantile, Tuning, infeasible
from workbench.tune.schema import tune_table
from workbench.tune.space import RPM, Dimension
from workbench.tune.trials import Trial

AT_AN_END = 0.01
"""A gain within this share of its range from an end stands at that end; of the range's logarithm where it has one."""

NEAR = 0.05
"""A constraint within this share of what is asked is one that the gains run into."""

When = Literal["before", "after"]
Basis = Literal["declared", "searched", "fresh"]
End = Literal["", "lower", "upper"]


def basis_of(tuning: Tuning) -> Basis:
    """On which machines controllers are compared: draws that the search has not seen where there are any."""
    table = tune_table(tuning.study)
    if not table.draws:
        return "declared"
    return "fresh" if table.fresh_draws else "searched"


def objective_of(tuned: ControllerTuning, when: When, basis: Basis) -> Quantile | None:
    """The objective on the declared machine, or its quantile on draws; None where there is none."""
    if basis == "declared":
        score = tuned.start if when == "before" else tuned.score
        return None if score is None else Quantile(score.nominal, score.nominal, score.nominal, 0)
    quantiles = tuned.on_fresh if basis == "fresh" else tuned.on_searched
    return quantiles.get("start" if when == "before" else "tuned")


def case_labels(cases: Sequence[ParsedCase]) -> list[str]:
    """What tells the cases of a controller apart, in words; "" where there is one."""
    columns = [parsed.case.columns for parsed in cases]
    differing = [name for name in columns[0] if len({repr(each.get(name)) for each in columns}) > 1]
    labels = ["_".join(dict.fromkeys(str(each.get(name)) for name in differing)) for each in columns]
    alike = len(set(labels)) < len(labels)
    return [f"{label}_{i + 1}" if alike else label for i, label in enumerate(labels)]


def broken(score: Score) -> list[str]:
    """The constraints that gains break."""
    return [name for name, beyond in score.violations.items() if beyond > 0.0]


def end_of(dimension: Dimension, value: float) -> End:
    """At which end of its range a gain stands, "" where it stands between them."""
    low, high, here = dimension.low, dimension.high, value
    if dimension.logarithmic:
        low, high, here = math.log(low), math.log(high), math.log(here)
    share = (here - low) / (high - low)
    return "lower" if share <= AT_AN_END else "upper" if share >= 1.0 - AT_AN_END else ""


def active(tuned: ControllerTuning) -> dict[str, int | None]:
    """The constraints that hold a controller back, with how many trials would be better and break it.

    None of a constraint that no better trial breaks, and that the tuned gains stand near to.
    """
    if tuned.score is None:
        return {}
    asked = tune_table(tuned.task.study).constraints
    limits = {"saturation": asked.saturated, "gain margin": 1.0, "phase margin": 1.0}
    near = {
        name: None for name, limit in limits.items() if limit and -NEAR * limit <= tuned.score.violations[name] <= 0.0
    }
    return near | dict(_better_but_broken(tuned, tuned.score.nominal))


def _better_but_broken(tuned: ControllerTuning, best: float) -> Mapping[str, int]:
    better = [trial for trial in tuned.trials if trial.nominal < best]
    counts = Counter(name for trial in better for name, beyond in trial.violations.items() if beyond > 0.0)
    return {name: count for name, count in counts.items() if count}


class Row(Protocol):
    """A row of a table for programs."""

    @property
    def columns(self) -> Mapping[str, object]:
        """Its values by column, in order; None where a column does not apply."""


@dataclass(frozen=True)
class Reached:
    """What gains reach on the declared machine: the smallest margins, and the metrics of each case by its label."""

    margins: Margins
    cases: Mapping[str, Mapping[str, float | None]]

    def columns(self, when: When) -> dict[str, float | None]:
        """As columns of results.csv."""
        margins = {f"gain_margin_dB_{when}": self.margins.gain_dB, f"phase_margin_deg_{when}": self.margins.phase_deg}
        metrics = {
            metric_column(name, label, when): value
            for label, values in self.cases.items()
            for name, value in values.items()
        }
        return {**margins, **metrics}


@dataclass(frozen=True)
class ResultRow:
    """A controller in results.csv (SI): objectives, margins, metrics of each case, quantiles on plant samples.

    On samples `objective` and `objective_before` are quantiles over those of the search, and `declared` holds J of both
    on the declared machine; None where there are no samples. `searched` and `fresh` have the quantiles of the "start"
    and of the "tuned" gains.
    """

    controller: str
    at: Mapping[str, object]
    outcome: str
    objective_before: float | None
    objective: float | None
    breaks_before: Sequence[str]
    trials: int
    best_trial: int | None
    seeds_differ: float | None
    declared: tuple[float, float | None] | None
    searched: Mapping[str, Quantile]
    fresh: Mapping[str, Quantile]
    before: Reached
    after: Reached | None

    @property
    def columns(self) -> dict[str, object]:
        """Its values by column of results.csv."""
        declared = {} if self.declared is None else dict(zip(_DECLARED, self.declared, strict=True))
        quantiles = {
            f"{when}_on_{kind}_{key}": value
            for kind, known in (("searched", self.searched), ("fresh", self.fresh))
            for when, each in known.items()
            for key, value in (("value", each.value), ("low", each.low), ("high", each.high))
        }
        return {
            "controller": self.controller,
            **self.at,
            "outcome": self.outcome,
            "objective_before": self.objective_before,
            "objective": self.objective,
            "breaks_before": ", ".join(self.breaks_before),
            "trials": self.trials,
            "best_trial": self.best_trial,
            "seeds_differ": self.seeds_differ,
            **declared,
            **quantiles,
            **self.before.columns("before"),
            **({} if self.after is None else self.after.columns("after")),
        }


_DECLARED = ("declared_before", "declared")


def result_row(tuned: ControllerTuning) -> ResultRow:
    """The row of a controller in results.csv."""
    draws = bool(tune_table(tuned.task.study).draws)
    basis: Basis = "searched" if draws else "declared"
    before, after = objective_of(tuned, "before", basis), objective_of(tuned, "after", basis)
    return ResultRow(
        controller=tuned.task.name,
        at=tuned.task.at,
        outcome=infeasible(tuned) if tuned.score is None else TUNED,
        objective_before=None if before is None else before.value,
        objective=None if after is None else after.value,
        breaks_before=broken(tuned.start),
        trials=len(tuned.trials),
        best_trial=None if tuned.best is None else tuned.number,
        seeds_differ=tuned.seeds_differ,
        declared=(tuned.start.nominal, None if tuned.score is None else tuned.score.nominal) if draws else None,
        searched=tuned.on_searched,
        fresh=tuned.on_fresh,
        before=_reached(tuned, tuned.start),
        after=None if tuned.score is None else _reached(tuned, tuned.score),
    )


def _reached(tuned: ControllerTuning, score: Score) -> Reached:
    labels = case_labels(tuned.task.cases)
    called = names_along(tuned.task.axis)
    metrics = [{called[name]: value for name, value in _metrics(run).items()} for run in score.runs]
    return Reached(score.margins, dict(zip(labels, metrics, strict=True)))


def metric_column(name: str, label: str, when: str) -> str:
    """The column of results.csv that holds a metric of a case."""
    return "_".join(part for part in (name, label, when) if part)


def _metrics(run: RunMetrics) -> Mapping[str, float | None]:
    """Metrics of a run; none of one that failed."""
    return dict.fromkeys(run.metrics) if run.broken else run.metrics


@dataclass(frozen=True)
class TrialRow:
    """A trial in trials.csv: whose it is, its number, and whether it could be chosen."""

    controller: str
    at: Mapping[str, object]
    number: int
    trial: Trial
    candidate: bool

    @property
    def columns(self) -> dict[str, object]:
        """Its values by column of trials.csv (SI; rpm in rpm)."""
        trial = self.trial
        return {
            "controller": self.controller,
            **self.at,
            "trial": self.number,
            "seed": trial.seed,
            "value": trial.value,
            "draws": trial.draws,
            "feasible": trial.feasible,
            "candidate": self.candidate,
            "breaks": ", ".join(name for name, beyond in trial.violations.items() if beyond > 0.0),
            "nominal": trial.nominal,
            "gain_margin_dB": trial.gain_margin_dB,
            "phase_margin_deg": trial.phase_margin_deg,
            **{name: value * 30.0 / math.pi if name == RPM else value for name, value in trial.point.items()},
        }


def trial_rows(tuned: ControllerTuning) -> list[TrialRow]:
    """A row a trial of a controller."""
    draws = tune_table(tuned.task.study).draws
    return [
        TrialRow(tuned.task.name, tuned.task.at, number, trial, trial.feasible and trial.draws == draws)
        for number, trial in enumerate(tuned.trials)
    ]
