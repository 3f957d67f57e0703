"""Every candidate on every drawn machine: the runs of a decision."""

import os
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, as_completed
from dataclasses import dataclass, replace

import pandas as pd

from workbench.decide.plan import Plan
from workbench.metrics import evaluate
from workbench.simulation.simulate import COMPLETED, simulate
from workbench.study.decide_schema import ERRORS, POWERS
from workbench.study.resolve import Resolved

Progress = Callable[[int, int], None]
"""Called with the number of finished runs, and of all."""


@dataclass(frozen=True)
class Machine:
    """A draw (number) at a spread, moving at a speed (m/s) and rotating at rpm: all controllers run on it."""

    rpm: float
    speed: float
    spread: float
    number: int


def run_all(plan: Plan, jobs: int | None = None, progress: Progress | None = None) -> pd.DataFrame:
    """Run everything: a row a run, by controller, rpm, speed, spread and draw, whatever the number of `jobs`.

    `error_m` and `power_W` are the figures that [decide] chooses, NaN where a run has none; `meets_accuracy` and
    `meets_power` say whether a run that completed keeps to the limits.
    """
    machines = [
        Machine(rpm, speed, spread, number)
        for speed in plan.speeds
        for spread in plan.spreads
        for rpm in dict.fromkeys(rpm for _, rpm in plan.candidates)
        for number in range(plan.draws)
    ]
    rows: list[dict[str, object]] = []
    with ThreadPoolExecutor(jobs or os.cpu_count() or 1) as executor:
        futures: list[Future[list[dict[str, object]]]] = [executor.submit(_run, plan, one) for one in machines]
        try:
            for future in as_completed(futures):
                rows += future.result()
                if progress is not None:
                    progress(len(rows), plan.runs)
        except BaseException:
            executor.shutdown(wait=False, cancel_futures=True)
            raise
    frame = pd.DataFrame(rows)
    order = {name: i for i, name in enumerate(dict.fromkeys(name for name, _ in plan.candidates))}
    keys = ["controller", "rpm", "speed_m_per_s", "spread", "draw"]
    return frame.sort_values(
        keys, key=lambda column: column.map(order) if column.name == keys[0] else column, ignore_index=True
    )


def _run(plan: Plan, machine: Machine) -> list[dict[str, object]]:
    """All controllers on one machine, which is built once: they differ in nothing but their loop."""
    names = [name for name, rpm in plan.candidates if rpm == machine.rpm]
    place = (machine.speed, machine.spread, machine.number)
    built = plan.machine((names[0], machine.rpm), *place)
    rows = []
    for name in names:
        loop = plan.loops[name, machine.rpm]
        figures = _figures(plan, replace(built, setup=replace(built.setup, loop=loop)))
        where = {"controller": name, "rpm": machine.rpm, "speed_m_per_s": machine.speed, "spread": machine.spread}
        rows.append({**where, "draw": machine.number, **figures})
    return rows


def _figures(plan: Plan, resolved: Resolved) -> dict[str, object]:
    """What is kept of a run."""
    error, powers = ERRORS[plan.table.figure], POWERS[plan.table.power_figure]
    run = simulate(resolved.setup)
    found = evaluate(run, resolved.signal, resolved.transient, resolved.band, (error, *powers))
    watts = [value for name in powers if isinstance(value := found[name], float)]
    value, power = found[error], sum(watts) if watts else float("nan")
    size = value if isinstance(value, float) else float("nan")
    completed = run.outcome == COMPLETED
    return {
        "outcome": run.outcome,
        "error_m": size,
        "power_W": power,
        "meets_accuracy": completed and size <= plan.table.accuracy,
        "meets_power": completed and power <= plan.table.power,
    }
