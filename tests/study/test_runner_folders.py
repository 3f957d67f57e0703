"""Folders of results: those that do not serve, what a killed run leaves, and that it goes on to the same bytes."""

import re
import shutil
import sqlite3
import subprocess
import sys
import time
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pandas as pd
import pytest
from command import PIPED, PROCESS, STUDY, changed, killed, ran, workbench, write

from workbench.study.store import Row, open_store

NOISE = '[sensors.position]\nnoise = "10 um"\n'

MANY = (
    changed('"1 s"', '"0.3 s"')
    .replace('"0.4 s"', '"0.1 s"')
    .replace("[0, 460]", "[0, 460]\n" + '"controllers.p.kp" = [100, 200, 300, 400]\n"simulation.seed" = [1, 2, 3]')
    + 'method = "rk4"\nstep = "10 us"\n'
    + NOISE
)
"""24 cases that take a little while each."""


def rows(folder: Path) -> int:
    """Rows committed so far."""
    try:
        with closing(sqlite3.connect(f"file:{folder / 'results.sqlite'}?mode=ro", uri=True)) as connection:
            return int(connection.execute("SELECT COUNT(*) FROM results").fetchone()[0])
    except sqlite3.Error:
        return 0


# --- folders that do not serve ---


def complaint(folder: Path, *options: str | Path, study: str = STUDY) -> str:
    """What a run that is refused says, without the folder."""
    answer = workbench("run", write(folder, study), *options)
    assert (answer.code, answer.err.count("\n")) == (2, 1)
    return answer.err.removeprefix("error: ").rstrip("\n").replace(str(folder), "@")


def test_results_are_not_replaced_unasked(tmp_path: Path) -> None:
    out = ran(tmp_path, STUDY)
    before = (out / "results.csv").read_bytes()
    said = complaint(tmp_path, "--out", out, study=changed("5 mm", "6 mm"))
    assert said == "@/results: holds results already; go on with --resume, start anew with --overwrite"
    assert (out / "results.csv").read_bytes() == before
    assert (ran(tmp_path, changed("5 mm", "6 mm"), "--overwrite") / "results.csv").read_bytes() != before


def test_another_study_cannot_be_resumed(tmp_path: Path) -> None:
    out = ran(tmp_path, STUDY)
    before = (out / "results.csv").read_bytes()
    said = complaint(tmp_path, "--out", out, "--resume", study=changed("5 mm", "6 mm"))
    assert said == (
        "@/results: its results are of another study (references.sine.amplitude: '5 mm' there, '6 mm' here); start "
        "anew with --overwrite, or choose another --out"
    )
    assert (out / "results.csv").read_bytes() == before
    assert (out / "study.toml").read_text(encoding="utf-8") == STUDY


@pytest.mark.parametrize(
    ("study", "said"),
    [
        (changed("rpm = [0, 460]", "rpm = [0, 120]"), "(axes.rpm: [0, 460] there, [0, 120] here)"),
        (f"{STUDY}seed = 3\n", "(simulation.seed: nothing there, 3 here)"),
        (changed("duration", "sample_time = 0.002\nduration"), "(simulation.sample_time: nothing there, 0.002 here)"),
    ],
)
def test_what_makes_it_another_study_is_said(tmp_path: Path, study: str, said: str) -> None:
    out = ran(tmp_path, STUDY)
    assert said in complaint(tmp_path, "--out", out, "--resume", study=study)


def test_the_order_of_axes_and_cases_counts(tmp_path: Path) -> None:
    """They number the rows and columns of results; the order of other tables is nothing."""
    axes = '"simulation.tolerance" = [1e-6, 1e-7]\n"simulation.transient" = ["0.2 s", "0.3 s"]\n'
    first, second = axes.splitlines()
    study = changed("rpm = [0, 460]\n", axes) + "[cases.a]\n[cases.b.plant.scale]\nmass = 2\n"
    out = ran(tmp_path, study)
    swapped = study.replace(axes, f"{second}\n{first}\n")
    said = complaint(tmp_path, "--out", out, "--resume", study=swapped)
    assert "of another study (order.axes: ['simulation.tolerance', 'simulation.transient'] there" in said
    cases = study.replace("[cases.a]\n", "") + "[cases.a]\n"
    assert "(order.cases: ['a', 'b'] there, ['b', 'a'] here)" in complaint(
        tmp_path, "--out", out, "--resume", study=cases
    )
    turned = study.replace('kind = "sine"\namplitude = "5 mm"', 'amplitude = "5 mm"\nkind = "sine"')
    assert workbench("run", write(tmp_path, turned), "--out", out, "--resume").code == 0


def test_another_controller_of_the_same_gains_is_another(tmp_path: Path) -> None:
    """What a gain file says of the controller's type counts beside its numbers."""
    gains = 'type = "{}"\n[[at]]\nsettings = {{ position_rate = "34 1/s" }}\n'
    study = changed('type = "pid"\nkp = "500 V/m"', 'gains = "gains.toml"')
    write(tmp_path, gains.format("static_map"), "gains.toml")
    out = ran(tmp_path, study)
    write(tmp_path, gains.format("uncompensated"), "gains.toml")
    assert "its results are of other parameters" in complaint(tmp_path, "--out", out, "--resume", study=study)


@pytest.mark.parametrize("name", ["results.csv", "results.parquet"])
def test_damaged_exports_are_written_again(tmp_path: Path, name: str) -> None:
    out = ran(tmp_path, STUDY)
    whole = (out / name).read_bytes()
    (out / name).write_bytes(whole[:500] if name.endswith("csv") else whole[:60] + bytes(20) + whole[80:])
    if name.endswith("parquet"):
        assert "cannot be read" in workbench("table", out, "--column", "rms_error_m").err
    assert workbench("run", write(tmp_path, STUDY), "--out", out, "--resume").code == 0
    assert (out / name).read_bytes() == whole


def test_other_draws_are_told_from_other_parameters(tmp_path: Path) -> None:
    drawn = f"{STUDY}\n[uncertainty]\ndraws = 2\nscale.mass = {{ min = 0.8, max = 1.5 }}\n"
    out = ran(tmp_path, drawn)
    for old, new, said in (
        ("draws = 2", "draws = 3", "(uncertainty.draws: 2 there, 3 here)"),
        ("max = 1.5", "max = 1.6", "(uncertainty.scale.mass.max: 1.5 there, 1.6 here)"),
    ):
        answer = complaint(tmp_path, "--out", out, "--resume", study=drawn.replace(old, new))
        assert answer.startswith(f"@/results: its results are of other draws {said}; start anew with --overwrite")


@pytest.mark.parametrize("left", ["no folder", "an empty folder", "an empty database"])
def test_resuming_begins_where_nothing_is_there_yet(tmp_path: Path, left: str) -> None:
    """A script repeats its command, whenever it was stopped."""
    out = tmp_path / "out"
    if left != "no folder":
        out.mkdir()
    if left == "an empty database":
        write(out, "", "results.sqlite")
    assert workbench("run", write(tmp_path, STUDY), "--out", out, "--resume").code == 0
    assert (out / "results.csv").read_bytes() == (ran(tmp_path, STUDY) / "results.csv").read_bytes()


def test_what_is_no_database_cannot_be_resumed(tmp_path: Path) -> None:
    (tmp_path / "none").mkdir()
    write(tmp_path / "none", "not a database", "results.sqlite")
    said = complaint(tmp_path, "--out", tmp_path / "none", "--resume")
    assert said == (
        "@/none/results.sqlite: is damaged (file is not a database); "
        "start anew with --overwrite, or choose another --out"
    )


def test_resume_or_overwrite(tmp_path: Path) -> None:
    said = complaint(tmp_path, "--out", tmp_path / "out", "--resume", "--overwrite")
    assert said == "--resume and --overwrite: choose one"


@pytest.mark.parametrize("place", ["file", "file/below", "/proc/no/such/folder"])
def test_a_folder_that_cannot_be_written(tmp_path: Path, place: str) -> None:
    write(tmp_path, "mine", "file")
    folder = Path(place) if place.startswith("/") else tmp_path / place
    said = complaint(tmp_path, "--out", folder)
    assert "cannot be written (" in said
    assert said.endswith("choose another folder with --out")
    assert ("(it is a file, or lies in one)" in said) == place.startswith("file")
    assert (tmp_path / "file").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("options", [(), ("--overwrite",)])
def test_files_of_others_are_never_removed(tmp_path: Path, options: tuple[str, ...]) -> None:
    """A thesis has a folder of figures of its own."""
    (tmp_path / "figures").mkdir()
    write(tmp_path / "figures", "mine", "rig.svg")
    said = complaint(tmp_path, "--out", tmp_path, *options)
    assert said == "@: holds study.toml, figures that no run wrote; choose another folder with --out"
    assert (tmp_path / "figures" / "rig.svg").read_text(encoding="utf-8") == "mine"


SCENARIO = 'title = "t"\nsource = "s"\n[plant.scale]\ncoulomb = 1.5\n'


def scenario_study(folder: Path) -> str:
    """A study that names one of the two scenario files beside it."""
    (folder / "scenarios").mkdir()
    write(folder / "scenarios", SCENARIO, "worn.toml")
    write(folder / "scenarios", SCENARIO, "other.toml")
    return changed("[0, 460]", '[0]\nscenario = ["worn"]')


def test_results_can_be_run_again_from_their_copy_of_the_study(tmp_path: Path) -> None:
    """Also into themselves; the scenario file comes along, one that the study does not name stays behind."""
    out = ran(tmp_path, scenario_study(tmp_path))
    assert [path.name for path in (out / "scenarios").iterdir()] == ["worn.toml"]
    expected = (out / "results.csv").read_bytes()
    shutil.rmtree(tmp_path / "scenarios")
    for again, option in ((tmp_path / "again", ()), (out, ("--overwrite",)), (out, ("--resume",))):
        answer = workbench("run", out / "study.toml", "--out", again, *option)
        assert (answer.code, answer.err) == (0, "")
        assert (again / "results.csv").read_bytes() == expected
        assert (again / "scenarios" / "worn.toml").read_text(encoding="utf-8") == SCENARIO


def test_scenarios_of_others_are_never_removed(tmp_path: Path) -> None:
    """Results beside the study: refused where a folder of scenarios is, and one that came later is kept."""
    study = scenario_study(tmp_path)
    mine = write(tmp_path, study, "mine.toml")
    refused = workbench("run", mine, "--out", tmp_path)
    assert refused.err.replace(str(tmp_path), "@") == (
        "error: @: holds scenarios that no run wrote; choose another folder with --out\n"
    )
    (tmp_path / "scenarios").rename(tmp_path / "later")
    assert workbench("run", write(tmp_path, STUDY, "plain.toml"), "--out", tmp_path).code == 0
    (tmp_path / "later").rename(tmp_path / "scenarios")
    assert workbench("run", mine, "--out", tmp_path, "--overwrite").code == 0
    assert sorted(path.name for path in (tmp_path / "scenarios").iterdir()) == ["other.toml", "worn.toml"]


def test_a_cluster_that_does_not_answer(tmp_path: Path) -> None:
    said = complaint(tmp_path, "--out", tmp_path / "out", "--cluster", "nonsense://nowhere")
    assert said.startswith(("nonsense://nowhere: no scheduler answers there (", "--cluster needs the extra"))


# --- killed, and in parallel ---


def test_the_same_bytes_whatever_the_jobs_killed_and_resumed_or_not(tmp_path: Path) -> None:
    """A real process, killed with SIGKILL once some cases are committed, and resumed."""
    study = write(tmp_path, MANY)
    part = tmp_path / "killed"
    complaints = killed(lambda: rows(part) >= 3, "run", study, "--out", part, "--jobs", "1")
    assert complaints.count(b"\n") == 1
    assert b"warning: " in complaints, "less than a period is left after the transient"
    assert 3 <= rows(part) < 24
    assert not (part / "results.csv").exists(), "no table before all cases are done"

    unfinished = workbench("table", part)
    assert unfinished.code == 2
    assert "holds no finished results" in unfinished.err
    kept = rows(part)
    assert workbench("run", study, "--out", part, "--jobs", "2", "--resume").code == 0
    assert workbench("run", study, "--out", tmp_path / "one", "--jobs", "1").code == 0
    assert workbench("run", study, "--out", tmp_path / "two", "--jobs", "2").code == 0
    first, second, resumed = ((tmp_path / name / "results.csv").read_bytes() for name in ("one", "two", "killed"))
    assert first == second == resumed
    assert first.count(b"\n") == 25
    assert kept < 24


def test_resume_runs_only_what_is_missing(tmp_path: Path) -> None:
    """A row in the database stands, even an absurd one."""
    out = ran(tmp_path, STUDY)
    with closing(sqlite3.connect(out / "results.sqlite")) as connection, connection:
        connection.execute("UPDATE results SET rms_error_m = 42 WHERE case_index = 0")
        connection.execute("DELETE FROM results WHERE case_index = 1")
    before = pd.read_csv(out / "results.csv")
    ran(tmp_path, STUDY, "--resume")
    after = pd.read_csv(out / "results.csv")
    assert after["rms_error_m"].tolist() == [42.0, before["rms_error_m"][1]]


def test_rows_are_committed_as_they_come(tmp_path: Path) -> None:
    """A second connection sees them while the first is open."""
    out = tmp_path / "out"
    with open_store(out, ["rpm", "outcome"], {"study": "a"}) as store:
        store.add([Row(1, [460, "completed"]), Row(2, [460, "stuck"])])
        until(lambda: rows(out) == 2)
        store.add([Row(0, [None, "diverged"])])
        assert store.done() == {0, 1, 2}
        (frame,) = store.frames()
    assert frame["outcome"].tolist() == ["diverged", "completed", "stuck"]


def until(condition: Callable[[], bool]) -> None:
    for _ in range(200):
        if condition():
            return
        time.sleep(0.05)
    pytest.fail("waited in vain")


def test_results_in_several_frames_are_those_of_one(tmp_path: Path) -> None:
    """What a column holds shows in some frames alone: numbers in one, a name in another, nothing in a third."""
    rows = [
        [1, 3, 2.0, None, None],
        [0.5, 4, None, None, None],
        ["a", 5, 3, None, "b"],
        [None, 6, 0.1 + 0.2, None, None],
    ]
    with open_store(tmp_path / "out", ["mixed", "whole", "real", "none", "word"], {"study": "a"}) as store:
        store.add([Row(i, row) for i, row in enumerate(rows)])
        for name, count in (("one", 4), ("several", 1)):
            (tmp_path / name).mkdir()
            store.export(tmp_path / name, count)
    assert (tmp_path / "several" / "results.csv").read_bytes() == (tmp_path / "one" / "results.csv").read_bytes()
    one, several = (pd.read_parquet(tmp_path / name / "results.parquet") for name in ("one", "several"))
    pd.testing.assert_frame_equal(one, several)
    assert one["mixed"].tolist()[:3] == ["1", "0.5", "a"]
    assert [str(kind) for kind in one.dtypes[1:3]] == ["int64", "float64"]


def test_plain_lines_when_piped(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """How far it is, and how long it may take; no control codes, and nothing of a run that is short."""
    study = write(tmp_path, changed("rpm = [0, 460]", "rpm = [0, 50, 100, 150, 200, 250]"))
    words = ["run", str(study), "--out", str(tmp_path / "out"), "--jobs", "1"]
    command = [sys.executable, "-c", PIPED.format(interval="0.0"), *words]
    told = subprocess.run(command, capture_output=True, text=True, check=True)
    lines = told.stderr.splitlines()
    assert [line.partition(",")[0] for line in lines] == [f"{count} of 6 cases" for count in range(1, 6)]
    assert lines[0] == "1 of 6 cases"  # which had to be compiled, and tells nothing of the others
    assert all(re.fullmatch(r"\d of 6 cases, about \d+ (s|min) left", line) for line in lines[1:])
    assert "\x1b" not in told.stdout + told.stderr
    monkeypatch.setattr("workbench.cli.progress.INTERVAL", 1e9)
    assert workbench(*words, "--overwrite").err == ""


def test_a_line_is_seen_when_it_is_written(tmp_path: Path) -> None:
    """The plan of a study that is still running, in a pipe."""
    study = write(tmp_path, changed('duration = "1 s"', 'duration = "500 s"'))
    command = [*PROCESS, "run", str(study), "--out", str(tmp_path / "out"), "--jobs", "1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None
        first = running.stdout.readline()
        still = running.poll() is None
        running.kill()
    assert first == "a study for tests\n"
    assert still
