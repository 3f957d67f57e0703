"""Identification: the thesis's method and the fit by simulation against known truths; the command, end to end."""

import json
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import workbench, write
from experiments import TRUTH, experiment_text, make_record

from plants.registry import THESIS
from workbench.fitting import covariance
from workbench.identify.simulation.method import SimulationFit, identify_by_simulation
from workbench.identify.thesis import method as thesis_method
from workbench.parameters.sets import build, read_parameters
from workbench.records.experiment import read_experiment
from workbench.records.friction import Slow, from_position, slower
from workbench.records.reading import read_records
from workbench.simulation.references import Sine
from workbench.simulation.simulate import Feed, Setup, simulate


def fitted(folder: Path, scale: Mapping[str, float], free: list[str]) -> SimulationFit:
    experiment = read_experiment(write(folder, experiment_text(scale, free), "experiment.toml"))
    return identify_by_simulation(experiment, read_records(experiment))


# --- the thesis's method ---

STATIC = {"coulomb": 330.0, "stribeck": 150.0, "viscous": 22800.0, "stribeck_velocity": 0.0024}


@pytest.mark.parametrize("force", [1.0, 0.1], ids=["axial", "rotary"])
def test_static_parameters_of_an_exact_curve(force: float) -> None:
    """(4.7) evaluated by hand on the thesis's speeds; a tenth of it is the size of rotary friction."""
    speed = np.linspace(0.0, 0.0114, 300)
    level = force * (330.0 + 150.0 * np.exp(-((speed / 0.0024) ** 2)) + 22800.0 * speed)
    found = thesis_method.static_parameters(Slow(0.1 * np.arange(300), speed, level))
    for name, value in STATIC.items():
        assert found[name] == pytest.approx(value * (1.0 if name == "stribeck_velocity" else force), rel=1e-5)


def test_bristle_of_a_slow_pull() -> None:
    """At a constant velocity v the LuGre bristle is z = (g/sigma0)(1 - exp(-sigma0 v t / g)), F = sigma0 z."""
    level, stiffness, v = 480.0, 2.6e6, 2e-5
    time = 0.01 * np.arange(1500)
    force = level * (1.0 - np.exp(-stiffness * v * time / level))
    found = thesis_method.dynamic_parameters(Slow(time, np.full(time.size, v), force), level, 15.0)
    assert found["bristle_stiffness"] == pytest.approx(stiffness, rel=0.01)


def test_the_thesis_rule_for_damping() -> None:
    """2 * 0.9 sqrt(2.6e6 * 15) = 1.124e4: table 5.2 has 1.1e4 N s/m beside 2.6e6 N/m and 15 kg."""
    assert 2.0 * thesis_method.DAMPING_RATIO * np.sqrt(2.6e6 * 15.0) == pytest.approx(1.1e4, rel=0.03)


def test_a_slow_ramp_is_differentiated_exactly() -> None:
    time = 1e-3 * np.arange(4000)
    data = slower(from_position(time, 0.01 * time, np.zeros(4000)))
    assert data.sample_time == pytest.approx(0.1)
    inside = np.isfinite(data.velocity)
    assert 30 < np.sum(inside) < 40
    np.testing.assert_allclose(data.velocity[inside], 0.01, rtol=1e-9)


def test_mean_and_deviation_over_repeats() -> None:
    found = thesis_method.over_repeats([{"coulomb": 1.0}, {"coulomb": 2.0}, {"coulomb": 3.0, "viscous": 5.0}])
    assert (found["coulomb"].value, found["coulomb"].std, found["coulomb"].count) == (2.0, 1.0, 3)
    assert found["viscous"].count == 1
    assert np.isnan(found["viscous"].std)


# --- covariance ---


def test_sandwich_of_correlated_noise() -> None:
    """The mean of AR(1) noise has the variance sigma^2 (1 + phi) / (1 - phi) / n: nine times the white one for 0.8."""
    size, phi, generator = 100_000, 0.8, np.random.default_rng(3)
    noise = np.zeros(size)
    for k in range(1, size):
        noise[k] = phi * noise[k - 1] + generator.standard_normal()
    length = 5 * covariance.long_run_length([noise])
    found = covariance.sandwich(np.ones((size, 1)), noise, [slice(0, size)], length, np.zeros(1))
    assert found[0, 0] == pytest.approx(1.0 / (1.0 - phi**2) * (1.0 + phi) / (1.0 - phi) / size, rel=0.25)


def test_a_variance_is_raised_and_correlations_stay() -> None:
    found = covariance.at_least(np.array([[1.0, 1.0], [1.0, 4.0]]), np.diag([9.0, 1.0]))
    np.testing.assert_allclose(found, [[9.0, 3.0], [3.0, 4.0]])


# --- by simulation ---

SCALE = {"coulomb": 0.7, "viscous": 1.4}


def test_a_perturbed_truth_is_found_within_its_uncertainty(tmp_path: Path) -> None:
    make_record(tmp_path)
    fit = fitted(tmp_path, SCALE, ["coulomb", "viscous"])
    assert list(fit.estimates) == ["coulomb", "coulomb_negative", "viscous", "viscous_negative"]
    for name, one in fit.estimates.items():
        assert abs(one.value - TRUTH[name]) < 3.0 * one.std, name
        assert one.std < 0.1 * TRUTH[name], name
        assert one.low < one.value < one.high
    assert fit.rms["pressure_1"] == pytest.approx(2e3 / np.sqrt(10.0), rel=0.1)  # the noise of a mean of ten
    assert fit.before["pressure_1"] > 5.0 * fit.rms["pressure_1"]
    np.testing.assert_allclose(np.diag(fit.correlation), 1.0)


def test_what_is_held_and_declared_with_a_deviation_widens_those_of_the_fit(tmp_path: Path) -> None:
    """Stribeck friction and bristles of the set have one; with these taken for right friction seems known to 2 %."""
    make_record(tmp_path)
    experiment = read_experiment(write(tmp_path, experiment_text(SCALE, ["coulomb", "viscous"]), "experiment.toml"))
    assert experiment.deviations["bristle_stiffness"] == pytest.approx(6e5)
    records = read_records(experiment)
    known = identify_by_simulation(replace(experiment, deviations={}), records)
    uncertain = identify_by_simulation(experiment, records)
    for name, one in known.estimates.items():
        assert one.value == uncertain.estimates[name].value
        assert one.std < 0.02 * TRUTH[name], name
        assert uncertain.estimates[name].std > 1.2 * one.std, name
    assert not any(note.startswith("The deviations include") for note in known.notes)
    (note,) = [note for note in uncertain.notes if note.startswith("The deviations include")]
    assert "bristle_stiffness" in note


def test_what_a_record_does_not_show_is_named_and_stays_as_declared(tmp_path: Path) -> None:
    """The end stops are never met: their stiffness has no effect on the record."""
    make_record(tmp_path)
    fit = fitted(tmp_path, SCALE, ["coulomb", "end_stop_stiffness"])
    assert fit.unidentified == {"end_stop_stiffness": "has no effect on the records"}
    assert set(fit.estimates) == {"coulomb", "coulomb_negative"}


def test_parameters_that_act_as_one_are_named(tmp_path: Path) -> None:
    """The flow gain and the valve's position gain only ever appear as a product."""
    make_record(tmp_path)
    fit = fitted(tmp_path, {"valve_flow_gain": 0.9}, ["valve_flow_gain", "valve_position_gain"])
    assert len(fit.unidentified) == 1
    (name, why), *_ = fit.unidentified.items()
    other = {"valve_flow_gain": "valve_position_gain", "valve_position_gain": "valve_flow_gain"}[name]
    assert why == f"cannot be told apart from {other}"


# --- the command ---


def test_the_command_from_record_to_a_plant_that_a_study_can_name(tmp_path: Path) -> None:
    make_record(tmp_path)
    path = write(tmp_path, experiment_text(SCALE, ["coulomb", "viscous"]), "experiment.toml")
    out = tmp_path / "out"
    checked = workbench("check", path)
    assert (checked.code, checked.err) == (0, "")
    assert checked.out.startswith(f"{path}: an experiment, in order\n")
    answer = workbench("identify", path, "--out", out, "--method", "simulation")
    assert (answer.code, answer.err) == (0, "")
    assert "| coulomb " in answer.out
    data = json.loads((out / "identified.json").read_text())
    coulomb = data["parameters"]["coulomb"]
    assert coulomb["declared"] == pytest.approx(0.7 * 330.0)
    assert coulomb["truth"] == 330.0
    assert coulomb["simulation"]["value"] == pytest.approx(330.0, rel=0.02)
    values = read_parameters(out / "plant.toml")
    assert values["coulomb"] == pytest.approx(coulomb["simulation"]["value"], rel=1e-9)
    assert values["mass"] == TRUTH["mass"]
    assert set(values) == set(TRUTH)
    assert workbench("check", out / "plant.toml").code == 0
    written = {str(item.relative_to(out)) for item in out.rglob("*.*")}
    assert {"tables/identified.csv", "tables/identified.md", "tables/identified.tex"} <= written
    assert {"figures/friction_velocity.pdf", "figures/record_record.svg", "figures/correlation.png"} <= written
    again = workbench("identify", path, "--out", out)
    assert again == (2, "", f"error: {out}: holds an identification already; replace it with --overwrite\n")


def test_the_thesis_method_alone_on_a_quasi_static_record(tmp_path: Path) -> None:
    """Without any sensor error its static parameters are the true ones to 1.5 %: the method's own smoothing."""
    parameters = build(THESIS.Parameters, TRUTH)
    state = THESIS.equilibrium(parameters, 0.0)[0]._replace(position=-0.07)
    feed = Feed("valve_voltage", Sine(1.0, 0.005, 1.0, -np.pi / 2))
    run = simulate(Setup(THESIS, parameters, state, THESIS.Inputs(0.0, 0.0), 35.0, feeds=(feed,)))
    columns = {name: run.signals[name] for name in ("position", "pressure_1", "pressure_2")}
    frame = pd.DataFrame({"time": run.time, "valve_voltage": run.command, **columns})
    frame.to_parquet(tmp_path / "record.parquet")
    path = write(tmp_path, experiment_text({"coulomb": 0.5}, ["coulomb"]), "experiment.toml")
    assert workbench("identify", path, "--out", tmp_path / "out", "--method", "thesis").code == 0
    data = json.loads((tmp_path / "out" / "identified.json").read_text())["parameters"]
    assert "coulomb_negative" not in data
    for name, value in STATIC.items():
        assert data[name]["thesis"]["mean"] == pytest.approx(value, rel=0.015), name
