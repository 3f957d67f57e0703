"""Whether effects stand in for what no effect is: a spring that is none, and one that is, on a mass that it holds."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from plants.effects.curves import CURVES
from plants.registry import plants
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.fit import Fit
from workbench.diagnose.selection.sets import Asked
from workbench.diagnose.simulation.fits import Fitting
from workbench.diagnose.simulation.lacking import dependence_of, lacking
from workbench.diagnose.simulation.setup import shooting_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.stand_ins import Place, standing_in
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

DECLARED = read_parameters(named_sets()["owen2001_simulation"])
SPRING, WAY = 2e4, 0.04
"""N/m, of the straight one, and m, within which the mass moves."""

EXPERIMENT = """\
title = "a drive"
[plant]
model = "drive_force"
parameters = "owen2001_simulation"
[channels]
time = { column = "time", unit = "s" }
command = { column = "force", unit = "N" }
position = { column = "position", unit = "m" }
[[records]]
file = "record.parquet"
"""

SPRINGS = {"straight": lambda way: SPRING * way, "hardening": lambda way: SPRING * way**3 / (0.5 * WAY) ** 2}

Found = tuple[Shooting, Fit, Asked]


def found_of(folder: Path, spring: str) -> Found:
    """A mass with a spring, of which a fit has found a straight one."""
    plant = plants()["drive_force"].with_effects(CURVES["force", "position"])
    nodes = np.linspace(-WAY, WAY, 12)
    own = plants()["drive_force"].with_effects(CURVES["force", "position"]).Parameters
    names = CURVES["force", "position"].own_names
    curve = dict(zip(names, [1.0, -WAY, WAY, *(-SPRINGS[spring](nodes))], strict=True))
    parameters = build(own, {**DECLARED, **curve})
    state, inputs = plant.equilibrium(build(own, DECLARED), 0.0)
    feed = Feed(plant.command, Multisine(900.0, 0.5, (1, 2, 3)))
    run = simulate(Setup(plant, parameters, state, inputs, 4.0, feeds=(feed,)))
    position = run.measurements[:, 0] + 5e-6 * np.random.default_rng(1).standard_normal(run.time.size)
    force = run.inputs[:, plant.input_index(plant.command)]
    pd.DataFrame({"time": run.time, "force": force, "position": position}).to_parquet(folder / "record.parquet")
    (folder / "experiment.toml").write_text(EXPERIMENT)
    experiment = read_experiment(folder / "experiment.toml")
    motions = motions_of(experiment, read_records(experiment))
    how = shooting_of(experiment, motions, held=False)
    assert how is not None
    fitting = Fitting(motions, ("coulomb", "viscous", "spring_stiffness"), {})
    fitted = fitting.final(fitting.found(how, {**declared_values(experiment), "spring_stiffness": SPRING}))
    return fitted.how, fitted.fit, Asked(declared_values(experiment), {}, len(how.effects), {})


@pytest.mark.parametrize("price", [6.0, None])
def test_a_curve_does_in_the_place_of_a_spring_that_is_none(tmp_path: Path, price: float | None) -> None:
    how, fitted, ask = found_of(tmp_path, "hardening")
    taken = {"spring_load": ("spring_stiffness",)}
    told = dependence_of(standing_in(how, Place.of(fitted, taken, 1e4, ask), lacking(how, fitted), price))
    assert told is not None
    assert told.gain is not None
    assert told.gain > 1e4, "more than the spring"
    assert (told.balance, told.signals[0]) == ("force", "position")


def test_no_curve_does_in_the_place_of_a_spring(tmp_path: Path) -> None:
    """It would cost more: nothing is left beside the spring that it could gain."""
    how, fitted, ask = found_of(tmp_path, "straight")
    assert fitted.rms == pytest.approx(1.0, abs=0.1)
    taken = {"spring_load": ("spring_stiffness",)}
    for price in (ask.of("spring_load", taken["spring_load"], fitted.balance), 15.0):
        assert standing_in(how, Place.of(fitted, taken, 1e4, ask), lacking(how, fitted), price) == []
