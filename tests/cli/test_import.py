"""`workbench import`: with a terminal and without, and what it does not overwrite."""

import io
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import fails, workbench

TIME = 0.01 * np.arange(1000)


def log(folder: Path) -> Path:
    """A drive's log: 5 V for each m/s, and 0.4 V of friction; the position in counts of 0.1 mm."""
    x, v = 0.2 * np.sin(TIME), 0.2 * np.cos(TIME)
    table = {"t": TIME, "u_cmd": 5.0 * v + 0.4 * np.sign(v), "encoder": np.rint(1e4 * x)}
    pd.DataFrame(table).to_csv(folder / "log.csv", index=False)
    return folder / "log.csv"


class Terminal(io.StringIO):
    """What is typed at a terminal."""

    def isatty(self) -> bool:
        return True


@pytest.mark.usefixtures("dots_alone")
def test_without_a_terminal_questions_stand_in_the_file_and_the_rest_is_checked(tmp_path: Path) -> None:
    out = tmp_path / "experiment.toml"
    answer = workbench("import", log(tmp_path), "--out", out)
    assert (answer.code, answer.err) == (0, "")
    assert f"wrote {out}: plant drive_voltage, 5 questions in it (# ?); next: workbench check {out}" in answer.out
    text = out.read_text()
    assert text.count("\n# ?") == 5
    mended = text.replace('unit = "mm", scale = 1.0', 'unit = "mm", scale = 0.1')
    assert mended != text
    out.write_text(mended)
    answer = workbench("check", out)
    assert (answer.code, answer.err) == (0, "")
    assert "identify: can use it\n  diagnose: can use it" in answer.out
    assert workbench("identify", out, "--out", tmp_path / "identified").code == 0


def test_at_a_terminal_questions_are_asked_with_the_guess_as_default(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Counts of 0.1 mm; plant, unit of the command, mass and gain as they are guessed."""
    monkeypatch.setattr(sys, "stdin", Terminal("0.1\n\n\n\n\n"))
    answer = workbench("import", log(tmp_path), "--out", tmp_path / "experiment.toml")
    assert (answer.code, answer.err) == (0, "")
    assert "how many mm is one? And which offset has it? [1]:" in answer.out
    assert "no question is left; next: workbench check" in answer.out
    assert 'position = { column = "encoder", unit = "mm", scale = 0.1 }' in (tmp_path / "experiment.toml").read_text()
    assert workbench("check", tmp_path / "experiment.toml").code == 0


def test_a_file_is_replaced_only_with_force(tmp_path: Path) -> None:
    out = tmp_path / "experiment.toml"
    out.write_text("mine")
    fails(workbench("import", log(tmp_path), "--out", out), "experiment.toml: is there already; --force replaces it")
    assert out.read_text() == "mine"
    assert workbench("import", log(tmp_path), "--out", out, "--force").code == 0
    assert out.read_text() != "mine"


def test_a_plant_and_a_set_may_be_named(tmp_path: Path) -> None:
    out = tmp_path / "experiment.toml"
    answer = workbench(
        "import", log(tmp_path), "--out", out, "--plant", "non_rotating", "--parameters", "owen2001_experiment"
    )
    assert answer.code == 0
    assert 'model = "non_rotating"  # as asked for\nparameters = "owen2001_experiment"\n' in out.read_text()
    assert "[plant.set]" not in out.read_text()
    command = ("import", log(tmp_path), "--out", tmp_path / "other.toml", "--plant", "drive_volt")
    fails(workbench(*command), 'unknown plant; did you mean "drive_voltage"?')
