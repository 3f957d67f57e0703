"""Scenarios: what each of them does to the truth, by formula; that the belief stays; the files that come along."""

import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from support import registered

from controllers.pid import PID, Settings
from plants.equation import fields, from_array, to_array
from plants.hydraulics import valve_opening
from plants.interface import Measurement, Plant
from plants.registry import plants
from workbench.cli import main
from workbench.errors import UserError
from workbench.parameters import LEAST_SHARE, drawn, named_sets, read_deviations, read_parameters
from workbench.simulation.references import Steps
from workbench.simulation.sensors import Channel, Sensors, systematic_error
from workbench.simulation.simulate import Integrator, Loop, Run, Setup, simulate
from workbench.study.document import read_study, unfold
from workbench.study.resolve import Resolved, resolve
from workbench.study.runner import plan, run_case

FOLDER = Path(__file__).parents[1] / "studies" / "scenarios"
FILES = sorted(FOLDER.glob("*.toml"))
HYDRAULIC = [item for item in plants().values() if item.command == "valve_voltage"]
TRUTH = read_parameters(named_sets()["owen2001_simulation"])
GAIN = 500.0
FILE_HEAD = 'title = "t"\nsource = "s"\n'

STUDY = """\
title = "a study for tests"
[plant]
model = "non_rotating"
parameters = "owen2001_simulation"
[axes]
scenario = {scenarios}
controller = ["p", "inverse"]
[controllers.p]
type = "pid"
kp = "500 V/m"
feedforward = 1
[controllers.inverse]
type = "lugre"
law = "valve_inversion"
[references.sine]
kind = "sine"
amplitude = "5 mm"
frequency = "5 Hz"
[simulation]
duration = "0.4 s"
transient = "0.1 s"
seed = 3
"""


def study_file(folder: Path, scenarios: list[str], extra: str = "", **beside: str) -> Path:
    """A study in `folder` with these scenarios on its axis, and the scenario files `beside` it."""
    (folder / "scenarios").mkdir(exist_ok=True)
    for name, text in beside.items():
        (folder / "scenarios" / f"{name}.toml").write_text(text, encoding="utf-8")
    path = folder / "study.toml"
    path.write_text(STUDY.format(scenarios=scenarios) + extra, encoding="utf-8")
    return path


def resolved(path: Path) -> list[Resolved]:
    study = read_study(path)
    return [resolve(study, case) for case in unfold(study)]


def hydraulic(loop_gain: float = GAIN, duration: float = 2.0, friction: bool = True, **changes: Any) -> Setup:
    """The non-rotating actuator under P control, with changes of its hydraulics and of its load force."""
    setup = registered("non_rotating", duration=duration)
    p = setup.parameters
    body = p.body._replace(load_force=changes.pop("load_force", 0.0))
    contact = p.friction
    if not friction:
        none = contact.positive._replace(coulomb=0.0, stribeck=0.0, bristle_stiffness=0.0)
        contact = contact._replace(positive=none, negative=none)
    truth = p._replace(hydraulics=p.hydraulics._replace(**changes), body=body, friction=contact)
    gains = PID.design(Settings(kp=loop_gain), p, setup.sample_time)
    return replace(setup, parameters=truth, loop=Loop(PID, gains))


# --- the plant ------------------------------------------------------------------------------------------------


ONE_PRESSURE = [item for item in HYDRAULIC if "load_pressure" in item.State._fields]


@pytest.mark.parametrize("plant", ONE_PRESSURE, ids=lambda plant: plant.name)
def test_ideal_valve_and_seal_change_no_bit(plant: Plant) -> None:
    """At 0 overlap and leakage the flow and pressure equations are those of the thesis, (3.22) and (3.28), exactly."""
    p = registered(plant.name, duration=1.0).parameters
    h = p.hydraulics
    assert (h.valve_overlap, h.leakage_coefficient) == (0.0, 0.0)
    random = np.random.default_rng(4)
    scales = np.array([item.scale for item in fields(plant.State)])
    inputs = from_array(plant.Inputs, np.zeros(len(fields(plant.Inputs))))
    area = 0.5 * (h.piston_area_1 + h.piston_area_2)
    for _ in range(100):
        state = from_array(plant.State, scales * random.normal(size=scales.size))
        spool, pressure = state.spool_position, state.load_pressure
        drop = h.supply_pressure - h.tank_pressure - np.sign(spool) * pressure
        flow = h.valve_flow_gain * spool * np.sqrt(max(h.flow_pressure_share * drop, 0.0))
        rate = 4.0 * h.bulk_modulus / (2.0 * h.hose_volume + area * h.stroke) * (flow - area * state.velocity)
        if abs(pressure) < h.supply_pressure:
            assert plant.derivatives(0.0, state, inputs, p).load_pressure == rate


def test_opening_of_an_overlapped_valve() -> None:
    h = registered("non_rotating", duration=1.0).parameters.hydraulics._replace(valve_overlap=6e-6)
    spool = np.array([-1e-4, -6e-6, -5.9e-6, 0.0, 6e-6, 7e-6, 6e-4])
    assert valve_opening(spool, h) == pytest.approx([-9.4e-5, 0.0, 0.0, 0.0, 0.0, 1e-6, 5.94e-4], abs=1e-18)


@pytest.mark.parametrize("load_force", [-600.0, 300.0])
def test_leakage_under_load_leaves_the_error_of_its_flow(load_force: float) -> None:
    """P_L = F / A leaks C P_L, which the valve must feed: e = C P_L / (K K_sv K_p sqrt((P_s - |P_L|) / 2))."""
    leak = 5e-12
    setup = hydraulic(load_force=load_force, leakage_coefficient=leak, friction=False, duration=3.0)
    run = simulate(replace(setup, reference=Steps((0.0,), 3.0)))
    pressure = load_force / TRUTH["piston_area_1"]
    root = np.sqrt((TRUTH["supply_pressure"] - abs(pressure)) / 2.0)
    expected = leak * pressure / (TRUTH["valve_flow_gain"] * TRUTH["valve_position_gain"] * GAIN * root)
    assert abs(expected) > 5e-5
    assert run.signals["error"][-1] == pytest.approx(expected, rel=1e-4)
    tight = simulate(replace(setup, parameters=hydraulic(load_force=load_force, friction=False).parameters))
    assert abs(tight.state("position")[-1]) < 1e-3 * abs(expected)


@pytest.mark.parametrize("gain", [200.0, 400.0])
def test_overlap_leaves_a_band_of_its_width_over_the_gain(gain: float) -> None:
    """Inside |e| < overlap / (K_sv K_p) the loop does nothing; from outside it comes to rest at the edge."""
    overlap = 6e-6
    edge = overlap / (TRUTH["valve_position_gain"] * gain)
    setup = hydraulic(gain, valve_overlap=overlap, duration=3.0)
    inside = simulate(replace(setup, reference=Steps((0.95 * edge,), 3.0)))
    assert np.max(np.abs(inside.state("position"))) == 0.0
    outside = simulate(replace(setup, reference=Steps((5e-3,), 3.0)))
    assert outside.signals["error"][-1] == pytest.approx(edge, rel=0.02)
    ideal = simulate(replace(hydraulic(gain, duration=3.0), reference=Steps((5e-3,), 3.0)))
    assert abs(ideal.signals["error"][-1]) < 0.02 * edge


def test_overlap_is_no_trouble_for_error_control() -> None:
    """The flow has kinks, no jumps: the solver takes no more than half as many steps again, and its error is small."""
    runs = []
    for overlap in (0.0, 18e-6):
        setup = replace(hydraulic(valve_overlap=overlap), reference=Steps((3e-3, -3e-3), 0.5))
        run, fine = simulate(setup), simulate(replace(setup, integrator=Integrator(tolerance=1e-9)))
        assert np.max(np.abs(run.state("position") - fine.state("position"))) < 1e-7
        runs.append(run)
    assert runs[1].steps < 1.5 * runs[0].steps


# --- sensors --------------------------------------------------------------------------------------------------


def measured(run: Run, name: str = "position") -> np.ndarray:
    return run.measurements[:, Measurement._fields.index(name)]


def moving(channels: dict[str, Channel], **options: Any) -> Run:
    return simulate(replace(hydraulic(), reference=Steps((8e-3, -8e-3), 0.5), sensors=Sensors(channels), **options))


def test_offset_and_gain_of_a_sensor() -> None:
    """The sensor reads (1 + g) y + b; the loop brings what it reads, not the position, to the reference."""
    offset, gain = 0.2e-3, 0.01
    run = moving({"position": Channel(offset=offset, gain_error=gain), "pressure_1": Channel(offset=5e4)})
    assert measured(run) == pytest.approx((1.0 + gain) * run.state("position") + offset, abs=1e-15)
    assert measured(run, "pressure_1") == pytest.approx(run.signals["pressure_1"] + 5e4, rel=1e-14)
    assert np.array_equal(measured(run, "pressure_2"), run.signals["pressure_2"])
    assert run.state("position")[499] == pytest.approx((8e-3 - offset) / (1.0 + gain), abs=2e-6)


def curve(peak: float, travel: float, seed: int, at: np.ndarray) -> np.ndarray:
    channel = Channel(calibration_error=peak, calibration_travel=travel, calibration_seed=seed)
    return systematic_error(at, Sensors({"position": channel}).errors()[0])


@pytest.mark.parametrize("seed", range(5))
def test_calibration_curve_is_smooth_has_its_peak_and_repeats(seed: int) -> None:
    """Peak within 1e-4; a wave of n periods and amplitude a has slopes up to 2 pi n a / travel; no mean."""
    peak, travel = 0.07e-3, 0.2
    at = np.linspace(-0.5, 0.5, 7001) * travel
    errors = curve(peak, travel, seed, at)
    assert np.max(np.abs(errors)) == pytest.approx(peak, rel=1e-4)
    spectrum = np.abs(np.fft.rfft(errors[:-1])) / 3500.0
    assert spectrum[1:5] == pytest.approx(spectrum[1] / np.arange(1, 5), rel=1e-9)
    assert np.max(np.delete(spectrum, [1, 2, 3, 4])) < 1e-9 * peak
    assert np.array_equal(errors, curve(peak, travel, seed, at))
    assert np.max(np.abs(errors - curve(peak, travel, seed + 1, at))) > 0.2 * peak


def test_calibration_error_is_what_the_engine_adds_before_noise_and_converter() -> None:
    """What a noisy, quantised channel shows: rint((y + e(y) + noise) / q) q, noise as without calibration error."""
    seed, step = 11, 2.0**-18
    channel = Channel(
        noise=1e-5, resolution=step, calibration_error=0.07e-3, calibration_travel=0.2, calibration_seed=3
    )
    run = moving({"position": channel}, seed=seed)
    position = run.state("position")
    noise = Sensors({"position": Channel(noise=1e-5)}).noise(position.size, seed)[:, 0]
    analogue = position + curve(0.07e-3, 0.2, 3, position) + noise
    assert np.max(np.abs(measured(run) - analogue)) <= 0.5 * step + 1e-12
    assert np.max(np.abs(measured(run) - position - noise)) > 1e-5


def test_controller_starts_from_what_the_sensor_shows() -> None:
    """An offset alone is no motion: the filtered velocity starts at 0 and a derivative gain has nothing to act on."""
    setup = registered("non_rotating", duration=0.05)
    gains = PID.design(Settings(kp=0.0, kd=50.0), setup.parameters, setup.sample_time)
    sensors = Sensors({"position": Channel(offset=1e-3)})
    run = simulate(replace(setup, loop=Loop(PID, gains), reference=Steps((0.0,), 1.0), sensors=sensors))
    assert np.max(np.abs(run.command)) < 1e-12


# --- the spread of friction -----------------------------------------------------------------------------------


@pytest.mark.parametrize(("name", "mean", "deviation"), [("coulomb", 330.0, 30.0), ("bristle_stiffness", 2.6e6, 0.6e6)])
def test_draws_have_the_mean_and_deviation_of_table_5_2(name: str, mean: float, deviation: float) -> None:
    """Over n seeds: within four standard errors, deviation / sqrt(n) and deviation / sqrt(2 n)."""
    n = 2000
    draws = np.array([drawn(name, mean, deviation, seed) for seed in range(n)])
    assert np.mean(draws) == pytest.approx(mean, abs=4.0 * deviation / np.sqrt(n))
    assert np.std(draws) == pytest.approx(deviation, abs=4.0 * deviation / np.sqrt(2.0 * n))
    assert np.all(draws >= LEAST_SHARE * mean)


def test_draws_are_independent_and_never_non_physical() -> None:
    seeds = range(500)
    coulomb, negative = (
        np.array([drawn(name, 1.0, 1.0, s) for s in seeds]) for name in ("coulomb", "coulomb_negative")
    )
    assert abs(np.corrcoef(coulomb, negative)[0, 1]) < 4.0 / np.sqrt(500)
    assert min(coulomb.min(), negative.min()) >= LEAST_SHARE
    assert min(drawn("load_force", 0.0, 1.0, s) for s in seeds) < -1.0  # a load may pull either way


@pytest.mark.parametrize(("name", "relative"), [("coulomb", 30 / 330), ("stribeck", 15 / 150),
    ("viscous", 2500 / 22800), ("stribeck_velocity", 0.3 / 2.4), ("bristle_stiffness", 0.6 / 2.6),
    ("bristle_damping", 0.1 / 1.1)])  # fmt: skip
def test_simulated_actuator_has_the_relative_spread_of_the_rig(name: str, relative: float) -> None:
    """Table 5.2, mean and deviation of each parameter, rounded."""
    path = named_sets()["owen2001_simulation"]
    assert read_deviations(path)[name] / read_parameters(path)[name] == pytest.approx(relative, rel=0.02)


def test_spread_is_the_same_for_every_controller_and_not_for_every_seed(tmp_path: Path) -> None:
    spread = (FOLDER / "friction_spread.toml").read_text(encoding="utf-8")
    p, inverse = resolved(study_file(tmp_path, ["friction_spread"], friction_spread=spread))
    assert p.setup.parameters == inverse.setup.parameters
    level = p.setup.parameters.friction.positive
    assert level.coulomb == drawn("coulomb", 370.0, 34.0, 3) != 370.0
    assert level == p.setup.parameters.friction.negative  # a set with one direction stays symmetric
    assert all(
        a != b
        for a, b in zip(level, registered("non_rotating", duration=1.0).parameters.friction.positive, strict=True)
    )

    text = (tmp_path / "study.toml").read_text(encoding="utf-8")
    (tmp_path / "study.toml").write_text(text.replace("seed = 3", "seed = 4"), encoding="utf-8")
    assert resolved(tmp_path / "study.toml")[0].setup.parameters.friction.positive.coulomb != level.coulomb


def test_spread_draws_each_direction_and_is_scaled_afterwards(tmp_path: Path) -> None:
    text = FILE_HEAD + '[plant]\nparameters = "owen2001_experiment"\nspread.coulomb = 2\nscale.coulomb = 3\n'
    truth = resolved(study_file(tmp_path, ["rig"], rig=text))[0].setup.parameters.friction
    assert truth.positive.coulomb == pytest.approx(3.0 * drawn("coulomb", 330.0, 60.0, 3), rel=1e-15)
    assert truth.negative.coulomb == pytest.approx(3.0 * drawn("coulomb_negative", 290.0, 50.0, 3), rel=1e-15)
    assert truth.positive.viscous == 22800.0


# --- files ----------------------------------------------------------------------------------------------------


def test_the_files_of_the_issue_are_there() -> None:
    assert {path.stem for path in FILES} == {
        *("nominal", "measured_rig", "friction_up", "friction_down", "friction_spread", "valve_overlap"),
        *("hose_fed_30", "hose_fed_100", "hose_fed_170", "internal_leakage", "payload"),
    }


def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, str, str]:
    monkeypatch.setattr(sys, "argv", ["workbench", *words])
    code = 0
    try:
        main()
    except SystemExit as ended:
        code = int(ended.code or 0)
    return code, *capsys.readouterr()


@pytest.mark.parametrize("path", FILES, ids=lambda path: path.stem)
def test_check_of_a_scenario(path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    code, out, err = command(monkeypatch, capsys, "check", str(path))
    assert (code, err) == (0, "")
    assert out.startswith(f"{path}: a scenario, in order; it changes ")


def test_every_scenario_runs_and_changes_the_truth_alone(tmp_path: Path) -> None:
    names = [path.stem for path in FILES]
    path = study_file(tmp_path, names, **{item.stem: item.read_text(encoding="utf-8") for item in FILES})
    planned = plan(read_study(path))
    gains = {case.axes["controller"]: set() for case in planned.cases}
    rows = {}
    for case, item in zip(planned.cases, planned.resolved, strict=True):
        gains[case.axes["controller"]].add(to_array(item.setup.loop.gains).tobytes())
        rows[tuple(case.axes.values())] = run_case(planned.study, case, None)
    assert [len(seen) for seen in gains.values()] == [1, 1]
    assert {row["outcome"] for row in rows.values()} == {"completed"}
    nominal = rows[("nominal", "p")]
    for name in names:
        differs = rows[(name, "p")]["rms_error_m"] != nominal["rms_error_m"]
        assert differs == (name != "nominal"), name


def test_truth_of_each_scenario(tmp_path: Path) -> None:
    names = [path.stem for path in FILES]
    path = study_file(tmp_path, names, **{item.stem: item.read_text(encoding="utf-8") for item in FILES})
    truth = dict(zip(names, [item.setup for item in resolved(path)][::2], strict=True))
    nominal = registered("non_rotating", duration=1.0).parameters
    assert truth["nominal"].parameters == truth["measured_rig"].parameters == nominal
    assert truth["friction_up"].parameters.friction.negative[:3] == pytest.approx((481.0, 282.1, 2318.0))
    assert truth["friction_down"].parameters.friction.positive[:3] == pytest.approx((259.0, 151.9, 2318.0))
    assert [truth[f"hose_fed_{n}"].parameters.hydraulics.bulk_modulus for n in (30, 100, 170)] == [30e6, 100e6, 170e6]
    assert truth["valve_overlap"].parameters.hydraulics.valve_overlap == pytest.approx(6e-6)
    assert truth["internal_leakage"].parameters.hydraulics.leakage_coefficient == pytest.approx(5e-12)
    assert truth["payload"].parameters.body[:2] == (68.0, 334.0)
    sensors = truth["measured_rig"].sensors
    assert sensors.resolution()[:3] == pytest.approx([0.2 / 4096, 17.2369e6 / 4096, 17.2369e6 / 4096], rel=1e-5)
    accuracy = 0.01 * 17.2369e6
    worst = [abs(c.offset) + abs(c.gain_error) * 4.91e6 for n, c in sensors.channels.items() if "pressure" in n]
    assert all(accuracy / 2.0 < value < accuracy for value in worst)


@pytest.mark.parametrize(
    ("text", "line", "message"),
    [
        ('title = "t"\n[plant.scale]\ncoulomb = 1.3\n', "", "source: is missing"),
        (FILE_HEAD + "[belief]\n", ":3", "belief: unknown key"),
        (FILE_HEAD + "[sensor]\n", ":3", 'sensor: unknown key; did you mean "sensors"?'),
        (FILE_HEAD + "[plant.scale]\ncolomb = 1.3\n", ":4", 'did you mean "coulomb"?'),
        (FILE_HEAD + '[plant.set]\nmass = "2 m"\n', ":4", "plant.set.mass"),
        (FILE_HEAD + "[plant.set]\nvalve_overlap = -1e-6\n", ":4", "expected a value that is not negative"),
        (FILE_HEAD + "[plant.spread]\nmass = 1\n", ":4", '"owen2001_simulation" gives no std for it'),
        (FILE_HEAD + "[plant.spread]\ncoulomb = -1\n", ":4", "expected a factor that is not negative"),
        (FILE_HEAD + '[sensors.position]\nnoise = "1 Pa"\n', ":", "sensors.position"),
        (FILE_HEAD + '[sensors.position]\ncalibration_error = "1 mm"\n', ":3", "together with calibration_travel"),
        (FILE_HEAD + "[sensors.position]\ngain_error = -1\n", ":4", "gain_error"),
    ],
)
def test_mistake_in_a_scenario_file_is_told_with_that_file_and_line(
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
    text: str,
    line: str,
    message: str,
) -> None:
    """By the check of the scenario and by that of a study that names it, alike."""
    study = study_file(tmp_path, ["mine"], mine=text)
    scenario = tmp_path / "scenarios" / "mine.toml"
    for file in (scenario, study):
        code, out, err = command(monkeypatch, capsys, "check", str(file))
        assert (code, out) == (2, "")
        assert err.startswith(f"error: {scenario}{line}")
        assert message in err
        assert err.count("\n") == 1


def test_unknown_scenario_gets_the_nearest_of_tables_and_files(tmp_path: Path) -> None:
    inline = "[scenarios.stiff.plant.set]\nbulk_modulus = 2e9\n"
    for wrong, right in (("stif", "stiff"), ("hose_fedd", "hose_fed")):
        with pytest.raises(UserError, match=f'unknown scenario "{wrong}"; did you mean "{right}"'):
            resolved(study_file(tmp_path, [wrong], inline, hose_fed=FILE_HEAD))


def test_table_of_the_study_comes_before_a_file_of_that_name(tmp_path: Path) -> None:
    inline = "[scenarios.soft.plant.set]\nbulk_modulus = 5e7\n"
    path = study_file(
        tmp_path, ["soft", "hard"], inline, soft="no TOML", hard=FILE_HEAD + "plant.set.bulk_modulus = 2e9\n"
    )
    moduli = [item.setup.parameters.hydraulics.bulk_modulus for item in resolved(path)]
    assert moduli == [5e7, 5e7, 2e9, 2e9]


def test_results_know_what_the_scenario_file_held(tmp_path: Path) -> None:
    """A run cannot be resumed with another scenario: the identity of a study covers the scenario files it names."""
    soft = FILE_HEAD + "plant.set.bulk_modulus = 5e7\n"
    seen = set()
    for text in (soft, soft + "# a remark\n", soft.replace("5e7", "6e7"), soft + "simulation.seed = 9\n"):
        seen.add(read_study(study_file(tmp_path, ["soft"], soft=text)).fingerprint)
    assert len(seen) == 3
