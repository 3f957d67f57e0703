"""A loop moves a plant by its sensors' noise: means over samples take that for an effect, and all samples do not."""

from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest
from command import write
from driven import TRUE
from experiments import CHANNELS

from controllers import pid
from controllers.pid import PID
from plants.effects.registry import effects
from plants.interface import Measurement
from plants.registry import CHAMBERS
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.selection.search import Found, search
from workbench.diagnose.simulation.fits import Fitting
from workbench.diagnose.simulation.reached import SimulationStart, asked_of
from workbench.diagnose.simulation.setup import shooting_of
from workbench.parameters.sets import build
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.reading import read_records
from workbench.simulation.references import Steps
from workbench.simulation.sensors import Channel, Sensors
from workbench.simulation.setup import Integrator, Loop, Setup
from workbench.simulation.simulate import simulate

EXPERIMENT = f"""\
title = "a rod that a loop holds where it is"
[plant]
model = "two_chamber"
parameters = "owen2001_simulation"
{CHANNELS}[[records]]
file = "record.parquet"
"""

NOISE = {"position": 5e-6, "pressure_1": 2e3, "pressure_2": 2e3}


def held(folder: Path, width: float, seed: int) -> Experiment:
    """40 s of P control at 200 V/m, which sees the noise of the position, over steps between which the rod rests; with
    a backlash of some `width` (m).
    """
    plant = CHAMBERS.with_effects(effects("m")["backlash"])
    parameters = build(plant.Parameters, {**TRUE, "backlash_width": width})
    loop = Loop(PID, PID.design(pid.Settings(kp=200.0), parameters, 1e-3))
    steps = Steps((0.0, 3e-3, -6e-3, 8e-3, 7e-3, -2e-3, 1e-3, 4e-3), 5.0)
    sensors = Sensors({name: Channel(noise=noise) for name, noise in NOISE.items()})
    exact = Integrator(tolerance=1e-9)
    start = plant.equilibrium(parameters, 0.0)
    run = simulate(Setup(plant, parameters, *start, 40.0, loop, steps, sensors=sensors, integrator=exact, seed=seed))
    shown = {name: run.measurements[:, Measurement._fields.index(name)] for name in NOISE}
    pd.DataFrame({"time": run.time, "valve_voltage": run.command, **shown}).to_parquet(folder / "record.parquet")
    return read_experiment(write(folder, EXPERIMENT, "experiment.toml"))


def sought(experiment: Experiment, all_samples: bool) -> Found:
    """A search for a backlash on the plant that is as it is declared, of which `all_samples` may have to show it."""
    motions = motions_of(experiment, read_records(experiment))
    how, values = shooting_of(experiment, motions), declared_values(experiment)
    assert how is not None
    fitting = Fitting(motions, ("coulomb",), {})
    base = fitting.final(fitting.begun(replace(how, effects=("backlash",)).with_tolerance(1e-7), values))
    start = SimulationStart(fitting.names, values, values, values, {}, {})
    ask = replace(asked_of(base.how, motions, start, {}), candidates=20)
    return search(base.fit, {}, ask if all_samples else replace(ask, shown=None, all_samples=None))


def test_what_a_loop_makes_of_noise_is_no_effect(tmp_path: Path) -> None:
    experiment = held(tmp_path, 0.0, 3)
    assert list(sought(experiment, all_samples=False).effects) == ["backlash"], "means over 10 samples show one"
    assert not sought(experiment, all_samples=True).effects


@pytest.mark.thorough
def test_what_is_there_all_samples_show_as_well(tmp_path: Path) -> None:
    found = sought(held(tmp_path, 1e-6, 1), all_samples=True)
    assert list(found.effects) == ["backlash"]
    assert found.fit.values["backlash_width"] == pytest.approx(1e-6, abs=4.0 * found.fit.deviations["backlash_width"])
