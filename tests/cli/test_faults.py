"""Faults in the middle of tune and decide: a line each, exit code 2, and --resume goes on with what was finished."""

import errno
import itertools
import json
import os
import pkgutil
import shutil
import sqlite3
import time
from collections.abc import Callable
from contextlib import closing
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from command import STUDIES, changed, workbench, write
from kill_studies import DECIDE
from tuned_study import STUDY

from workbench.decide.kept import DATABASE as RUNS
from workbench.decide.report.folder import RUNS as DECIDE_FOLDER
from workbench.study.store import DATABASE
from workbench.tune.report.folder import FOLDER as TUNE_FOLDER

pytestmark = pytest.mark.usefixtures("dots_alone")

SHORT = DECIDE.replace("[0, 125]", "[0]").replace("fresh_draws = 60", "fresh_draws = 2").replace('"1 s"', '"0.1 s"')

GOES_ON = "what is finished is kept in @: mend that, then go on with --resume\n"


@dataclass(frozen=True)
class Subject:
    """A command, its study, where it keeps each piece of `work` that it has finished, and its folder."""

    words: tuple[str, ...]
    study: str
    database: str
    table: str
    work: str
    last: str
    folder: Any

    def __call__(self, folder: Path, *options: str) -> tuple[int, str]:
        """Exit code and complaint of the command; @ is the folder of its results."""
        path, out = write(folder, self.study), folder / "out"
        answer = workbench(self.words[0], path, *self.words[1:], "--out", out, "--jobs", "1", *options)
        assert answer.err.count("\n") <= 1
        return answer.code, answer.err.replace(str(out), "@")

    def rows(self, folder: Path) -> int:
        """How many pieces are kept."""
        with closing(sqlite3.connect(folder / "out" / self.database)) as connection:
            return int(connection.execute(f"SELECT COUNT(*) FROM {self.table}").fetchone()[0])


SUBJECTS = {
    "tune": Subject(
        words=("tune", "--controller", "p"),
        study=changed("trials = 20", "trials = 4", STUDY),
        database=DATABASE,
        table="trials",
        work="workbench.tune.search:Search._run",
        last="workbench.tune.report.folder.write_json",
        folder=TUNE_FOLDER,
    ),
    "decide": Subject(
        words=("decide",),
        study=SHORT,
        database=RUNS,
        table="runs",
        work="workbench.decide.batches:_measured",
        last="workbench.decide.report.folder.write_json",
        folder=DECIDE_FOLDER,
    ),
}


@pytest.fixture(params=SUBJECTS)
def subject(request: pytest.FixtureRequest) -> Subject:
    """Either command in turn."""
    return SUBJECTS[request.param]


def after(count: int, subject: Subject, then: Callable[[], object], patch: pytest.MonkeyPatch) -> None:
    """Let something happen when so many pieces of work are finished."""
    whole, numbers = pkgutil.resolve_name(subject.work), itertools.count()

    def counted(*arguments: Any) -> Any:
        if next(numbers) == count:
            then()
        return whole(*arguments)

    patch.setattr(subject.work.replace(":", "."), counted)


def stop() -> None:
    raise KeyboardInterrupt


def full(*_: object) -> None:
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_faults_one_after_the_other_lose_nothing(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, subject: Subject
) -> None:
    """Another program takes the database; the disk is full when all is to be written; the clock is set back."""
    monkeypatch.setattr("workbench.publish.database.PATIENCE", 0.01)
    other = sqlite3.connect(":memory:", check_same_thread=False)

    def taken() -> None:
        nonlocal other
        other = sqlite3.connect(tmp_path / "out" / subject.database, timeout=60.0, check_same_thread=False)
        other.execute("BEGIN EXCLUSIVE")

    with monkeypatch.context() as patch:
        after(2, subject, taken, patch)
        assert subject(tmp_path) == (2, f"error: @: database is locked; {GOES_ON}")
    other.close()
    assert subject.rows(tmp_path) == 2
    assert [path.name for path in (tmp_path / "out").iterdir()] == [subject.database]

    with monkeypatch.context() as patch:
        patch.setattr(subject.last, full)
        assert subject(tmp_path, "--resume") == (2, f"error: @: No space left on device; {GOES_ON}")
    kept = subject.rows(tmp_path)
    assert kept > 2
    assert not (tmp_path / "out" / "run.json").exists()

    clock = itertools.count(time.time(), -10.0)
    with monkeypatch.context() as patch:
        after(0, subject, stop, patch)  # nothing is left to run
        patch.setattr(time, "time", lambda: next(clock))
        assert subject(tmp_path, "--resume") == (0, "")
    assert subject.rows(tmp_path) == kept
    assert json.loads((tmp_path / "out" / "run.json").read_text(encoding="utf-8"))["wall_seconds"] == 0.0
    assert not list(tmp_path.rglob(".*"))


def test_a_folder_that_is_removed_in_mid_run(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, subject: Subject) -> None:
    after(2, subject, lambda: shutil.rmtree(tmp_path / "out"), monkeypatch)
    code, said = subject(tmp_path)
    assert code == 2
    assert said.startswith("error: @")
    assert said.endswith(GOES_ON)
    assert not (tmp_path / "out").exists()


def test_a_second_command_on_a_folder_is_told(tmp_path: Path, subject: Subject) -> None:
    with subject.folder.opened(tmp_path / "out") as database:
        database.write_text("of the first")
        for options in ((), ("--resume",), ("--overwrite",)):
            told = "error: @: another command is at work there; wait for it, or choose another --out\n"
            assert subject(tmp_path, *options) == (2, told)
        assert database.read_text() == "of the first"


@pytest.mark.parametrize("harm", ["a row", "the file"])
def test_damaged_runs_are_not_taken(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, subject: Subject, harm: str
) -> None:
    after(2, subject, stop, monkeypatch)
    assert subject(tmp_path)[0] == 130
    database = tmp_path / "out" / subject.database
    column = subject.table.removesuffix("s")
    with closing(sqlite3.connect(database)) as connection, connection:
        connection.execute(f"UPDATE {subject.table} SET {column} = substr({column}, 1, 20)")
    if harm == "the file":
        database.write_bytes(database.read_bytes()[:-2048] + os.urandom(2048))
    code, said = subject(tmp_path, "--resume")
    assert code == 2
    assert said.startswith(f"error: @/{subject.database}: is damaged (")
    assert said.endswith("); start anew with --overwrite, or choose another --out\n")


@pytest.mark.parametrize("command", ["identify", "diagnose"])
def test_a_second_command_of_all_or_nothing_is_told_before_the_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, command: str
) -> None:
    """And the first, on a disk that fills up, leaves nothing."""
    work = {"identify": "identify.identification.identify", "diagnose": "diagnose.diagnose.diagnose"}
    experiment, out = STUDIES / "closed_loop" / "experiment.toml", tmp_path / "out"
    busy = f"error: {out}: another command is at work there; wait for it, or choose another --out\n"

    def meanwhile(*_: object) -> None:
        assert workbench(command, experiment, "--out", out) == (2, "", busy)
        full()

    monkeypatch.setattr(f"workbench.{work[command]}", meanwhile)
    told = f"error: {out}: No space left on device; nothing is written: mend that and run it again\n"
    assert workbench(command, experiment, "--out", out) == (2, "", told)
    assert list(tmp_path.iterdir()) == []


def test_a_disk_that_fills_up_after_the_last_case_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Of a run, whose tables and pages come then: all cases are kept, and what remains is made with --resume."""
    study, out = write(tmp_path, STUDY), tmp_path / "out"
    told = f"error: {out}: No space left on device; all cases are kept in {out}: mend that, then go on with --resume\n"
    with monkeypatch.context() as patch:
        patch.setattr("workbench.study.report.folder.write_results_page", full)
        answer = workbench("run", study, "--out", out, "--jobs", "1")
        assert (answer.code, answer.err) == (2, told)
    assert workbench("run", study, "--out", out, "--resume").code == 0
    assert (out / "results.html").exists()
