"""Where searches begin: the gains of the study, then classic tunings of a PID for the same plant."""

from collections.abc import Mapping, Sequence

import numpy as np

from workbench.tune.classic import StartingPoint, starting_points
from workbench.tune.objective import margin_speed
from workbench.tune.schema import tune_table
from workbench.tune.space import Point
from workbench.tune.task import Task

PID_GAINS = {"kp", "ki", "kd"}
"""The settings that classic tunings give."""


def starts_of(task: Task, classic: Sequence[StartingPoint]) -> list[Mapping[str, float]]:
    """The points with which every search begins: the gains of the study, then classic tunings of just its gains."""
    return [task.start, *_classic(task, classic)]


def has_pid_gains(task: Task) -> bool:
    """Whether a classic tuning of a PID says something of what is tuned."""
    return bool(PID_GAINS & {dimension.name for dimension in task.dimensions})


def classic_points(task: Task, point: Point) -> list[StartingPoint]:
    """The classic tunings of a PID for the plant of a task's first case, at the speed of its margins; none for a plant
    whose command has no limit: nothing then says how large a command is.
    """
    case, asked = task.declared(point)[0], tune_table(task.study).constraints
    if not np.isfinite(case.setup.plant.command_limit(case.belief)):
        return []
    return starting_points(case.setup, case.belief, margin_speed(case, asked))


def _classic(task: Task, points: Sequence[StartingPoint]) -> list[dict[str, float]]:
    """Classic starting points of just the PID gains that are tuned, within their limits; the rest is the study's."""
    pid = PID_GAINS & {dimension.name for dimension in task.dimensions}
    starts = []
    for point in points if pid else ():
        gains = {name: value for name, value in point.settings.items() if value}
        if set(gains) == pid:
            wanted = {**task.start, **gains}
            starts.append(
                {
                    dimension.name: min(max(wanted[dimension.name], dimension.low), dimension.high)
                    for dimension in task.dimensions
                }
            )
    return [point for i, point in enumerate(starts) if point not in (task.start, *starts[:i])]
