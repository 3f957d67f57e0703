"""Trials of a search, and the file that keeps them: a killed tuning finds again what it has run."""

import json
import sqlite3
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from plants.equation import source_hash
from workbench.errors import UserError
from workbench.study.plan import PROGRAM_FOLDERS
from workbench.study.study import Study
from workbench.tune.schema import reference_controller, tune_table
from workbench.tune.space import Point

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
    """What stored trials of these controllers must agree in: the study but for controllers that do not matter, [tune]
    without the number of trials and of seeds, draws, code.
    """
    table, uncertainty, controllers = tune_table(study), study.file.uncertainty, study.file.controllers
    own = {name: controllers[name] for name in (*names, reference_controller(study))}
    bare = replace(study, file=study.file.model_copy(update={"controllers": own}))
    return {
        "program": source_hash((*PROGRAM_FOLDERS, "workbench/tune")),
        "study": bare.fingerprint,
        "tune": table.model_dump(mode="json", exclude={"trials", "seed", "seeds", "fresh_draws"}),
        "uncertainty": None if uncertainty is None else uncertainty.model_dump(mode="json"),
    }


class TrialStore:
    """The file of trials. Several searches may write at a time."""

    def __init__(self, connection: sqlite3.Connection, folder: Path) -> None:
        self._connection, self._folder = connection, folder
        self._lock = threading.Lock()

    def known(self, search: str, identity: Mapping[str, object]) -> dict[str, Trial]:
        """The trials of a search, by `key_of`; empty for a new one.

        Raises:
            UserError: they are of another study.
        """
        text = json.dumps(identity, sort_keys=True)
        with self._lock:
            self._connection.execute("INSERT OR IGNORE INTO searches VALUES (?, ?)", (search, text))
            self._connection.commit()
            query = "SELECT identity FROM searches WHERE name = ?"
            (own,) = self._connection.execute(query, (search,)).fetchone()
            rows = self._connection.execute("SELECT key, trial FROM trials WHERE search = ?", (search,)).fetchall()
        if own != text:
            raise UserError(
                f"{self._folder}: its trials of {search} are of another study or version of the program; start "
                "anew with --overwrite, or choose another --out"
            )
        return {key: Trial(**json.loads(trial)) for key, trial in rows}

    def keep(self, search: str, key: str, trial: Trial) -> None:
        """Store a trial."""
        with self._lock:
            values = (search, key, json.dumps(asdict(trial)))
            self._connection.execute("INSERT OR REPLACE INTO trials VALUES (?, ?, ?)", values)
            self._connection.commit()


@contextmanager
def trials_in(database: Path) -> Iterator[TrialStore]:
    """The trials that `database` keeps; made where there is none.

    Raises:
        UserError: a file that holds something else.
    """
    connection = sqlite3.connect(database, check_same_thread=False)
    try:
        connection.execute("PRAGMA synchronous = OFF")  # a killed process loses nothing; only a lost machine would
        connection.executescript(_TABLES)
        columns = {row[1] for row in connection.execute("PRAGMA table_info(trials)")}
        if not {"search", "key", "trial"} <= columns:
            raise UserError(f"{database.parent}: its trials are of another version of the program; use --overwrite")
        yield TrialStore(connection, database.parent)
    except sqlite3.DatabaseError as error:
        raise UserError(f"{database}: holds no trials ({error}); start anew with --overwrite") from None
    finally:
        connection.close()
