"""Files of records as loggers write them: each format, and texts under headers of several rows."""

import gzip
import math
import re
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import write
from scipy.io import savemat

from workbench.errors import UserError
from workbench.records.experiment import read_experiment
from workbench.records.formats.interface import UNITS
from workbench.records.reading import Record, read_records
from workbench.records.tables import numbers_of, read_table, seconds

TIME = 0.01 * np.arange(300)
POSITION = 40.0 * np.sin(2.0 * TIME)
VOLTAGE = 2.0 * np.cos(2.0 * TIME)

EXPERIMENT = """\
title = "a file of some format"
[plant]
model = "non_rotating"
parameters = "owen2001_experiment"
[channels]
time = { column = "TIME", unit = "s" }
valve_voltage = { column = "U", unit = "V" }
position = { column = "X", unit = "mm" }
[[records]]
FILE
"""


def record_of(folder: Path, file: str, time: str = "time", u: str = "u", x: str = "x") -> Record:
    """The record of a file, by its columns' names; `file` may be whole keys of [[records]]."""
    text = EXPERIMENT.replace("TIME", time).replace('"U"', f'"{u}"').replace('"X"', f'"{x}"')
    text = text.replace("FILE", file if "=" in file else f'file = "{file}"')
    (record,) = read_records(read_experiment(write(folder, text, "experiment.toml")))
    return record


def holds(record: Record, rtol: float = 1e-9) -> None:
    """That the record is the one that was written."""
    assert record.sample_time == pytest.approx(0.01)
    np.testing.assert_allclose(record.channels["position"], 1e-3 * POSITION, rtol=rtol, atol=1e-12)
    np.testing.assert_allclose(record.channels["valve_voltage"], VOLTAGE, rtol=rtol, atol=1e-12)


def rows(separator: str, decimal: str = ".", *, end: str = "") -> str:
    """The numbers as a text."""
    lines = (separator.join(repr(float(n)) for n in row) + end for row in zip(TIME, VOLTAGE, POSITION, strict=True))
    return "\n".join(lines).replace(".", decimal) + "\n"


@pytest.mark.parametrize(
    ("text", "columns", "units"),
    [
        pytest.param(
            "LabVIEW Measurement\nWriter_Version\t2\nSeparator\tTab\nDate\t2023/05/04\n***End_of_Header***\n\n"
            "X_Value\tVoltage\tWeg\nsec\tV\tmm\n" + rows("\t"),
            ("X_Value", "Voltage", "Weg"),
            {"X_Value": "sec", "Voltage": "V", "Weg": "mm"},
            id="labview",
        ),
        pytest.param(
            "#DSPACE export\n#raster: 10 ms\n\ntime;Model Root/u;Model Root/x\n[s];[V];[mm]\n" + rows(";", ","),
            ("time", "Model Root/u", "Model Root/x"),
            {"time": "s", "Model Root/u": "V", "Model Root/x": "mm"},
            id="dspace",
        ),
        pytest.param(
            "x-axis,1,2\nsecond,Volt,mm\n" + rows(","),
            ("x-axis", "1", "2"),
            {"x-axis": "second", "1": "Volt", "2": "mm"},
            id="keysight",
        ),
        pytest.param("% t u x\n" + rows("  "), ("t", "u", "x"), {}, id="commented"),
        pytest.param(
            '"Zeit, gesamt","Ventil ""A""","Weg"\n' + rows(",", end=","),
            ("Zeit, gesamt", r"Ventil \"A\"", "Weg"),
            {},
            id="quoted",
        ),
    ],
)
def test_texts_under_headers_of_several_rows(
    tmp_path: Path, text: str, columns: tuple[str, str, str], units: dict[str, str]
) -> None:
    (tmp_path / "log.csv").write_text(text, encoding="utf-8-sig")
    record = record_of(tmp_path, "log.csv", *columns)
    holds(record)
    assert read_table(tmp_path / "log.csv").attrs[UNITS] == units
    with gzip.open(tmp_path / "log.txt.gz", "wt", encoding="cp1252") as file:
        file.write(text)
    holds(record_of(tmp_path, "log.txt.gz", *columns))


def test_a_text_of_windows_and_words_among_its_numbers(tmp_path: Path) -> None:
    """UTF-16 with a mark; a sensor that says "---"; a clock of dates."""
    stamps = pd.to_datetime("2024-03-01 07:59:59") + pd.to_timedelta(TIME, unit="s")
    lines = [f"{t};{u};{x}" for t, u, x in zip(stamps, VOLTAGE, POSITION, strict=True)]
    lines[100] = lines[100].rsplit(";", 1)[0] + ";---"
    body = "\n".join(line.replace(".", ",") for line in lines)
    (tmp_path / "log.csv").write_text(f"Zeit;Spannung;Weg\n{body}\n", encoding="utf-16")
    record = record_of(tmp_path, "log.csv", "Zeit", "Spannung", "Weg")
    assert np.flatnonzero(~record.valid).tolist() == [100]
    known = record.valid
    np.testing.assert_allclose(record.channels["position"][known], 1e-3 * POSITION[known], atol=1e-9)


def test_structs_of_matlab(tmp_path: Path) -> None:
    """Fields, a matrix's columns, a series with Time and Data, and Simulink's structure with time."""
    signals = np.empty(2, dtype=object)
    signals[:] = [{"values": VOLTAGE, "label": "u", "dimensions": 1.0}, {"values": POSITION, "label": ""}]
    content = {
        "log": {"t": TIME, "cyl": {"x": POSITION}, "u": VOLTAGE, "name": "rig"},
        "ts": {"Time": TIME, "Data": np.column_stack([VOLTAGE, POSITION])},
        "out": {"time": TIME, "signals": signals},
        "wide": np.vstack([TIME, VOLTAGE, POSITION]),
        "gain": 3.0,
    }
    savemat(tmp_path / "log.mat", content)
    holds(record_of(tmp_path, "log.mat", "log.t", "log.u", "log.cyl.x"))
    holds(record_of(tmp_path, "log.mat", "ts.Time", "ts.Data_0", "ts.Data_1"))
    holds(record_of(tmp_path, "log.mat", "out.time", "out.u", "out.signals_1"))
    holds(record_of(tmp_path, "log.mat", "wide_0", "wide_1", "wide_2"))


def test_matlab_from_7_3_on(tmp_path: Path) -> None:
    """As MATLAB lays it out: transposed, text as numbers, struct arrays as lists of references."""
    import h5py

    with h5py.File(tmp_path / "log.mat", "w", userblock_size=512) as file:
        file["log/t"], file["log/u"] = TIME[None], VOLTAGE[None]
        file["log/pos"] = np.vstack([POSITION, -POSITION])
        file["#refs#/a"], file["#refs#/b"] = VOLTAGE[None], POSITION[None]
        for name, label in (("c", "u"), ("d", "x")):
            file[f"#refs#/{name}"] = np.array([[ord(label)]], dtype=np.uint16)
            file[f"#refs#/{name}"].attrs["MATLAB_class"] = np.bytes_("char")
        file["out/time"] = TIME[None]
        for field, names in (("values", "ab"), ("label", "cd")):
            file[f"out/signals/{field}"] = np.array([[file[f"#refs#/{name}"].ref] for name in names], h5py.ref_dtype)
    with (tmp_path / "log.mat").open("r+b") as raw:
        raw.write(b"MATLAB 7.3 MAT-file, Platform: GLNXA64".ljust(116) + bytes(8) + b"\x00\x02IM")
    holds(record_of(tmp_path, "log.mat", "log.t", "log.u", "log.pos_0"))
    holds(record_of(tmp_path, "log.mat", "out.time", "out.u", "out.x"))


def test_tdms(tmp_path: Path) -> None:
    """Waveforms with an increment, and a file that has a channel of the time."""
    from nptdms import ChannelObject, TdmsWriter

    wave = {"wf_increment": 0.01, "wf_start_offset": 0.0, "wf_samples": TIME.size}
    for name, channels in {
        "wave": {"u": (VOLTAGE, {**wave, "unit_string": "V"}), "x": (POSITION, {**wave, "unit_string": "mm"})},
        "plain": {"time": (TIME, {}), "u": (VOLTAGE, {}), "x": (POSITION, {})},
    }.items():
        with TdmsWriter(tmp_path / f"{name}.tdms") as file:
            file.write_segment([ChannelObject("log", key, *value) for key, value in channels.items()])
        holds(record_of(tmp_path, f"{name}.tdms"))
    assert read_table(tmp_path / "wave.tdms").attrs[UNITS] == {"time": "s", "u": "V", "x": "mm"}


def test_mdf_with_channels_of_two_rates(tmp_path: Path) -> None:
    """Position at 100 Hz and voltage at 50: the record has the slower one's rate."""
    from asammdf import MDF, Signal

    with MDF() as file:
        file.append([Signal(POSITION, TIME, name="x", unit="mm")])
        file.append([Signal(VOLTAGE[::2], TIME[::2], name="u", unit="V")])
        file.save(tmp_path / "log.mf4")
    record = record_of(tmp_path, "log.mf4")
    assert record.sample_time == pytest.approx(0.02)
    np.testing.assert_allclose(record.channels["position"], 1e-3 * POSITION[: 2 * record.time.size : 2], atol=1e-12)
    assert read_table(tmp_path / "log.mf4").attrs[UNITS]["x"] == "mm"


def test_ros_bags(tmp_path: Path) -> None:
    """Two topics of ROS 2, with a header's stamp and without."""
    from rosbags.rosbag2 import StoragePlugin, Writer
    from rosbags.typesys import Stores, get_typestore

    store = get_typestore(Stores.LATEST)
    joint, number = store.types["sensor_msgs/msg/JointState"], store.types["std_msgs/msg/Float64"]
    header, stamp = store.types["std_msgs/msg/Header"], store.types["builtin_interfaces/msg/Time"]
    with Writer(tmp_path / "bag", version=9, storage_plugin=StoragePlugin.SQLITE3) as bag:
        joints = bag.add_connection("/joint_states", joint.__msgtype__, typestore=store)
        valve = bag.add_connection("/valve", number.__msgtype__, typestore=store)
        for t, u, x in zip(TIME, VOLTAGE, POSITION, strict=True):
            nano = round(1e9 * (1000.0 + t))
            at = header(stamp(nano // 10**9, nano % 10**9), "rig")
            message = joint(at, ["rod"], np.array([x]), np.zeros(0), np.zeros(0))
            bag.write(joints, nano + 123, store.serialize_cdr(message, joint.__msgtype__))
            bag.write(valve, nano, store.serialize_cdr(number(u), number.__msgtype__))
    record = record_of(tmp_path, "bag/bag.db3", "time", "valve.data", "joint_states.position_0")
    holds(record, rtol=1e-6)


def test_a_library_that_is_missing_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "nptdms", None)
    (tmp_path / "log.tdms").write_bytes(b"TDSm")
    said = 'log.tdms: nptdms is needed to read it and is not installed: pip install "friction-workbench[formats]"'
    with pytest.raises(UserError, match=re.escape(said)):
        read_table(tmp_path / "log.tdms")


@pytest.mark.parametrize("ending", ["tdms", "mf4", "mat", "bag"])
def test_a_file_that_is_none_of_its_ending_is_one_line(tmp_path: Path, ending: str) -> None:
    (tmp_path / f"log.{ending}").write_text("t,x\n1,2\n")
    with pytest.raises(UserError, match=f"log.{ending}: cannot be read as a table") as raised:
        read_table(tmp_path / f"log.{ending}")
    assert "\n" not in str(raised.value)


def test_a_file_for_each_channel(tmp_path: Path) -> None:
    """Position every 10 ms, voltage every 25 ms from 0.2 s on: the coarser grid, over what they have in common."""
    pd.DataFrame({"time": TIME, "x": POSITION}).to_csv(tmp_path / "x.csv", index=False)
    late = np.arange(0.2, 2.9, 0.025)
    pd.DataFrame({"time": late, "u": 2.0 * np.cos(2.0 * late)}).to_csv(tmp_path / "u.csv", index=False)
    files = 'files = { position = "x.csv", valve_voltage = "u.csv" }'
    record = record_of(tmp_path, files)
    assert record.sample_time == pytest.approx(0.025)
    wanted = 0.04 * np.sin(2.0 * (0.2 + record.time))
    np.testing.assert_allclose(record.channels["position"], wanted, atol=1e-5)
    assert "2 clocks are put on an even grid of 25 ms" in record.notes[0]
    assert record_of(tmp_path, files + '\nsample_time = "10 ms"').sample_time == pytest.approx(0.01)


@pytest.mark.parametrize(
    ("keys", "said"),
    [
        (
            'files = { position = "x.csv" }',
            "records.0.files: no file for valve_voltage; name one, or leave the channel",
        ),
        (
            'files = { positon = "x.csv" }',
            'records.0.files.positon: no channel of [channels]; did you mean "position"?',
        ),
        ('file = "a.csv"\nfiles = { position = "x.csv" }', "expected either file, or files: one for each channel"),
    ],
)
def test_a_mistake_in_the_files_of_channels_is_one_line(tmp_path: Path, keys: str, said: str) -> None:
    with pytest.raises(UserError) as raised:
        record_of(tmp_path, keys)
    assert said in str(raised.value)
    assert "\n" not in str(raised.value)


def test_a_field_of_very_many_digits_takes_no_time(tmp_path: Path) -> None:
    """Whether it is a number is seen in one pass: it takes as long as it is, not the square of that."""
    path = tmp_path / "log.csv"
    path.write_text("time,position\n0,1\n1,2\n" + "9" * 200_000 + "x,3\n", encoding="utf-8")
    assert list(read_table(path).columns) == ["time", "position"]


def test_whole_numbers_that_no_float_can_hold_are_infinite() -> None:
    column = pd.Series([1, 10**400, -3, "x"], dtype=object)
    assert numbers_of(column).tolist() == pytest.approx([1.0, math.inf, -3.0, math.nan], nan_ok=True)


def test_no_date_is_looked_for_in_very_long_text() -> None:
    """It would take minutes."""
    found = seconds(pd.Series(["10:00:00", "3" * 1_000_000 + " a", "10:00:02"]))
    assert found.tolist() == pytest.approx([0.0, math.nan, 2.0], nan_ok=True)


@pytest.mark.parametrize("zones", [("+01:00", "+01:00"), ("+01:00", "+02:00"), ("Z", "Z")])
def test_dates_of_one_time_zone_or_several(zones: tuple[str, str]) -> None:
    first, second = zones
    hours = {"+01:00": 1.0, "+02:00": 2.0, "Z": 0.0}
    found = seconds(pd.Series([f"2026-01-01T10:00:00{first}", f"2026-01-01T10:00:01{second}"]))
    assert found.tolist() == pytest.approx([0.0, 1.0 - 3600.0 * (hours[second] - hours[first])])
