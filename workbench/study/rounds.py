"""The rounds of a study: its cases, then those that its questions have run once more, on machines not yet drawn."""

from collections.abc import Callable
from itertools import count
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.errors import UserError
from workbench.study.plan import Plan, again
from workbench.study.sections import sections_of
from workbench.study.store import FRESH, export, read_results
from workbench.study.study import Study

if TYPE_CHECKING:
    import pandas as pd

RunCases = Callable[[Plan, Path, bool, bool], None]
"""Runs the cases of a plan into a folder; whether it goes on with what is there, or else replaces it."""


def run_rounds(
    planned: Plan,
    folder: Path,
    run: RunCases,
    *,
    resume: bool = False,
    overwrite: bool = False,
    tell: Callable[[str], None] = lambda line: None,
) -> None:
    """Run a study with `run`, round by round; later rounds lie in folders of `folder`. `tell` is told of each of them.

    Raises:
        UserError: a folder does not serve.
    """
    run(planned, folder, resume, overwrite)
    for section, table in sections_of(planned.study):
        fresh: pd.DataFrame | None = None
        rounds = count(1)
        while (more := section.again(table, read_results(folder), fresh)) is not None:
            measured = again(planned, more.wanted, more.draws)
            tell(f"{more.said} again, on {more.draws} fresh draws: {len(measured.cases)} cases")
            own = folder / FRESH / f"round_{next(rounds)}"
            run(measured, own, resume, not resume)
            from pandas import concat  # a study without such questions does without

            fresh = concat([fresh, read_results(own)], ignore_index=True)
        if fresh is not None:
            export(fresh, folder / FRESH)


def with_draws(study: Study, option: str, number: int | None, section: str, key: str) -> Study:
    """The study with this number of draws in a table of its own; `option` is what asks for it.

    Raises:
        UserError: it has no such table.
    """
    if number is None:
        return study
    table = getattr(study.file, section)
    if table is None:
        raise UserError(f"{study.path}: {option} needs a table [{section}]; leave it out")
    return study.with_section(section, table.model_copy(update={key: number}))
