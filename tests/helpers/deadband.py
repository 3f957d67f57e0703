"""Records of a valve with overlap, and the experiment that diagnoses them: tests of its report share both."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
from command import write
from experiments import CHANNELS, TRUTH, save_record

from plants.registry import CHAMBERS
from workbench.fitting.replay import Sampled
from workbench.parameters.sets import build
from workbench.simulation.references import Multisine
from workbench.simulation.simulate import Feed, Setup, simulate

OVERLAP = 1e-5
"""m. Half of what the valve's voltage moves the spool by in these records."""

EXPERIMENT = f"""\
title = "a valve with overlap"
[plant]
model = "non_rotating"
parameters = "owen2001_experiment"
{CHANNELS}[[records]]
file = "fit.parquet"
[[records]]
file = "other.parquet"
use = "held_out"
"""


def make_record(folder: Path, name: str, effect: Mapping[str, float], amplitude: float, seed: int) -> None:
    """10 s in both directions, with white noise and a voltage that a computer holds from sample to sample."""
    parameters = build(CHAMBERS.Parameters, {**TRUTH, **effect})
    state, _ = CHAMBERS.equilibrium(parameters, 0.0)
    time = 1e-3 * np.arange(10_001)
    voltage = Sampled(time, Multisine(amplitude, 0.2, (1, 2, 3, 5))(time)[0])
    feed = Feed("valve_voltage", voltage, linear=False)
    run = simulate(Setup(CHAMBERS, parameters, state, CHAMBERS.Inputs(0.0, 0.0), 10.0, feeds=(feed,)))
    save_record(folder / f"{name}.parquet", run, seed)


def make_experiment(folder: Path) -> Path:
    """The experiment file, with its records beside it."""
    make_record(folder, "fit", {"valve_overlap": OVERLAP}, 0.6, 1)
    make_record(folder, "other", {"valve_overlap": OVERLAP}, 0.5, 2)
    return write(folder, EXPERIMENT, "experiment.toml")
