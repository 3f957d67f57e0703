"""The runs of a decision, kept as they end: one that was killed finds again what it has run."""

import json
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import astuple
from pathlib import Path
from typing import Any

from plants.equation import source_hash
from workbench.decide.batches import Kept, SampleRun
from workbench.decide.plan import PROGRAM, Plan
from workbench.publish.database import check_identity, damaged, database_at
from workbench.study.identity import led_to_when_drawn

DATABASE = "runs.sqlite"

OF_THE_ANSWER = {"probability", "draws", "fresh_draws", "contenders", "assumptions"}
"""What of [decide] says how many runs there are and what they mean: more draws go on with those there are."""

_TABLES = """
CREATE TABLE IF NOT EXISTS identity (key TEXT PRIMARY KEY, value TEXT);
CREATE TABLE IF NOT EXISTS runs (run TEXT);
"""


def identity_of(plan: Plan) -> dict[str, str]:
    """What kept runs must agree in: the study with its machine, [decide], what is drawn, code."""
    uncertainty, study = plan.study.file.uncertainty, plan.study
    cases = [case for own in plan.cases.values() for case in own.values()]
    return {
        "study": study.computed,
        "[decide]": plan.table.model_dump_json(exclude=OF_THE_ANSWER),
        "[uncertainty]": "" if uncertainty is None else uncertainty.model_dump_json(exclude={"draws"}),
        **led_to_when_drawn(cases),
        "version of the program": source_hash(PROGRAM),
    }


@contextmanager
def kept_runs(database: Path, plan: Plan) -> Iterator[Kept]:
    """The runs that `database` keeps, made where there is none; new ones are kept there while the block lasts.

    Raises:
        UserError: they are of something else, or damaged.
    """
    with database_at(database, _TABLES) as rows:
        check_identity(rows, identity_of(plan), database.parent)
        try:
            known = [_run_of(text) for (text,) in rows.read("SELECT run FROM runs")]
        except (TypeError, ValueError) as error:
            raise damaged(database, error) from error

        def keep(run: SampleRun) -> None:
            rows.write("INSERT INTO runs VALUES (?)", (json.dumps(astuple(run)),))

        yield Kept({run.key: run for run in known}, keep)


def _run_of(text: str) -> SampleRun:
    """A run as it was kept; a name that many have is there once."""
    values: list[Any] = [sys.intern(value) if isinstance(value, str) else value for value in json.loads(text)]
    return SampleRun(*values)
