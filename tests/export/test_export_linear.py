"""workbench export linear: what is written is what python-control has of the same loop, with its names and units."""

import json
import re
from pathlib import Path
from typing import Any

import control
import numpy as np
import pytest
from command import ROOT, STUDY, changed, fails, workbench, write
from scipy.io import loadmat

import workbench as wb

SPEED = "30 mm/s"
GUIDE = ROOT / "docs" / "export.md"


def exported(folder: Path, name: str, *options: str) -> Path:
    out = folder / name
    study = write(folder, STUDY)
    answer = workbench("export", "linear", study, "--out", out, "--case", "rpm=460", "--speed", SPEED, *options)
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.endswith(f"wrote {out}\n")
    return out


def system_of(model: dict[str, Any]) -> control.StateSpace:
    """As the last line of Python in docs/export.md makes it."""
    (code,) = re.findall(r"```python\n(.*?)```", GUIDE.read_text(encoding="utf-8"), flags=re.DOTALL)
    names: dict[str, Any] = {"model": model, "control": control}
    exec(code[code.index("plant =") :], names)
    found: control.StateSpace = names["plant"]
    return found


def test_json_is_what_python_control_has(tmp_path: Path) -> None:
    text = exported(tmp_path, "plant.json").read_text(encoding="utf-8")
    models = json.loads(text)["models"]
    assert [*models] == ["rest", "sliding", "slow", "open_loop"]
    loop = wb.Study(tmp_path / "study.toml").setup(rpm=460)
    sliding, whole = wb.linearise(loop, speed=SPEED), system_of(models["sliding"])
    np.testing.assert_array_equal(whole.A, sliding.A)
    np.testing.assert_array_equal(whole.B, sliding.B)
    row = whole.output_labels.index("position")
    np.testing.assert_array_equal(whole.C[row], sliding.C[0])
    assert (whole.state_labels, whole.input_labels) == (sliding.state_labels, sliding.input_labels)
    units = dict(zip(models["sliding"]["outputs"], models["sliding"]["output_units"], strict=True))
    assert (units["position"], units["load_pressure"], units["rotation_power"]) == ("m", "Pa", "W")
    assert models["sliding"]["at_states"][whole.state_labels.index("velocity")] == pytest.approx(0.03, rel=0.02)
    found, loop_gain = system_of(models["open_loop"]), wb.loop_gain(loop, speed=SPEED)
    assert found.dt == loop_gain.dt == 0.001
    at = np.exp(0.001j * np.logspace(0, 3, 20))
    np.testing.assert_array_equal(found(at), loop_gain(at))
    low, command = np.array([1e-2j]), whole.input_labels.index("valve_voltage")
    np.testing.assert_allclose(system_of(models["slow"])(low), whole(low)[row, command], rtol=1e-4)
    np.testing.assert_array_equal(system_of(models["rest"]).A, wb.linearise(loop).A)


def test_mat_holds_the_same_and_no_time(tmp_path: Path) -> None:
    models = json.loads(exported(tmp_path, "plant.json").read_text(encoding="utf-8"))["models"]
    path = exported(tmp_path, "plant.mat")
    whole = loadmat(path, simplify_cells=True)
    assert whole["case"] == "rpm = 460"
    for name, model in models.items():
        for key, value in model.items():
            if key[-5:] == "units" or key in ("states", "inputs", "outputs"):
                assert np.atleast_1d(whole[name][key]).tolist() == value
            elif key == "said":
                assert whole[name][key] == value
            else:
                np.testing.assert_array_equal(np.ravel(whole[name][key]), np.ravel(value))
    first = path.read_bytes()
    assert first.startswith(b"MATLAB 5.0 MAT-file, written by Friction Workbench  ")
    assert exported(tmp_path, "plant.mat", "--overwrite").read_bytes() == first


def test_what_is_refused(tmp_path: Path) -> None:
    study, out = write(tmp_path, STUDY), tmp_path / "plant.json"

    def refused(said: str, *options: str | Path) -> None:
        fails(workbench("export", "linear", study, "--case", "rpm=460", *options), said)
        assert not out.exists()

    refused("expected a name that ends in .mat or .json", "--out", tmp_path / "plant.txt")
    refused('speed: got "30 mm", expected a quantity in m/s', "--out", out, "--speed", "30 mm")
    refused("speed is 0 m/s, expected one that slides", "--out", out, "--speed", "0 m/s")
    out.write_text("mine", encoding="utf-8")
    fails(workbench("export", "linear", study, "--case", "rpm=0", "--out", out), "is there already; replace it")
    assert out.read_text(encoding="utf-8") == "mine"


def test_a_loop_that_does_not_slide_is_told(tmp_path: Path) -> None:
    study = write(tmp_path, changed('kp = "500 V/m"', 'kp = "90000 V/m"'))
    options = ("--case", "rpm=0", "--speed", SPEED, "--out", tmp_path / "plant.mat")
    fails(workbench("export", "linear", study, *options), "rpm 0: the rod does not slide steadily at 0.03 m/s: ")
