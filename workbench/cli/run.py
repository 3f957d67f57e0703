"""A study from end to end: every case, then once more those that may win its comparison, on fresh draws."""

import sys
from dataclasses import dataclass, replace
from itertools import count
from pathlib import Path

import pandas as pd
import typer

from workbench.cli.progress import ProgressBar
from workbench.compare.finalists import finalists
from workbench.errors import UserError
from workbench.files import read_toml
from workbench.identify.experiment import is_experiment
from workbench.study.document import Study, only_decides, read_study
from workbench.study.report_schema import ComparisonTable
from workbench.study.runner import Plan, again, plan, run_study
from workbench.study.store import DATABASE, FRESH, export, read_results


@dataclass(frozen=True)
class Options:
    """How a study is run; as `run_study` has them."""

    jobs: int | None
    cluster: str | None
    resume: bool
    overwrite: bool
    keep_all: bool


def planned_study(path: Path, out: Path, draws: int | None, fresh_draws: int | None) -> Plan:
    """The plan of a study file, with other numbers of draws than it says where these are given.

    Raises:
        UserError: it is no study for `run`, or what it says is wrong, or it draws nothing.
    """
    if is_experiment(read_toml(path)[0]):
        raise UserError(f"{path}: this is an experiment; use workbench identify {path} --out {out}")
    study = read_study(path)
    if only_decides(study):
        raise UserError(f"{path}: has [decide] and no [references]; use workbench decide {path} --out {out}")
    return plan(_with_draws(study, draws, fresh_draws))


def _with_draws(study: Study, draws: int | None, fresh_draws: int | None) -> Study:
    """The study with these numbers of draws."""
    changed = {}
    for option, number, key, section in (
        ("--draws", draws, "draws", "uncertainty"),
        ("--fresh-draws", fresh_draws, "fresh_draws", "comparison"),
    ):
        if number is None:
            continue
        table = getattr(study.file, section)
        if table is None:
            raise UserError(f"{study.path}: {option} needs a table [{section}]; leave it out")
        changed[section] = table.model_copy(update={key: number})
    return replace(study, file=study.file.model_copy(update=changed))


def run_all(planned: Plan, out: Path, options: Options) -> None:
    """Run the cases of a plan into `out`, then those of its finalists into the folder `fresh` there, round by round.

    Raises:
        UserError: a folder does not serve.
    """
    try:
        _run(planned, out, options)
        spec = planned.study.file.comparison
        if spec is not None and spec.fresh_draws:
            _again(planned, spec, out, options)
    except KeyboardInterrupt:
        print(f"stopped; finished cases are kept in {out}: go on with --resume", file=sys.stderr)
        raise typer.Exit(130) from None


def _again(planned: Plan, spec: ComparisonTable, out: Path, options: Options) -> None:
    """Measure the best of each class on fresh draws; where they hunt there, those behind them, until one holds."""
    searched, rounds = read_results(out), count(1)
    fresh: pd.DataFrame | None = None
    while wanted := finalists(spec, searched, fresh):
        number = next(rounds)
        measured = again(planned, wanted, spec.fresh_draws)
        who = "the best of each class" if number == 1 else "those behind whom hunting has taken out"
        print(f"{who} again, on {spec.fresh_draws} fresh draws: {len(measured.cases)} cases")
        folder = out / FRESH / f"round_{number}"
        resume = options.resume and (folder / DATABASE).exists()
        _run(measured, folder, replace(options, resume=resume, overwrite=not resume))
        fresh = pd.concat([fresh, read_results(folder)], ignore_index=True)
    if fresh is not None:
        export(fresh, out / FRESH)


def _run(planned: Plan, folder: Path, options: Options) -> None:
    with ProgressBar(len(planned.cases)) as progress:
        run_study(
            planned,
            folder,
            jobs=options.jobs,
            cluster=options.cluster,
            resume=options.resume,
            overwrite=options.overwrite,
            keep_all=options.keep_all,
            progress=progress,
        )
