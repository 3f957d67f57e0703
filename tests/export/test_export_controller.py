"""workbench export controller: its folder, its test program, and what it refuses."""

import json
import shutil
import subprocess
from pathlib import Path

import pytest
from command import changed, fails, workbench, write

from workbench.publish.folders import LOCK

SHORT = changed('duration = "1 s"', 'duration = "0.6 s"')
"""A study of two cases."""


def exported(folder: Path, *options: str, text: str = SHORT) -> Path:
    out = folder / "c"
    answer = workbench("export", "controller", write(folder, text), "--out", out, "--case", "rpm=460", *options)
    assert (answer.code, answer.err) == (0, "")
    assert "a step takes at most 24 additions, 26 multiplications, 2 divisions, 9 comparisons" in answer.out
    assert "measured: position\n" in answer.out
    return out


def made_and_run(folder: Path) -> "subprocess.CompletedProcess[str]":
    flags = "CFLAGS=-Werror -Wshadow -Wconversion -Wdouble-promotion"
    return subprocess.run(
        ["make", "-s", "-B", "-C", str(folder), "test", flags], capture_output=True, text=True, check=False
    )


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_the_folder_replays_the_study_and_notices_other_gains(tmp_path: Path) -> None:
    out = exported(tmp_path)
    assert {path.name for path in out.iterdir()} - {LOCK} == {
        *("p.h", "p.c", "main.c", "vector.h", "Makefile", "README.md", "export.json")
    }
    done = made_and_run(out)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout == "p: 601 steps, twice: greatest difference 0 V, bound 1e-09 V: equal\n"
    source = (out / "p.c").read_text(encoding="utf-8")
    (out / "p.c").write_text(changed(".proportional = 500.0,", ".proportional = 500.1,", source), encoding="utf-8")
    done = made_and_run(out)
    assert done.returncode != 0
    assert done.stdout.endswith(": DIFFERENT\n")


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_single_precision_has_a_bound_of_its_own(tmp_path: Path) -> None:
    done = made_and_run(exported(tmp_path, "--precision", "single"))
    assert (done.returncode, done.stderr) == (0, "")
    assert "bound 0.01 V: equal" in done.stdout
    assert float(done.stdout.partition("difference ")[2].split()[0]) > 0.0


def test_the_same_study_gives_the_same_bytes_and_nothing_of_this_machine(tmp_path: Path) -> None:
    first = {path.name: path.read_bytes() for path in exported(tmp_path).iterdir()}
    again = {path.name: path.read_bytes() for path in exported(tmp_path, "--overwrite").iterdir()}
    assert again == first
    assert not any(str(tmp_path).encode() in content for content in first.values())
    record = json.loads(first["export.json"])
    assert (record["case"], record["controller"], record["sample_time_s"]) == ({"rpm": 460}, "pid", 0.001)
    assert record["operations"]["multiplications"] == 26


def test_the_controller_of_the_rotation(tmp_path: Path) -> None:
    out = tmp_path / "c"
    study = write(tmp_path, SHORT)
    answer = workbench("export", "controller", study, "--out", out, "--case", "rpm=460", "--rotation")
    assert (answer.code, answer.err) == (0, "")
    assert "measured: rotation_speed, motor_current" in answer.out
    assert "rotation_step(rotation_state *state" in (out / "rotation.h").read_text(encoding="utf-8")
    assert "the wanted speed of rotation" in (out / "README.md").read_text(encoding="utf-8")


def test_what_is_refused(tmp_path: Path) -> None:
    study, out = write(tmp_path, SHORT), tmp_path / "c"

    def refused(*said: str, options: tuple[str, ...] = (), path: Path = study) -> None:
        fails(workbench("export", "controller", path, "--out", out, *options), *said)
        assert not out.exists()

    refused("2 cases, expected one; choose with --case AXIS=VALUE, of rpm: 0, 460")
    refused("no case with rpm 5; the axes are rpm: 0, 460", options=("--case", "rpm=5"))
    refused("no axis speed; expected one of rpm", options=("--case", "speed=5"))
    refused('--case "460": expected AXIS=VALUE', options=("--case", "460"))
    refused('no controller "q"', options=("--case", "rpm=0", "--controller", "q"))
    refused("nothing controls the rotation", options=("--case", "rpm=0", "--rotation"))
    open_loop = changed('kp = "500 V/m"', "", changed('type = "pid"', 'type = "open_loop"', SHORT))
    open_loop = changed('amplitude = "5 mm"', 'amplitude = "1 V"', open_loop)
    experiment = write(tmp_path, 'title = "e"\n[channels]\n[[records]]\nfile = "a.csv"\n', "experiment.toml")
    refused("this is an experiment; expected a study", path=experiment)
    refused("open_loop has no feedback", options=("--case", "rpm=0"), path=write(tmp_path, open_loop, "open.toml"))


@pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")
def test_a_title_is_a_comment_and_no_code(tmp_path: Path) -> None:
    title = r"""title = 'a */ int x; /* b ???/ c \\'"""
    out = exported(tmp_path, text=changed('title = "a study for tests"', title, SHORT))
    done = made_and_run(out)
    assert (done.returncode, done.stderr) == (0, "")
    assert done.stdout.endswith(": equal\n")


def test_a_folder_that_holds_something_else_stays_as_it_is(tmp_path: Path) -> None:
    out = tmp_path / "c"
    out.mkdir()
    write(out, "mine", "Makefile")
    fails(
        workbench("export", "controller", write(tmp_path, SHORT), "--out", out, "--case", "rpm=460"),
        "holds Makefile that no controller wrote",
    )
    assert (out / "Makefile").read_text(encoding="utf-8") == "mine"
