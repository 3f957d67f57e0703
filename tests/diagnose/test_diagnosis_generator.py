"""The generator of records with undeclared effects: it agrees with the plant, converges, is silent at strength 0."""

import json
from pathlib import Path

import numpy as np
import pytest
from diagnosis.effects import EFFECTS, UNLISTED
from diagnosis.generator import (
    DECLARED,
    NOISE,
    NOMINAL,
    SAMPLE_TIME,
    SPREAD,
    check_physical,
    make_experiment,
    simulate,
    true_rig,
)
from diagnosis.physics import POSITION, PRESSURE_1, PRESSURE_2, SUBSTEPS, run

from plants.registry import THESIS
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records
from workbench.simulation.references import Sine
from workbench.simulation.simulate import Feed, Setup
from workbench.simulation.simulate import simulate as simulate_plant

pytestmark = pytest.mark.thorough

MEASURED = [POSITION, PRESSURE_1, PRESSURE_2]
ALL = [(name, True) for name in EFFECTS] + [(name, False) for name in UNLISTED]


def chosen(name: str, listed: bool, strength: float) -> dict[str, dict[str, float]]:
    """Arguments of `true_rig` for one effect."""
    return {"effects": {name: strength} if listed else {}, "unlisted": {} if listed else {name: strength}}


def test_nominal_rig_is_the_plant() -> None:
    """Same voltage into both: 4 s with presliding, reversals and 0.05 m/s, without any effect."""
    parameters = build(THESIS.Parameters, read_parameters(named_sets()[DECLARED]))
    state, _ = THESIS.equilibrium(parameters, 0.0)
    feed = Feed("valve_voltage", Sine(0.8, 0.5, phase=0.5 * np.pi), linear=False)
    plant = simulate_plant(Setup(THESIS, parameters, state, THESIS.Inputs(0.0, 0.0), 4.0, feeds=(feed,)))
    assert plant.outcome == "completed"
    samples = plant.command.size
    states, _, _ = run(NOMINAL, 0.0, plant.command, np.zeros((samples, 3)), np.zeros(3), SAMPLE_TIME, SUBSTEPS)
    assert np.ptp(states[:, POSITION]) > 5e-3
    load_pressure = states[:, PRESSURE_1] - states[:, PRESSURE_2]
    assert np.max(np.abs(states[:, POSITION] - plant.state("position"))) < 0.01 * NOISE[0]
    assert np.max(np.abs(load_pressure - plant.state("load_pressure"))) < 0.05 * NOISE[1]


@pytest.mark.parametrize(("name", "listed"), ALL)
def test_half_the_step_changes_less_than_the_noise(name: str, listed: bool) -> None:
    rig = true_rig(3, **chosen(name, listed, 1.0))
    coarse, fine = (
        simulate(rig, 3, "fit", substeps=SUBSTEPS * n, noisy=False, duration=15.0).states[:, MEASURED] for n in (1, 2)
    )
    assert np.all(np.sqrt(np.mean((coarse - fine) ** 2, axis=0)) < 0.05 * NOISE)


@pytest.mark.parametrize(("name", "listed"), ALL)
def test_strength(name: str, listed: bool) -> None:
    """Strength 0 is the rig without the effect; 1 is a record that is clearly another, and physical."""
    without, silent, strong = (true_rig(5, {}), *(true_rig(5, **chosen(name, listed, s)) for s in (0.0, 1.0)))
    base, same, other = (simulate(rig, 5, "held_out", duration=20.0) for rig in (without, silent, strong))
    np.testing.assert_array_equal(base.states, same.states)
    check_physical(other, strong)
    shown = [
        np.max(np.abs(base.channels[channel] - other.channels[channel])) / noise
        for channel, noise in zip(("position", "pressure_1", "pressure_2"), NOISE, strict=True)
    ]
    assert max(shown) > 20.0


def test_true_parameters_differ_from_declared_ones() -> None:
    declared = read_parameters(named_sets()[DECLARED])
    rigs = [true_rig(seed, {}) for seed in range(9)]
    for name, spread in SPREAD.items():
        values = np.array([getattr(rig, name) / getattr(NOMINAL, name) for rig in rigs]) - 1.0
        assert 0.3 * spread < np.max(np.abs(values)) <= spread
        known = "valve_flow_gain" if name == "flow_gain" else name
        assert declared[known] == getattr(NOMINAL, name)


def test_the_experiment_is_read(tmp_path: Path) -> None:
    path = make_experiment(tmp_path / "a", {"rotation_periodic_force": 0.5}, seed=7)
    records = read_records(read_experiment(path), None)
    assert [record.use for record in records] == ["fit", "held_out"]
    assert all(record.sample_time == pytest.approx(SAMPLE_TIME) for record in records)
    truth = json.loads((path.parent / "truth.json").read_text())
    assert truth["effects"] == {"rotation_periodic_force": 0.5}
    angle = records[0].channels["rotation_angle"]
    assert np.mean(np.diff(angle)) / SAMPLE_TIME == pytest.approx(truth["rig"]["rotation_speed"], rel=1e-4)
    rig = true_rig(7, {"rotation_periodic_force": 0.5})
    exact = simulate(rig, 7, "fit").states
    for column, channel, noise in zip(MEASURED, ("position", "pressure_1", "pressure_2"), NOISE, strict=True):
        error = records[0].channels[channel] - exact[:, column]
        assert np.std(error) == pytest.approx(noise, rel=0.02)
    again = make_experiment(tmp_path / "b", {"rotation_periodic_force": 0.5}, seed=7)
    assert (again.parent / "fit.parquet").read_bytes() == (path.parent / "fit.parquet").read_bytes()
    assert not np.array_equal(records[0].channels["position"][:1000], records[1].channels["position"][:1000])
