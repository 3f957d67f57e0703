"""A study of an axis that turns: read and written in rad, deg and N m, and never in m, mm or N."""

from pathlib import Path

import pandas as pd
import pytest
from command import workbench
from mistakes import expect

from plants.axis import ROTARY
from workbench.metrics.registry import names_along
from workbench.parameters.sets import known_units, named_sets, parameter_value, read_parameters
from workbench.toml.units import QuantityError, si

STUDY = """\
title = "a joint, for tests"
[plant]
model = "rotary_current"
parameters = "walkman_joint"
set = { coulomb = "2 N m", viscous = "15 N m s" }
start_position = "1 deg"

[controllers.p]
type = "pid"
kp = "800 A/rad"
kd = "16 A s/rad"

[references.sine]
kind = "sine"
amplitude = "5 deg"
frequency = "1 Hz"
offset = "1 deg"

[sensors]
position = { noise = "0.001 deg", resolution = "0.0007 deg" }

[simulation]
duration = "2 s"
transient = "1 s"

[[tables]]
name = "errors"
title = "errors"
index = "controller"

[[tables.columns]]
result = "rms_error_rad"
label = "rms error"
unit = "deg"

[axes]
controller = ["p"]
"""


def test_results_are_in_rad_and_tables_in_deg(tmp_path: Path) -> None:
    path = tmp_path / "study.toml"
    path.write_text(STUDY)
    answer = workbench("run", path, "--out", tmp_path / "out", "--keep-trajectories")
    assert (answer.code, answer.err) == (0, "")
    header = (tmp_path / "out" / "results.csv").read_text().splitlines()[0].split(",")
    assert [name for name in header if name.endswith("_m") or "_m_" in name] == [
        "motor_torque_rms_N_m",
        "friction_slope_N_m_s_per_rad",
    ]
    frame = pd.read_csv(tmp_path / "out" / "results.csv")
    rms = float(frame["rms_error_rad"].iloc[0])
    assert 1e-4 < rms < 5e-3
    table = pd.read_csv(tmp_path / "out" / "tables" / "errors.csv")
    assert table.columns[1] == "rms error (deg)"
    assert float(table.iloc[0, 1]) == pytest.approx(rms * 57.29578, rel=0.01)
    signals = pd.read_parquet(next((tmp_path / "out" / "trajectories").glob("*.parquet")))
    assert {"drive_torque", "disturbance_torque", "drive_current"} <= {*signals.columns}
    assert signals["position"].iloc[0] == pytest.approx(0.0174533, rel=1e-5)
    assert abs(signals["reference_position"]).max() == pytest.approx(6.0 / 57.29578, rel=1e-4)
    drawn = workbench("plot", tmp_path / "out", "--y", "position", "--out", tmp_path / "p.png")
    assert (drawn.code, drawn.err) == (0, "")


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('"2 N m"', '"2 N"', '@:5: plant.set.coulomb: got "2 N", expected a torque in N m, such as "1 N m"'),
        ('"15 N m s"', '"15 N s/m"', '@:5: plant.set.viscous: got "15 N s/m", expected a quantity in N m s/rad, such '),
        ("coulomb =", "mass =", '@:5: plant.set.mass: unknown parameter "mass"; a turning axis has inertia (kg m^2)'),
        (
            '"1 deg"\n\n',
            '"1 mm"\n\n',
            "@:6: plant.start_position: got a quantity in m, expected a quantity in rad, such ",
        ),
        (
            '"5 deg"',
            '"5 mm"',
            '@:15: references.sine.amplitude: got "5 mm", expected a quantity in rad, such as "1 rad"',
        ),
        ('"800 A/rad"', '"800 A/m"', '@:10: controllers.p.kp: got "800 A/m", expected a quantity in A/rad, such '),
        (
            '"0.001 deg"',
            '"1 um"',
            '@:20: sensors.position.noise: got "1 um", expected a quantity in rad, such as "1 rad"',
        ),
        ('"rms_error_rad"', '"rms_error_m"', '@:32: tables.0.columns.0.result: unknown figure "rms_error_m"; '),
    ],
)
def test_what_is_written_for_another_axis_is_a_mistake_of_one_line(
    tmp_path: Path, old: str, new: str, said: str
) -> None:
    text = STUDY.replace(old, new, 1)
    assert text != STUDY
    if said.startswith("@:32"):
        said = said.replace("@:32", f"@:{1 + text[: text.index(new)].count(chr(10))}")
    expect(tmp_path, text, said)


MIXED = """\
title = "both"
[controllers.p]
type = "pid"
kp = 800
[references.sine]
kind = "sine"
amplitude = 0.01
frequency = 1
[simulation]
duration = 1
[cases.straight]
plant = { model = "drive_force", parameters = "canudas1995" }
[cases.turning]
plant = { model = "rotary_current", parameters = "walkman_joint" }
"""


def test_straight_and_turning_plants_make_two_studies(tmp_path: Path) -> None:
    said = "@:14: cases.turning.plant.model: drive_force has positions in m, rotary_current in rad; make two studies"
    expect(tmp_path, MIXED, said)


def test_a_comparison_with_rotation_is_refused(tmp_path: Path) -> None:
    text = STUDY + '\n[comparison]\nplain = ["p"]\n'
    expect(
        tmp_path,
        text,
        f"@:{text.count(chr(10)) - 1}: comparison: asks whether to rotate a rod, and rotary_current has ",
    )


def test_parameters_are_read_in_the_light_of_their_axis() -> None:
    assert parameter_value("viscous", "3 N m s", ROTARY) == 3.0  # a user writes it without the radian
    assert parameter_value("stribeck_velocity", "1 deg/s", ROTARY) == pytest.approx(0.0174533, rel=1e-5)
    assert parameter_value("measured_at", "load", ROTARY) == 1.0
    with pytest.raises(QuantityError, match='got "3 N", expected a torque in N m'):
        parameter_value("coulomb", "3 N", ROTARY)
    with pytest.raises(QuantityError):
        si("1 1/s", "rad/s")  # a frequency is no speed
    assert known_units(ROTARY)["spring_stiffness"] == "N m/rad"
    assert known_units()["spring_stiffness"] == "N/m"
    assert read_parameters(named_sets()["walkman_joint_elastic"])["measured_at"] == 0.0


def test_columns_have_one_name_on_each_axis() -> None:
    names = names_along(ROTARY)
    assert names["rms_error_m"] == "rms_error_rad"
    assert names["friction_slope_N_s_per_m"] == "friction_slope_N_m_s_per_rad"
    assert names["jerk_rms_m_per_s3"] == "jerk_rms_rad_per_s3"
    assert names["motor_torque_rms_N_m"] == "motor_torque_rms_N_m"
    assert len({*names.values()}) == len(names)
