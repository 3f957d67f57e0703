"""Records of a mass that a force drives, maybe against a spring that nobody declared, and their experiment."""

from collections.abc import Mapping
from pathlib import Path
from types import MappingProxyType

import numpy as np
import pandas as pd
from declared_parameters import write_declared

from plants.effects.attach import meant
from plants.registry import plants
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.simulation.setup import shooting_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.fitting.replay import Sampled
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

TRUE = read_parameters(named_sets()["owen2001_simulation"])
"""Of the mass and its friction."""

NOTHING: Mapping[str, float] = MappingProxyType({})

FORCE = 900.0
"""N: amplitude."""

EXPERIMENT = """\
title = "a drive"
[plant]
model = "drive_force"
parameters = "declared.toml"
[channels]
time = {{ column = "time", unit = "s" }}
{channel} = {{ column = "force", unit = "N" }}
position = {{ column = "position", unit = "m" }}
[[records]]
file = "record.parquet"
"""


def driven_experiment(
    folder: Path,
    stiffness: float,
    noise: float,
    duration: float,
    sensor: float | None = None,
    stroke: float = TRUE["stroke"],
    acting: Mapping[str, float] = NOTHING,
    seed: int = 1,
) -> Path:
    """An experiment of `duration` (s) with a spring (N/m) and noise of the position (m); the force is a command, or
    what a `sensor` with noise (N) shows; the `stroke` is in m. The friction is declared 1.5 times too large, and what
    else is `acting` not at all.
    """
    bare = plants()["drive_force"]
    plant = bare.with_effects(*meant(bare, list(acting)))
    truth = {**TRUE, "spring_stiffness": stiffness, "stroke": stroke, **acting}
    parameters = build(plant.Parameters, truth)
    state, inputs = plant.equilibrium(parameters, 0.0)
    time = 1e-3 * np.arange(round(1e3 * duration) + 1)
    feed = Feed(plant.command, Sampled(time, Multisine(FORCE, 0.5, (1, 2, 3))(time)[0]))
    run = simulate(Setup(plant, parameters, state, inputs, duration, feeds=(feed,)))
    draw = np.random.default_rng(seed)
    position = run.measurements[:, 0] + noise * draw.standard_normal(run.time.size)
    shown = run.inputs[:, plant.input_index(plant.command)] + (sensor or 0.0) * draw.standard_normal(run.time.size)
    frame = pd.DataFrame({"time": run.time, "force": shown, "position": position})
    frame.to_parquet(folder / "record.parquet", index=False)
    declared = {**truth, "coulomb": 1.5 * truth["coulomb"], "spring_stiffness": 0.0}
    write_declared(folder / "declared.toml", bare, declared)
    path = folder / "experiment.toml"
    path.write_text(EXPERIMENT.format(channel="command" if sensor is None else "force"), encoding="utf-8")
    return path


def driven_shooting(
    folder: Path, noise: float, duration: float, acting: Mapping[str, float] = NOTHING
) -> tuple[Shooting, list[Motion], dict[str, float]]:
    """How a mass that no spring holds is simulated along such a record, the record's motion, and what is declared."""
    experiment = read_experiment(driven_experiment(folder, 0.0, noise, duration, stroke=1.0, acting=acting))
    motions = motions_of(experiment, read_records(experiment))
    how = shooting_of(experiment, motions, held=False)  # the force of this record is no computer's
    assert how is not None
    return how, motions, declared_values(experiment)
