"""Experiment files and records: what is read, and what is said of a record that cannot be used."""

import re
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from command import fails, write
from experiments import identify
from scipy.io import savemat

from workbench.errors import UserError
from workbench.records.experiment import read_experiment
from workbench.records.reading import Record, read_records

EXPERIMENT = """\
title = "a short record"
[plant]
model = "non_rotating"
parameters = "owen2001_experiment"
[fit]
free = ["coulomb"]
coulomb = { min = "1 N", max = "2 kN" }
[channels]
time = { column = "t", unit = "ms" }
valve_voltage = { column = "u", unit = "V" }
position = { column = "x", unit = "mm", offset = -10.0 }
pressure_1 = { column = "pA", unit = "bar", scale = 0.5 }
[[records]]
file = "record.csv"
"""


def table(samples: int = 400) -> pd.DataFrame:
    """Raw numbers: ms, V, mm from one end, counts of half a bar; position and pressure move on, none rests."""
    time = np.arange(samples, dtype=float)
    return pd.DataFrame({"t": time, "u": 0.0, "x": 10.0 + 0.1 * time, "pA": 40.0 + 0.01 * time})


def record_of(folder: Path, data: pd.DataFrame, experiment: str = EXPERIMENT, **options: Any) -> Record:
    """The record that the program makes of `data`."""
    data.to_csv(folder / "record.csv", index=False, **options)
    return read_records(read_experiment(write(folder, experiment, "experiment.toml")))[0]


def test_units_scale_and_offset(tmp_path: Path) -> None:
    record = record_of(tmp_path, table())
    assert record.sample_time == pytest.approx(1e-3)
    assert record.channels["position"][100] == pytest.approx(0.010)  # (10 + 10 - 10) mm
    assert record.channels["pressure_1"][100] == pytest.approx(0.5 * 41.0 * 1e5)
    assert np.all(record.valid)


def test_a_copy_under_another_name_is_refused_in_a_line(tmp_path: Path) -> None:
    """Fitted it would count twice."""
    table().to_csv(tmp_path / "copy.csv", index=False)
    with pytest.raises(UserError, match=r"copy\.csv: holds the same samples as .*record\.csv; expected another motion"):
        record_of(tmp_path, table(), f'{EXPERIMENT}[[records]]\nfile = "copy.csv"\n')


def test_a_position_from_one_end_is_refused_with_the_offset_that_puts_it_right(tmp_path: Path) -> None:
    """12 to 48 mm of a stroke of 60 mm; the offset may be written as a quantity."""
    data = spoiled(x=30.0 - 18.0 * np.cos(0.02 * table()["t"]))
    text = EXPERIMENT.replace("owen2001_experiment", "owen2001_simulation").replace(", offset = -10.0", "")
    with pytest.raises(UserError, match='from -30 to 30 mm: 0 is its middle; give channel position offset = "-30 mm"'):
        record_of(tmp_path, data, text)
    record = record_of(tmp_path, data, text.replace('unit = "mm"', 'unit = "mm", offset = "-30 mm"'))
    assert record.channels["position"][0] == pytest.approx(-0.018)
    assert np.all(np.abs(record.channels["position"]) < 0.0181)


def test_a_position_may_exceed_the_stroke_by_noise(tmp_path: Path) -> None:
    record = record_of(tmp_path, spoiled(x=10.0 + 87.0 * np.sin(0.01 * table()["t"])))
    assert record.channels["position"].max() > 0.5 * 0.172


@pytest.mark.parametrize("separator", [";", "\t", ","])
def test_any_separator_parquet_and_mat_are_the_same_record(tmp_path: Path, separator: str) -> None:
    data = table()
    reference = record_of(tmp_path, data, sep=separator)
    data.to_parquet(tmp_path / "record.parquet")
    savemat(tmp_path / "record.mat", {name: data[name].to_numpy() for name in data})
    for ending in ("parquet", "mat"):
        text = EXPERIMENT.replace("record.csv", f"record.{ending}")
        other = read_records(read_experiment(write(tmp_path, text, "experiment.toml")))[0]
        for name, values in reference.channels.items():
            np.testing.assert_allclose(other.channels[name], values, rtol=1e-12)


@pytest.mark.parametrize("separator", [";", "\t"])
def test_a_decimal_comma(tmp_path: Path, separator: str) -> None:
    """As a European spreadsheet writes it; a number may have no comma."""
    data = table()
    reference = record_of(tmp_path, data)
    other = record_of(tmp_path, data, sep=separator, decimal=",")
    for name, values in reference.channels.items():
        np.testing.assert_allclose(other.channels[name], values, rtol=1e-12)
    assert np.any(np.char.find((tmp_path / "record.csv").read_text().splitlines(), ",") > 0)


def test_a_small_gap_is_marked_and_never_filled(tmp_path: Path) -> None:
    data = table()
    data.loc[100:104, "x"] = np.nan
    record = record_of(tmp_path, data.drop(index=range(200, 203)))
    assert record.time.size == 400
    assert np.flatnonzero(~record.valid).tolist() == [100, 101, 102, 103, 104, 200, 201, 202]
    assert record.notes == ("8 samples in 2 gaps are left out",)


def spoiled(**columns: Any) -> pd.DataFrame:
    """The table with some columns replaced."""
    return table().assign(**columns)


COUNTED = re.sub('column = "(.*?)"', lambda found: f"column = {list(table()).index(found[1])}", EXPERIMENT)
"""The same channels by the numbers of their columns."""


def test_a_compressed_file_without_a_header_by_column_numbers(tmp_path: Path) -> None:
    table().to_csv(tmp_path / "record.csv.gz", sep=";", header=False, index=False)
    path = write(tmp_path, COUNTED.replace("record.csv", "record.csv.gz"), "experiment.toml")
    record, reference = read_records(read_experiment(path))[0], record_of(tmp_path, table())
    for name, values in reference.channels.items():
        assert record.channels[name] == pytest.approx(values)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("column = 3", "column = 4", "no column 4 for pressure_1: it has 4 columns, and they count from 0 to 3"),
        ("column = 3", 'column = "pA"', 'no column "pA" for pressure_1: the file has no header; give the number of'),
    ],
)
def test_a_column_that_a_file_without_a_header_lacks(tmp_path: Path, old: str, new: str, said: str) -> None:
    with pytest.raises(UserError, match=re.escape(said)):
        record_of(tmp_path, table(), COUNTED.replace(old, new), header=False)


def test_an_uneven_clock_is_put_on_a_grid_and_a_long_gap_is_told(tmp_path: Path) -> None:
    jitter = np.random.default_rng(3).uniform(-0.4, 0.4, 400)
    data = spoiled(t=table()["t"] + jitter, x=10.0 + 0.1 * (table()["t"] + jitter))
    text = EXPERIMENT.replace('"record.csv"', '"record.csv"\nskip = 10\nrows = 300\nsample_time = "2 ms"')
    record = record_of(tmp_path, data, text)
    assert record.sample_time == pytest.approx(2e-3)
    assert record.time.size == pytest.approx(150, abs=1)
    start = 0.1 * (10.0 + jitter[10])
    assert record.channels["position"] * 1e3 == pytest.approx(start + 0.2 * np.arange(record.time.size))
    data = spoiled(t=table()["t"] + 500.0 * (table()["t"] > 150.0))  # of rows 10 to 310
    assert record_of(tmp_path, data, text).notes[0] == "cut at its gaps into 2 pieces of 0.3 s in all"


def test_a_position_that_is_held_at_its_end_is_not_saturated(tmp_path: Path) -> None:
    """A converter's counts that creep to where a servo holds them for a third of the record."""
    counts = np.rint(100.0 * (1.0 - np.exp(-table()["t"] / 40.0)))
    assert record_of(tmp_path, spoiled(x=counts)).channels["position"].max() == pytest.approx(0.09)


@pytest.mark.parametrize(
    ("span", "hint"),
    [
        ("18.8", " (it seems 1000 times off)"),  # mm as m: a third of the stroke
        ("2.5", " (it seems 1000 times off)"),
        ("60", " (it seems 1000 times off)"),
        ("18800", " (it seems 1e+06 times off)"),  # um as m
        ("0.6", ""),
    ],
)
def test_a_length_in_another_unit_is_off_by_thousands(tmp_path: Path, span: str, hint: str) -> None:
    """Of a stroke of 60 mm a record may use a small part: what is 300 times too long is no hundred times off."""
    data = spoiled(x=0.5 * float(span) * np.sin(0.05 * table()["t"]))
    text = EXPERIMENT.replace("owen2001_experiment", "owen2001_simulation")
    with pytest.raises(UserError, match=r"the position spans \S+ m, and the stroke is 0.06 m; ") as raised:
        record_of(tmp_path, data, text.replace('unit = "mm", offset = -10.0', 'unit = "m"'))
    assert str(raised.value).endswith(f"is the unit of channel position right?{hint}")


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (
            table().rename(columns={"pA": "p_A"}),
            'no column "pA" for pressure_1; did you mean "p_A"? There are t, u, x, p_A',
        ),
        (
            spoiled(t=table()["t"] // 20.0),
            "95 % of the time stamps are out of order, repeated most of them: is the time ",
        ),
        (spoiled(t=-table()["t"]), "the time goes back again and again"),
        (
            spoiled(t=table()["t"] + 500.0 * (table()["t"] // 40.0)),
            "its gaps leave pieces of at most 40 samples, exp",
        ),
        (spoiled(x=12.5), "position is stuck: 0.0025 throughout"),
        (spoiled(pA=np.minimum(table()["pA"], 41.0)), "pressure_1 is saturated: at its largest value 2.05e+06"),
        (spoiled(x=table()["t"] * 10.0), "the position spans 3.99 m, and the stroke is 0.172 m"),
        (spoiled(pA=table()["pA"] * 100.0), "pressure_1 reaches 2.1995e+08 Pa, and the supply is 4.91e+06 Pa"),
        (spoiled(pA=table()["pA"] * 1e-5), "is the unit of channel pressure_1 right? (it seems 1e-05 times off)"),
        (
            spoiled(x=70.0 + 0.1 * table()["t"]),
            "the position goes from 60 to 99.9 mm, and a stroke of 172 mm from -86 to 86 mm: 0 is its middle; give "
            'channel position offset = "-96 mm", if that is the middle here',
        ),
        (spoiled(u=646.0 * np.sin(0.1 * table()["t"])), "valve_voltage reaches 646 V, and its limit is 10 V; is the"),
        (spoiled(u=-1.0), "the rod moves against valve_voltage on most of its way; is the sign of channel valve_volt"),
        (
            table(1000).assign(u=1e-3, x=10.0 + 0.05 * np.arange(1000), pA=40.0 + 1e-3 * np.arange(1000)),
            "by 0.001 V; is the unit of channel valve_voltage right?",
        ),
        (table(20), "holds 20 samples, expected at least 50"),
        (spoiled(pA="none"), 'column "pA" (pressure_1) holds no numbers'),
    ],
)
def test_a_record_that_cannot_be_used(tmp_path: Path, data: pd.DataFrame, said: str) -> None:
    with pytest.raises(UserError) as raised:
        record_of(tmp_path, data)
    assert said in str(raised.value)
    assert str(raised.value).startswith(str(tmp_path / "record.csv"))
    assert "\n" not in str(raised.value)


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            'model = "non_rotating"',
            'model = "non_rotatin"',
            ':3: plant.model: unknown plant "non_rotatin"',
        ),
        (
            'free = ["coulomb"]',
            'free = ["coulom"]',
            'fit.free.0: unknown parameter "coulom"; did you mean "coulomb"?',
        ),
        ('min = "1 N"', 'min = "1 m"', ':7: fit.coulomb.min: got "1 m", expected a quantity in N, such as "1 N"'),
        ('unit = "bar"', 'unit = "mm"', ':12: channels.pressure_1.unit: got "mm", expected a unit such as "Pa"'),
        (
            'unit = "mm"',
            'unit = "milimeter"',
            ':11: channels.position.unit: got "milimeter"; did you mean "millimeter"?',
        ),
        ('min = "1 N"', 'min = "1 newtn"', 'a number with a unit; did you mean "1 newton"?'),
        ("pressure_1 =", "pressur_1 =", ':12: channels.pressur_1: unknown channel; did you mean "pressure_1"?'),
        ('file = "record.csv"', 'fil = "record.csv"', ':14: records.0.fil: unknown key; did you mean "file"?'),
        ('file = "record.csv"', 'file = "other.csv"', "other.csv: no such file"),
        ('max = "2 kN"', 'max = "0 N"', ":7: fit.coulomb: expected a min below max"),
    ],
)
def test_a_wrong_experiment_is_one_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    assert EXPERIMENT.count(old) == 1
    fails(identify(tmp_path, EXPERIMENT.replace(old, new), "simulation"), said)
    assert not (tmp_path / "out").exists()
