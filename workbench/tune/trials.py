"""Trials of a search, and the file that keeps them: a killed tuning finds again what it has run."""

import json
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from plants.equation import source_hash
from workbench.errors import UserError
from workbench.publish.database import Database, damaged, database_at
from workbench.study.identity import led_to_when_drawn
from workbench.study.plan import PROGRAM_FOLDERS
from workbench.study.resolve import ParsedCase
from workbench.study.study import Study
from workbench.tune.schema import reference_controller, tune_table
from workbench.tune.space import Point
from workbench.tune.task import Task

PROGRAM = (*PROGRAM_FOLDERS, "workbench/tune")
"""Folders of the source files on which a trial depends."""

ON_DRAWS = "limit cycle on draws"
"""The constraint that is judged on plant samples, and of points alone that would be the best."""

_TABLES = """
CREATE TABLE IF NOT EXISTS searches (name TEXT PRIMARY KEY, identity TEXT);
CREATE TABLE IF NOT EXISTS trials (search TEXT, key TEXT, trial TEXT, PRIMARY KEY (search, key));
"""


@dataclass(frozen=True)
class Trial:
    """A point that was tried.

    `value` is what is made small: J on the declared machine (`draws` 0), or its quantile over so many draws; infinite
    where a run failed, or where none was made since the margins were too small. `nominal` is J on the declared machine,
    `violations` say by constraint how far beyond it the point is (<= 0: kept).
    """

    point: Point
    value: float
    nominal: float
    violations: Mapping[str, float]
    gain_margin_dB: float  # noqa: N815 - the unit's own letters
    phase_margin_deg: float
    stable: bool
    draws: int
    seed: int

    @property
    def feasible(self) -> bool:
        """Whether all constraints are kept."""
        return all(beyond <= 0.0 for beyond in self.violations.values())


def key_of(point: Point, draws: int, level: str) -> str:
    """What tells a trial from the others of a search: its point, and how thoroughly it was run."""
    return json.dumps([level, draws, sorted(point.items())])


def identity_of(study: Study, names: Sequence[str]) -> dict[str, object]:
    """What trials of these controllers must agree in: the study but for controllers that do not matter, [tune] without
    the number of trials and of seeds, draws, code.
    """
    table, uncertainty, controllers = tune_table(study), study.file.uncertainty, study.file.controllers
    own = {name: controllers[name] for name in (*names, reference_controller(study))}
    bare = replace(study, file=study.file.model_copy(update={"controllers": own}))
    return {
        "program": source_hash(PROGRAM),
        "study": bare.fingerprint,
        "tune": table.model_dump(mode="json", exclude={"trials", "seed", "seeds", "fresh_draws"}),
        "uncertainty": None if uncertainty is None else uncertainty.model_dump(mode="json"),
    }


def kept_identity(task: Task, reference: Sequence[ParsedCase]) -> dict[str, object]:
    """What kept trials of a task must agree in: the same, and what the study's files lead to in its cases and in those
    of the reference controller.
    """
    own = (task.name, reference_controller(task.study))
    cases = [_with_controllers(each, own) for each in (*task.cases, *reference)]
    return {**identity_of(task.study, [task.name]), **led_to_when_drawn(cases)}


def _with_controllers(parsed: ParsedCase, names: Sequence[str]) -> ParsedCase:
    """A case that knows of no controllers but these."""
    tables = parsed.case.tables
    known = {name: table for name, table in tables["controllers"].items() if name in names}
    return replace(parsed, case=replace(parsed.case, tables={**tables, "controllers": known}))


class TrialStore:
    """The file of trials. Several searches may write at a time."""

    def __init__(self, database: Database, path: Path) -> None:
        self._database, self._path = database, path

    def known(self, search: str, identity: Mapping[str, object]) -> dict[str, Trial]:
        """The trials of a search, by `key_of`; empty for a new one.

        Raises:
            UserError: they are of another study, or damaged.
        """
        text = json.dumps(identity, sort_keys=True)
        self._database.write("INSERT OR IGNORE INTO searches VALUES (?, ?)", (search, text))
        ((own,),) = self._database.read("SELECT identity FROM searches WHERE name = ?", (search,))
        rows = self._database.read("SELECT key, trial FROM trials WHERE search = ?", (search,))
        try:
            differing = [key for key, value in json.loads(own).items() if value != identity.get(key)]
            trials = {key: Trial(**json.loads(trial)) for key, trial in rows}
        except (AttributeError, TypeError, ValueError) as error:
            raise damaged(self._path, error) from error
        if own != text:
            raise UserError(
                f"{self._path.parent}: its trials of {search} are of another study or version of the program "
                f"({', '.join(differing)}); start anew with --overwrite, or choose another --out"
            )
        return trials

    def keep(self, search: str, key: str, trial: Trial) -> None:
        """Store a trial."""
        values = (search, key, json.dumps(asdict(trial)))
        self._database.write("INSERT OR REPLACE INTO trials VALUES (?, ?, ?)", values)


@contextmanager
def trials_in(database: Path) -> Iterator[TrialStore]:
    """The trials that `database` keeps; made where there is none.

    Raises:
        UserError: a file that holds something else, or is damaged.
    """
    with database_at(database, _TABLES) as rows:
        columns = {name for (name,) in rows.read("SELECT name FROM pragma_table_info('trials')")}
        if not {"search", "key", "trial"} <= columns:
            raise UserError(f"{database.parent}: its trials are of another version of the program; use --overwrite")
        yield TrialStore(rows, database)
