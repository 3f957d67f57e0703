"""What tuning asks of a controller: figures of its runs over those of a yardstick, and constraints that it keeps.

    J = sum over figures k of  w_k * mean over cases of  |f_k| / |f_k of the yardstick in that case|

J = 1 is as good as the yardstick, a controller of the study with the gains that stand there. On machines that are drawn
J is taken on each, over the yardstick's figures on the declared machine, and its quantile is what counts.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any

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
class Ran:
    """What one run leaves: wanted figures by column (None: does not apply), its outcome, share of time saturated."""

    figures: Mapping[str, float | None]
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

    `margins` are the smallest over the cases. `value` is what is made small: J, or its quantile over draws, of which
    `on_draws` holds those of all draws. `ran` is empty of a point that was not run, since its margins are too small.
    """

    nominal: float
    ran: Sequence[Ran]
    violations: Mapping[str, float]
    margins: Margins
    value: float
    on_draws: Sequence[float] = field(default_factory=tuple)

    @property
    def feasible(self) -> bool:
        """Whether all constraints are kept."""
        return all(beyond <= 0.0 for beyond in self.violations.values())


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
    found = [margins(case.setup, margin_speed(case, constraints)) for case in cases]
    worst = [one for one in found if not one.stable] or found
    by_gain = min(worst, key=lambda one: one.gain_dB)
    by_phase = min(worst, key=lambda one: one.phase_deg)
    return replace(by_phase, gain_dB=by_gain.gain_dB, gain_frequency=by_gain.gain_frequency)


def run(resolved: Resolved, columns: Sequence[str]) -> Ran:
    """Simulate a case and take what is asked of it."""
    setup = resolved.setup
    done = simulate(setup)
    judged = [*columns, "limit_cycle"] if rests(resolved) else columns
    figures = evaluated(resolved, done, judged)
    last = done.time.size - 1  # 0 of a run that diverges at once
    start = min(first_sample(done.time, resolved.transient), last) if last else 0
    limit = float(setup.plant.command_limit(setup.parameters))
    wanted = {name: figures[name] for name in columns}
    return Ran(
        {name: value if isinstance(value, float) else None for name, value in wanted.items()},
        done.outcome,
        float(np.mean(np.abs(done.command[start:]) >= limit)),
        None if figures["limit_cycle"] is None else figures["limit_cycle"] in HUNTING,
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
    held_cases: dict[tuple[Any, ...], Resolved] = {}
    for case in cases:
        machine = (case.setup.parameters, case.setup.rotation_speed)
        held_cases.setdefault(machine, held(case, level, constraints.hold_duration))
    return list(held_cases.values())


class Goal:
    """The objective of a study's [tune] over its cases, and its constraints."""

    def __init__(self, table: TuneTable, yardstick: Sequence[Ran]) -> None:
        """`yardstick`: what the yardstick does in each case on the declared machine.

        Raises:
            UserError: a figure that is weighed, and that the yardstick has in no case, or has as 0.
        """
        self.table = table
        self.weights = table.objective.used
        self.columns = tuple(self.weights)
        self.units = [dict(one.figures) for one in yardstick]
        for column in self.columns:
            known = [abs(value) for one in self.units if (value := one[column]) is not None]
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

    def objective(self, ran: Sequence[Ran]) -> float:
        """J of runs of all cases on one machine; infinite where one of them failed."""
        if any(one.broken for one in ran):
            return math.inf
        total = 0.0
        for column, weight in self.weights.items():
            pairs = [(one.figures[column], unit[column]) for one, unit in zip(ran, self.units, strict=True)]
            ratios = [abs((figure or 0.0) / unit) for figure, unit in pairs if unit is not None]
            total += weight * float(np.mean(ratios))
        return total

    def violations(self, found: Margins, ran: Sequence[Ran], held: Sequence[Ran]) -> dict[str, float]:
        """By constraint, how far beyond its limit a point is, as a share of the limit (<= 0: kept)."""
        asked = self.table.constraints
        beyond = {
            "run to its end": 1.0 if any(one.broken for one in (*ran, *held)) else -1.0,
            "saturation": max((one.saturated for one in ran), default=0.0) - asked.saturated,
            "stable loop": -1.0 if found.stable else 1.0,
            "gain margin": _short(found.gain_dB, asked.gain_margin_dB),
            "phase margin": _short(found.phase_deg, asked.phase_margin_deg),
        }
        if asked.limit_cycle:
            beyond["limit cycle"] = 1.0 if any(one.hunting for one in (*ran, *held)) else -1.0
        return beyond

    def on_machine(self, ran: Sequence[Ran]) -> float:
        """J on a drawn machine: infinite also where it saturates for too long, or hunts where a reference rests."""
        asked = self.table.constraints
        if any(one.saturated > asked.saturated or (asked.limit_cycle and one.hunting) for one in ran):
            return math.inf
        return self.objective(ran)


def _short(value: float, asked: float) -> float:
    """By which share of what is asked a margin is short; that of a loop that is not stable is negative."""
    return float(np.clip((asked - value) / asked, -1.0, FARTHEST)) if asked else -1.0
