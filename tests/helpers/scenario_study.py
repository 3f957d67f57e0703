"""A small study with scenarios, as tests of them write and resolve it."""

from pathlib import Path

from command import STUDIES

from workbench.simulation.simulate import simulate
from workbench.study.case_runs import figures_of
from workbench.study.reading import read_study
from workbench.study.resolve import Resolved, resolve
from workbench.study.study import Case, Study
from workbench.study.unfold import unfold

FOLDER = STUDIES / "scenarios"
FILE_HEAD = 'title = "t"\nsource = "s"\n'

INVERSE = """\
[controllers.inverse]
type = "lugre"
law = "valve_inversion"
[references.sine]
kind = "sine"
amplitude = "5 mm"
frequency = "5 Hz"
[simulation]
duration = "0.4 s"
transient = "0.1 s"
"""
"""A compensator over two periods of a sine, beside what else a study has."""

HEAD = """\
title = "a study for tests"
[plant]
model = "non_rotating"
parameters = "owen2001_simulation"
[axes]
scenario = {scenarios}
controller = ["p", "inverse"]
[controllers.p]
type = "pid"
kp = "500 V/m"
feedforward = 1
"""

STUDY = f"{HEAD}{INVERSE}seed = 3\n"


def study_file(folder: Path, scenarios: list[str], extra: str = "", **beside: str) -> Path:
    """A study in `folder` with these scenarios on its axis, and the scenario files `beside` it."""
    (folder / "scenarios").mkdir(exist_ok=True)
    for name, text in beside.items():
        (folder / "scenarios" / f"{name}.toml").write_text(text, encoding="utf-8")
    path = folder / "study.toml"
    path.write_text(STUDY.format(scenarios=scenarios) + extra, encoding="utf-8")
    return path


def resolved(path: Path) -> list[Resolved]:
    study = read_study(path)
    return [resolve(study, case) for case in unfold(study)]


def row_of(study: Study, case: Case) -> dict[str, float | str | None]:
    """The figures of a case, without its solver errors."""
    resolved = resolve(study, case)
    return figures_of(resolved, simulate(resolved.setup))
