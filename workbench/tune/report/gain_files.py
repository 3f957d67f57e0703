"""Tuned gains as gain files: one of each controller, which a study may name."""

import math
from collections.abc import Sequence
from importlib.metadata import version

from workbench.publish.along import SHOWN
from workbench.toml.file_names import file_name
from workbench.toml.gain_file import KEY, Entry, GainFile, MarginsTable
from workbench.tune.objective import Score, margins_of
from workbench.tune.result import ControllerTuning
from workbench.tune.schema import reference_controller, tune_table
from workbench.tune.space import RPM, THRESHOLD, Point
from workbench.tune.task import Task, in_user_units

PACKAGES = ("optuna", "cobyqa", "scipy", "numpy", "numba")
"""Whose versions a gain file keeps."""

DIGITS = 6
"""Significant digits of what a gain file says of the search; settings have all that were tried."""


def gain_files(tunings: Sequence[ControllerTuning]) -> dict[str, GainFile]:
    """Every gain file, by its name in the folder of gains: NAME.toml, or MACHINE/NAME.toml."""
    by_name: dict[str, list[ControllerTuning]] = {}
    for tuned in tunings:
        if tuned.best is not None:
            folder = f"{file_name(str(tuned.task.at['machine']))}/" if "machine" in tuned.task.at else ""
            by_name.setdefault(f"{folder}{file_name(tuned.task.name)}.toml", []).append(tuned)
    return {name: gain_file(own) for name, own in by_name.items()}


def gain_file(tunings: Sequence[ControllerTuning]) -> GainFile:
    """The gain file of a controller with feasible gains: an entry for each of these tunings of it."""
    task = tunings[0].task
    return GainFile(
        title=f"{task.name}, tuned" + (f", {task.at['machine']}" if "machine" in task.at else ""),
        source=f"workbench tune, {task.study.path.name}: {task.study.file.title}",
        type=task.cases[0].controller.type,
        at=[
            _entry(tuned, tuned.best, tuned.score)
            for tuned in sorted(tunings, key=lambda tuned: tuned.task.rpm or 0.0)
            if tuned.best is not None and tuned.score is not None
        ],
    )


def _entry(tuned: ControllerTuning, best: Point, score: Score) -> Entry:
    """[[at]] of one tuning."""
    task, table = tuned.task, tune_table(tuned.task.study)
    written = in_user_units(task, best)
    rotation = {name: value for name, value in written.items() if name in (RPM, THRESHOLD)}
    given = task.cases[0].tables.controllers[task.name]
    own = {key: value for key, value in given.items() if key not in ("type", KEY)}
    differ = tuned.seeds_differ
    return Entry(
        rpm=task.rpm,
        settings={**own, **{name: value for name, value in written.items() if name not in rotation}},
        rotation=rotation,
        objective={
            "value": _short(score.value),
            "with_the_study_s_gains": _short(_start(tuned)),
            "on_the_declared_machine": _short(score.nominal),
            "yardstick": reference_controller(task.study),
            "weights": {name: weight for name, weight in table.objective.model_dump().items() if weight},
            **_draws(tuned),
        },
        margins=_margins(task, best),
        search={
            "by": "optuna TPE, then COBYQA",
            "trials": table.trials,
            "seeds": list(tuned.seeds),
            "objective_of_each": [math.inf if value is None else _short(value) for value in tuned.seeds.values()],
            **({} if differ is None else {"seeds_differ": _short(differ)}),
            "versions": {name: version(name) for name in PACKAGES},
        },
    )


def _start(tuned: ControllerTuning) -> float:
    return tuned.on_searched["start"].value if tuned.on_searched else tuned.start.value


def _short(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


def _margins(task: Task, best: Point) -> MarginsTable:
    """The smallest margins over the cases; those that are finite."""
    smallest = margins_of(task.declared(best), tune_table(task.study).constraints)
    return MarginsTable(
        gain_margin_dB=_short(smallest.gain_dB) if math.isfinite(smallest.gain_dB) else None,
        phase_margin_deg=_short(smallest.phase_deg) if math.isfinite(smallest.phase_deg) else None,
        speed=SHOWN[task.axis].speed(smallest.speed),
    )


def _draws(tuned: ControllerTuning) -> dict[str, object]:
    """The quantiles on the plant samples of the search and on fresh ones, with their intervals."""
    tables: dict[str, object] = {}
    for kind, quantiles in (("searched", tuned.on_searched), ("fresh", tuned.on_fresh)):
        if (reached := quantiles.get("tuned")) is not None:
            tables[f"on_{kind}_draws"] = {
                "draws": reached.draws,
                "value": _short(reached.value),
                "low": _short(reached.low),
                "high": _short(reached.high),
            }
    return tables
