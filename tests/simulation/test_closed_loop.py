"""The closed loop: records of a rig, their diagnosis, and the study of controllers on the corrected plant."""

import json
import shutil
from pathlib import Path

import pandas as pd
import pytest
from command import STUDIES, changed, workbench, write

RIG = {
    "valve_overlap": 10e-6,
    "viscous_negative": 0.9 * 3400.0,
    "coulomb": 1.15 * 370.0,
    "valve_flow_gain": 0.95 * 5.9e-4,
}
"""What studies/closed_loop/rig.toml has and its experiment does not say (SI)."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory, png_alone: None) -> Path:
    """The three commands, in order."""
    path = tmp_path_factory.mktemp("closed_loop")
    rig = shutil.copytree(STUDIES / "closed_loop", path / "studies" / "closed_loop") / "rig.toml"
    rig.write_text(changed('duration = "30 s"', 'duration = "20 s"', rig.read_text(encoding="utf-8")), encoding="utf-8")
    text = (STUDIES / "closed_loop.toml").read_text(encoding="utf-8")
    write(path / "studies", changed('duration = "24 s"', 'duration = "14 s"', text), "closed_loop.toml")  # one period
    shutil.copytree(STUDIES / "scenarios", path / "studies" / "scenarios")
    for command, file, name in (
        ("run", "closed_loop/rig.toml", "closed_loop_rig"),
        ("diagnose", "closed_loop/experiment.toml", "closed_loop_diagnosis"),
        ("run", "closed_loop.toml", "closed_loop"),
    ):
        answer = workbench(command, path / "studies" / file, "--out", path / "results" / name)
        assert answer.code == 0, answer.err
    return path / "results"


@pytest.mark.thorough
def test_what_nobody_declared_is_found_with_its_size(folder: Path) -> None:
    report = json.loads((folder / "closed_loop_diagnosis" / "report.json").read_text())
    assert report["verdict"] == "effect_found"
    assert {one["name"] for one in report["effects"]} == {"valve_deadband", "direction_asymmetry"}
    numbers = {name: one["value"] for effect in report["effects"] for name, one in effect["parameters"].items()}
    for name, value in numbers.items():
        assert value == pytest.approx(RIG[name], rel=0.005)
    assert report["simulation"]["after"] < 1.1  # standard deviations of noise
    after = report["error"]["held_out"]["after"]
    assert after["position_rms_m"] < 0.01 * report["error"]["held_out"]["before"]["position_rms_m"]


@pytest.mark.thorough
def test_the_corrected_plant_ranks_controllers_as_the_rig_does(folder: Path) -> None:
    results = pd.read_csv(folder / "closed_loop" / "results.csv")
    slow = results[(results["case"] == "declared") & (results["reference"] == "slow_sine")]
    errors = slow.pivot(index="controller", columns="scenario", values="rms_error_m")
    assert errors["corrected"].to_numpy() == pytest.approx(errors["rig"].to_numpy(), rel=0.02)
    assert errors["nominal"].idxmin() == "friedland_park"
    assert errors["rig"].idxmin() == errors["corrected"].idxmin() == "pi"
    assert errors["nominal"].rank()["pi"] > 5


def test_without_a_diagnosis_the_study_says_what_it_misses(tmp_path: Path) -> None:
    shutil.copy(STUDIES / "closed_loop.toml", tmp_path)
    answer = workbench("check", tmp_path / "closed_loop.toml")
    assert answer.code == 2
    assert "closed_loop_diagnosis/plant.toml: no such file" in answer.err
