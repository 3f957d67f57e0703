"""The Python interface: the same numbers and the same mistakes as the command line, in objects."""

import os
import subprocess
import sys
import warnings
from collections.abc import Callable
from importlib.util import find_spec
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import ROOT, STUDY, changed, workbench, write
from plugin_site import site
from short_loop import small

import workbench as wb
from controllers.registry import controllers
from workbench import api
from workbench.study.store import read_results

pytestmark = pytest.mark.usefixtures("png_alone")

HEAVY = ("numpy", "pandas", "numba", "pydantic", "scipy", "matplotlib", "control", "casadi", "optuna")

LOADED = """\
[plant]
model = "rotating"
parameters = "owen2001_simulation"
bristle = "isotropic"
motor_limits = false
set = { coulomb = "400 N" }
[belief]
set = { coulomb = "350 N" }
[sensors.position]
noise = "5 um"
resolution = "2 um"
"""


def same(row: pd.Series, other: pd.Series) -> None:
    """Two rows of results agree to the last digit."""
    for name, value in row.items():
        beside = other[name]
        assert value == beside or (pd.isna(value) and pd.isna(beside)), name


# --- the front door ---


def test_importing_it_costs_nothing() -> None:
    code = f"import sys, workbench; print([name for name in {HEAVY!r} if name in sys.modules], len(sys.modules))"
    before = "import sys; print([], len(sys.modules))"
    runs = [subprocess.run([sys.executable, "-c", text], capture_output=True, text=True) for text in (before, code)]
    least, most = (int(run.stdout.split()[-1]) for run in runs)
    assert runs[1].stdout.startswith("[]")
    assert most - least < 10  # itself, and what of the standard library it takes


def test_the_public_names_are_those_of_the_api_and_a_function_for_each_controller() -> None:
    assert set(api.__all__) == {*wb.__all__, *controllers()}
    assert set(wb.__all__) <= set(dir(wb))
    for name in api.__all__:
        assert callable(getattr(wb, name))
    with pytest.raises(AttributeError, match="no attribute 'simulat'; did you mean \"simulate\""):
        wb.simulat  # noqa: B018


def test_a_room_is_called_as_its_question_and_stays_a_room() -> None:
    import workbench.tune.run as room

    assert wb.tune is sys.modules["workbench.tune"]
    assert callable(wb.tune)
    assert wb.tune.__doc__ == api.tune.__doc__
    assert find_spec("workbench.tune.run").name == room.__name__


def test_controllers_of_other_packages_have_a_function(tmp_path: Path) -> None:
    folder = site(tmp_path)
    code = "import workbench as wb; print(wb.deadband_p(kp=5).table == wb.controller('deadband_p', kp=5).table)"
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join([str(folder), str(ROOT)])}
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, env=environment)
    assert run.stdout == "True\n", run.stderr


@pytest.mark.parametrize(
    ("call", "message"),
    [
        (lambda loop: small(controller="pid"), 'setup: controller: got "pid", expected a controller such as wb.pid('),
        (lambda loop: small(controller=wb.pid), "setup: controller: got a function, expected a controller such as"),
        (lambda loop: small(reference="sine"), 'setup: reference: got "sine", expected a reference such as wb.sine('),
        (lambda loop: small(plant="rotating"), 'setup: plant: got "rotating", expected a dictionary of further keys'),
        (lambda loop: wb.simulate(wb.Study), "simulate: got the class Study, expected a loop; make one with wb.setup("),
        (lambda loop: wb.simulate(None), "simulate: got None, expected a loop; make one with wb.setup(...), or"),
        (lambda loop: wb.evaluate(loop), "evaluate: got a LoopSetup, expected a run; use wb.evaluate(wb.simulate("),
        (lambda loop: wb.linearise(3), "linearise: got 3, expected a loop; make one with wb.setup("),
        (lambda loop: wb.loop_gain(wb.pid(kp=500), speed=0.1), "loop_gain: got a ControllerChoice, expected a loop;"),
        (lambda loop: wb.margins(wb.simulate(loop), speed=0.1), "margins: got a LoopRun, expected a loop; make one"),
        (lambda loop: wb.Study(loop), "study: got a LoopSetup, expected the path of a study file, or its content"),
        (lambda loop: wb.tune(loop), "study: got a LoopSetup, expected the path of a study file, or its content"),
        (lambda loop: wb.identify({}), "identify: got a dict, expected the path of an experiment file"),
        (lambda loop: wb.diagnose(loop), "diagnose: got a LoopSetup, expected the path of an experiment file"),
        (lambda loop: wb.StudyResults.read(loop), "StudyResults.read: got a LoopSetup, expected the path of a folder"),
    ],
)
def test_a_thing_of_another_kind_is_a_mistake_in_one_line(call: Callable[[wb.LoopSetup], object], message: str) -> None:
    with pytest.raises(wb.UserError) as caught:
        call(small())
    assert str(caught.value).startswith(message)
    assert "\n" not in str(caught.value)


# --- one loop ---


def test_a_setup_gives_the_row_of_the_same_study(tmp_path: Path) -> None:
    text = STUDY
    for old, new in {
        '[plant]\nmodel = "by_rpm"\nparameters = "owen2001_simulation"\n': LOADED,
        "rpm = [0, 460]": 'rpm = [120]\nscenario = ["friction_up"]',
        'type = "pid"\nkp = "500 V/m"': 'type = "tafazoli"\nposition_rate = "30 1/s"',
    }.items():
        text = changed(old, new, text)
    assert workbench("run", write(tmp_path, text), "--out", tmp_path / "out").code == 0
    loop = wb.setup(
        "rotating",
        "owen2001_simulation",
        rpm=120,
        scenario="friction_up",
        controller=wb.tafazoli(position_rate=30.0),
        reference=wb.sine(0.005, "2 Hz"),
        duration=1.0,
        transient="400 ms",
        plant={"bristle": "isotropic", "motor_limits": False, "set": {"coulomb": np.float64(400.0)}},
        belief={"set": {"coulomb": 350}},
        sensors={"position": {"noise": "5 um", "resolution": 2e-6}},
    )
    row = wb.evaluate(wb.simulate(loop))
    same(row, read_results(tmp_path / "out").iloc[0])
    assert row["solver_error_m"] > 0.0
    assert wb.evaluate(wb.simulate(loop), solver_error=False)["solver_error_m"] is None


def test_a_study_of_a_file_has_the_same_loops(tmp_path: Path) -> None:
    study = wb.Study(write(tmp_path, STUDY))
    results = study.run(tmp_path / "out", jobs=2)
    same(wb.evaluate(wb.simulate(study.setup(rpm=460))), results.case(rpm="460").row)


@pytest.mark.parametrize(
    ("changes", "words"),
    [
        ({"controller": wb.pid(kpp=1)}, 'setup: controllers.pid.kpp: unknown key; did you mean "kp"?'),
        ({"controller": wb.pid(kp="5 mm")}, 'controllers.pid.kp: got "5 mm", expected a quantity in V/m'),
        ({"controller": wb.pid(kp=500, jerk_density=1)}, "controllers.pid.jerk_density: has no effect"),
        ({"reference": wb.sine("3 s", 1)}, 'references.sine.amplitude: got "3 s", expected a quantity in m'),
        ({"reference": wb.recorded("motion.csv", time="t", value="x")}, "motion.csv: no such file"),
        ({"duration": "5"}, 'simulation.duration: got "5" without a unit'),
        ({"rpm": 60}, "rpm: plant"),
        ({"belief": "owen"}, 'belief.parameters: unknown parameter set "owen"'),
        ({"scenario": "friction_upp"}, 'axes.scenario: unknown scenario "friction_upp"; did you mean "friction_up"?'),
        ({"sensors": {"position": {"nois": 1}}}, 'sensors.position.nois: unknown key; did you mean "noise"?'),
        ({"plant": {"flow": "chapter4"}}, 'plant.flow: got "chapter4", expected'),
        ({"plant": {"set": {"coulomb": np}}}, "setup.plant.set.coulomb: got a module, expected a number"),
    ],
    ids=lambda value: next(iter(value)) if isinstance(value, dict) else "",
)
def test_mistakes_are_those_of_a_study(changes: dict[str, object], words: str) -> None:
    with pytest.raises(wb.UserError) as told:
        small(**changes)
    assert words in str(told.value)
    assert "pydantic" not in str(told.value)


def test_what_is_seldom_meant_is_a_warning() -> None:
    with pytest.warns(UserWarning, match=r"setup: references.sine: reaches 0.04 m, the stroke ends at \+-0.03"):
        small(reference=wb.sine("40 mm", "2 Hz"))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        small()


def test_what_a_run_holds_cannot_be_changed() -> None:
    run = wb.simulate(small())
    for array in (run.time, run.run.states, run.run.inputs, run.run.measurements, run.run.memory):
        with pytest.raises(ValueError, match="read-only"):
            array[:] = 0.0


def test_a_run_as_a_frame_has_its_units() -> None:
    run = wb.simulate(small(controller=wb.pid(kp=500, ki=100)))
    frame = run.frame()
    assert list(frame.columns) == ["time", *run.run.signals]
    assert frame.attrs["units"]["controller_integral"] == "V"
    assert frame.attrs["units"]["axial_friction"] == "N"
    assert set(frame.attrs["units"]) == set(frame.columns)
    np.testing.assert_array_equal(frame["position"], run.run.state("position"))


def test_a_plot_has_a_panel_for_each_unit() -> None:
    run = wb.simulate(small())
    beside = run.plot("position", "valve_voltage", "reference_position").axes
    assert [axes.get_ylabel() for axes in beside] == ["position, reference position (m)", "valve voltage (V)"]
    assert [text.get_text() for text in beside[0].get_legend().get_texts()] == ["position", "reference position"]
    figure = run.plot("position", "valve_voltage")
    assert [axes.get_ylabel() for axes in figure.axes] == ["position (m)", "valve voltage (V)"]
    assert figure.axes[-1].get_xlabel() == "time (s)"
    assert figure._repr_png_().startswith(b"\x89PNG")
    with pytest.raises(wb.UserError, match='no signal "axial_frction"; did you mean "axial_friction"'):
        run.plot("axial_frction")
