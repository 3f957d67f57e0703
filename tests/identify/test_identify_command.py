"""What a command does between its samples: a computer holds it, and a fit that draws lines there is off."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from declared_parameters import write_declared
from driven import EXPERIMENT, FORCE, TRUE

from plants.registry import plants
from workbench.fitting.replay import Sampled
from workbench.identify.identification import identify
from workbench.identify.simulation.method import AS_HELD
from workbench.parameters.sets import build
from workbench.records.experiment import read_experiment
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

SAMPLE_TIME, DURATION, NOISE = 5e-3, 4.0, 2e-6

FREE = '[fit]\nmethod = "simulation"\nfree = ["mass", "coulomb", "viscous"]\n'


@pytest.mark.parametrize("held", [True, False], ids=["a computer's", "a signal's"])
def test_a_fit_finds_whether_a_command_is_held(held: bool, tmp_path: Path) -> None:
    """A rough force on a mass, whose position drifts as far as its command is off between two samples."""
    plant, truth = plants()["drive_force"], {**TRUE, "stroke": 1.0}
    parameters = build(plant.Parameters, truth)
    state, inputs = plant.equilibrium(parameters, 0.0)
    time, draw = SAMPLE_TIME * np.arange(round(DURATION / SAMPLE_TIME) + 1), np.random.default_rng(3)
    force = Multisine(FORCE, 0.5, (1, 2, 3))(time)[0] + 0.2 * FORCE * draw.standard_normal(time.size)
    feed = Feed(plant.command, Sampled(time, force), not held)
    run = simulate(Setup(plant, parameters, state, inputs, DURATION, feeds=(feed,), sample_time=SAMPLE_TIME))
    position = run.measurements[:, 0] + NOISE * draw.standard_normal(time.size)
    pd.DataFrame({"time": time, "force": force, "position": position}).to_parquet(tmp_path / "record.parquet")
    write_declared(tmp_path / "declared.toml", plant, {**truth, "mass": 1.1 * TRUE["mass"]})
    path = tmp_path / "experiment.toml"
    path.write_text(EXPERIMENT.format(channel="command").replace("[channels]", f"{FREE}[channels]"), encoding="utf-8")
    fitted = identify(read_experiment(path)).simulation
    assert fitted is not None
    assert (AS_HELD in fitted.notes) is held
    assert not fitted.refuted
    for name in ("mass", "coulomb", "viscous"):
        found = fitted.estimates[name]
        assert abs(found.value - TRUE[name]) < 3.0 * found.std < 0.02 * TRUE[name], name
