"""An axis that turns, identified from a record in deg and N m: answered in those units."""

import json
import tomllib
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import workbench

from plants.registry import plants
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

EXPERIMENT = """\
title = "a joint on a spring"
[plant]
model = "rotary_torque"
parameters = "walkman_joint"
set = { coulomb = "2.3 N m", viscous = "12 N m s", spring_stiffness = "60 N m/rad" }
[fit]
free = ["coulomb", "viscous"]
method = "simulation"
coulomb = { min = "0.1 N m", max = "20 N m" }
[channels]
time = { column = "time", unit = "s" }
command = { column = "torque", unit = "N m" }
position = { column = "angle", unit = "deg" }
[[records]]
file = "joint.csv"
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An experiment with a record of 8 s of a joint that has 2 N m and 14 N m s/rad."""
    folder = tmp_path_factory.mktemp("joint")
    plant = plants()["rotary_torque"]
    values = dict(read_parameters(named_sets()["walkman_joint"]))
    values |= {"spring_stiffness": 60.0, "coulomb": 2.0, "viscous": 14.0}
    for name in ("coulomb", "viscous"):
        values[f"{name}_negative"] = values[name]
    parameters = build(plant.Parameters, values)
    state, inputs = plant.equilibrium(parameters, 0.0)
    feeds = (Feed("drive_torque", Multisine(30.0, 0.25, (1, 3))),)
    run = simulate(Setup(plant, parameters, state, inputs, 8.0, feeds=feeds))
    noise = np.random.default_rng(1).normal(0.0, 0.002, run.time.size)
    angle = np.rad2deg(run.state("position")) + noise
    frame = pd.DataFrame({"time": run.time, "torque": run.signals["drive_torque"], "angle": angle})
    frame.to_csv(folder / "joint.csv", index=False)
    (folder / "experiment.toml").write_text(EXPERIMENT)
    return folder


@pytest.mark.usefixtures("dots_alone")
def test_a_joint_is_identified_in_its_own_units(folder: Path) -> None:
    out = folder / "out"
    answer = workbench("identify", folder / "experiment.toml", "--out", out)
    assert (answer.code, answer.err) == (0, "")
    found = json.loads((out / "identified.json").read_text())["parameters"]
    assert (found["coulomb"]["unit"], found["viscous"]["unit"]) == ("N m", "N m s/rad")
    assert found["coulomb"]["simulation"]["value"] == pytest.approx(2.0, rel=0.02)
    assert found["viscous"]["simulation"]["value"] == pytest.approx(14.0, rel=0.02)
    assert "position, simulated against measured: " in answer.out
    assert " deg rms as declared, " in answer.out
    assert " mm" not in answer.out
    written = tomllib.loads((out / "plant.toml").read_text())["parameters"]
    assert written["inertia"]["value"] == "1.1001 kg m^2"
    assert read_parameters(out / "plant.toml")["viscous"] == pytest.approx(14.0, rel=0.02)


def test_a_channel_in_a_straight_unit_is_a_mistake(folder: Path) -> None:
    path = folder / "straight.toml"
    path.write_text(EXPERIMENT.replace('unit = "deg"', 'unit = "mm"'))
    answer = workbench("check", path)
    assert answer.code == 2
    assert 'channels.position.unit: got "mm", the unit of an axis that goes straight' in answer.err
    assert 'expected a unit such as "rad"' in answer.err


def test_a_drive_with_a_compliance_has_nothing_to_diagnose(folder: Path) -> None:
    path = folder / "elastic.toml"
    text = EXPERIMENT.replace("rotary_torque", "two_inertia_torque").replace("walkman_joint", "walkman_joint_elastic")
    path.write_text(text)
    answer = workbench("diagnose", path, "--out", folder / "diagnosis")
    assert answer.code == 2
    assert "plant two_inertia_torque has no balance that records could show" in answer.err
