"""A record that begins with a rod that rests under pressures which a closed valve holds."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command import write
from experiments import CHANNELS, identify, save_record

from plants.equation import replaced
from plants.registry import plants
from workbench.fitting.replay import Sampled, observe
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Feed, Integrator, Setup
from workbench.simulation.simulate import simulate

EXPERIMENT = f"""\
title = "from a held rest"
[plant]
model = "non_rotating"
parameters = "owen2001_simulation"
[fit]
free = ["coulomb"]
{CHANNELS}[[records]]
file = "record.parquet"
"""

HELD = 3e5
"""Pa between the chambers: half of what breaks the rod away."""


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The thesis's rig moved by its valve after half a second of rest, its friction 1.15 times as declared."""
    made = tmp_path_factory.mktemp("held")
    plant, values = plants()["two_chamber"], read_parameters(named_sets()["owen2001_simulation"])
    values = {**values, "coulomb": 1.15 * values["coulomb"]}
    parameters = build(plant.Parameters, values)
    state, inputs = plant.equilibrium(parameters, 0.0)
    first = {"pressure_1": state.pressure_1 + 0.5 * HELD, "pressure_2": state.pressure_2 - 0.5 * HELD}
    carried = HELD * values["piston_area_1"] / values["bristle_stiffness"]
    state = replaced(state, {**first, "bristle_deflection": carried})
    time = 1e-3 * np.arange(3001)
    command = np.where(time > 0.5, Multisine(1.5, 0.5, (1, 2, 3))(time - 0.5)[0], 0.0)
    feed = Feed(plant.command, Sampled(time, command), linear=False)
    run = simulate(Setup(plant, parameters, state, inputs, 3.0, feeds=(feed,), integrator=Integrator(tolerance=1e-9)))
    save_record(made / "record.parquet", run, 4)
    write(made, EXPERIMENT, "experiment.toml")
    return made


def test_the_simulation_begins_as_the_record_does(folder: Path) -> None:
    experiment = read_experiment(folder / "experiment.toml")
    seen = observe(read_records(experiment)[0], experiment)
    shown = seen.predicted(experiment, {})
    assert shown is not None
    rest = seen.time < 0.4
    for name in ("pressure_1", "pressure_2"):
        assert np.max(np.abs(shown[name] - seen.measured[name])[rest]) < 5e3, "Pa, of 300 kPa that are held"
    assert np.ptp(shown["position"][rest]) < 1e-6, "it rests"


def test_several_parameters_together_show_the_same_bits(folder: Path) -> None:
    """Whether the first integrator or a later one serves them, or none does."""
    experiment = read_experiment(folder / "experiment.toml")
    seen = observe(read_records(experiment)[0], experiment)
    stiff, soft = {"bristle_stiffness": 2e9}, {"bristle_stiffness": 1e7}
    several: list[dict[str, float]] = [{}, {"coulomb": 300.0}, stiff, soft, {"viscous": 900.0}, {"bulk_modulus": 5e8}]
    fixed = replace(seen, integrators=seen.integrators[:1])
    for one in (seen, fixed):
        alone = [one.predicted(experiment, changes) for changes in several]
        for found, other in zip(one.predicted_each(experiment, several), alone, strict=True):
            assert (found is None) == (other is None)
            for name in found or {}:
                np.testing.assert_array_equal(found[name], other[name])
    assert fixed.predicted(experiment, stiff) is None, "fixed steps are too long for it"
    assert seen.predicted(experiment, stiff) is not None


def test_friction_is_found_from_a_held_rest(folder: Path) -> None:
    assert identify(folder, EXPERIMENT, "simulation").code == 0
    found = json.loads((folder / "out/identified.json").read_text(encoding="utf-8"))
    one = found["parameters"]["coulomb"]
    assert abs(one["simulation"]["value"] - 1.15 * one["declared"]) < 4.0 * one["simulation"]["std"]
    assert one["simulation"]["std"] < 0.2 * one["declared"]


def test_pressures_that_no_contact_holds_are_not_begun_with(folder: Path) -> None:
    """A sensor's offset: the rod rests, as it did before that was looked at."""
    experiment = read_experiment(folder / "experiment.toml")
    (record,) = read_records(experiment)
    off = replace(record, channels={**record.channels, "pressure_1": record.channels["pressure_1"] + 10.0 * HELD})
    lost = record.channels["pressure_1"].copy()
    lost[:20] = np.nan
    for spoiled in (off, replace(record, channels={**record.channels, "pressure_1": lost})):
        state = observe(spoiled, experiment).setup.state
        assert state.load_pressure == pytest.approx(0.0), "balanced"
