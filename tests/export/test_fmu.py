"""A plant as an FMU: what the file holds, and that it runs as the study does, here and in an independent importer."""

import ctypes
import shutil
import zipfile
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree as ET

import numpy as np
import pandas as pd
import pytest
from command import STUDY, changed, fails, workbench, write
from short_loop import small

from plants.effects.registry import EFFECTS
from plants.equation import fields, from_array, leaves, to_array
from plants.registry import plants
from workbench.export.compiler import compiled_library
from workbench.export.fmi.equations import DECLARED, Equations, equations_of
from workbench.export.fmi.fmu import VERSIONS, exported
from workbench.export.fmi.units import unit_definitions
from workbench.fmu.description import read_fmu
from workbench.fmu.machine import ABSENT, FmuMachine, Mapped
from workbench.simulation.references import Sine
from workbench.simulation.sensors import Channel, Sensors
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")

OUTPUTS = 'position = "position", velocity = "velocity", pressure_1 = "measured_pressure_1", pressure_2 = "pressure_2"'


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> dict[int, Path]:
    """The standing rod of the study that tests change, as an FMU of either version."""
    folder = tmp_path_factory.mktemp("fmu")
    study, paths = write(folder, STUDY), {}
    for fmi in VERSIONS:
        paths[fmi] = folder / f"plant_{fmi}.fmu"
        answer = workbench("export", "plant", study, "--out", paths[fmi], "--fmi", str(fmi), "--case", "rpm=0")
        assert (answer.code, answer.err) == (0, "")
        assert f"FMI {fmi}.0, co-simulation and model exchange" in answer.out
    return paths


def content(path: Path) -> dict[str, bytes]:
    """The files of an archive."""
    with zipfile.ZipFile(path) as archive:
        return {name: archive.read(name) for name in archive.namelist()}


def test_the_same_study_gives_the_same_bytes(made: dict[int, Path], tmp_path: Path) -> None:
    study = write(tmp_path, STUDY)
    for fmi, path in made.items():
        again = tmp_path / "again.fmu"
        arguments = ("--out", again, "--fmi", str(fmi), "--case", "rpm=0", "--overwrite")
        assert workbench("export", "plant", study, *arguments).code == 0
        assert again.read_bytes() == path.read_bytes()
    other = changed('parameters = "owen2001_simulation"', 'parameters = "owen2001_simulation"\nset.mass = "50 kg"')
    arguments = ("--out", again, "--fmi", "3", "--case", "rpm=0", "--overwrite")
    assert workbench("export", "plant", write(tmp_path, other), *arguments).code == 0
    assert read_fmu(again).token != read_fmu(made[3]).token


@pytest.mark.parametrize("fmi", VERSIONS)
def test_the_description_tells_every_variable_with_unit_and_start(fmi: int, made: dict[int, Path]) -> None:
    fmu = read_fmu(made[fmi])
    assert fmu.named("input") == ["valve_voltage", "disturbance_force"]
    assert {"position", "velocity", "load_pressure", "measured_position", "axial_friction"} <= {*fmu.named("output")}
    assert {"mass", "coulomb", "coulomb_negative", "supply_pressure"} <= {*fmu.named("parameter")}
    assert fmu.variables["axial_friction"].unit == "N"
    assert not any(name.startswith("measured_friction") for name in fmu.variables), "no rig measures it"
    root = ET.fromstring(content(made[fmi])["modelDescription.xml"])
    numbers = {item.attrib["name"]: item if fmi == 3 else item[0] for item in root.iterfind("ModelVariables/*")}
    assert numbers["mass"].attrib["start"] == "34.0"
    assert numbers["der(velocity)"].get("unit") == "m/s^2"
    listed = root.iterfind("ModelStructure/Outputs/Unknown" if fmi == 2 else "ModelStructure/Output")
    on = {item.get("index" if fmi == 2 else "valueReference"): item.get("dependencies") for item in listed}
    name = "measured_position"
    reference = fmu.variables[name].reference + (fmi == 2)
    assert on[str(reference)] == str(1 + (fmi == 2)), "the position alone: no algebraic loop through a controller"


def test_units_are_defined_by_base_units() -> None:
    element = unit_definitions(["N", "rad/s", "m^2/(s Pa^0.5)"])
    force, speed, flow = element
    assert force[0].attrib == {"kg": "1", "m": "1", "s": "-2"}
    assert speed[0].attrib == {"rad": "1", "s": "-1"}
    assert not len(flow), "FMI has whole exponents alone"


def test_the_sources_stand_beside_the_binary(made: dict[int, Path]) -> None:
    for fmi, path in made.items():
        files = content(path)
        names = {"machine.c", "machine.h", "model.h", "plant.c", f"fmi{fmi}.c", f"fmi{fmi}.h"}
        assert {f"sources/{name}" for name in names} <= {*files}
        text = b"".join(files[f"sources/{name}"] for name in names).decode()
        assert "malloc" not in text.replace("*state = malloc(sizeof(Machine))", ""), "a saved state alone is beside"


def test_without_a_compiler_the_sources_go_alone(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("CC", "no_compiler")
    out = tmp_path / "plant.fmu"
    answer = workbench("export", "plant", write(tmp_path, STUDY), "--out", out, "--case", "rpm=0")
    assert answer.code == 0
    assert 'sources alone, no binary: no C compiler: "no_compiler" is not found on PATH' in answer.out
    assert not any(name.startswith("binaries") for name in content(out))


def test_what_cannot_be_exported_is_told_in_a_line(tmp_path: Path) -> None:
    study = write(tmp_path, STUDY)
    out = tmp_path / "plant.fmu"
    fails(workbench("export", "plant", study, "--out", tmp_path / "plant"), "ends in .fmu")
    fails(workbench("export", "plant", study, "--out", out), "2 cases, expected one", "rpm: 0, 460")
    fails(workbench("export", "plant", study, "--out", out, "--case", "speed=0"), "no axis speed")
    fails(workbench("export", "plant", tmp_path / "none.toml", "--out", out), "none.toml")
    assert not out.exists()
    out.write_bytes(b"mine")
    fails(workbench("export", "plant", study, "--out", out, "--case", "rpm=0"), "is there already", "--overwrite")
    assert out.read_bytes() == b"mine"


@pytest.mark.parametrize("fmi", VERSIONS)
def test_an_exported_plant_in_the_place_of_its_own_gives_the_same_figures(
    fmi: int, made: dict[int, Path], tmp_path: Path
) -> None:
    sensors = '[sensors]\ndelay = "1.5 ms"\nposition = { noise = "5 um", resolution = "1 um" }\n[simulation]'
    native = changed("[simulation]", sensors, changed('model = "by_rpm"', 'model = "non_rotating"'))
    native = changed("rpm = [0, 460]", 'controller = ["p", "lp"]\n[controllers.lp]\ntype = "load_pressure"', native)
    shutil.copy(made[fmi], tmp_path / "plant.fmu")
    mapping = f'[plant]\nfmu = "plant.fmu"\ninputs = {{ valve_voltage = "valve_voltage" }}\noutputs = {{ {OUTPUTS} }}'
    ours, theirs = (rows_of(tmp_path, text) for text in (native, changed("[plant]", mapping, native)))
    shared = [name for name in theirs.columns if theirs[name].notna().all() and "solver" not in name]
    assert {"phase_lag_deg", "rms_error_m", "max_error_m", "control_effort_V", "stuck_fraction"} <= {*shared}
    pd.testing.assert_frame_equal(theirs[shared], ours[shared], rtol=1e-7)
    assert theirs["solver_error_m"].max() < 1e-8


def names_of(cls: type[NamedTuple]) -> list[str]:
    """The names of its numbers, as users know them."""
    return [item.name for item in fields(cls)]


def rows_of(folder: Path, text: str) -> pd.DataFrame:
    """The results of a study."""
    out = folder / "results"
    answer = workbench("run", write(folder, text), "--out", out, "--overwrite", "--allow-fmu")
    assert (answer.code, answer.err) == (0, "")
    return pd.read_csv(out / "results.csv")


def as_machine(setup: Setup, path: Path) -> Setup:
    """The setup with its plant's FMU in the place of the equations; it sees the position alone."""
    path.write_bytes(exported(setup, 3, "a plant").archive)
    fmu, plant = read_fmu(path), setup.plant
    inputs, outputs = (
        tuple(Mapped(fmu.variables[name].reference, 1.0) for name in names_of(cls))
        for cls in (plant.Inputs, plant.State)
    )
    return replace(setup, machine=FmuMachine(fmu, inputs, outputs, (0, *[ABSENT] * 5), (), True))


def test_a_filter_before_the_converter_sees_lines_between_samples(tmp_path: Path) -> None:
    """The error falls with the square of the sample time: the filter is solved exactly along lines."""
    sensors = Sensors({"position": Channel(anti_alias=100.0)})
    distances = []
    for sample_time in (2e-3, 1e-3):
        setup = replace(small().simulation, sensors=sensors, sample_time=sample_time)
        ours, theirs = simulate(setup), simulate(as_machine(setup, tmp_path / "plant.fmu"))
        distances.append(float(np.max(np.abs(ours.measurements[:, 0] - theirs.measurements[:, 0]))))
    assert distances[1] < 1e-7
    assert 3.0 < distances[0] / distances[1] < 6.0


def test_a_ramp_between_samples_is_held_at_its_middle(tmp_path: Path) -> None:
    feed = Feed("disturbance_force", Sine(200.0, 5.0))
    setup = replace(small().simulation, feeds=(feed,))
    ours, theirs = simulate(setup), simulate(as_machine(setup, tmp_path / "plant.fmu"))
    assert np.ptp(ours.state("position")) > 5e-3
    assert np.max(np.abs(ours.state("position") - theirs.state("position"))) < 1e-7


def run_in_c(equations: Equations, folder: Path, time: float, *values: np.ndarray) -> list[np.ndarray]:
    """Rates and outputs of the C, compiled."""
    (folder / "plant.c").write_text(equations.code, encoding="utf-8")
    declared = "".join(f"{function};\n" for function in DECLARED.values())
    (folder / "model.h").write_text(f"#include <math.h>\n{declared}", encoding="utf-8")
    library = ctypes.CDLL(str(compiled_library([folder / "plant.c"], folder / "plant.so")))
    pointer = ctypes.POINTER(ctypes.c_double)
    found = [np.empty(len(equations.rates)), np.empty(len(equations.outputs))]
    for function, out in zip((library.plant_rates, library.plant_outputs), found, strict=True):
        vectors = (array.ctypes.data_as(pointer) for array in (*values, out))
        function(ctypes.c_double(time), *vectors)
    return found


@pytest.mark.parametrize("name", plants())
def test_the_equations_in_c_are_those_of_the_plant(name: str, tmp_path: Path) -> None:
    """At a random point, at a time other than 0, rates and outputs are what the plant's functions give there."""
    plant = plants()[name]
    if name in ("non_rotating", "drive_force"):
        plant = plant.with_effects(EFFECTS.working()["viscous_drift"])
    random = np.random.default_rng(1)
    values = [random.uniform(0.5, 1.5, len(fields(cls))) for cls in (plant.State, plant.Inputs, plant.Parameters)]
    state, inputs, parameters = map(from_array, (plant.State, plant.Inputs, plant.Parameters), values)
    equations = equations_of(plant)
    rates = to_array(plant.derivatives(3.0, state, inputs, parameters))
    found_rates, values_of = run_in_c(equations, tmp_path, 3.0, *values)
    np.testing.assert_allclose(found_rates, rates, rtol=1e-12)
    found = {output.name: value for output, value in zip(equations.named, values_of, strict=True)}
    signals = leaves(plant.signals(3.0, state, inputs, parameters))
    expected = dict(zip(names_of(plant.Signals), signals, strict=True))
    expected |= {f"measured_{name}": value for name, value in plant.measure(state, parameters)._asdict().items()}
    assert found == pytest.approx({name: float(expected[name]) for name in found}, rel=1e-12)
