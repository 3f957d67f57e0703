"""Folders for one command at a time, whole or not at all; databases that are committed while they grow."""

import errno
import os
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import pytest

from workbench.errors import UserError
from workbench.publish.database import Database, database_at
from workbench.publish.folders import GrowingFolder, ResultFolder, faults_told, write_whole
from workbench.publish.locks import alone

GROWING = GrowingFolder("tally", "marks", ("page.html", "marks.sqlite"))
RESULT = ResultFolder("answer", ("answer.json", "tables"))
TABLES = "CREATE TABLE IF NOT EXISTS marks (mark TEXT)"
BUSY = "@: another command is at work there; wait for it, or choose another --out"


def said(error: pytest.ExceptionInfo[UserError], folder: Path) -> str:
    """A message without the folder; of one line."""
    text = str(error.value).replace(str(folder), "@")
    assert "\n" not in text
    return text


# --- one command at a time ---


def test_a_lock_is_held_by_one_and_leaves_nothing(tmp_path: Path) -> None:
    path = tmp_path / ".lock"
    with alone(path, "busy"):
        for _ in range(2):
            with pytest.raises(UserError, match="busy"), alone(path, "busy"):
                raise AssertionError
    assert not path.exists()
    with alone(path, "busy"):
        assert path.exists()


HOLDER = """\
import sys, time
from pathlib import Path
from workbench.publish.locks import alone
with alone(Path(sys.argv[1]), "busy"):
    print("held", flush=True)
    time.sleep(60)
"""


def test_the_lock_of_a_killed_process_is_free(tmp_path: Path) -> None:
    path = tmp_path / ".lock"
    with subprocess.Popen([sys.executable, "-c", HOLDER, path], stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout is not None
        assert holder.stdout.readline() == "held\n"
        with pytest.raises(UserError, match="busy"), alone(path, "busy"):
            raise AssertionError
        holder.kill()
    assert path.exists()
    with alone(path, "busy"):
        pass
    assert not path.exists()


def test_a_folder_that_is_removed_meanwhile_is_no_traceback(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with GROWING.opened(folder):
        (folder / ".lock").unlink()
        folder.rmdir()
    assert not folder.exists()


def test_a_growing_folder_serves_one_command(tmp_path: Path) -> None:
    with GROWING.opened(tmp_path) as mark:
        mark.touch()
        for options in ({"resume": True}, {"overwrite": True}, {}):
            with pytest.raises(UserError) as error, GROWING.opened(tmp_path, **options):
                raise AssertionError
            assert said(error, tmp_path) == BUSY
    assert [path.name for path in tmp_path.iterdir()] == ["marks.sqlite"]


@pytest.mark.parametrize("there", [True, False])
def test_a_folder_of_results_serves_one_command(tmp_path: Path, there: bool) -> None:
    folder = tmp_path / "out"
    if there:
        folder.mkdir()
    with RESULT.claimed(folder, overwrite=False):
        with pytest.raises(UserError) as error, RESULT.claimed(folder, overwrite=True):
            raise AssertionError
        assert said(error, folder) == BUSY
        RESULT.write(folder, lambda beside: (beside / "answer.json").write_text("42"))
    assert {path.name for path in (*tmp_path.iterdir(), *folder.iterdir())} == {"out", "answer.json"}


# --- going on ---


def test_where_there_is_nothing_to_go_on_with_work_begins(tmp_path: Path) -> None:
    """No folder, an empty one, one that a kill left with a lock alone; then what is there stays."""
    for name in ("none", "empty", "locked"):
        folder = tmp_path / name
        if name != "none":
            folder.mkdir()
        if name == "locked":
            (folder / ".lock").touch()
        with GROWING.opened(folder, resume=True) as mark:
            assert not mark.exists()
            mark.write_text("mine")
        with GROWING.opened(folder, resume=True) as mark:
            assert mark.read_text() == "mine"
        with pytest.raises(UserError, match=r"holds marks already; go on with --resume"), GROWING.opened(folder):
            raise AssertionError
        with GROWING.opened(folder, overwrite=True) as mark:
            assert not mark.exists()


def test_what_others_wrote_is_not_gone_on_with(tmp_path: Path) -> None:
    (tmp_path / "page.html").write_text("mine")
    with pytest.raises(UserError) as error, GROWING.opened(tmp_path, resume=True):
        raise AssertionError
    assert said(error, tmp_path) == "@: holds page.html that no tally wrote; choose another folder with --out"
    assert [path.name for path in tmp_path.iterdir()] == ["page.html"]


def test_the_journal_of_a_database_that_is_replaced_goes_with_it(tmp_path: Path) -> None:
    for name in ("marks.sqlite", "marks.sqlite-journal"):
        (tmp_path / name).write_text("of a killed command")
    with GROWING.opened(tmp_path, overwrite=True):
        assert [path.name for path in tmp_path.iterdir()] == [".lock"]


@pytest.mark.parametrize("there", [True, False])
def test_what_a_kill_left_is_cleaned(tmp_path: Path, there: bool) -> None:
    folder = tmp_path / "out"
    left = (folder if there else tmp_path) / (".answer.part" if there else ".out.part")
    left.mkdir(parents=True)
    (left / "answer.json").write_text("half")
    with RESULT.claimed(folder, overwrite=False):
        assert not left.exists()
        RESULT.write(folder, lambda beside: (beside / "answer.json").write_text("42"))
    assert not left.exists()
    assert (folder / "answer.json").read_text() == "42"


# --- faults ---


def full(path: Path) -> None:
    """Half a file, and no place for the rest."""
    path.write_text("half")
    raise OSError(errno.ENOSPC, os.strerror(errno.ENOSPC))


def test_a_full_disk_leaves_files_as_they_were(tmp_path: Path) -> None:
    path = tmp_path / "a.csv"
    path.write_text("whole")
    with pytest.raises(OSError, match="No space left"):
        write_whole(path, full)
    assert [each.read_text() for each in tmp_path.iterdir()] == ["whole"]


def test_a_full_disk_leaves_no_answer(tmp_path: Path) -> None:
    folder = tmp_path / "out"
    with pytest.raises(UserError) as error, RESULT.claimed(folder, False):
        RESULT.write(folder, lambda beside: full(beside / "answer.json"))
    assert said(error, folder) == "@: No space left on device; nothing is written: mend that and run it again"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("folder", ["/proc/no/such/folder", "file", "file/below"])
def test_a_place_that_cannot_be_written_is_told_before_the_work(tmp_path: Path, folder: str) -> None:
    (tmp_path / "file").write_text("mine")
    path = tmp_path / folder
    for opened in (GROWING.opened(path, resume=True), RESULT.claimed(path, overwrite=True)):
        with pytest.raises(UserError) as error, opened:
            raise AssertionError
        assert "--out" in said(error, path)
    assert (tmp_path / "file").read_text() == "mine"


def test_a_fault_names_the_file_that_it_is_of(tmp_path: Path) -> None:
    with pytest.raises(UserError) as error, faults_told(tmp_path, "all is kept"):
        (tmp_path / "none" / "a.csv").write_text("")
    assert said(error, tmp_path) == "@/none/a.csv: No such file or directory; all is kept"


# --- databases ---


def marks(path: Path) -> list[str]:
    """What another connection sees."""
    with closing(sqlite3.connect(f"{path.as_uri()}?mode=ro", uri=True)) as connection:
        return [mark for (mark,) in connection.execute("SELECT mark FROM marks")]


def mark(database: Database, *texts: str) -> None:
    database.write("INSERT INTO marks VALUES (?)", *((text,) for text in texts))


def test_rows_are_committed_a_little_while_after_they_are_written(tmp_path: Path) -> None:
    """By themselves, in the middle of work that goes on; with an error too."""
    path = tmp_path / "marks.sqlite"

    def work() -> None:
        with database_at(path, TABLES) as database:
            mark(database, "a", "b")
            deadline = time.monotonic() + 60.0
            while marks(path) != ["a", "b"] and time.monotonic() < deadline:
                time.sleep(0.01)
            assert marks(path) == ["a", "b"]
            mark(database, "c")
            raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        work()
    assert marks(path) == ["a", "b", "c"]


def test_a_database_that_a_kill_left_empty_is_filled(tmp_path: Path) -> None:
    (tmp_path / "marks.sqlite").touch()
    with database_at(tmp_path / "marks.sqlite", TABLES) as database:
        mark(database, "a")
    assert marks(tmp_path / "marks.sqlite") == ["a"]


@pytest.mark.parametrize("harm", ["truncated", "overwritten", "text"])
def test_a_damaged_database_is_told_and_left_alone(tmp_path: Path, harm: str) -> None:
    path = tmp_path / "marks.sqlite"
    with database_at(path, TABLES) as database:
        mark(database, *(f"{number} " * 100 for number in range(200)))
    whole = path.read_bytes()
    harmed = {"truncated": whole[: len(whole) // 2], "overwritten": whole[:4096] + b"\xff" * (len(whole) - 4096)}
    path.write_bytes(harmed.get(harm, b"not a database" * 100))
    before = path.read_bytes()
    with pytest.raises(UserError) as error, database_at(path, TABLES):
        raise AssertionError
    assert said(error, path).startswith("@: is damaged (")
    assert said(error, path).endswith("); start anew with --overwrite, or choose another --out")
    assert path.read_bytes() == before


def test_damaged_text_is_told(tmp_path: Path) -> None:
    path = tmp_path / "marks.sqlite"
    with database_at(path, TABLES) as database:
        mark(database, "a mark that is long enough to be found")
    path.write_bytes(path.read_bytes().replace(b"long enough", b"long \xff\xfe\xff\xfegh"))
    with database_at(path, TABLES) as database, pytest.raises(UserError) as error:
        database.read("SELECT mark FROM marks")
    assert said(error, path).startswith("@: is damaged ('utf-8' codec can't decode byte 0xff")


def test_a_database_that_another_program_holds(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("workbench.publish.database.PATIENCE", 0.01)
    path = tmp_path / "marks.sqlite"
    with database_at(path, TABLES) as database:
        mark(database, "a")
    with closing(sqlite3.connect(path)) as other:
        other.execute("BEGIN EXCLUSIVE")
        with pytest.raises(UserError) as error, faults_told(path, "it is kept"), database_at(path, TABLES):
            raise AssertionError
        assert said(error, path) == "@: database is locked; it is kept"
    assert marks(path) == ["a"]


def test_a_full_disk_ends_the_work_and_keeps_what_was_committed(tmp_path: Path) -> None:
    """SQLite's own limit on pages in place of a small disk."""
    path = tmp_path / "marks.sqlite"

    def work() -> None:
        with faults_told(tmp_path, "it is kept"), database_at(path, f"{TABLES}; PRAGMA max_page_count = 4") as database:
            mark(database, "a")
            database.commit()
            mark(database, *(f"{number} " * 1000 for number in range(200)))

    with pytest.raises(UserError) as error:
        work()
    assert said(error, tmp_path) == "@: database or disk is full; it is kept"
    assert marks(path) == ["a"]
