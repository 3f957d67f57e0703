"""What a study would run, in words."""

import sys
from collections.abc import Sequence

from workbench.decide import plan as decision
from workbench.report.decision_words import enough
from workbench.study.runner import Plan
from workbench.tune.task import Task, tune_table


def say_plan(planned: Plan) -> None:
    """Print title, axes, number of cases and simulated time of a study; its warnings to standard error."""
    file = planned.study.file
    print(file.title + (f" ({file.source})" if file.source else ""))
    for name, values in _axes_of(planned).items():
        print(f"  {name}: {', '.join(values)}")
    count = len(planned.cases)
    print(f"  {count} case{'s' * (count > 1)}, {planned.simulated_seconds:g} s of simulated time")
    for line in planned.warnings:
        print(f"warning: {line}", file=sys.stderr)


def say_decision(planned: decision.Plan) -> None:
    """Print what a decision would run."""
    print(f"a decision: {planned.study.file.title}")
    if planned.table.machine is not None:
        print(f"  machine: {planned.table.machine}")
    print(f"  controllers: {', '.join(dict.fromkeys(name for name, _ in planned.candidates))}")
    print(f"  rpm: {', '.join(f'{rpm:g}' for rpm in dict.fromkeys(rpm for _, rpm in planned.candidates))}")
    print(f"  speeds (mm/s): {', '.join(f'{1e3 * speed:g}' for speed in planned.speeds)}")
    print(f"  spreads: {', '.join(f'{spread:g}' for spread in planned.spreads)}")
    runs = f"{planned.runs} runs, {planned.simulated_seconds:.0f} s of simulated time"
    if not planned.several:
        print(f"  one machine: {runs}")
        return
    print(f"  search on {planned.draws} draws: {runs}")
    print(f"  then {planned.fresh_draws} fresh draws of each candidate that may be chosen:")
    print(f"    {enough(planned.table.probability, planned.fresh_draws)}")


def say_tuning_plan(tasks: Sequence[Task]) -> None:
    """Print what a tuning would find, controller by controller."""
    table = tune_table(tasks[0].study)
    machines = f", each on {table.draws} drawn machines" if table.draws else ""
    searches = f"{table.seeds} searches of " if table.seeds > 1 else ""
    print(f"a tuning: {searches}{table.trials} trials a controller{machines}; tuned are")
    names = {f"  {task.name}: {', '.join(one.name for one in task.dimensions)}": None for task in tasks}
    print("\n".join(names))
    if table.per:
        each = len({repr(task.at) for task in tasks})
        print(f"  each at {each} combinations of {' and '.join(table.per)}: {len(tasks)} tunings")


def _axes_of(planned: Plan) -> dict[str, list[str]]:
    axes: dict[str, dict[str, None]] = {}
    for case in planned.cases:
        for name, value in case.columns.items():
            axes.setdefault(name, {})[str(value)] = None
    return {name: list(values) for name, values in axes.items()}
