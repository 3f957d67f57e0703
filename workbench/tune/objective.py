"""What tuning asks of a controller: metrics of its runs over those of a reference controller, and constraints.

    J = sum over metrics k of  w_k * mean over cases of  |m_k| / |m_k of the reference controller in that case|

J = 1 is as good as the reference controller, one of the study with the gains that stand there. On plant samples J is
taken on each, over the reference controller's metrics on the declared machine, and its quantile is what counts.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from workbench.errors import UserError
from workbench.linear.open_loop import Margins, margins
from workbench.metrics.limit_cycle import HUNTING
from workbench.metrics.window import first_sample
from workbench.simulation.simulate import COMPLETED, TORQUE_LIMITED, simulate
from workbench.study.hold import HOLD_SHARE, held, largest_level
from workbench.study.resolve import Resolved
from workbench.study.run_on import evaluated
from workbench.tune.schema import ConstraintsTable, TuneTable

SLOW = 0.01
"""m/s at which margins are taken where no reference moves steadily and the study says nothing."""

NOTHING = 1e-9
"""m. An error below it is the solver's: nothing is measured by it."""

FARTHEST = 5.0
"""Shares by which a margin counts as short at most: an unstable loop may have none at all."""


@dataclass(frozen=True)
class RunMetrics:
    """What one run leaves: wanted metrics by column (None: does not apply), its outcome, share of time saturated, and
    whether it hunts where its reference rests (None: it does not rest).
    """

    metrics: Mapping[str, float | None]
    outcome: str
    saturated: float
    hunting: bool | None

    @property
    def broken(self) -> bool:
        """Whether the run failed; one whose motor cannot hold its speed is what it is, with any gains."""
        return self.outcome not in (COMPLETED, TORQUE_LIMITED)


@dataclass(frozen=True)
class Score:
    """Of one point: J on the declared machine, the run of each case, by constraint how far it is beyond (<= 0: kept).

    `margins` are the smallest over the cases. `value` is what is made small: J, or its quantile over plant samples, of
    which `on_samples` holds those of all. `runs` is empty of a point that was not run: its margins are too small.
    """

    nominal: float
    runs: Sequence[RunMetrics]
    violations: Mapping[str, float]
    margins: Margins
    value: float
    on_samples: Sequence[float] = field(default_factory=tuple)

    @property
    def feasible(self) -> bool:
        """Whether all constraints are kept."""
        return all(beyond <= 0.0 for beyond in self.violations.values())

    def to_json(self) -> dict[str, object]:
        """As JSON holds it: what is infinite is None."""
        return {
            "objective": finite(self.value),
            "objective_on_the_declared_machine": finite(self.nominal),
            "gain_margin_dB": finite(self.margins.gain_dB),
            "phase_margin_deg": finite(self.margins.phase_deg),
            "breaks": [name for name, beyond in self.violations.items() if beyond > 0.0],
        }


def finite(value: float | None) -> float | None:
    """A number that JSON can hold; None of any other."""
    return None if value is None or not math.isfinite(value) else float(value)


def fastest(resolved: Resolved) -> float:
    """The largest speed (m/s) that a case's reference asks for at a sample, jumps not counted."""
    setup = resolved.setup
    if setup.reference is None:
        return 0.0
    times = setup.sample_time * np.arange(round(setup.duration / setup.sample_time) + 1)
    return float(np.max(np.abs(setup.reference(times)[1])))


def margin_speed(resolved: Resolved, constraints: ConstraintsTable) -> float:
    """The speed (m/s) at which a case's loop is linearised."""
    return constraints.margin_speed or fastest(resolved) or SLOW


def margins_of(cases: Sequence[Resolved], constraints: ConstraintsTable) -> Margins:
    """The smallest margins over the cases; unstable if any of them is."""
    every = [margins(case.setup, margin_speed(case, constraints)) for case in cases]
    worst = [each for each in every if not each.stable] or every
    by_gain = min(worst, key=lambda each: each.gain_dB)
    by_phase = min(worst, key=lambda each: each.phase_deg)
    return replace(by_phase, gain_dB=by_gain.gain_dB, gain_frequency=by_gain.gain_frequency)


def run(resolved: Resolved, columns: Sequence[str]) -> RunMetrics:
    """Simulate a case and take what is asked of it."""
    setup = resolved.setup
    record = simulate(setup)
    wanted = [*columns, "limit_cycle"] if rests(resolved) else columns
    metrics = evaluated(resolved, record, wanted)
    last = record.time.size - 1  # 0 of a run that diverges at once
    start = min(first_sample(record.time, resolved.transient), last) if last else 0
    limit = float(setup.plant.command_limit(setup.parameters))
    values = {name: metrics[name] for name in columns}
    return RunMetrics(
        metrics={name: value if isinstance(value, float) else None for name, value in values.items()},
        outcome=record.outcome,
        saturated=float(np.mean(np.abs(record.command[start:]) >= limit)),
        hunting=None if metrics["limit_cycle"] is None else metrics["limit_cycle"] in HUNTING,
    )


def rests(resolved: Resolved) -> bool:
    """Whether the reference of a case holds still anywhere."""
    reference = resolved.setup.reference
    return reference is not None and bool(reference.dwells(resolved.setup.duration))


def hold(cases: Sequence[Resolved], constraints: ConstraintsTable) -> list[Resolved]:
    """The cases on which a limit cycle can be judged: those that rest, else each machine with a step that is held."""
    resting = [case for case in cases if rests(case)]
    if resting or not constraints.limit_cycle:
        return []
    level = constraints.hold_level or HOLD_SHARE * max(largest_level(case) for case in cases)
    held_cases: dict[tuple[object, ...], Resolved] = {}
    for case in cases:
        machine = (case.setup.parameters, case.setup.rotation_speed)
        held_cases.setdefault(machine, held(case, level, constraints.hold_duration))
    return list(held_cases.values())


class Objective:
    """The objective of a study's [tune] over its cases, and its constraints."""

    def __init__(self, table: TuneTable, reference: Sequence[RunMetrics]) -> None:
        """`reference`: what the reference controller does in each case on the declared machine.

        Raises:
            UserError: a metric that is weighed, and that the reference controller has in no case, or has as 0.
        """
        self.table = table
        self.weights = table.objective.used
        self.columns = tuple(self.weights)
        self.units = [dict(each.metrics) for each in reference]
        for column in self.columns:
            known = [abs(value) for each in self.units if (value := each[column]) is not None]
            if not known:
                raise UserError(
                    f"[tune.objective]: {column} does not apply to any of the cases; leave it out, or tune on others"
                )
            least = NOTHING if column.endswith("_m") else 0.0
            if min(known) <= least:
                raise UserError(
                    f"[tune.objective]: the yardstick's {column} is {min(known):.2g}, nothing by which another could "
                    "be measured; choose another yardstick, or other cases, or leave it out"
                )

    def value(self, runs: Sequence[RunMetrics]) -> float:
        """J of runs of all cases on one machine; infinite where one of them failed."""
        if any(each.broken for each in runs):
            return math.inf
        total = 0.0
        for column, weight in self.weights.items():
            pairs = [(each.metrics[column], unit[column]) for each, unit in zip(runs, self.units, strict=True)]
            ratios = [abs((metric or 0.0) / unit) for metric, unit in pairs if unit is not None]
            total += weight * float(np.mean(ratios))
        return total

    def violations(self, smallest: Margins, runs: Sequence[RunMetrics], held: Sequence[RunMetrics]) -> dict[str, float]:
        """By constraint, how far beyond its limit a point is, as a share of the limit (<= 0: kept)."""
        asked = self.table.constraints
        beyond = {
            "run to its end": 1.0 if any(each.broken for each in (*runs, *held)) else -1.0,
            "saturation": max((each.saturated for each in runs), default=0.0) - asked.saturated,
            "stable loop": -1.0 if smallest.stable else 1.0,
            "gain margin": _short(smallest.gain_dB, asked.gain_margin_dB),
            "phase margin": _short(smallest.phase_deg, asked.phase_margin_deg),
        }
        if asked.limit_cycle:
            beyond["limit cycle"] = 1.0 if any(each.hunting for each in (*runs, *held)) else -1.0
        return beyond

    def on_sample(self, runs: Sequence[RunMetrics]) -> float:
        """J on a plant sample: infinite also where it saturates for too long, or hunts where a reference rests."""
        asked = self.table.constraints
        if any(each.saturated > asked.saturated or (asked.limit_cycle and each.hunting) for each in runs):
            return math.inf
        return self.value(runs)


def _short(value: float, asked: float) -> float:
    """By which share of what is asked a margin is short; that of a loop that is not stable is negative."""
    return float(np.clip((asked - value) / asked, -1.0, FARTHEST)) if asked else -1.0
