"""workbench rehearse: the exported C in the loop gives the study's figures, and other C does not."""

import csv
import json
import shutil
from collections.abc import Sequence
from pathlib import Path

import pytest
from command import changed, fails, workbench, write

from workbench.export.compiler import compiled_library
from workbench.rehearse import lockstep

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="no C compiler")

SHORT = changed('duration = "1 s"', 'duration = "0.9 s"')


def test_a_study_and_its_rehearsal_are_equal(tmp_path: Path) -> None:
    out = tmp_path / "out"
    answer = workbench("rehearse", write(tmp_path, SHORT), "--out", out, "--jobs", "1")
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.endswith("figures: study and rehearsal are equal to the last printed digit\n")
    rows = list(csv.DictReader((out / "rehearsal.csv").read_text(encoding="utf-8").splitlines()))
    assert {row["rpm"] for row in rows} == {"0", "460"}
    assert {"outcome", "rms_error_m", "phase_lag_deg", "solver_error_m"} <= {row["figure"] for row in rows}
    assert all(row["study"] == row["rehearsed"] != "" for row in rows)
    assert {row["difference"] for row in rows} == {"", "0"}
    record = json.loads((out / "rehearsal.json").read_text(encoding="utf-8"))
    assert record["figures"] == record["equal"] == len(rows)
    written = {path.relative_to(out / "controllers").as_posix() for path in out.glob("controllers/*/*")}
    assert written == {
        f"{name}_{number}/{file}"
        for number, (name, own) in enumerate((("pid_position", "pid"), ("speed_servo_rotation", "speed_servo")))
        for file in (f"{own}.c", f"{own}.h", "lockstep.c")
    }


def test_other_c_gives_other_figures(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def altered(sources: Sequence[Path], library: Path) -> Path:
        text = sources[0].read_text(encoding="utf-8")
        sources[0].write_text(changed("return command;", "return 1.01 * command;", text), encoding="utf-8")
        return compiled_library(sources, library)

    monkeypatch.setattr(lockstep, "compiled_library", altered)
    study = changed("rpm = [0, 460]", "rpm = [0]", SHORT)
    answer = workbench("rehearse", write(tmp_path, study), "--out", tmp_path / "out", "--jobs", "1")
    assert answer.code == 1
    assert "figures differ; the largest difference: " in answer.out.splitlines()[-1]


def test_what_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    study, out = write(tmp_path, SHORT), tmp_path / "out"
    monkeypatch.setenv("CC", "no_such_compiler -O2")
    fails(workbench("rehearse", study, "--out", out), 'no C compiler: "no_such_compiler" is not found on PATH')
    monkeypatch.delenv("CC")
    out.mkdir()
    write(out, "{}", "rehearsal.json")
    fails(workbench("rehearse", study, "--out", out), "holds a rehearsal already; replace it with --overwrite")
    fails(workbench("rehearse", study, "--out", tmp_path / "new", "--draws", "2"), "--draws needs a table")
    assert not (tmp_path / "new").exists()
