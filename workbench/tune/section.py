"""[tune]: what a study has to do with the tuning of its controllers."""

from workbench.study.sections import Section
from workbench.study.study import Study
from workbench.tune.prepare import tasks_of
from workbench.tune.schema import TuneTable


def _description(table: TuneTable, study: Study) -> list[str]:
    """What a tuning would find, controller by controller."""
    tasks = tasks_of(study)
    machines = f", each on {table.draws} drawn machines" if table.draws else ""
    searches = f"{table.seeds} searches of " if table.seeds > 1 else ""
    lines = [f"a tuning: {searches}{table.trials} trials a controller{machines}; tuned are"]
    lines += dict.fromkeys(
        f"  {task.name}: {', '.join(dimension.name for dimension in task.dimensions)}" for task in tasks
    )
    if table.per:
        places = len({repr(task.at) for task in tasks})
        lines.append(f"  each at {places} combinations of {' and '.join(table.per)}: {len(tasks)} tunings")
    return lines


TUNE = Section(name="tune", table=TuneTable, command="tune", describe=_description)
