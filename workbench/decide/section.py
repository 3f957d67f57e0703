"""[decide]: what a study has to do with a decision."""

from workbench.decide.plan import Plan, plan_decision
from workbench.decide.run import enough
from workbench.decide.schema import DecideTable
from workbench.study.sections import Section


def description(planned: Plan) -> list[str]:
    """What a decision would run, line by line."""
    lines = [f"a decision: {planned.study.file.title}"]
    if planned.table.machine is not None:
        lines.append(f"  machine: {planned.table.machine}")
    lines += [
        f"  controllers: {', '.join(dict.fromkeys(name for name, _ in planned.candidates))}",
        f"  rpm: {', '.join(f'{rpm:g}' for rpm in dict.fromkeys(rpm for _, rpm in planned.candidates))}",
        f"  speeds (mm/s): {', '.join(f'{1e3 * speed:g}' for speed in planned.speeds)}",
        f"  spreads: {', '.join(f'{spread:g}' for spread in planned.spreads)}",
    ]
    runs = f"{planned.runs} runs, {planned.simulated_seconds:.0f} s of simulated time"
    if not planned.several:
        return [*lines, f"  one machine: {runs}"]
    return [
        *lines,
        f"  search on {planned.draws} draws: {runs}",
        f"  then {planned.fresh_draws} fresh draws of each candidate that may be chosen:",
        f"    {enough(planned.table.probability, planned.fresh_draws)}",
    ]


DECIDE = Section(
    name="decide",
    table=DecideTable,
    command="decide",
    describe=lambda table, study: description(plan_decision(study)),
)
