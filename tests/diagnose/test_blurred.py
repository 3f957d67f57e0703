"""A quick machine that is sampled slowly is looked at sample by sample: means lose what its parameters change."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from plants.registry import plants
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.fit import AS_IT_IS, Fit, fit
from workbench.diagnose.simulation.setup import KEPT, as_quick, blurs, shooting_of
from workbench.fitting.replay import Sampled
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

STEP, DURATION = 4e-3, 6.0
"""s between samples, and of the record."""

NOISE = {"position": 5e-6, "pressure_1": 2e3, "pressure_2": 2e3}
"""m, Pa."""

NAMES = ("valve_flow_gain", "bulk_modulus", "coulomb", "viscous")

EXPERIMENT = """\
title = "a cylinder"
[plant]
model = "non_rotating"
parameters = "owen2001_simulation"
[channels]
time = { column = "time", unit = "s" }
valve_voltage = { column = "voltage", unit = "V" }
position = { column = "position", unit = "m" }
pressure_1 = { column = "pressure_1", unit = "Pa" }
pressure_2 = { column = "pressure_2", unit = "Pa" }
[[records]]
file = "record.parquet"
"""


def experiment(folder: Path, jumps: float) -> Path:
    """That of a cylinder whose voltage swings slowly, and jumps (V) from sample to sample."""
    plant = plants()["non_rotating"]
    parameters = build(plant.Parameters, read_parameters(named_sets()["owen2001_simulation"]))
    state, inputs = plant.equilibrium(parameters, 0.0)
    draw, time = np.random.default_rng(4), STEP * np.arange(round(DURATION / STEP) + 1)
    voltage = Multisine(0.3, 0.5, (1, 2, 3))(time)[0] + jumps * draw.standard_normal(time.size)
    feed = Feed(plant.command, Sampled(time, voltage), linear=False)
    run = simulate(Setup(plant, parameters, state, inputs, DURATION, feeds=(feed,), sample_time=STEP))
    shown = {
        name: run.measurements[:, place] + noise * draw.standard_normal(time.size)
        for place, (name, noise) in enumerate(NOISE.items())
    }
    pd.DataFrame({"time": time, "voltage": voltage, **shown}).to_parquet(folder / "record.parquet", index=False)
    path = folder / "experiment.toml"
    path.write_text(EXPERIMENT, encoding="utf-8")
    return path


@pytest.mark.parametrize(("jumps", "quick"), [(0.0, False), (1.0, True)])
def test_means_that_lose_what_parameters_change_are_told(tmp_path: Path, jumps: float, quick: bool) -> None:
    known = read_experiment(experiment(tmp_path, jumps))
    motions, values = motions_of(known, read_records(known)), declared_values(known)
    how = shooting_of(known, motions)
    assert how is not None
    assert motions[0].thinning > 1
    means, samples = (fit(how.balance(one, ()), values, NAMES, search=AS_IT_IS) for one in (motions, as_quick(motions)))
    for name, place in zip(NOISE, samples.balance.series[0], strict=True):
        left = float(np.std(samples.residual[place])) * motions[0].sensed[name]
        assert left == pytest.approx(NOISE[name], rel=0.1), "noise alone, whatever it was taken for"
    assert blurs(how, means) is quick
    assert not blurs(how, samples), "there is nothing finer"
    assert bool(np.median(informed(means) / informed(samples)) < KEPT) is quick


def informed(fitted: Fit) -> np.ndarray:
    """What the parameters change of all channels, in the noise of each: squares, shape (parameters,)."""
    (places,) = fitted.balance.series
    sizes = [np.sum(fitted.changes[place] ** 2, axis=0) / np.var(fitted.residual[place]) for place in places]
    return np.asarray(np.sum(sizes, axis=0))
