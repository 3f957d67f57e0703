"""Candidates on plant samples: the runs of a decision, a row each."""

import math
from collections.abc import Sequence
from concurrent.futures import Future, as_completed
from dataclasses import dataclass, replace

import pandas as pd

from workbench.decide.plan import Candidate, Plan, Stage
from workbench.decide.schema import ERRORS, MOTOR, POWERS, PUMP, REAL_SPEED
from workbench.metrics.evaluate import evaluate
from workbench.metrics.limit_cycle import HUNTING
from workbench.parallel.workers import workers
from workbench.progress import Progress, silent
from workbench.simulation.simulate import COMPLETED, simulate
from workbench.study.hold import HOLD_SHARE, held
from workbench.study.resolve import Resolved
from workbench.study.run_on import evaluated

KEYS = ("controller", "rpm", "speed_m_per_s", "spread", "draw")
"""What a row is told from the others of its stage by."""


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


@dataclass(frozen=True)
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
    def columns(self) -> dict[str, object]:
        """Its values by column of draws.parquet."""
        return {
            "stage": self.stage,
            "controller": self.controller,
            "rpm": self.rpm,
            "speed_m_per_s": self.speed,
            "spread": self.spread,
            "draw": self.number,
            "outcome": self.outcome,
            "error_m": self.error,
            "power_W": self.power,
            PUMP: self.pump,
            MOTOR: self.motor,
            REAL_SPEED: self.real_rpm,
            "meets_accuracy": self.accurate,
            "meets_power": self.within_power,
            "hunts": self.hunts,
        }


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


def run_batches(
    plan: Plan, wanted: Sequence[Batch], jobs: int | None = None, doing: str = "runs", progress: Progress = silent
) -> pd.DataFrame:
    """Run everything: a row a run, by controller, rpm, speed, spread and draw, whatever the number of `jobs`.

    `progress` is told what is being done, and the share of these runs that is.
    """
    rows: list[SampleRun] = []
    runs = sum(batch.runs for batch in wanted)
    with workers(jobs) as executor:
        futures: list[Future[list[SampleRun]]] = [executor.submit(_run, plan, batch) for batch in wanted]
        for future in as_completed(futures):
            rows += future.result()
            progress(f"{doing}: {len(rows)} of {runs} runs", len(rows) / runs)
    return in_order(plan, runs_frame(rows))


def runs_frame(rows: Sequence[SampleRun]) -> pd.DataFrame:
    """Runs as a table."""
    return pd.DataFrame([row.columns for row in rows])


def in_order(plan: Plan, frame: pd.DataFrame) -> pd.DataFrame:
    """Rows by controller as the study names them, then by the other `KEYS`."""
    order = {name: i for i, name in enumerate(dict.fromkeys(name for name, _ in plan.candidates))}
    return frame.sort_values(
        list(KEYS), key=lambda column: column.map(order) if column.name == KEYS[0] else column, ignore_index=True
    )


def _run(plan: Plan, batch: Batch) -> list[SampleRun]:
    """All controllers on one plant sample, built once a speed: they differ in nothing but their loop."""
    rows, first = [], next(iter(batch.speeds))
    built = {
        speed: plan.sampled((first, batch.rpm), speed, batch.spread, batch.number, batch.stage)
        for speed in dict.fromkeys(speed for speeds in batch.speeds.values() for speed in speeds)
    }
    for name, speeds in batch.speeds.items():
        loop, hunts = plan.loops[name, batch.rpm], None
        for speed in speeds:
            resolved = replace(built[speed], setup=replace(built[speed].setup, loop=loop))
            hunts = _hunts(plan, resolved) if hunts is None else hunts
            rows.append(_measured(plan, batch, name, speed, resolved, hunts))
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
