"""Experiments as tests of identification and diagnosis share them: their files, records, and the command on them."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
from command import Answer, workbench, write

from plants.registry import THESIS
from workbench.identify.thesis import method as thesis_method
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.references import Multisine
from workbench.simulation.simulate import Feed, Run, Setup, simulate

TRUTH = dict(read_parameters(named_sets()["owen2001_experiment"]))

CHANNELS = """\
[channels]
time = { column = "time", unit = "s" }
valve_voltage = { column = "valve_voltage", unit = "V" }
position = { column = "position", unit = "m" }
pressure_1 = { column = "pressure_1", unit = "Pa" }
pressure_2 = { column = "pressure_2", unit = "Pa" }
"""
"""Of a record as `save_record` and `axial_record` write it."""


def save_record(path: Path, run: Run, seed: int) -> None:
    """A run as a rig would have recorded it, with white noise: 5 um and 2 kPa."""
    noise = np.random.default_rng(seed).standard_normal((3, run.time.size))
    deviations = {"position": 5e-6, "pressure_1": 2e3, "pressure_2": 2e3}
    noisy = {name: run.signals[name] + std * e for (name, std), e in zip(deviations.items(), noise, strict=True)}
    pd.DataFrame({"time": run.time, "valve_voltage": run.command, **noisy}).to_parquet(path)


def identify(folder: Path, text: str, method: str | None = None) -> Answer:
    """The command on an experiment of this text, by its own method or by another one."""
    options = [] if method is None else ["--method", method]
    return workbench("identify", write(folder, text, "experiment.toml"), "--out", folder / "out", *options)


# --- a record of both directions ---

EXPERIMENT = f"""\
title = "a simulated record"
[plant]
model = "non_rotating"
parameters = "owen2001_experiment"
[plant.scale]
SCALE
[fit]
free = [FREE]
{CHANNELS}[[records]]
file = "record.parquet"
[truth]
parameters = "owen2001_experiment"
"""


def make_record(folder: Path, *, duration: float = 4.0) -> None:
    """A record of both directions at up to 0.012 m/s, with white noise."""
    parameters = build(THESIS.Parameters, TRUTH)
    state, _ = THESIS.equilibrium(parameters, 0.0)
    feed = Feed("valve_voltage", Multisine(0.6, 0.25, (1, 2, 3)))
    run = simulate(Setup(THESIS, parameters, state, THESIS.Inputs(0.0, 0.0), duration, feeds=(feed,)))
    save_record(folder / "record.parquet", run, seed=7)


def experiment_text(scale: Mapping[str, float], free: list[str]) -> str:
    """The experiment with a declared plant that is wrong by these factors."""
    lines = "\n".join(f"{name} = {value}" for name, value in scale.items())
    return EXPERIMENT.replace("SCALE", lines).replace("FREE", ", ".join(f'"{name}"' for name in free))


# --- slow extensions at speeds of rotation ---

AREA = 2.66e-3
TIME = 1e-3 * np.arange(30_000)
CURVE = {"coulomb": 330.0, "stribeck": 150.0, "viscous": 22800.0, "stribeck_velocity": 0.0024}
LINE = {"coulomb": 40.0, "stribeck": 0.0, "viscous": 30000.0, "stribeck_velocity": 1.0}

AXIAL = f"""\
title = "two speeds"
[plant]
model = "non_rotating"
parameters = "owen2001_experiment"
[fit]
method = "thesis"
{CHANNELS}[[records]]
file = "run_*.parquet"
rpm = "rpm"
[[published]]
table = "printed"
title = "printed"
source = "a book"
note = "a remark"
direction = "forward"
rpm = [0, 25]
values = {{ coulomb = [300, 0], static = [450, nan], stribeck_velocity = [0.002, 0.003] }}
std = {{ coulomb = [30, nan] }}
[[figures]]
name = "at_25"
title = "at 25 rpm"
rpm = 25
[[figures]]
name = "over_rpm"
title = "over rpm"
parameter = "static"
"""


def axial_record(path: Path, law: Mapping[str, float], rpm: float) -> None:
    """A slow extension on the exact steady curve, with 10 N of noise."""
    velocity = 0.0114 * (TIME / TIME[-1]) ** 2
    noise = 10.0 * np.random.default_rng(int(rpm)).standard_normal(TIME.size)
    load = (thesis_method.steady(velocity, **law) + noise) / AREA
    position = np.cumsum(velocity) * 1e-3 - 0.057
    data = {"time": TIME, "valve_voltage": 0.3 * TIME, "position": position, "rpm": rpm}
    pd.DataFrame({**data, "pressure_1": 2.4e6 + load / 2.0, "pressure_2": 2.4e6 - load / 2.0}).to_parquet(path)
