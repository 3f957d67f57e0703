"""Channels along axes that go straight and that turn, and measured rates beside the position."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import workbench, write

from workbench.errors import UserError
from workbench.records.experiment import read_experiment
from workbench.records.reading import Record, read_records

STEP = 1e-3

STRAIGHT = """\
title = "rates"
[plant]
model = "drive_voltage"
parameters = "canudas1995"
[plant.set]
force_gain = "1 N/V"
[fit]
free = ["coulomb"]
[channels]
time = { column = "t", unit = "s" }
command = { column = "u", unit = "V" }
position = { column = "x", unit = "mm" }
velocity = { column = "v", unit = "mm/s" }
[[records]]
file = "log.csv"
"""

TURNING = (
    STRAIGHT.replace('"drive_voltage"', '"rotary_voltage"')
    .replace('"canudas1995"', '"walkman_joint"')
    .replace('force_gain = "1 N/V"', 'torque_gain = "1 N m/V"')
    .replace('column = "x", unit = "mm"', 'column = "x", unit = "deg"')
    .replace('unit = "mm/s"', 'unit = "rpm"')
)


def record_of(folder: Path, text: str = STRAIGHT, **columns: np.ndarray) -> Record:
    """The record of 4 s of a sine of 1 Hz and 10, as the channels of `text` have it."""
    time = STEP * np.arange(4000)
    x, v = 10.0 * np.sin(6.0 * time), 60.0 * np.cos(6.0 * time)
    pd.DataFrame({"t": time, "u": v / 100.0, "x": x, "v": v, **columns}).to_csv(folder / "log.csv", index=False)
    return read_records(read_experiment(write(folder, text, "experiment.toml")))[0]


def test_a_turning_axis_has_angles_and_a_torque(tmp_path: Path) -> None:
    """10 deg; 60 rpm are 2 pi rad/s."""
    text = TURNING.replace("[[records]]", 'torque = { column = "u", unit = "kN m" }\n[[records]]')
    record = record_of(tmp_path, text)
    assert np.max(record.channels["position"]) == pytest.approx(np.deg2rad(10.0), rel=1e-4)
    assert record.channels["velocity"][0] == pytest.approx(2.0 * np.pi)
    assert record.channels["force"][0] == pytest.approx(600.0)


@pytest.mark.parametrize(
    ("text", "old", "new", "said"),
    [
        (
            STRAIGHT,
            'unit = "mm" ',
            'unit = "deg" ',
            'got "deg", the unit of an axis that turns, and that of drive_volt',
        ),
        (
            TURNING,
            'unit = "deg" ',
            'unit = "mm" ',
            'got "mm", the unit of an axis that goes straight, and that of rotary_volt',
        ),
        (STRAIGHT, "velocity =", "torque =", 'goes straight, and what drives it is a force: call it "force", in N'),
        (TURNING, "velocity =", "force =", 'turns, and what drives it is a torque: call the channel "torque", in N m'),
        (STRAIGHT, 'unit = "mm/s"', 'unit = "rpm"', 'got "rpm", the unit of an axis that turns'),
        (STRAIGHT, ', unit = "mm/s"', "", 'got no unit; expected that of the column, such as unit = "m/s"'),
        (STRAIGHT, 'unit = "mm/s"', 'unit = "bar"', 'got "bar", expected a unit such as "m/s"'),
        (STRAIGHT, "velocity =", "velocty =", 'unknown channel; did you mean "velocity"?'),
    ],
)
def test_what_belongs_to_the_other_kind_of_axis_is_one_line(
    tmp_path: Path, text: str, old: str, new: str, said: str
) -> None:
    assert text.count(old) == 1
    with pytest.raises(UserError) as raised:
        record_of(tmp_path, text.replace(old, new))
    assert said in str(raised.value)
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("factor", "said"),
    [
        (1.0, "velocity agrees with the slope of position: 1 times it"),
        (-1.0, "velocity goes against the slope of position: one of the two has the wrong sign"),
        (1e-3, "velocity is 0.001 times the slope of position: one of the two has a wrong unit or scale"),
        (0.0, "velocity is 0 throughout, and position changes: is this its column?"),
    ],
)
def test_a_measured_velocity_is_held_against_the_position(tmp_path: Path, factor: float, said: str) -> None:
    noise = np.random.default_rng(1).standard_normal(4000)
    v = factor * (60.0 * np.cos(6.0 * STEP * np.arange(4000)) + 5.0 * noise)
    assert record_of(tmp_path, v=v).notes == (said,)
    assert said in workbench("check", tmp_path / "experiment.toml").out


def test_a_velocity_of_something_else_is_told(tmp_path: Path) -> None:
    v = np.random.default_rng(1).standard_normal(4000)
    (note,) = record_of(tmp_path, v=v).notes
    assert note.startswith("velocity does not follow the slope of position (correlation ")


def test_an_acceleration_is_held_against_the_velocity(tmp_path: Path) -> None:
    text = STRAIGHT.replace("[[records]]", 'acceleration = { column = "a", unit = "m/s^2" }\n[[records]]')
    a = -360.0 * np.sin(6.0 * STEP * np.arange(4000))  # mm/s^2, declared as m/s^2
    assert "acceleration is 1e+03 times the slope of velocity: one of" in record_of(tmp_path, text, a=a).notes[1]


@pytest.mark.parametrize(("column", "told"), [("Setpoint [mm]", True), ("Position actual [mm]", False)])
def test_a_column_that_is_called_as_what_was_wanted_is_told(column: str, told: bool, tmp_path: Path) -> None:
    text = STRAIGHT.replace('column = "x"', f'column = "{column}"')
    record = record_of(tmp_path, text, **{column: 10.0 * np.sin(6.0 * STEP * np.arange(4000))})
    said = f'the column of position is called "{column}", as what was wanted is: was it measured?'
    assert (said in record.notes) is told
    assert (said in workbench("check", tmp_path / "experiment.toml").out) is told


@pytest.mark.parametrize(
    ("column", "unit", "told"),
    [
        pytest.param("Weg [cm]", "mm", True, id="another unit of the same kind"),
        pytest.param("Weg [mm]", "mm", False, id="the same"),
        pytest.param("Weg [V]", "mm", False, id="what a sensor gives"),
        pytest.param("Weg", "mm", False, id="none"),
        pytest.param("Weg [cm]", "mm, scale = 10.0", False, id="converted"),
    ],
)
def test_a_column_that_is_called_by_another_unit_is_told(column: str, unit: str, told: bool, tmp_path: Path) -> None:
    kind, _, scale = unit.partition(",")
    text = STRAIGHT.replace(
        'column = "x", unit = "mm"', f'column = "{column}", unit = "{kind}"{"," * bool(scale)}{scale}'
    )
    record = record_of(tmp_path, text, **{column: 10.0 * np.sin(6.0 * STEP * np.arange(4000))})
    said = f'the column of position is called "{column}", and its unit said to be mm: which is right?'
    assert (said in record.notes) is told
    checked = workbench("check", tmp_path / "experiment.toml")
    assert checked.code == 0
    assert (said in checked.out) is told
