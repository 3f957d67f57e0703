"""Identification over speeds of rotation: groups, rotary records, printed tables, figures; the shipped experiments."""

import json
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from command import STUDIES, fails, workbench
from experiments import AXIAL, CURVE, LINE, TIME, axial_record, identify

from workbench.identify.simulation.nuisance import columns
from workbench.identify.thesis import method as thesis_method
from workbench.records.friction import Slow
from workbench.simulation.simulate import simulate
from workbench.study.plan import plan
from workbench.study.reading import read_study

RADIUS, TORQUE = 31.75e-3, 0.77

ROTARY = """\
title = "around the rod"
[plant]
model = "rotating_anisotropic"
parameters = "owen2001_experiment"
[fit]
method = "thesis"
[channels]
time = { column = "time", unit = "s" }
rotation_speed = { column = "speed", unit = "rad/s" }
motor_current = { column = "current", unit = "A" }
[[records]]
file = "run_*.parquet"
[[published]]
table = "printed"
title = "printed"
direction = "rotary"
values = { coulomb = [34.7], static = [49.3] }
[[figures]]
name = "friction"
title = "friction"
"""


@pytest.fixture
def two_speeds(tmp_path: Path) -> Path:
    axial_record(tmp_path / "run_a.parquet", CURVE, 0.0)
    axial_record(tmp_path / "run_b.parquet", LINE, 25.0)
    return tmp_path


def test_each_speed_of_rotation_has_its_own_friction(two_speeds: Path) -> None:
    """Standing, the Stribeck curve; turning, a line, of which no Stribeck friction is made up."""
    answer = identify(two_speeds, AXIAL)
    assert (answer.code, answer.err) == (0, "")
    out = two_speeds / "out"
    groups = json.loads((out / "identified.json").read_text())["thesis"]["by_rpm"]
    assert list(groups) == ["0", "25"]
    for name, value in CURVE.items():
        assert groups["0"][name]["mean"] == pytest.approx(value, rel=0.03), name
    assert groups["0"]["static"]["mean"] == pytest.approx(480.0, rel=0.02)
    assert groups["25"]["viscous"]["mean"] == pytest.approx(30000.0, rel=0.01)
    assert groups["25"]["static"]["mean"] == pytest.approx(40.0, rel=0.05)
    assert groups["25"]["stribeck"]["mean"] == 0.0
    assert "stribeck_velocity" not in groups["25"]
    assert "25 rpm, forward: no Stribeck friction is seen, and a line is fitted" in answer.out
    assert not (out / "plant.toml").exists(), "there is no one plant"
    assert sorted(path.name for path in (out / "figures").glob("*.png")) == ["at_25.png", "over_rpm.png"]


def test_a_printed_table_stands_beside_what_is_found(two_speeds: Path) -> None:
    identify(two_speeds, AXIAL)
    table = pd.read_csv(two_speeds / "out" / "tables" / "printed.csv", dtype=str, keep_default_na=False)
    assert table["rpm"].tolist() == ["0", "25"]
    assert table["coulomb, published"].tolist() == ["300 (30.0)", "0"]
    assert table["static, published"].tolist() == ["450", ""]
    assert table["stribeck velocity (mm/s)"][1] == ""
    assert float(table["static (N)"][0]) == pytest.approx(480.0, rel=0.02)
    text = (two_speeds / "out" / "tables" / "printed.md").read_text()
    assert "Of one run, by the thesis's method. Published: a book." in text
    assert "a remark" in text


def test_rotary_records_give_friction_around_the_rod(tmp_path: Path) -> None:
    """F = K_t i / R at w = R omega; names end in _rotary and the plant file has them."""
    law = {"coulomb": 34.7, "stribeck": 14.6, "viscous": 8.3, "stribeck_velocity": 0.042}
    surface = 0.7 * (TIME / TIME[-1]) ** 2
    current = thesis_method.steady(surface, **law) * RADIUS / TORQUE
    frame = pd.DataFrame({"time": TIME, "speed": surface / RADIUS, "current": current})
    frame.to_parquet(tmp_path / "run_a.parquet")
    answer = identify(tmp_path, ROTARY)
    assert (answer.code, answer.err) == (0, "")
    found = json.loads((tmp_path / "out" / "identified.json").read_text())["parameters"]
    for name, value in law.items():
        assert found[f"{name}_rotary"]["thesis"]["mean"] == pytest.approx(value, rel=0.01), name
    assert "[parameters.coulomb_rotary]" in (tmp_path / "out" / "plant.toml").read_text()
    table = pd.read_csv(tmp_path / "out" / "tables" / "printed.csv")
    assert table["this program"].tolist() == pytest.approx([34.7, 49.3], rel=0.01)


@pytest.mark.parametrize("stribeck", [0.0, 30.0])
def test_stribeck_friction_is_told_from_none(stribeck: float) -> None:
    """30 N over 3 mm/s, as the thesis has it while rotating, is seen through 3 N of scatter; a line is a line."""
    speed = np.linspace(0.0, 0.0114, 350)
    noise = 3.0 * np.random.default_rng(2).standard_normal(350)
    force = 10.0 + stribeck * np.exp(-((speed / 0.003) ** 2)) + 30000.0 * speed + noise
    found = thesis_method.static_parameters(Slow(0.1 * np.arange(350), speed, force))
    assert np.isnan(found["stribeck_velocity"]) == (stribeck == 0.0)
    assert found["coulomb"] + found["stribeck"] == pytest.approx(10.0 + stribeck, abs=5.0)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("coulomb = [300, 0]", "coulomb = [300]", "coulomb has 1 values, expected 2: one for each rpm"),
        ("coulomb = [300, 0]", "colomb = [300, 0]", 'unknown parameter "colomb"; did you mean "coulomb"?'),
        ("rpm = 25\n", "rpm = 26\n", "at_25: no record at 26 rpm, expected one of 0, 25"),
        ('rpm = "rpm"', 'rpm = "rp"', 'no column "rp" for rpm; did you mean "rpm"?'),
        ('rpm = "rpm"', 'rpm = "time"', 'column "time" holds no one speed of rotation'),
    ],
)
def test_what_does_not_fit_is_one_line(two_speeds: Path, old: str, new: str, said: str) -> None:
    assert AXIAL.count(old) == 1
    fails(identify(two_speeds, AXIAL.replace(old, new)), said)
    assert not (two_speeds / "out").exists()


def test_a_plant_that_stands_cannot_follow_a_record_that_turns(two_speeds: Path) -> None:
    answer = identify(two_speeds, AXIAL, "simulation")
    assert (answer.code, answer.out) == (2, "")
    assert "plant non_rotating does not rotate, and there are records at 25 rpm; take a rotating plant" in answer.err


class _Position:
    """What `columns` needs of a record: its outputs."""

    def __init__(self, position: np.ndarray) -> None:
        self.measured = {"position": position}


def test_all_records_share_one_calibration_curve() -> None:
    """At equal positions of two records the same column has the same value; each record keeps its own start."""
    there, back = np.linspace(-0.07, 0.07, 200), np.linspace(0.07, -0.07, 200)
    records: list[Any] = [_Position(there), _Position(back)]
    found, names = columns(records, np.concatenate([there, back]), {"position_calibration": 7e-5})
    curves = [i for i, name in enumerate(names) if name.startswith("calibration")]
    assert names.count("start_0") == names.count("start_1") == 1
    assert len(curves) > 5
    np.testing.assert_allclose(found[:200, curves], found[200:, curves][::-1], atol=1e-12)


# --- what the program comes with ---

EXPERIMENTS = sorted((STUDIES / "identification").glob("*.toml"))


@pytest.mark.parametrize("path", EXPERIMENTS, ids=lambda path: path.stem)
def test_the_shipped_experiments_are_in_order(path: Path) -> None:
    answer = workbench("check", path)
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.startswith((f"{path}: an experiment, in order", f"{path}: an experiment; its records are not"))


def test_the_virtual_rig_turns_as_fast_as_figure_5_1() -> None:
    planned = plan(read_study(STUDIES / "thesis_chapter4.toml"))
    assert len(planned.cases) == 150
    (first, *_) = [i for i, case in enumerate(planned.cases) if case.name == "pure_rotation"]
    run = simulate(planned.resolved[first].setup)
    surface = run.signals["surface_speed"]
    assert surface[0] == 0.0
    assert surface[-1] == pytest.approx(0.7, abs=0.05)
    assert np.max(np.abs(run.signals["velocity"])) < 1e-6, "without axial motion"


def test_repeats_share_their_sensors_calibration_and_not_its_noise() -> None:
    planned = plan(read_study(STUDIES / "thesis_chapter4.toml"))
    one, other = planned.resolved[0].setup, planned.resolved[1].setup
    assert one.seed != other.seed
    assert np.array_equal(one.sensors.errors(), other.sensors.errors())
