"""The wizard on logs of many kinds: channels by names and by numbers, units, signs, plants, parameters to begin with.

The motion of each is a sum of two sines, and its friction is Coulomb's and viscous.
"""

import contextlib
import re
import tomllib
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple
from unicodedata import category

import numpy as np
import pandas as pd
import pytest
from drawn_machines import hydraulic
from scipy.io import savemat

from plants.registry import CHAMBERS, DRIVE_FORCE, PLANTS, THESIS
from workbench.errors import UNSEEN, UserError
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.importing.columns import rounded_up
from workbench.records.importing.importing import proposal_for
from workbench.records.importing.proposal import Ask
from workbench.records.importing.words import MOST_WORDS, scores, words_of
from workbench.records.importing.writing import text_of
from workbench.records.reading import read_records
from workbench.records.schema import FRICTION
from workbench.records.tables import read_table

TIME = 0.002 * np.arange(10_000)


class Driven(NamedTuple):
    """A motion (SI) and the force that drives it."""

    position: np.ndarray
    velocity: np.ndarray
    force: np.ndarray


def driven(way: float, period: float, *, mass: float, coulomb: float, viscous: float) -> Driven:
    """A mass that goes a way (m) about 0 to and fro."""
    first, second = 2.0 * np.pi / period, 2.0 * np.pi / period * 1.7
    x = way * (0.6 * np.sin(first * TIME) + 0.4 * np.sin(second * TIME))
    v = way * (0.6 * first * np.cos(first * TIME) + 0.4 * second * np.cos(second * TIME))
    a = -way * (0.6 * first**2 * np.sin(first * TIME) + 0.4 * second**2 * np.sin(second * TIME))
    return Driven(x, v, mass * a + coulomb * np.sign(v) + viscous * v)


def imported(*logs: Path, plant: str | None = None, ask: Ask | None = None) -> tuple[dict[str, Any], str]:
    """What the wizard writes of logs, as content and as text."""
    text = text_of(proposal_for(logs, plant, None, logs[0].parent, ask), logs[0].parent)
    return tomllib.loads(text), text


def read(log: Path, text: str) -> Experiment:
    """The experiment, read as any other, and its records with it."""
    path = log.with_suffix(".toml")
    path.write_text(text, encoding="utf-8")
    experiment = read_experiment(path)
    assert read_records(experiment, None)
    return experiment


def columns(content: Mapping[str, Any]) -> dict[str, str]:
    """The columns of the channels."""
    return {name: channel["column"] for name, channel in content["channels"].items()}


def test_a_small_pneumatic_axis_in_mm_and_bar_in_german(tmp_path: Path) -> None:
    """3 kg; a LabVIEW export with decimal commas; the position is counted from an end."""
    x, v, force = driven(0.08, 4.0, mass=3.0, coulomb=12.0, viscous=60.0)
    table = [
        TIME,
        5.0 * v / np.max(np.abs(v)),
        100.0 + 1e3 * x,
        100.0 + 1e3 * x,
        4.0 + force / 98.0,
        4.0 - force / 98.0,
    ]
    lines = ["Prüfstand 2", "", "Zeit\tVentilspannung\tWeg_ist\tWeg_soll\tDruck_A\tDruck_B", "s\tV\tmm\tmm\tbar\tbar"]
    lines += ["\t".join(f"{number:.5f}" for number in row).replace(".", ",") for row in zip(*table, strict=True)]
    (tmp_path / "log.csv").write_text("\n".join(lines), encoding="cp1252")
    content, text = imported(tmp_path / "log.csv")
    assert columns(content) == {
        "time": "Zeit",
        "valve_voltage": "Ventilspannung",
        "position": "Weg_ist",
        "pressure_1": "Druck_A",
        "pressure_2": "Druck_B",
    }
    assert content["channels"]["position"] == {
        "column": "Weg_ist",
        "unit": "mm",
        "offset": pytest.approx(-100.0, abs=1.0),
    }
    assert "# not used: Weg_soll: what was wanted, by its name" in text
    assert all("#" in line for line in text.splitlines() if line.startswith(tuple(content["channels"])))
    experiment = read(tmp_path / "log.csv", text)
    assert experiment.plant.command == "valve_voltage"
    assert {"pressure_1", "pressure_2"} <= set(experiment.plant.channels)
    assert "[channels]" in text.partition("# ?")[2]  # what nobody can know is asked before


def test_a_press_in_inch_and_psi_in_french(tmp_path: Path) -> None:
    """600 kg; pressures that mirror each other are not one in other units; percent of a command are asked for."""
    x, v, force = driven(0.3, 10.0, mass=600.0, coulomb=3e3, viscous=2e4)
    content = {
        "Temps [ms]": 1e3 * TIME,
        "Commande vanne [%]": 80.0 * v / np.max(np.abs(v)),
        "Position [in]": x / 0.0254,
        "Pression A [psi]": (6e6 + 100.0 * force) / 6894.757,
        "Pression B [psi]": (6e6 - 100.0 * force) / 6894.757,
        "Temp huile [degC]": 40.0 + 0.01 * TIME,
    }
    pd.DataFrame(content).to_csv(tmp_path / "log.csv", sep=";", index=False, encoding="utf-8-sig")
    found, text = imported(tmp_path / "log.csv")
    assert columns(found) == dict(
        zip(("time", "valve_voltage", "position", "pressure_1", "pressure_2"), list(content)[:5], strict=True)
    )
    assert [found["channels"][name]["unit"] for name in ("time", "position", "pressure_1")] == ["ms", "inch", "psi"]
    assert found["fit"]["free"] == ["coulomb", "viscous", "bristle_stiffness", "valve_flow_gain", "bulk_modulus"]
    assert "# ? valve_voltage: how many volts are 100 % of Commande vanne [%]?" in text
    assert "# not used: Temp huile [degC]" in text
    read(tmp_path / "log.csv", text)


def test_counts_are_asked_for_and_answers_count_in_what_is_made_of_them(tmp_path: Path) -> None:
    """An encoder of 1 um and a converter of 16 bits, in a struct of MATLAB, over microseconds."""
    x, _, force = driven(0.05, 3.0, mass=20.0, coulomb=30.0, viscous=100.0)
    log = {"t": 1e6 * TIME, "encoder": np.rint(x / 1e-6) + 20_000.0, "u_dac": np.rint(force / 400.0 * 32767.0)}
    savemat(tmp_path / "log.mat", {"log": log})
    content, text = imported(tmp_path / "log.mat")
    assert columns(content) == {"time": "log.t", "position": "log.encoder", "command": "log.u_dac"}
    assert content["channels"]["time"]["unit"] == "us"
    assert len(re.findall(r"# \? .* looks like counts .*: how many (mm|V) is one\?", text)) == 2
    assert content["plant"]["model"] == "drive_voltage"
    assert content["fit"]["method"] == "simulation"
    answers = {"how many mm": "0.001", "how many V": str(10.0 / 32767.0), "how much drives": "40 N/V"}

    def answer(question: str, guess: str) -> str:
        return next((given for words, given in answers.items() if words in question), guess)

    content, text = imported(tmp_path / "log.mat", ask=answer)
    assert "\n# ?" not in text
    values = read(tmp_path / "log.mat", text).values
    assert values["force_gain"] == 40.0
    assert values["coulomb"] * 40.0 == pytest.approx(30.0, rel=0.15)  # least squares took a gain of 1 N/V
    assert values["viscous"] * 40.0 == pytest.approx(100.0, rel=0.15)


def test_a_rotary_joint_in_deg_and_newton_metres(tmp_path: Path) -> None:
    """A TDMS file of waveforms, which knows its units."""
    from nptdms import ChannelObject, TdmsWriter

    x, v, torque = driven(0.8, 5.0, mass=0.5, coulomb=3.0, viscous=2.0)
    channels = {"joint_angle": (np.rad2deg(x), "deg"), "torque": (torque, "Nm"), "joint_vel": (np.rad2deg(v), "deg/s")}
    with TdmsWriter(tmp_path / "log.tdms") as file:
        file.write_segment(
            [
                ChannelObject(
                    "joint", name, values, {"wf_increment": 0.002, "wf_start_offset": 0.0, "unit_string": unit}
                )
                for name, (values, unit) in channels.items()
            ]
        )
    content, text = imported(tmp_path / "log.tdms")
    assert columns(content) == {
        "time": "time",
        "position": "joint_angle",
        "torque": "torque",
        "velocity": "joint_vel",
    }
    units = {name: channel["unit"] for name, channel in content["channels"].items()}
    assert units == {"time": "s", "position": "deg", "torque": "N m", "velocity": "deg/s"}
    experiment = read(tmp_path / "log.tdms", text)
    assert experiment.plant.name == "rotary_torque"
    assert read_records(experiment)[0].notes == ("velocity agrees with the slope of position: 1 times it",)


def test_a_slow_log_with_jitter_gaps_and_dates_is_entered_as_it_is(tmp_path: Path) -> None:
    """10 min at 19 Hz, command and position alone, in Italian."""
    draw = np.random.default_rng(2)
    time = 0.053 * (np.arange(11_300) + draw.uniform(-0.3, 0.3, 11_300))
    time = time[time % 97.0 > 0.5]
    x = 150.0 * np.sin(2.0 * np.pi * time / 10.0)
    u = 1.5 * np.sign(np.cos(2.0 * np.pi * time / 10.0)) + 2.0 * np.cos(2.0 * np.pi * time / 10.0)
    stamps = pd.Timestamp("2024-05-06 10:00:00") + pd.to_timedelta(time, unit="s")
    table = pd.DataFrame({"Tempo": stamps, "Comando (V)": u.round(3), "Posizione (mm)": x.round(2)})
    table.to_csv(tmp_path / "log.csv", index=False)
    content, text = imported(tmp_path / "log.csv")
    assert columns(content) == {"time": "Tempo", "command": "Comando (V)", "position": "Posizione (mm)"}
    assert 'file = "log.csv"  # 18.8' in text
    assert "cut at its gaps into 7 pieces" in text
    assert content["plant"]["model"] == "valve_axis"  # so slow a log shows no force
    assert {"velocity_gain", "dead_band_negative"} <= set(content["plant"]["set"])
    records = read_records(read(tmp_path / "log.csv", text))
    assert len(records) == 7
    assert sum(record.time[-1] for record in records) > 590.0


def test_without_names_the_numbers_tell(tmp_path: Path) -> None:
    """No header: time in ms, raw volts, then mm; a speed that the slope follows, its integral's reference, noise."""
    x, v, force = driven(0.02, 6.0, mass=1.0, coulomb=800.0, viscous=100.0)
    noise = np.random.default_rng(1).standard_normal(TIME.size)
    late = np.interp(TIME - 0.1, TIME, x)
    pump = np.rint(9e4 * v)  # rpm
    table = [
        1e3 * TIME,
        1.0 + 30.0 * late,
        1e3 * late,
        pump,
        5.0 + force / 500.0,
        5.0 - force / 500.0 + 0.1 * noise,
        noise,
    ]
    np.savetxt(tmp_path / "log.tsv", np.column_stack(table), fmt="%.6g", delimiter="\t")
    content, text = imported(tmp_path / "log.tsv")
    assert columns(content) == {"time": 0, "position": 2, "pump_speed": 3, "pressure_1": 4, "pressure_2": 5}
    assert content["channels"]["pump_speed"]["unit"] == "rpm"
    assert content["plant"]["model"] == "pump_cylinder"
    assert "# not used: 1: 2 in other units, it seems" in text
    assert text.count("# ? position: is it column 2?") == 1
    read(tmp_path / "log.tsv", text)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_a_position_that_goes_against_its_command_turns_the_command(tmp_path: Path, sign: float) -> None:
    x, _, force = driven(0.1, 4.0, mass=1.0, coulomb=20.0, viscous=50.0)
    pd.DataFrame({"t": TIME, "u": sign * force / 10.0, "x": x}).to_csv(tmp_path / "log.csv", index=False)
    content, text = imported(tmp_path / "log.csv")
    assert content["channels"]["command"].get("scale", 1.0) == sign
    assert ("the position moves against it" in text) == (sign < 0.0)


def test_a_force_against_a_pressure_has_the_signs_of_friction(tmp_path: Path) -> None:
    """A rod that is pushed in against 3 bar: a positive force there is one against pressure_1."""
    x, v, friction = driven(0.02, 6.0, mass=0.1, coulomb=8.0, viscous=50.0)
    table = {"time_s": TIME, "pos_mm": 1e3 * x, "pressure_bar": 3.0 + 0.02 * np.sign(v), "force_N": 150.0 + friction}
    pd.DataFrame(table).to_csv(tmp_path / "log.csv", index=False)
    content, _ = imported(tmp_path / "log.csv")
    assert columns(content) == dict(zip(("time", "position", "pressure_1", "force"), table, strict=True))
    assert (content["channels"]["force"]["scale"], content["channels"]["position"]["scale"]) == (-1.0, -1.0)
    assert content["plant"]["model"] == "drive_force"
    assert "piston_area_1" in content["fit"]["free"]
    assert content["fit"]["method"] == "thesis"


def test_the_last_of_several_logs_is_held_out_and_all_are_of_one_kind(tmp_path: Path) -> None:
    x, _, force = driven(0.1, 4.0, mass=1.0, coulomb=20.0, viscous=50.0)
    table = pd.DataFrame({"t": TIME, "u": force / 10.0, "x": x})
    for name in "abc":
        table.to_csv(tmp_path / f"{name}.csv", index=False)
    content, _ = imported(*(tmp_path / f"{name}.csv" for name in "abc"))
    assert [record["use"] for record in content["records"]] == ["fit", "fit", "held_out"]
    table.rename(columns={"u": "v_cmd"}).to_csv(tmp_path / "c.csv", index=False)
    with pytest.raises(UserError, match=r"c\.csv: no numbers that change in u, which .*a\.csv has"):
        imported(*(tmp_path / f"{name}.csv" for name in "abc"))


def test_a_wanted_voltage_is_the_command_where_nothing_else_is(tmp_path: Path) -> None:
    """A PLC's log of what it asks of a valve; beside a measured voltage it is not used."""
    x, _, force = driven(0.1, 4.0, mass=1.0, coulomb=20.0, viscous=50.0)
    table = {"Zeit_s": TIME, "Soll_V": force / 10.0, "Ist_mm": 1e3 * x, "Soll_mm": 1e3 * np.roll(x, -20)}
    pd.DataFrame(table).to_csv(tmp_path / "log.csv", index=False)
    content, text = imported(tmp_path / "log.csv")
    assert columns(content) == {"time": "Zeit_s", "command": "Soll_V", "position": "Ist_mm"}
    assert "not used: Soll_mm" in text
    pd.DataFrame({**table, "Ventil_V": force / 11.0}).to_csv(tmp_path / "log.csv", index=False)
    content, text = imported(tmp_path / "log.csv")
    assert columns(content)["valve_voltage"] == "Ventil_V"
    assert "not used: Soll_V" in text


@pytest.mark.parametrize(("about", "offset"), [(0.25, -200.0), (-0.25, 200.0), (0.05, 0.0)])
def test_a_set_chooses_a_plant_that_it_serves_and_knows_the_stroke(tmp_path: Path, about: float, offset: float) -> None:
    """Unequal areas are no machine of one load pressure; a way within the stroke is counted from an end of it."""
    x, _, force = driven(0.03, 4.0, mass=1.0, coulomb=20.0, viscous=50.0)
    table = {"t_s": TIME, "valve_V": force / 10.0, "x_mm": 1e3 * (about + x)}
    table |= {"pA_bar": 30.0 + force / 50.0, "pB_bar": 40.0 - force / 50.0}
    pd.DataFrame(table).to_csv(tmp_path / "log.csv", index=False)
    values = {**hydraulic(1), "stroke": 0.4}
    lines = [f'{name} = {{ value = {number!r}, source = "made up" }}' for name, number in values.items()]
    (tmp_path / "machine.toml").write_text("\n".join(['title = "m"', 'source = "made up"', "[parameters]", *lines]))
    text = text_of(proposal_for([tmp_path / "log.csv"], None, "machine.toml", tmp_path), tmp_path)
    content = tomllib.loads(text)
    assert content["plant"]["model"] == "cylinder"
    assert content["channels"]["position"].get("offset", 0.0) == offset
    assert {*FRICTION, "valve_flow_gain", "bulk_modulus"} <= {*content["fit"]["free"]}


@pytest.mark.parametrize(("level", "chosen"), [(5.0, "air"), (80.0, "non_rotating")])
def test_low_pressures_are_those_of_air(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, level: float, chosen: str
) -> None:
    """Of two plants with the same sensors, one of which has no oil."""
    air = replace(CHAMBERS, name="air", Parameters=DRIVE_FORCE.Parameters)
    monkeypatch.setitem(PLANTS.__dict__, "ours", {"air": air, "non_rotating": THESIS})
    x, v, force = driven(0.08, 4.0, mass=3.0, coulomb=12.0, viscous=60.0)
    table = {"t": TIME, "valve_V": v, "x_mm": 1e3 * x, "pA_bar": level + 0.01 * force, "pB_bar": level - 0.01 * force}
    pd.DataFrame(table).to_csv(tmp_path / "log.csv", index=False)
    content, _ = imported(tmp_path / "log.csv")
    assert content["plant"]["model"] == chosen


@pytest.mark.parametrize(
    ("name", "channel"),
    [
        ("ValvePos_cmd", "valve_voltage"),
        ("p_A", "pressure_1"),
        ("P2", "pressure_2"),
        ("druckKolbenseite", "pressure_1"),
        ("p_supply", "supply_pressure"),
        ("Fuerza", "force"),
        ("vitesse", "velocity"),
        ("Drehmoment", "torque"),
        ("joint_states.position_0", "position"),
        ("i_mot", "motor_current"),
        ("n_Pumpe", "pump_speed"),
        ("x", "position"),
        ("vir", "command"),
        ("Force cmd", "command"),
        ("tau_cmd", "command"),
        ("Force_cmd_fb", "force"),
    ],
)
def test_names_of_channels(name: str, channel: str) -> None:
    found = scores(name)
    assert max(found, key=lambda each: found[each]) == channel


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ({"a": TIME[::-1] * 0.0 + 1.0, "b": TIME}, "no two columns of numbers that change, of at least 50 rows"),
        ({"a": np.sin(TIME), "b": np.cos(TIME)}, "no column goes on as a time does"),
        ({"t": TIME, "supply": np.cos(TIME)}, "none of its columns looks like a position: t, supply"),
        ({"t": TIME, "weg": np.sin(TIME)}, "no plant fits these channels: position; name one with --plant"),
    ],
)
def test_a_log_that_cannot_be_imported_is_one_line(tmp_path: Path, table: dict[str, np.ndarray], said: str) -> None:
    pd.DataFrame(table).to_csv(tmp_path / "log.csv", index=False)
    with pytest.raises(UserError) as raised:
        imported(tmp_path / "log.csv")
    assert said in str(raised.value)
    assert "\n" not in str(raised.value)


def test_odd_names_of_columns_and_files_make_an_experiment_that_can_be_read(tmp_path: Path) -> None:
    """A column whose name nobody sees is named by its number."""
    time = np.arange(0.0, 20.0, 0.01)
    columns = {"time": time, "command_V": np.sin(time), 'position "<b>"\u202e mm': 10.0 * np.sin(time - 0.3)}
    log = tmp_path / "log\u200b $.csv"
    pd.DataFrame(columns).to_csv(log, index=False)
    text = text_of(proposal_for([log], None, None, tmp_path), tmp_path)
    assert text.isascii() or all(category(letter) not in UNSEEN for letter in text.replace("\n", ""))
    content = tomllib.loads(text)
    assert content["records"][0]["file"] == log.name
    assert content["channels"]["position"]["column"] == 2


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"position": np.where(np.arange(2000) == 7, 1e-15, 0.0)}, '"position" moves by '),
        ({"time": 5e-324 * np.arange(2000)}, "between samples, expected 1e-07 to 1e"),
        ({"time": 1e20 * np.arange(2000)}, "between samples, expected 1e-07 to 1e"),
    ],
)
def test_logs_without_a_motion_or_a_clock_are_refused(tmp_path: Path, change: dict[str, Any], said: str) -> None:
    time = 0.01 * np.arange(2000)
    pd.DataFrame({"time": time, "command_V": np.sin(time), "position": np.cos(time), **change}).to_csv(
        tmp_path / "log.csv", index=False
    )
    with pytest.raises(UserError, match=said):
        proposal_for([tmp_path / "log.csv"], None, None, tmp_path)


@pytest.mark.parametrize("ending", ["mat", "csv.gz", "parquet"])
def test_a_damaged_file_is_refused_whatever_its_reader_raises(tmp_path: Path, ending: str) -> None:
    path, table = tmp_path / f"log.{ending}", pd.DataFrame({"time": TIME, "position": np.sin(TIME)})
    if ending == "mat":
        savemat(path, {name: table[name].to_numpy() for name in table}, do_compression=True)
    elif ending == "parquet":
        table.to_parquet(path)
    else:
        table.to_csv(path, index=False)
    whole = path.read_bytes()
    for place in range(20, len(whole) - 1, len(whole) // 12):
        path.write_bytes(whole[:place] + b"\xff\x00\xff" + whole[place + 3 :])
        with contextlib.suppress(UserError):
            read_table(path)
    path.write_bytes(whole[: len(whole) // 2])
    with pytest.raises(UserError, match="cannot be read as a table"):
        read_table(path)


@pytest.mark.parametrize(("value", "expected"), [(0.0, 1.0), (-1.0, 1.0), (5e-324, 1.0), (np.inf, 1.0), (np.nan, 1.0)])
def test_what_has_no_measure_is_rounded_to_one(value: float, expected: float) -> None:
    """Found by fuzzing: a channel of nothing, or beyond all numbers."""
    assert rounded_up(value) == expected
    assert rounded_up(0.0013) == pytest.approx(0.0015)


def test_of_a_name_of_thousands_of_words_some_are_looked_at() -> None:
    assert len(words_of("valve " + " ".join(f"w{i}" for i in range(20_000)))) == MOST_WORDS + 1
