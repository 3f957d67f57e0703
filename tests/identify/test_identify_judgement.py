"""What an identification says when records do not give what is asked: no effect, bounds, wrong signs, bad units."""

import json
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import STUDY, Answer, fails, workbench, write
from driven import driven_experiment
from experiments import AXIAL, CURVE, LINE, axial_record, experiment_text, identify, make_record

from workbench.identify.identification import identify as run_identification
from workbench.identify.readiness import method_of
from workbench.identify.thesis import method as thesis_method
from workbench.identify.thesis.method import Estimate
from workbench.parameters.sets import read_parameters
from workbench.records.experiment import read_experiment

pytestmark = pytest.mark.usefixtures("dots_alone")


def test_a_single_parameter_without_effect(tmp_path: Path) -> None:
    """A table that says so, without a warning and without a plant.toml."""
    make_record(tmp_path, duration=1.0)
    answer = identify(tmp_path, experiment_text({"coulomb": 0.9}, ["end_stop_stiffness"]), "simulation")
    assert (answer.code, answer.err) == (0, "")
    assert "not identified" in answer.out
    assert "end_stop_stiffness cannot be identified from these records" in answer.out
    assert "has no effect on the records" in answer.out
    assert not (tmp_path / "out" / "plant.toml").exists()
    assert (
        "simulation"
        not in json.loads((tmp_path / "out" / "identified.json").read_text())["parameters"]["end_stop_stiffness"]
    )


def test_a_wrong_gain_is_an_error_and_no_result(tmp_path: Path) -> None:
    make_record(tmp_path, duration=2.0)
    frame = pd.read_parquet(tmp_path / "record.parquet")
    frame["valve_voltage"] *= 5.0
    frame.to_parquet(tmp_path / "record.parquet")
    answer = identify(tmp_path, experiment_text({"coulomb": 0.9}, ["coulomb"]), "simulation")
    fails(answer, "plant non_rotating does not follow ", "record.parquet: position is off by", "is a sign or a unit in")
    assert f"or does the plant lack something? workbench diagnose {tmp_path}" in answer.err
    assert not (tmp_path / "out").exists()


def test_a_bound_that_is_hit_is_told(tmp_path: Path) -> None:
    """The truth is 330 N: at 300 N there is neither deviation nor interval, and the other direction is still found."""
    make_record(tmp_path)
    text = experiment_text({"coulomb": 0.7}, ["coulomb"]).replace(
        "[fit]", '[fit]\ncoulomb = { min = "0 N", max = "300 N" }'
    )
    answer = identify(tmp_path, text, "simulation")
    assert (answer.code, answer.err) == (0, "")
    assert "300.0, at its bound" in answer.out
    assert "coulomb is at its bound of 300 N, and has no deviation there" in answer.out
    found = json.loads((tmp_path / "out" / "identified.json").read_text())["parameters"]
    assert found["coulomb"]["simulation"] == {"value": pytest.approx(300.0), "at_bound": True}
    assert found["coulomb_negative"]["simulation"]["value"] == pytest.approx(290.0, rel=0.1)
    entry = (tmp_path / "out" / "plant.toml").read_text().partition("[parameters.coulomb]\n")[2].partition("\n\n")[0]
    assert entry.startswith('value = "300 N"\n')
    assert "std" not in entry.replace("standard", "")
    assert read_parameters(tmp_path / "out" / "plant.toml")["coulomb"] == pytest.approx(300.0)


def test_a_declared_value_outside_its_bounds(tmp_path: Path) -> None:
    text = experiment_text({"coulomb": 0.7}, ["coulomb"]).replace("[fit]", '[fit]\ncoulomb = { max = "100 N" }')
    fails(
        identify(tmp_path, text, "simulation"),
        "fit.coulomb: the declared value 231 N is outside these bounds; widen them",
    )


@pytest.mark.parametrize("method", ["thesis", "simulation"])
def test_swapped_pressures(tmp_path: Path, method: str) -> None:
    axial_record(tmp_path / "run_a.parquet", CURVE, 0.0)
    text = AXIAL.replace('"pressure_1"', '"x"').replace('"pressure_2"', '"pressure_1"').replace('"x"', '"pressure_2"')
    answer = identify(tmp_path, text, method)
    fails(
        answer, "run_a.parquet: friction does not oppose the motion (-", "are the columns of pressure_1 and pressure_2"
    )


def test_swapped_pressures_under_a_declared_load(tmp_path: Path) -> None:
    """A load drives the rod by itself at most."""
    axial_record(tmp_path / "run_a.parquet", CURVE, 0.0)
    swapped = (
        AXIAL.replace('"pressure_1"', '"x"').replace('"pressure_2"', '"pressure_1"').replace('"x"', '"pressure_2"')
    )
    for load, told in (("20 N", True), ("2 kN", False)):
        text = swapped.replace("[channels]", f'[plant.set]\nload_force = "{load}"\n[channels]', 1)
        answer = workbench("check", write(tmp_path, text, "experiment.toml"))
        assert ("friction does not oppose the motion (-" in answer.err) is told, (load, answer.err)


def test_pressures_in_the_wrong_unit(tmp_path: Path) -> None:
    """bar declared as kPa: both chambers at half a percent of the supply."""
    axial_record(tmp_path / "run_a.parquet", CURVE, 0.0)
    frame = pd.read_parquet(tmp_path / "run_a.parquet")
    frame[["pressure_1", "pressure_2"]] *= 1e-2
    frame.to_parquet(tmp_path / "run_a.parquet")
    fails(identify(tmp_path, AXIAL, "thesis"), "is the unit of channel pressure_1 right? (it seems 0.01 times off)")


@pytest.mark.parametrize("unit", ["kN", "N", "mN"])
def test_a_force_in_the_wrong_unit(unit: str, tmp_path: Path) -> None:
    path = driven_experiment(tmp_path, 0.0, 5e-6, 6.0, sensor=1.0)
    path.write_text(path.read_text(encoding="utf-8").replace('unit = "N"', f'unit = "{unit}"'), encoding="utf-8")
    answer = workbench("check", path)
    told = "is the unit of channel force right, or are coulomb and viscous?" in answer.out + answer.err
    assert told == (unit != "N"), answer


def test_an_offset_that_nobody_believes_is_told(tmp_path: Path) -> None:
    """200 kPa where the sensor is good to 20 kPa."""
    make_record(tmp_path, duration=2.0)
    frame = pd.read_parquet(tmp_path / "record.parquet")
    frame[["pressure_1", "pressure_2"]] += 2e5
    frame.to_parquet(tmp_path / "record.parquet")
    text = experiment_text({"coulomb": 0.9}, ["coulomb"])
    sensors = '[sensors]\npressure_1_offset = "20 kPa"\npressure_2_offset = "20 kPa"\n'
    answer = identify(tmp_path, text.replace("[[records]]", f"{sensors}[[records]]"), "simulation")
    assert answer.code == 0
    assert "pressure_1_offset is 10 times the standard deviation that [sensors] gives it (2e+04 Pa)" in answer.out
    assert "take for right what was declared without a deviation" in answer.out


# --- the thesis's method ---


@pytest.mark.parametrize(
    ("value", "std", "count", "said"),
    [
        (0.0, 0.0, 10, "none is seen, the fit is at its bound of 0"),
        (68.0, 94.0, 8, "the standard deviation over the records is 138 % of its value"),
        (68.0, 30.0, 8, ""),
        (68.0, float("nan"), 1, ""),
    ],
)
def test_what_the_thesis_method_does_not_identify(value: float, std: float, count: int, said: str) -> None:
    assert thesis_method.doubt(Estimate(value, std, count)) == said


def test_what_the_thesis_method_does_not_see_stays_as_declared(tmp_path: Path) -> None:
    """A line has no Stribeck friction: plant.toml keeps the declared one, the tables say "not identified"."""
    axial_record(tmp_path / "run_a.parquet", LINE, 0.0)
    text = AXIAL.partition("[[published]]")[0]
    answer = identify(tmp_path, text, "thesis")
    assert (answer.code, answer.err) == (0, "")
    (line,) = [line for line in answer.out.splitlines() if line.startswith("| stribeck ")]
    assert line.split("|")[4].strip() == "not identified"
    assert "stribeck is not identified by the thesis's method and stays as declared: none is seen" in answer.out
    assert read_parameters(tmp_path / "out" / "plant.toml")["stribeck"] == 150.0
    assert read_parameters(tmp_path / "out" / "plant.toml")["viscous"] == pytest.approx(30000.0, rel=0.01)


def test_a_damping_far_from_the_thesis_rule_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """2 * 0.9 sqrt(sigma0 M) is 1.124e4 N s/m for table 5.2."""
    found = {"bristle_stiffness": 2.6e6, "bristle_damping": 4.6e5}
    monkeypatch.setattr(thesis_method, "dynamic_parameters", lambda *_: found)
    assert thesis_method.damping_rule(2.6e6, 15.0) == pytest.approx(1.124e4, rel=1e-3)
    axial_record(tmp_path / "run_a.parquet", CURVE, 0.0)
    answer = identify(tmp_path, AXIAL.partition("[[published]]")[0], "thesis")
    assert "0 rpm, forward: bristle_damping is over 10 times what (4.14) gives" in answer.out


# --- what `check` says ---


def checked(folder: Path, text: str) -> Answer:
    return workbench("check", write(folder, text, "experiment.toml"))


@pytest.mark.parametrize(
    ("said", "pressures", "expected"),
    [("", True, "both"), ("", False, "simulation"), ("thesis", False, "thesis"), ("simulation", True, "simulation")],
)
def test_without_a_method_it_is_what_the_channels_show(
    tmp_path: Path, said: str, pressures: bool, expected: str
) -> None:
    text = AXIAL.replace('method = "thesis"', f'method = "{said}"' if said else "")
    path = tmp_path / "experiment.toml"
    path.write_text(text if pressures else text.replace('pressure_2 = { column = "pressure_2", unit = "Pa" }', ""))
    assert method_of(read_experiment(path)) == expected


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ("[fit]", "[fit]\nfree = []", "fit.free: is empty: expected at least one parameter"),
        ('rpm = "rpm"', 'use = "held_out"', 'no record is there for the fit; give one use = "fit"'),
        ('rpm = "rpm"', "rpm = 25.0", "plant non_rotating does not rotate, and there are records at 25 rpm"),
        ('rpm = "rpm"', "", "figures: at_25: no record at 25 rpm, expected one of 0"),
        ('"run_*', '"rum_*', "records: no file is called rum_*.parquet in "),
        ('pressure_2 = { column = "pressure_2", unit = "Pa" }', "", "add pressure_2 to [channels], or take method"),
        (
            'valve_voltage = { column = "valve_voltage", unit = "V" }',
            "",
            "a simulation needs the measured valve_voltage",
        ),
    ],
)
def test_check_finds_what_identify_would(tmp_path: Path, old: str, new: str, said: str) -> None:
    axial_record(tmp_path / "run_a.parquet", CURVE, 0.0)
    assert AXIAL.count(old) == 1
    text = AXIAL.replace('method = "thesis"', 'method = "both"').replace(old, new)
    answer = checked(tmp_path, text)
    assert said in answer.out + answer.err
    assert answer.code == 2 or "; for diagnose alone\n" in answer.out or "\n  identify --method " in answer.out
    assert identify(tmp_path, text, "both").code == 2
    assert not (tmp_path / "out").exists()


def test_check_says_which_command_an_experiment_serves(tmp_path: Path) -> None:
    """What stops the thesis's method stops neither a simulation nor a diagnosis; what stops all is an error."""
    axial_record(tmp_path / "run_a.parquet", CURVE, 0.0)
    text = AXIAL.partition("[[published]]")[0].replace('method = "thesis"', 'method = "both"')
    answer = checked(tmp_path, text)
    assert answer.out.startswith(f"{tmp_path / 'experiment.toml'}: an experiment, in order\n")
    assert "\n  identify: can use it\n  diagnose: can use it\n" in answer.out
    answer = checked(tmp_path, text.replace('pressure_2 = { column = "pressure_2", unit = "Pa" }', ""))
    assert (answer.code, answer.err) == (0, "")
    assert "; for identify alone\n" in answer.out
    assert "\n  identify --method thesis: not, since the thesis's method needs position, pressure_1 and" in answer.out
    assert "\n  identify --method simulation: can use it\n  diagnose: not, since its channels allow no" in answer.out
    assert "run_a.parquet: fit, 29.999 s at 1000 Hz" in answer.out
    answer = checked(tmp_path, text.replace('rpm = "rpm"', "skip = 20000\nrows = 500"))
    assert answer.code == 0
    assert "500 samples are too few for the thesis's averaging" in answer.out
    assert "diagnose: not, since " in answer.out
    fails(checked(tmp_path, text.replace('rpm = "rpm"', 'use = "held_out"')), ": no record is there for the fit; give")
    neither = "\n".join(line for line in text.splitlines() if "pressure_2" not in line and "voltage" not in line)
    fails(checked(tmp_path, neither), "no command can use it: identify --method thesis: the thesis's method needs")


def test_check_names_the_file_that_was_meant(tmp_path: Path) -> None:
    axial_record(tmp_path / "de_drive_B.parquet", CURVE, 0.0)
    text = AXIAL.partition("[[published]]")[0].replace("run_*.parquet", "de_drive_C.parquet")
    answer = checked(tmp_path, text)
    assert (answer.code, answer.err) == (0, "")
    assert 'de_drive_C.parquet: is not there (yet?); did you mean "de_drive_B.parquet"?\n' in answer.out
    assert "\n  diagnose: can use it as soon as all records are there\n" in answer.out


def test_check_says_whom_a_record_is_missing(tmp_path: Path) -> None:
    """To identify, what is held out is not needed."""
    axial_record(tmp_path / "de_drive_B.parquet", CURVE, 0.0)
    text = AXIAL.partition("[[published]]")[0].replace("run_*.parquet", "de_drive_B.parquet")
    answer = checked(tmp_path, text + '[[records]]\nfile = "de_drive_C.parquet"\nuse = "held_out"\n')
    assert (answer.code, answer.err) == (0, "")
    assert "\n  identify: can use it\n  diagnose: can use it as soon" in answer.out


def test_check_says_which_records_are_not_there_yet(tmp_path: Path) -> None:
    text = AXIAL.replace("run_*.parquet", "records/run_*.parquet")
    answer = checked(tmp_path, text)
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.startswith(f"{tmp_path / 'experiment.toml'}: an experiment; its records are not there yet\n")
    assert "in order" not in answer.out


@pytest.mark.parametrize(
    ("column", "ratio", "duration", "said"),
    [
        ("position", 1e-3, 30.0, "expected more than 0.6 mm/s; it travels 0.114 mm of a stroke of 172 mm: is the unit"),
        ("time", 1e3, 3.0, "; samples are 1 s apart: is the unit of channel time right (ms)?"),
        ("position", 1.0, 0.1, "0.1 s are too short to see a velocity; take a longer record"),
    ],
)
@pytest.mark.parametrize("method", ["thesis", "simulation"])
def test_nothing_slides(tmp_path: Path, column: str, ratio: float, duration: float, said: str, method: str) -> None:
    """mm declared as um, ms as s, and a record that is too short."""
    axial_record(tmp_path / "run_a.parquet", CURVE, 0.0)
    frame = pd.read_parquet(tmp_path / "run_a.parquet")
    frame = frame[frame["time"] <= duration].assign(**{column: frame[column] * ratio})
    frame.to_parquet(tmp_path / "run_a.parquet")
    text = AXIAL.partition("[[published]]")[0]
    fails(identify(tmp_path, text, method), f"nothing slides in {tmp_path / 'run_a.parquet'}: ", said)


@pytest.mark.parametrize("method", ["thesis", "simulation"])
def test_a_time_in_another_unit_than_its_column(tmp_path: Path, method: str) -> None:
    """Seconds declared as milliseconds: 15 s are 15 ms."""
    axial_record(tmp_path / "run_a.parquet", CURVE, 0.0)
    frame = pd.read_parquet(tmp_path / "run_a.parquet")
    frame[frame["time"] <= 15.0].assign(time=1e-3 * frame["time"]).to_parquet(tmp_path / "run_a.parquet")
    text = AXIAL.partition("[[published]]")[0]
    said = "0.015 s are too short to see a velocity; take a longer record, or is the unit of channel time right?"
    fails(identify(tmp_path, text, method), f"{tmp_path / 'run_a.parquet'}: {said}")
    assert said in checked(tmp_path, text).err


def test_an_empty_record(tmp_path: Path) -> None:
    (tmp_path / "run_a.csv").write_text("")
    text = AXIAL.replace("run_*.parquet", "run_a.csv").partition("[[published]]")[0]
    fails(identify(tmp_path, text, "thesis"), f"{tmp_path / 'run_a.csv'}: the file is empty")


def test_the_wrong_kind_of_file(tmp_path: Path) -> None:
    study, experiment = write(tmp_path, STUDY, "study.toml"), write(tmp_path, AXIAL, "experiment.toml")
    open_loop = write(tmp_path, 'title = "no controller"\n[cases.one]\n', "open_loop.toml")
    for command in ("identify", "diagnose"):
        fails(workbench(command, open_loop, "--out", "x"), f"{open_loop}: this is a study")
        told = f"{study}: this is a study, not an experiment; workbench run {study}, or wb.Study, runs it"
        fails(workbench(command, study, "--out", "x"), told)
    fails(workbench("run", experiment, "--out", "x"), f"this is an experiment; use workbench identify {experiment}")


def test_short_help() -> None:
    assert workbench("identify", "-h").out == workbench("identify", "--help").out
    assert "Usage" in workbench("-h").out


def test_what_is_being_done_is_told_in_words(tmp_path: Path) -> None:
    make_record(tmp_path, duration=1.0)
    path = write(tmp_path, experiment_text({"coulomb": 0.9}, ["coulomb"]), "experiment.toml")
    told: list[str] = []
    run_identification(read_experiment(path), "simulation", told.append)
    assert told[0] == "reading the records"
    assert told[-1].startswith("fit of ")
    assert told[-1].endswith(" simulations")


# --- files ---


def test_an_interrupted_identification_leaves_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    axial_record(tmp_path / "run_a.parquet", CURVE, 0.0)
    text = AXIAL.partition("[[published]]")[0]
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "mine.txt").write_text("mine")

    def stopped(*_: object) -> str:
        raise OSError(28, "No space left on device")

    with monkeypatch.context() as patched:
        patched.setattr("workbench.identify.result.Identification.to_json", stopped)
        path = write(tmp_path, text, "experiment.toml")
        assert workbench("identify", path, "--out", tmp_path / "out").code == 2
    assert sorted(item.name for item in tmp_path.rglob("*") if item.is_file()) == [
        "experiment.toml",
        "mine.txt",
        "run_a.parquet",
    ]
    assert identify(tmp_path, text, "thesis").code == 0, "a foreign file does no harm"
    names = {item.name for item in (tmp_path / "out").iterdir()}
    names_of_ours = {"identified.json", "identified.html", "plant.toml", "contents.json", "tables", "figures"}
    assert names == {"mine.txt"} | names_of_ours
    assert not np.any([item.name.startswith(".") for item in tmp_path.iterdir()])


def test_a_file_in_the_place_of_the_folder(tmp_path: Path) -> None:
    axial_record(tmp_path / "run_a.parquet", CURVE, 0.0)
    write(tmp_path, "mine", "out")
    fails(identify(tmp_path, AXIAL, "simulation"), "out: is a file; give --out a folder")
