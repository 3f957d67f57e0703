"""What `workbench tune` leaves in its folder.

tuned/NAME.toml            gains of each controller, as a study names them
results.csv, trials.csv    a row a controller; a row a trial (SI)
tuning.html, tables/, figures/
results.sqlite             the trials, while they are found: a row a trial
contents.json              what it says, for `workbench report`
study.toml, run.json       the study, and what ran it; run.json is there only where all is
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pandas as pd

from workbench.errors import visible
from workbench.parallel.workers import workers
from workbench.progress import Progress, silent
from workbench.publish.contents import CONTENTS, Contents, write_contents
from workbench.publish.folders import GrowingFolder, remove, write_whole
from workbench.publish.pictures import save
from workbench.publish.run_record import PACKAGES, ran_on
from workbench.publish.tables import write_frame
from workbench.study.store import DATABASE, STUDY_COPY, write_json
from workbench.toml.file_names import file_name
from workbench.toml.gain_file import gain_file_text
from workbench.tune.report.bode import bode_picture
from workbench.tune.report.error import error_picture
from workbench.tune.report.gain_files import gain_files
from workbench.tune.report.history import history_picture
from workbench.tune.report.importance import importance_picture
from workbench.tune.report.page import page
from workbench.tune.report.panels import Picture, Pictures
from workbench.tune.report.rows import Row, result_row, trial_rows
from workbench.tune.report.step import step_picture
from workbench.tune.report.tables import Table, brief, tables_of
from workbench.tune.report.traces import traces_of
from workbench.tune.report.words import first_lines, held_equal, infeasible_lines, sentences
from workbench.tune.result import Tuning
from workbench.tune.schema import tune_table

GAINS, RESULTS, TRIALS, PAGE, RECORD = "tuned", "results.csv", "trials.csv", "tuning.html", "run.json"
MOST_DRAWN = 24
"""Tunings of which figures are drawn."""

LAST = (PAGE, CONTENTS, RECORD)
"""What is there only where all is."""

SHOWN = (GAINS, RESULTS, TRIALS, "tables", "figures")
FOLDER = GrowingFolder("tuning", "trials", (STUDY_COPY, *SHOWN, *LAST, DATABASE))
"""What a tuning may write, and replace; the database, which marks the folder as its own, last."""


opened_folder = FOLDER.opened


@dataclass(frozen=True, eq=False)
class Written:
    """What a tuning has left: its folder, its results a row a controller, and what is said of them."""

    folder: Path
    results: pd.DataFrame
    lines: Sequence[str]
    table: Table


def write_tuning(
    tuning: Tuning,
    folder: Path,
    *,
    began: float,
    jobs: int | None = None,
    cluster: str | None = None,
    progress: Progress = silent,
) -> Written:
    """Write gains, results, trials, tables, figures and the page; run.json, which says that all are there, last.

    `began`: when the tuning did (s since the epoch), with so many `jobs` or on a `cluster`. `progress` is told what is
    being made, and how far all is.
    """
    for name in LAST:
        remove(folder / name)
    (folder / STUDY_COPY).write_text(tuning.study.text, encoding="utf-8")
    _write_gains(tuning, folder / GAINS)
    _write_rows([row for tuned in tuning.tuned for row in trial_rows(tuned)], folder / TRIALS)
    results = _write_rows([result_row(tuned) for tuned in tuning.tuned], folder / RESULTS)
    for name in ("tables", "figures"):
        remove(folder / name)
    tables = tables_of(tuning)
    for name, table in tables.items():
        write_frame(name, table, folder / "tables")
    progress("figures", 0.95)
    pictures = _pictures(tuning, jobs)
    for name, picture in {**pictures.shared, **pictures.own}.items():
        save(picture.figure, name, folder / "figures", caption=picture.caption)
    html = page(tuning, tables, pictures, folder)
    write_whole(folder / PAGE, lambda path: path.write_text(html, encoding="utf-8"))
    record = _record(tuning, began, cluster or jobs)
    write_contents(_contents(tuning, tables, pictures, record), folder)
    write_json(folder / RECORD, record)
    lines = [*first_lines(tuning), *infeasible_lines(tuning)]
    return Written(folder, results, lines, tables["tuning"])


def _write_gains(tuning: Tuning, folder: Path) -> None:
    """A gain file of each controller, by machine where it is tuned for several, with the entries that there are."""
    remove(folder)
    folder.mkdir()
    for name, content in gain_files(tuning.tuned).items():
        (folder / name).parent.mkdir(exist_ok=True)
        write_whole(folder / name, partial(Path.write_text, data=gain_file_text(content), encoding="utf-8"))


def _write_rows(rows: Sequence[Row], path: Path) -> pd.DataFrame:
    frame = pd.DataFrame([row.columns for row in rows])
    write_whole(path, lambda beside: frame.to_csv(beside, index=False, lineterminator="\n"))
    return frame


def _pictures(tuning: Tuning, jobs: int | None) -> Pictures:
    if len(tuning.tuned) > MOST_DRAWN:
        return Pictures(
            {}, {}, [f"No figures: {len(tuning.tuned)} tunings are more than the {MOST_DRAWN} that are drawn."]
        )
    if tune_table(tuning.study).per:
        return Pictures({"history": history_picture(tuning)}, {}, [])
    with workers(jobs) as executor:
        traced = traces_of(tuning, executor)
    shared = {
        "history": history_picture(tuning),
        "importance": importance_picture(tuning),
        "step": step_picture(traced),
        "error": error_picture(traced),
    }
    own = {f"bode_{file_name(tuned.task.name)}": bode_picture(tuned) for tuned in tuning.tuned}
    return Pictures(
        {name: drawn for name, drawn in shared.items() if isinstance(drawn, Picture)},
        {name: drawn for name, drawn in own.items() if isinstance(drawn, Picture)},
        [drawn for drawn in (*shared.values(), *own.values()) if isinstance(drawn, str)],
    )


def _contents(
    tuning: Tuning, tables: Mapping[str, Table], pictures: Pictures, record: Mapping[str, object]
) -> Contents:
    study = tuning.study
    return Contents(
        title=study.file.title,
        question=study.file.question,
        answer=sentences(tuning),
        notes=[*held_equal(tuning), *pictures.missing],
        command=f"workbench tune {study.path.name}",
        tables=list(tables),
        figures=[*pictures.shared, *pictures.own],
        details=[],
        provenance=record,
        file=study.path.name,
        text=study.text,
    )


def _record(tuning: Tuning, began: float, jobs: int | str | None) -> dict[str, object]:
    """What ran: as run.json of a study says it."""
    return {**tuning.provenance, **ran_on(began, jobs, (*PACKAGES, "optuna"))}


def say_tuning(written: Written) -> None:
    """Print what a tuning found, and where it is."""
    print(visible("\n".join(written.lines)))
    print(visible(f"\n{brief(written.table).to_markdown(index=False, disable_numparse=True)}\n"))
    print(f"wrote {written.folder / PAGE}")
    print(f"results in {written.folder}: {', '.join(name for name in SHOWN if (written.folder / name).exists())}")
