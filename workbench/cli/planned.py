"""The study that a command is given, and its plan."""

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.errors import UserError

if TYPE_CHECKING:
    from workbench.study.plan import Plan
    from workbench.study.study import Study


def study_at(path: Path, instead: str = "expected a study") -> "Study":
    """A study file as read; `instead` is what there is to say of an experiment.

    Raises:
        UserError: it is an experiment, or has unknown or missing keys.
    """
    from workbench.records.experiment import is_experiment
    from workbench.study.reading import read_study
    from workbench.toml.reading import read_toml

    if is_experiment(read_toml(path)[0]):
        raise UserError(f"{path}: this is an experiment; {instead}")
    return read_study(path)


def planned_study(
    path: Path, out: Path, draws: int | None = None, fresh_draws: int | None = None, allow_fmu: bool = False
) -> "Plan":
    """The plan of a study file that is to be run, with other numbers of draws than it says where these are given.

    Raises:
        UserError: it is no study to be run, or what it says is wrong, or it draws nothing.
    """
    from workbench.study.plan import plan
    from workbench.study.rounds import with_draws
    from workbench.study.sections import other_command

    study = replace(study_at(path, f"use workbench identify {path} --out {out}"), allow_fmu=allow_fmu)
    if (other := other_command(study)) is not None:
        use = f"use workbench {other.command} {path} --out {out}"
        raise UserError(f"{path}: has [{other.name}] and no [references]; {use}")
    study = with_draws(study, "--draws", draws, "uncertainty", "draws")
    return plan(with_draws(study, "--fresh-draws", fresh_draws, "comparison", "fresh_draws"))
