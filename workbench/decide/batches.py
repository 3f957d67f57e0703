"""Candidates on plant samples: the runs of a decision, a row each."""

import functools
import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from typing import TypeAlias

import pandas as pd

from plants.equation import source_hash
from workbench.decide.plan import PROGRAM, Candidate, Plan, Stage, plan_decision
from workbench.decide.schema import ERRORS, MOTOR, POWERS, PUMP, REAL_SPEED
from workbench.errors import UserError
from workbench.metrics.evaluate import evaluate
from workbench.metrics.limit_cycle import HUNTING
from workbench.parallel.chunks import KilledError, enough, in_chunks
from workbench.parallel.cluster import check_version
from workbench.progress import Progress, silent
from workbench.simulation.simulate import COMPLETED, simulate
from workbench.study.hold import HOLD_SHARE, held
from workbench.study.resolve import Resolved
from workbench.study.run_on import evaluated
from workbench.study.study import Study

KEYS = ("controller", "rpm", "speed_m_per_s", "spread", "draw")
"""What a row is told from the others of its stage by."""

Key: TypeAlias = tuple[Stage, str, float, float, float, int]
"""What a run is told from all others by: its stage, and the values of `KEYS`."""


@dataclass(frozen=True)
class Batch:
    """A plant sample (number) at a spread, rotating at rpm: which controllers move on it at which speeds (m/s)."""

    stage: Stage
    rpm: float
    spread: float
    number: int
    speeds: dict[str, Sequence[float]]

    @property
    def runs(self) -> int:
        """How many runs it is, those of holds not counted."""
        return sum(map(len, self.speeds.values()))


@dataclass(frozen=True, slots=True)
class SampleRun:
    """A candidate on a plant sample (number): its `error` (m) and `power` (W) as [decide] chooses them, NaN where the
    run has none, the mean power (W) of pump and of the motor's terminals, the real speed (rpm), None where there is
    none, whether a run that completed keeps to the limits, and whether the loop hunts while a step is held.
    """

    stage: Stage
    controller: str
    rpm: float
    speed: float
    spread: float
    number: int
    outcome: str
    error: float
    power: float
    pump: float | None
    motor: float | None
    real_rpm: float | None
    accurate: bool
    within_power: bool
    hunts: bool

    @property
    def key(self) -> Key:
        """What tells it from all others."""
        return self.stage, self.controller, self.rpm, self.speed, self.spread, self.number


COLUMNS = {
    "stage": "stage",
    "controller": "controller",
    "rpm": "rpm",
    "speed_m_per_s": "speed",
    "spread": "spread",
    "draw": "number",
    "outcome": "outcome",
    "error_m": "error",
    "power_W": "power",
    PUMP: "pump",
    MOTOR: "motor",
    REAL_SPEED: "real_rpm",
    "meets_accuracy": "accurate",
    "meets_power": "within_power",
    "hunts": "hunts",
}
"""What of a run each column of draws.parquet holds."""


@dataclass(frozen=True)
class Kept:
    """Runs that were made before, by their key, and what is told of every new one as it ends."""

    known: Mapping[Key, SampleRun]
    keep: Callable[[SampleRun], object]


NOTHING_KEPT = Kept({}, lambda run: None)


def batches(stage: Stage, wanted: Sequence[tuple[Candidate, float, float]], numbers: Sequence[int]) -> list[Batch]:
    """The candidates at their speeds and spreads on plant samples of these numbers, those of one sample together."""
    grouped: dict[tuple[float, float], dict[str, list[float]]] = {}
    for (name, rpm), speed, spread in wanted:
        grouped.setdefault((rpm, spread), {}).setdefault(name, []).append(speed)
    return [
        Batch(stage, rpm, spread, number, dict(speeds))
        for (rpm, spread), speeds in grouped.items()
        for number in numbers
    ]


@dataclass(frozen=True)
class BatchRuns:
    """The work of a decision, a batch a piece. It can travel to another machine, which plans the decision anew."""

    plan: Plan
    wanted: Sequence[Batch]
    known: Mapping[Key, SampleRun]

    def __call__(self, places: Sequence[int]) -> list[list[SampleRun]]:
        """The runs of these batches, as many as take about a chunk's time; those that are known are not made again."""
        began, made = time.perf_counter(), list[list[SampleRun]]()
        for place in places:
            made.append(_run(self.plan, self.wanted[place], self.known))
            if enough(began):
                break
        return made

    def __reduce__(self) -> tuple[object, ...]:
        machine = self.plan.table.machine
        return _arrived, (self.plan.study, machine, self.wanted, self.known, source_hash(PROGRAM))


def _arrived(
    study: Study, machine: str | None, wanted: Sequence[Batch], known: Mapping[Key, SampleRun], version: str
) -> BatchRuns:
    check_version(version, PROGRAM)
    return BatchRuns(plan_decision(study, machine), wanted, known)


def run_batches(
    plan: Plan,
    wanted: Sequence[Batch],
    jobs: int | None = None,
    doing: str = "runs",
    progress: Progress = silent,
    kept: Kept = NOTHING_KEPT,
    cluster: str | None = None,
) -> pd.DataFrame:
    """Run everything that is not `kept`: a row a run, by controller, rpm, speed, spread and draw, wherever it is made.

    Args:
        plan: the decision.
        wanted: batches of it.
        jobs: batches at a time on this machine; default one a core.
        doing: what is being done, for `progress`, which is told of it and of the share of these runs that is done.
        progress: see there.
        kept: runs that were made before, and what is told of new ones.
        cluster: address of a dask scheduler to work on instead.

    Raises:
        UserError: a plant sample takes its process down whenever it is run, or the cluster does not serve.
    """
    rows: list[SampleRun] = []
    runs = sum(batch.runs for batch in wanted)
    work = BatchRuns(plan, wanted, kept.known)
    try:
        with closing(in_chunks(work, range(len(wanted)), jobs=jobs, cluster=cluster)) as chunks:
            for chunk in chunks:
                made = [run for batch in chunk.results for run in batch]
                for run in made:
                    if run.key not in kept.known:
                        kept.keep(run)
                rows += made
                progress(f"{doing}: {len(rows)} of {runs} runs", len(rows) / runs)
    except KilledError as error:
        batch = wanted[error.place]
        raise UserError(
            f"draw {batch.number} at {batch.rpm:g} rpm: its process was killed whenever it ran, as a system does that "
            "is out of memory; finished runs are kept: go on with --resume --jobs 1"
        ) from None
    return in_order(plan, runs_frame(rows))


def runs_frame(rows: Sequence[SampleRun]) -> pd.DataFrame:
    """Runs as a table."""
    return pd.DataFrame({column: [getattr(row, name) for row in rows] for column, name in COLUMNS.items()})


def in_order(plan: Plan, frame: pd.DataFrame) -> pd.DataFrame:
    """Rows by controller as the study names them, then by the other `KEYS`."""
    order = {name: i for i, name in enumerate(dict.fromkeys(name for name, _ in plan.candidates))}
    return frame.sort_values(
        list(KEYS), key=lambda column: column.map(order) if column.name == KEYS[0] else column, ignore_index=True
    )


def _run(plan: Plan, batch: Batch, known: Mapping[Key, SampleRun]) -> list[SampleRun]:
    """All controllers on one plant sample, built once a speed: they differ in nothing but their loop."""
    rows, first = list[SampleRun](), next(iter(batch.speeds))

    @functools.cache
    def built(speed: float) -> Resolved:
        return plan.sampled((first, batch.rpm), speed, batch.spread, batch.number, batch.stage)

    for name, speeds in batch.speeds.items():
        loop, hunts = plan.loops[name, batch.rpm], None
        for speed in speeds:
            run = known.get((batch.stage, name, batch.rpm, speed, batch.spread, batch.number))
            if run is None:
                resolved = replace(built(speed), setup=replace(built(speed).setup, loop=loop))
                hunts = _hunts(plan, resolved) if hunts is None else hunts
                run = _measured(plan, batch, name, speed, resolved, hunts)
            hunts = run.hunts
            rows.append(run)
    return rows


def _hunts(plan: Plan, resolved: Resolved) -> bool:
    """Whether a loop hunts, or diverges, while a step is held."""
    table = plan.table
    case = held(resolved, table.hold_level or HOLD_SHARE * table.amplitude, table.hold_duration)
    run = simulate(case.setup)
    return run.diverged or evaluated(case, run, ("limit_cycle",))["limit_cycle"] in HUNTING


def _measured(plan: Plan, batch: Batch, name: str, speed: float, resolved: Resolved, hunts: bool) -> SampleRun:
    """Run a controller at a speed (m/s), and keep what counts."""
    error, powers = ERRORS[plan.table.figure], POWERS[plan.table.power_figure]
    run = simulate(resolved.setup)
    wanted = (error, *powers, PUMP, MOTOR, REAL_SPEED)
    metrics = evaluate(run, resolved.signal, resolved.transient, resolved.band, wanted)
    numbers = {column: value if isinstance(value, float) else None for column, value in metrics.items()}
    watts = [value for column in powers if (value := numbers[column]) is not None]
    size, power = numbers[error], sum(watts) if watts else math.nan
    completed = run.outcome == COMPLETED
    return SampleRun(
        stage=batch.stage,
        controller=name,
        rpm=batch.rpm,
        speed=speed,
        spread=batch.spread,
        number=batch.number,
        outcome=run.outcome,
        error=math.nan if size is None else size,
        power=power,
        pump=numbers[PUMP],
        motor=numbers[MOTOR],
        real_rpm=numbers[REAL_SPEED],
        accurate=completed and size is not None and size <= plan.table.accuracy,
        within_power=completed and power <= plan.table.power,
        hunts=hunts,
    )
