"""A folder of results: results.sqlite while the study runs, tables for people and programs when it is done.

study.toml        the study as it was run
machines/, scenarios/     the files of machines and scenarios that it names
results.sqlite    one row a finished case, committed in chunks as these end, and sketches of trajectories for the page
results.csv, results.parquet, run.json        written when all cases are done
results.html      tables, figures and every case, of a study that has no page of its own
trajectories/     one Parquet file a case that a figure needs, or for all with --keep-trajectories
records/          one Parquet file a case with the signals that the study names under `records`
fresh/            the finalists of a comparison on machines not drawn before: results.csv and results.parquet of all
                  rounds, and for each round a folder of the same form as this one
"""

import functools
import importlib
import json
import sqlite3
from collections.abc import Callable, Collection, Iterable, Iterator, Mapping, Sequence
from contextlib import closing, contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from workbench.errors import UserError
from workbench.metrics.registry import OUTCOME
from workbench.publish.database import Database, check_identity, database_at
from workbench.publish.folders import GrowingFolder, anew, made, write_whole
from workbench.simulation.run import Run
from workbench.study.layers import LAYERS
from workbench.study.study import INDEX, Case, Study
from workbench.toml.file_names import file_name

if TYPE_CHECKING:
    import pandas as pd

DATABASE = "results.sqlite"

STUDY_COPY = "study.toml"
FRESH = "fresh"
DRAWS = "draws.csv"
"""The machines that were drawn."""

REPLACED = (
    STUDY_COPY,
    "results.csv",
    "results.parquet",
    "results.html",
    DRAWS,
    "run.json",
    "trajectories",
    "records",
    "tables",
    "figures",
    FRESH,
    DATABASE,
)
"""What a run may write into its folder, and therefore may replace; the database, which marks it as ours, last."""

RECORDS = "records"
EXPORTS = ("results.csv", "results.parquet")
"""What `export` writes."""

EXPORTED = 1_000
"""Rows that are read and written at a time: results may be larger than memory."""

FOLDER = GrowingFolder("run", "results", REPLACED, kept=tuple(layer.section for layer in LAYERS.values()))
"""With machines and scenarios, of which no file is removed: studies look for theirs in folders of these names."""


class Row(NamedTuple):
    """A finished case: its index, its values in the order of the columns, the sketch of its motion if it has one."""

    case: int
    values: Sequence[object]
    sketch: str | None = None


class Store:
    """Results by case, in a database."""

    def __init__(self, database: Database, columns: Sequence[str]) -> None:
        self._database = database
        self.columns = list(columns)

    def done(self) -> set[int]:
        """Indices of the finished cases."""
        return {index for (index,) in self._database.read(f"SELECT {INDEX} FROM results")}

    def add(self, rows: Sequence[Row]) -> None:
        """Keep finished cases."""
        marks = ", ".join("?" * (1 + len(self.columns)))
        sketches = [(row.case, row.sketch) for row in rows if row.sketch is not None]
        self._database.write("INSERT OR REPLACE INTO sketches VALUES (?, ?)", *sketches)
        self._database.write(
            f"INSERT OR REPLACE INTO results VALUES ({marks})", *([row.case, *row.values] for row in rows)
        )

    def made(self) -> str:
        """What `keep_made` has kept last; "" before."""
        return "".join(content for (content,) in self._database.read("SELECT content FROM made"))

    def keep_made(self, content: str) -> None:
        """Keep what was made of the results."""
        self._database.write("INSERT OR REPLACE INTO made VALUES (0, ?)", (content,))

    def frames(self, rows: int = EXPORTED) -> "Iterator[pd.DataFrame]":
        """All finished cases in order, so many at a time, each column with one type throughout; without any, one frame.

        An axis of numbers and text, such as 0 and "460 rpm", is text.
        """
        import pandas as pd  # who has nothing to do does not wait for it

        types = {name: self._type(name) for name in self.columns}
        query = f"SELECT * FROM results WHERE {INDEX} > ? ORDER BY {INDEX} LIMIT {rows}"
        block = self._database.read(query, (-1,))
        while True:
            frame = pd.DataFrame(block, columns=[INDEX, *self.columns]).drop(columns=INDEX)
            for name, kind in types.items():
                if kind == "text":
                    frame[name] = frame[name].map(str, na_action="ignore").astype(object)
                elif kind != "null":
                    frame[name] = frame[name].astype(np.dtype(kind))
            yield frame
            if len(block) < rows or not (block := self._database.read(query, (block[-1][0],))):
                return

    def export(self, folder: Path, rows: int = EXPORTED) -> None:
        """Write results.csv and results.parquet, each whole or not at all, reading so many rows at a time."""
        text = [name for name in self.columns if self._type(name) == "text"]
        _export(functools.partial(self.frames, rows), folder, text)

    def _type(self, column: str) -> str:
        """What the values of a column are together: "text", "float64", "int64", or "null" without any."""
        found = self._database.read(f"SELECT DISTINCT typeof({_quoted(column)}) FROM results")
        types = {name for (name,) in found}
        if "text" in types or types <= {"null"}:
            return "text" if "text" in types else "null"
        return "int64" if types == {"integer"} else "float64"


@contextmanager
def open_store(
    folder: Path,
    columns: Sequence[str],
    identity: Mapping[str, str],
    *,
    resume: bool = False,
    overwrite: bool = False,
) -> Iterator[Store]:
    """The results in `folder`, for this process alone: those of an earlier run, to go on with, or none yet.

    Raises:
        UserError: the folder holds results that are neither to be gone on with nor replaced, or of another study or
            version; another command is at work there; or the disk fails while the block is.
    """
    names = ", ".join(_quoted(column) for column in columns)
    tables = f"""
        CREATE TABLE IF NOT EXISTS identity (key TEXT PRIMARY KEY, value TEXT);
        CREATE TABLE IF NOT EXISTS results ({INDEX} INTEGER PRIMARY KEY, {names});
        CREATE TABLE IF NOT EXISTS sketches ({INDEX} INTEGER PRIMARY KEY, content TEXT);
        CREATE TABLE IF NOT EXISTS made (only INTEGER PRIMARY KEY, content TEXT);
        """
    with FOLDER.opened(folder, resume=resume, overwrite=overwrite) as path, database_at(path, tables) as database:
        check_identity(database, identity, folder)
        yield Store(database, columns)


def write_study(study: Study, folder: Path) -> None:
    """Copy a study and the files of machines and scenarios that it names, so that it can be run again from there."""
    anew(folder / STUDY_COPY).write_text(study.text, encoding="utf-8")
    for (section, name), (_, text) in study.sources.items():
        path = anew(made(folder / str(section)) / f"{name}.toml")
        path.write_text(text, encoding="utf-8")


def _quoted(name: str) -> str:
    return '"' + name.replace('"', '""') + '"'


def export(frame: "pd.DataFrame", folder: Path) -> None:
    """Write results.csv and results.parquet, each whole or not at all."""
    _export(lambda: [frame], folder)


def _export(frames: "Callable[[], Iterable[pd.DataFrame]]", folder: Path, text: Collection[str] = ()) -> None:
    """The same of several frames, whose columns agree; those that hold `text` in any of them are named."""
    write_whole(folder / EXPORTS[0], lambda path: _write_csv(frames(), path))
    write_whole(folder / EXPORTS[1], lambda path: _write_parquet(frames(), text, path))


def _write_csv(frames: "Iterable[pd.DataFrame]", path: Path) -> None:
    for i, frame in enumerate(frames):
        frame.to_csv(path, index=False, lineterminator="\n", float_format="%.10g", mode="a" if i else "w", header=not i)


def _write_parquet(frames: "Iterable[pd.DataFrame]", text: Collection[str], path: Path) -> None:
    import pyarrow as pa
    import pyarrow.parquet as pq

    writer: Any = None
    for frame in frames:
        if writer is None:
            schema = pa.Schema.from_pandas(frame, preserve_index=False)
            for name in text:
                schema = schema.set(schema.get_field_index(name), pa.field(name, pa.string()))
            writer = pq.ParquetWriter(path, schema, write_page_checksum=True)
        writer.write_table(pa.Table.from_pandas(frame, schema=schema, preserve_index=False))
    writer.close()


def is_exported(folder: Path, count: int) -> bool:
    """Whether the folder holds the exports of so many cases, undamaged as far as reading them tells."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table, results = (folder / name for name in EXPORTS)
    if not (table.exists() and results.exists()):
        return False
    try:
        with table.open("rb") as lines, pq.ParquetFile(results, page_checksum_verification=True) as read:
            return sum(1 for _ in lines) == count + 1 and sum(batch.num_rows for batch in read.iter_batches()) == count
    except (OSError, pa.ArrowInvalid):
        return False  # damaged: they are written again


def write_json(path: Path, content: Mapping[str, object]) -> None:
    """Write a JSON file, whole or not at all."""
    text = json.dumps(content, indent=2, sort_keys=True) + "\n"
    write_whole(path, lambda temporary: temporary.write_text(text, encoding="utf-8"))


def trajectory_path(folder: Path, index: int) -> Path:
    """Where the trajectory of a case lies."""
    return folder / "trajectories" / f"case_{index:04d}.parquet"


def ready_to_write() -> None:
    """Have at hand what writes trajectories and records, before processes are made that would each load it."""
    for name in ("pandas", "pyarrow.parquet"):
        importlib.import_module(name)


def write_trajectory(run: Run, path: Path) -> None:
    """All signals of a run (SI) over time, as Parquet."""
    _write_signals({"time": run.time, **run.signals}, path)


def _write_signals(signals: Mapping[str, np.ndarray], path: Path) -> None:
    import pandas as pd

    made(path.parent)
    frame = pd.DataFrame(signals)
    write_whole(path, lambda temporary: frame.to_parquet(temporary, index=False))


def record_path(folder: Path, case: Case) -> Path:
    """Where the record of a case lies: its name, its rpm where that is an axis, and its place among all cases."""
    parts = [
        file_name(case.name or "case"),
        *([f"{case.rpm:g}_rpm"] if "rpm" in case.axes else []),
        f"{case.index:04d}",
    ]
    return folder / RECORDS / f"{'_'.join(parts)}.parquet"


def write_record(run: Run, names: Sequence[str], rpm: float, path: Path) -> None:
    """Time and those of the named signals that the run has (SI), and the rpm that was set, as Parquet."""
    signals = {name: run.signals[name] for name in names if name in run.signals}
    _write_signals({"time": run.time, **signals, "rpm": np.full(run.time.size, rpm)}, path)


def read_sketches(folder: Path) -> dict[int, str]:
    """The sketches of trajectories that a study has kept, by case, fit to stand in a script; none where there is no
    database any more, or one of an earlier version.
    """
    database = folder / DATABASE
    if not database.exists():
        return {}
    with closing(sqlite3.connect(database)) as connection:
        if not connection.execute("SELECT 1 FROM sqlite_master WHERE name = 'sketches'").fetchone():
            return {}
        rows = connection.execute(f"SELECT {INDEX}, content FROM sketches ORDER BY {INDEX}").fetchall()
    return {int(index): str(content).replace("<", r"\u003c") for index, content in rows}


def finished_in(folder: Path) -> int:
    """How many cases are finished in a folder, where another command may be at work; 0 where none has begun."""
    database = folder / DATABASE
    if not database.exists():
        return 0
    try:
        with closing(sqlite3.connect(f"{database.resolve().as_uri()}?mode=ro", uri=True)) as connection:
            return int(connection.execute("SELECT COUNT(*) FROM results").fetchone()[0])
    except sqlite3.DatabaseError:
        return 0  # no table yet, or damaged: the run tells


def read_results(folder: Path, only: Collection[str] | None = None) -> "pd.DataFrame":
    """The results of a finished study: all columns, or the axes, the outcome, and `only` these of the others.

    Raises:
        UserError: there are none, or the file is damaged.
    """
    import pyarrow.parquet as pq

    path = folder / "results.parquet"
    if not path.exists() and (folder / DATABASE).exists():
        raise UserError(f"{folder}: holds no finished results yet; wait for the run there, or go on with --resume")
    if not path.exists():
        raise UserError(f"{folder}: holds no finished results; run a study with --out {folder} first")
    try:
        names = pq.read_schema(path).names
        first = names.index(OUTCOME.name) + 1
        chosen = names if only is None else [*names[:first], *(name for name in names[first:] if name in only)]
        checked = {"pre_buffer": False, "page_checksum_verification": True}
        table = pq.read_table(path, columns=chosen, use_threads=False, **checked)  # one after another
        return table.to_pandas(split_blocks=True, self_destruct=True)  # not twice in memory
    except (OSError, ValueError) as error:
        raise UserError(f"{path}: cannot be read ({error}); run the study again with --resume") from None
