"""An FMU of another maker in a study: it runs like any plant, when it is allowed to."""

import functools
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import changed as changed_in
from command import fails, workbench, write
from foreign_fmu import DESCRIPTION, STUDY, motor_fmu

from workbench.simulation.run import Run
from workbench.simulation.simulate import simulate
from workbench.study.plan import plan
from workbench.study.reading import read_study

changed = functools.partial(changed_in, study=STUDY)
"""The study with one place of it changed."""

PID = STUDY[STUDY.index('type = "pid"') : STUDY.index("[references")]
SINE = STUDY[STUDY.index('kind = "sine"') : STUDY.index("[simulation]")]


def results(folder: Path, text: str, *options: str) -> pd.DataFrame:
    """The rows of a study that is run with its FMU allowed."""
    out = folder / "results"
    answer = workbench("run", write(folder, text), "--out", out, "--allow-fmu", *options)
    assert (answer.code, answer.err) == (0, "")
    return pd.read_csv(out / "results.csv")


def run_of(folder: Path, text: str, case: int = 0) -> Run:
    """The run of a case of a study whose FMU is allowed."""
    study = replace(read_study(write(folder, text)), allow_fmu=True)
    return simulate(plan(study).declared[case].setup)


def test_an_fmu_runs_with_leave_alone(tmp_path: Path) -> None:
    motor_fmu(tmp_path)
    study, out = write(tmp_path, STUDY), tmp_path / "results"
    assert workbench("check", study).code == 0
    fails(workbench("run", study, "--out", out), "motor.fmu", "foreign code", "add --allow-fmu")
    assert not out.exists()
    fails(workbench("run", study, "--out", out, "--dry-run"), "--allow-fmu")
    rows = results(tmp_path, STUDY)
    assert [*rows["outcome"]] == ["completed"] * 3
    assert rows["rms_error_rad"].is_monotonic_increasing, "the more it sticks, the further it is off"


def test_the_motor_turns_as_its_equations_say_in_the_units_of_the_model(tmp_path: Path) -> None:
    """K (u - K w)/R = b w at rest of the speed, without Coulomb friction: w = 5 V * 0.25 / 0.175."""
    motor_fmu(tmp_path)
    text = changed_in(SINE, 'kind = "steps"\nlevels = ["5 V"]\ndwell = "2 s"\n', changed(PID, 'type = "open_loop"\n'))
    run = run_of(tmp_path, text)
    assert run.inputs[0, 0] == 5.0
    assert run.state("velocity")[-1] == pytest.approx(5.0 * 0.25 / 0.175, rel=1e-5)
    assert np.gradient(run.state("position"), run.time)[-2] == pytest.approx(run.state("velocity")[-2], rel=1e-4)


def test_an_fmu_starts_where_its_start_values_say(tmp_path: Path) -> None:
    motor_fmu(tmp_path)
    text = changed("[axes]", '[plant.start_values]\nstart_angle = "90 deg"\n[axes]')
    assert run_of(tmp_path, text).state("position")[0] == pytest.approx(np.pi / 2.0)
    assert run_of(tmp_path, text).measurements[0, 0] == pytest.approx(np.pi / 2.0)


def test_results_are_the_same_whatever_the_jobs_and_resumed(tmp_path: Path) -> None:
    motor_fmu(tmp_path)
    results(tmp_path, STUDY, "--jobs", "2")
    first = (tmp_path / "results" / "results.csv").read_bytes()
    results(tmp_path, STUDY, "--resume")
    assert (tmp_path / "results" / "results.csv").read_bytes() == first
    results(tmp_path, STUDY, "--overwrite", "--jobs", "1")
    assert (tmp_path / "results" / "results.csv").read_bytes() == first


def test_another_fmu_of_the_same_name_is_not_gone_on_with(tmp_path: Path) -> None:
    motor_fmu(tmp_path)
    results(tmp_path, STUDY)
    motor_fmu(tmp_path, more={"resources/note.txt": b"another edition"})
    answer = workbench("run", tmp_path / "study.toml", "--out", tmp_path / "results", "--resume", "--allow-fmu")
    assert answer.code == 2
    assert "parameters" in answer.err


def test_an_fmu_that_fails_is_a_row_that_says_why(tmp_path: Path) -> None:
    motor_fmu(tmp_path)
    axis = '"plant.start_values.coulomb" = ["0 N m", "0.4 N m", "0.8 N m"]'
    rows = results(tmp_path, changed(axis, '"plant.start_values.fails_at" = ["0.5 s", "10 s"]'))
    assert [*rows["outcome"]] == ["FMU failed: fmi2DoStep: the winding has burnt through", "completed"]
    assert np.isnan(rows["rms_error_rad"][0])
    rows = results(tmp_path, changed(axis, '"plant.start_values.coulomb" = [-1.0, 0.4]'), "--overwrite")
    assert [*rows["outcome"]] == ["FMU failed: fmi2ExitInitializationMode: coulomb is negative", "completed"]
    text = changed(axis, '"plant.start_values.fails_at" = ["0.5 s"]')
    assert run_of(tmp_path, text).time[-1] == pytest.approx(0.5)


def test_a_unit_that_contradicts_the_fmu_s_is_refused(tmp_path: Path) -> None:
    motor_fmu(tmp_path)
    text = changed('velocity = "w"', 'velocity = { variable = "w", unit = "rpm" }')
    fails(workbench("check", write(tmp_path, text)), '"w" is in deg/s, and not in rpm; leave the unit out')
    text = changed('velocity = "w"', 'velocity = { variable = "w", unit = "deg/s" }')
    assert workbench("check", write(tmp_path, text)).code == 0


def test_what_needs_equations_says_so(tmp_path: Path) -> None:
    motor_fmu(tmp_path)
    axis = '"plant.start_values.coulomb" = ["0 N m", "0.4 N m", "0.8 N m"]'
    tuned = write(tmp_path, changed("[axes]\n" + axis, "[tune.objective]\nrms_error = 1"))
    fails(workbench("tune", tuned, "--out", tmp_path / "out"), "tune needs a plant's equations", "use workbench run")
    fails(workbench("check", tuned), "tune needs a plant's equations")
    one = write(tmp_path, changed("[axes]\n" + axis, ""))
    fails(workbench("export", "plant", one, "--out", tmp_path / "out.fmu"), "an FMU has no equations")
    for what, out in (("linear", "out.mat"), ("controller", "out.fmu")):
        fails(workbench("export", what, one, "--out", tmp_path / out), f"export {what} needs a plant's equations")
    fails(workbench("rehearse", one, "--out", tmp_path / "out.fmu"), "rehearse needs a plant's equations")
    assert not (tmp_path / "out.fmu").exists()


@pytest.mark.skipif(sys.platform != "linux", reason="cases are run in processes there")
def test_an_fmu_that_crashes_ends_the_run_with_a_line(tmp_path: Path) -> None:
    motor_fmu(tmp_path)
    axis = '"plant.start_values.coulomb" = ["0 N m", "0.4 N m", "0.8 N m"]'
    study = write(tmp_path, changed(axis, '"plant.start_values.coulomb" = [0.4, 1000.0]'))
    answer = workbench("run", study, "--out", tmp_path / "results", "--allow-fmu", "--jobs", "2")
    assert answer.code == 2
    assert answer.err.count("\n") == 1
    assert "plant.start_values.coulomb 1000.0: its process was killed whenever it ran: its FMU crashes" in answer.err


MISTAKES = {
    'fmu = "motor.fmu"': {
        'fmu = "none.fmu"': "none.fmu: cannot be read",
        'fmu = "motor.toml"': "no archive that can be read",
        "": "inputs belongs to fmu",
    },
    'inputs = { drive_voltage = "u" }': {
        "": 'plant.inputs: lacks drive_voltage; expected drive_voltage = "...", one of u',
        'inputs = { drive_voltage = "v" }': 'motor.fmu has no variable "v"; expected one of u',
        'inputs = { drive_voltage = "phi" }': '"phi" is output in motor.fmu, expected input',
        'inputs = { drive_current = "u", drive_voltage = "u" }': "rotary_voltage has no such input",
    },
    'outputs = { position = "phi", velocity = "w" }': {
        'outputs = { position = "phi" }': "plant.outputs: lacks velocity",
        'outputs = { position = "w", velocity = "w" }': '"w" is in deg/s, expected rad',
        'outputs = { position = "i", velocity = "w" }': '"i" says no unit, expected rad: write { variable = "i"',
        'outputs = { position = "count", velocity = "w" }': '"count" is of type Integer, expected Real',
        'outputs = { position = { variable = "phi", unit = "m" }, velocity = "w" }': '"phi" is in deg, which is no m',
    },
    '"plant.start_values.coulomb" = ["0 N m", "0.4 N m", "0.8 N m"]': {
        '"plant.start_values.coulom" = [1.0]': 'did you mean "coulomb"?',
        '"plant.start_values.coulomb" = ["1 N"]': '"coulomb" is in N.m',
        '"plant.start_values.w" = [1.0]': "has no parameter or start value of that name",
        '"plant.set.inertia" = [1.0]': "an FMU has parameters of its own",
        '"plant.scale.inertia" = [1.0]': "an FMU has parameters of its own",
        '"plant.start_position" = ["1 deg"]': "is the FMU's own affair",
        '"simulation.method" = ["rk4"]': "is the FMU's own affair",
    },
    'type = "pid"': {'type = "pid"\nderivative_on = "nothing"': "unknown key"},
}


@pytest.mark.parametrize(("old", "new", "said"), [(o, n, s) for o, items in MISTAKES.items() for n, s in items.items()])
def test_a_wrong_mapping_is_refused_in_a_line(old: str, new: str, said: str, tmp_path: Path) -> None:
    motor_fmu(tmp_path)
    study, out = write(tmp_path, changed(old, new)), tmp_path / "results"
    for answer in (workbench("check", study), workbench("run", study, "--out", out, "--allow-fmu")):
        assert (answer.code, answer.out) == (2, ""), answer
        assert said in answer.err
        assert answer.err.count("\n") == 1
    assert not out.exists()


def test_an_fmu_for_another_platform_is_refused(tmp_path: Path) -> None:
    path = motor_fmu(tmp_path)
    path.write_bytes(path.read_bytes().replace(b"binaries/linux64/motor.so", b"binaries/win6464/motor.dl"))
    out = tmp_path / "results"
    answer = workbench("run", write(tmp_path, STUDY), "--out", out, "--allow-fmu")
    assert answer.code == 2
    assert "has no binary for" in answer.err
    assert "it has win64" in answer.err
    assert not out.exists()


def test_a_reading_that_a_controller_needs_has_to_be_mapped(tmp_path: Path) -> None:
    motor_fmu(tmp_path)
    text = STUDY.replace("rotary_voltage", "non_rotating").replace('"motor.toml"', '"owen2001_simulation"')
    text = text.replace("drive_voltage", "valve_voltage").replace("rad", "m").replace("10 deg", "10 mm")
    text = text.replace('"phi"', '{ variable = "i", unit = "m" }').replace('"w"', '{ variable = "i", unit = "m/s" }')
    fails(
        workbench(
            "check",
            write(tmp_path, changed_in(PID.replace("rad", "m"), 'type = "load_pressure"\nkp = "500 V/m"\n', text)),
        ),
        'controller type "load_pressure" needs pressure_1; expected it in [plant.outputs]',
    )
    assert workbench("check", write(tmp_path, text)).code == 0


def test_a_description_says_units_by_type_and_by_name(tmp_path: Path) -> None:
    motor_fmu(
        tmp_path, DESCRIPTION.replace('<Unit name="deg"><BaseUnit rad="1" factor="0.017453292519943295"/></Unit>', "")
    )
    assert workbench("check", write(tmp_path, STUDY)).code == 0
    no_radian = DESCRIPTION.replace('<BaseUnit rad="1" s="-1" factor', '<BaseUnit s="-1" factor')
    motor_fmu(tmp_path, no_radian)
    fails(workbench("check", write(tmp_path, STUDY)), '"w" is in deg/s, expected rad/s; if that is meant, write {')
    told = changed('velocity = "w"', 'velocity = { variable = "w", unit = "deg/s" }')
    assert workbench("check", write(tmp_path, told)).code == 0
    for wrong in ("rad/s", "rpm"):
        text = changed('velocity = "w"', f'velocity = {{ variable = "w", unit = "{wrong}" }}')
        fails(workbench("check", write(tmp_path, text)), f'"w" is in deg/s, and not in {wrong}; leave the unit out')
