"""Slow and jittery logs: cut at their gaps, put on a grid of their own rate, and told what nobody can see at it."""

import json
from pathlib import Path
from unittest import mock

import numpy as np
import pandas as pd
import pytest
from command import workbench, write

from workbench.diagnose import diagnose
from workbench.errors import UserError
from workbench.records.experiment import read_experiment
from workbench.records.reading import Record, read_records

EXPERIMENT = """\
title = "a log off the laboratory"
[plant]
model = "drive_voltage"
parameters = "parameters.toml"
[fit]
method = "simulation"
free = ["coulomb", "viscous"]
[channels]
time = { column = "t", unit = "s" }
command = { column = "u", unit = "V" }
position = { column = "x", unit = "mm" }
[[records]]
file = "log.csv"
"""

VALUES = {
    "force_gain": "40 N/V",
    "mass": "20 kg",
    "load_force": "0 N",
    "coulomb": "40 N",
    "viscous": "500 N s/m",
    "stribeck": "0 N",
    "stribeck_velocity": "10 mm/s",
    "bristle_stiffness": "2e5 N/m",
    "bristle_damping": "0 N s/m",
    "end_stop_stiffness": "0 N/m",
    "end_stop_damping": "0 s/m",
}

STEP = 0.053


def drive(time: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Voltage and position (mm) of a mass on Coulomb and viscous friction, moved as slowly as 19 Hz can follow.

    u = (M a + 60 sign(v) + 800 v) / 40, of a position that is a sine of 10 s and another of 23 s.
    """
    parts = [(0.15, 2.0 * np.pi / 10.0), (0.1, 2.0 * np.pi / 23.0)]
    x = sum(a * np.sin(w * time) for a, w in parts)
    v = sum(a * w * np.cos(w * time) for a, w in parts)
    acceleration = sum(-a * w**2 * np.sin(w * time) for a, w in parts)
    return (20.0 * acceleration + 60.0 * np.sign(v) + 800.0 * v) / 40.0, 1e3 * np.asarray(x)


def log(seconds: float = 600.0, *, jitter: float = 0.3, gaps: bool = True, every: float = 97.0) -> pd.DataFrame:
    """Steps of 53 ms with jitter of 30 %, single samples missing, and `every` so many s a gap of 0.5 s."""
    draw = np.random.default_rng(5)
    count = round(seconds / STEP)
    time = STEP * (np.arange(count) + draw.uniform(-0.5 * jitter, 0.5 * jitter, count))
    if gaps:
        keep = (time % every > 0.5) & (draw.random(count) > 0.01)
        time = time[keep]
    u, x = drive(time)
    return pd.DataFrame({"t": time, "u": u, "x": x + 0.05 * draw.standard_normal(x.size)})


def experiment(folder: Path, data: pd.DataFrame, text: str = EXPERIMENT) -> Path:
    """The experiment of a log."""
    data.to_csv(folder / "log.csv", index=False)
    lines = [f'[parameters.{name}]\nvalue = "{value}"\nsource = "a test"\n' for name, value in VALUES.items()]
    write(folder, 'title = "t"\nsource = "a test"\n' + "".join(lines), "parameters.toml")
    return write(folder, text, "experiment.toml")


def records(folder: Path, data: pd.DataFrame) -> list[Record]:
    """The records that the program makes of a log."""
    return read_records(read_experiment(experiment(folder, data)))


def test_a_log_is_cut_at_its_gaps_and_put_on_its_own_grid(tmp_path: Path) -> None:
    found = records(tmp_path, log())
    assert len(found) == 7
    assert [round(record.start) for record in found] == [0, 97, 194, 291, 388, 485, 582]
    for record in found:
        assert record.sample_time == pytest.approx(STEP, rel=0.02)
        known = record.valid
        assert np.mean(known) > 0.99
        start = log()["t"].iloc[0] + record.start
        wanted = drive(start + record.time)[1] * 1e-3
        assert np.max(np.abs(record.channels["position"] - wanted)[known]) < 1e-3  # of 150 mm; noise is 0.05 mm
    first, *others = found
    assert "cut at its gaps into 7 pieces of 59" in first.notes[0]
    assert any("are put on an even grid of 53" in note for note in first.notes)
    assert all(record.notes == () for record in others)
    assert found[1].name == "log, piece 2 from 97 s"


def test_what_19_hz_cannot_show_is_told(tmp_path: Path) -> None:
    """Eight samples of 53 ms are 0.42 s: 2.4 Hz, and of a lag 2.4 Hz sqrt(3) / 2 pi."""
    (note,) = [note for note in records(tmp_path, log(gaps=False))[0].notes if "Hz" in note]
    assert "faster than 2.4 Hz: no time constant below 120 ms, and a delay to a fraction of a sample of 53 ms" in note
    data = log(jitter=0.0, gaps=False)
    fast = data.assign(t=data["t"] / 53.0)
    assert records(tmp_path, fast)[0].notes == ()


def test_stamps_that_are_late_repeated_or_ahead_are_dropped_and_counted(tmp_path: Path) -> None:
    """Of an even clock: late are rows 100 and 101, repeated is 200, ahead 300, without a time 400."""
    data = log(jitter=0.0, gaps=False)
    time = data["t"].to_numpy(copy=True)
    time[[100, 101, 200, 300, 400]] = [time[97] + 1e-3, time[97] + 2e-3, time[199], time[340], np.nan]
    (record,) = records(tmp_path, data.assign(t=time))
    assert record.notes[:4] == (
        "1 row without a time is dropped",
        "1 row whose time repeats the one before is dropped",
        "2 rows whose time is before that of an earlier one are dropped",
        "1 row whose time is ahead of those that follow is dropped",
    )
    assert np.flatnonzero(~record.valid).tolist() == [100, 101, 200, 300, 400]


def test_a_clock_that_starts_anew_is_another_piece(tmp_path: Path) -> None:
    """Two runs in one file, each from 0 on."""
    run = log(100.0, jitter=0.0, gaps=False)
    found = records(tmp_path, pd.concat([run, run]))
    assert [record.piece for record in found] == [1, 2]
    assert found[1].start == pytest.approx(100.0, abs=2.0 * STEP)
    np.testing.assert_allclose(found[0].channels["position"], found[1].channels["position"])


def test_what_is_missing_of_a_channel_is_a_gap_too(tmp_path: Path) -> None:
    data = log(jitter=0.0, gaps=False)
    found = records(tmp_path, data.assign(x=data["x"].where((data["t"] < 100.0) | (data["t"] > 103.0))))
    assert [record.piece for record in found] == [1, 2]
    assert any("position is missing from 100." in note for note in found[0].notes)


def test_a_channel_with_a_slower_clock_sets_the_grid(tmp_path: Path) -> None:
    """Position every fifth row, NaN between."""
    data = log(jitter=0.0, gaps=False)
    (record,) = records(tmp_path, data.assign(x=data["x"].where(data.index % 5 == 0)))
    assert record.sample_time == pytest.approx(5.0 * STEP)
    assert np.all(record.valid)
    assert "position has a value every 0.265 s alone" in record.notes[0]


def test_a_clock_that_goes_back_all_the_time_is_none(tmp_path: Path) -> None:
    saw = np.arange(4000.0) % 20.0
    with pytest.raises(UserError, match="goes back again and again, more than 100 times: is this its column"):
        records(tmp_path, log(212.0, gaps=False).assign(t=saw))


@pytest.mark.usefixtures("dots_alone")
def test_check_and_identify_take_the_pieces_and_tell_of_them(tmp_path: Path) -> None:
    """A free run over 25 s finds the true 60 N and 800 N s/m from 40 N and 500 N s/m."""
    path = experiment(tmp_path, log(66.0, every=25.0))
    answer = workbench("check", path)
    assert (answer.code, answer.err) == (0, "")
    assert "log.csv: fit, 64" in answer.out
    assert " s at 18." in answer.out
    assert "cut at its gaps into 3 pieces" in answer.out
    answer = workbench("identify", path, "--out", tmp_path / "identified")
    assert (answer.code, answer.err) == (0, "")
    assert "cut at its gaps into 3 pieces" in answer.out
    found = json.loads((tmp_path / "identified" / "identified.json").read_text())["parameters"]
    assert found["coulomb"]["simulation"]["value"] == pytest.approx(60.0, rel=0.02)
    assert found["viscous"]["simulation"]["value"] == pytest.approx(800.0, rel=0.02)


@pytest.mark.thorough
@pytest.mark.usefixtures("dots_alone")
def test_a_diagnosis_takes_the_pieces_and_tells_of_them(tmp_path: Path) -> None:
    path = experiment(tmp_path, log(30.0, every=10.0))
    with mock.patch.object(diagnose, "simulated_baseline", return_value=None):  # it takes long
        answer = workbench("diagnose", path, "--out", tmp_path / "diagnosed")
    assert (answer.code, answer.err) == (0, "")
    assert "log, piece 1 from 0 s: cut at its gaps into 3 pieces" in answer.out
    assert "faster than 2.4 Hz" in answer.out


def test_a_command_of_the_wrong_sign_and_rows_that_are_not_there_are_told(tmp_path: Path) -> None:
    data = log(60.0, gaps=False)
    path = experiment(tmp_path, data.assign(u=-data["u"]))
    answer = workbench("diagnose", path, "--out", tmp_path / "out")
    assert answer.code == 2
    assert (
        "log.csv: the command takes work from the motion instead of giving it: is the sign of command or" in answer.err
    )
    under_a_load = EXPERIMENT.replace("[fit]", '[plant.set]\nload_force = "50 N"\n[fit]')
    path = experiment(tmp_path, data.assign(u=-data["u"]), under_a_load)
    assert workbench("check", path).code == 0, "what hangs on a drive may drive it"
    path = experiment(tmp_path, data, EXPERIMENT + "skip = 100000\n")
    answer = workbench("check", path)
    assert answer.code == 2
    assert f"log.csv: skip = 100000 leaves none of its {len(data)} rows; expected fewer" in answer.err


def test_rows_are_used_once(tmp_path: Path) -> None:
    """What is fitted and held out tests nothing; two parts of one log are two records."""
    again = '[[records]]\nfile = "log.csv"\n'
    for more, uses in (('use = "held_out"\n', "once for the fit and once held out"), ("", "both times")):
        answer = workbench("check", experiment(tmp_path, log(60.0, gaps=False), EXPERIMENT + again + more))
        assert answer.code == 2
        assert (
            f"experiment.toml:15: records.1.file: rows of {tmp_path / 'log.csv'} are used already, {uses}" in answer.err
        )
    halves = f'{EXPERIMENT}rows = 500\n{again}skip = 500\nuse = "held_out"\n'
    path = experiment(tmp_path, log(60.0, gaps=False), halves)
    answer = workbench("check", path)
    assert (answer.code, answer.err) == (0, "")
    assert "no record is held out" not in answer.out
    assert "no record is held out" in workbench("check", experiment(tmp_path, log(60.0, gaps=False))).out
    answer = workbench("check", experiment(tmp_path, log(60.0, gaps=False), halves.replace("skip = 500", "skip = 499")))
    assert answer.code == 2


def test_what_the_file_says_itself_is_no_value_of_the_set(tmp_path: Path) -> None:
    """A plain name is said for both directions."""
    said = EXPERIMENT.replace("[fit]", '[plant.set]\nload_force = "50 N"\n[plant.scale]\ncoulomb = 2.0\n[fit]')
    known = read_experiment(experiment(tmp_path, log(60.0, gaps=False), said))
    assert known.source_of("mass") == "as declared: parameters.toml"
    assert {known.source_of(name) for name in ("load_force", "coulomb", "coulomb_negative")} == {
        "as declared: experiment.toml"
    }
