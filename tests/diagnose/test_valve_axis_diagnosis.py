"""An axis whose velocity follows a voltage, on which no force acts: what it lacks is looked for in its command."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from declared_parameters import write_declared

from plants.valve_axis import VALVE_AXIS
from workbench.diagnose.diagnose import diagnose
from workbench.fitting.replay import Sampled
from workbench.parameters.sets import build
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

TRUE = {
    "velocity_gain": 0.05,
    "dead_band": 1.0,
    "command_delay": 0.15,
    "velocity_gain_negative": 0.03,
    "dead_band_negative": 0.6,
    "command_delay_negative": 0.03,
    "axis_time_constant": 0.08,
    "drift_velocity": -0.002,
    "voltage_limit": 10.0,
    "stroke": 10.0,
}
NOISE = 1e-4
"""m: of the position."""

EXPERIMENT = """\
title = "an axis"
[plant]
model = "valve_axis"
parameters = "declared.toml"
[channels]
time = {column = "time", unit = "s"}
valve_voltage = {column = "voltage", unit = "V"}
position = {column = "position", unit = "m"}
[[records]]
file = "record.parquet"
"""


def axis_experiment(folder: Path, bent: float) -> Path:
    """40 s of an axis whose valve got the logged voltage `bent` by a share of itself, to and fro over its range; its
    gain is declared 1.3 times too large.
    """
    parameters = build(VALVE_AXIS.Parameters, TRUE)
    state, inputs = VALVE_AXIS.equilibrium(parameters, 0.0)
    time = 1e-2 * np.arange(4001)
    logged = np.clip(Multisine(5.0, 0.2, (1, 2, 3))(time)[0], -TRUE["voltage_limit"], TRUE["voltage_limit"])
    got = logged * (1.0 + bent * np.sin(2.0 * np.pi * logged / np.max(logged)))
    feed = Feed("valve_voltage", Sampled(time, got), linear=False)
    run = simulate(Setup(VALVE_AXIS, parameters, state, inputs, float(time[-1]), feeds=(feed,), sample_time=1e-2))
    position = run.measurements[:, 0] + NOISE * np.random.default_rng(1).standard_normal(run.time.size)
    frame = pd.DataFrame({"time": run.time, "voltage": logged, "position": position})
    frame.to_parquet(folder / "record.parquet", index=False)
    declared = {**TRUE, "velocity_gain": 1.3 * TRUE["velocity_gain"]}
    write_declared(folder / "declared.toml", VALVE_AXIS, declared)
    (folder / "experiment.toml").write_text(EXPERIMENT, encoding="utf-8")
    return folder / "experiment.toml"


@pytest.mark.thorough
def test_what_bends_its_command_is_told_on_its_own_balance(tmp_path: Path) -> None:
    diagnosis = diagnose(axis_experiment(tmp_path, 0.05))
    assert diagnosis.verdict == "unexplained"
    assert diagnosis.unexplained is not None
    assert diagnosis.unexplained.balance == "velocity"
    assert "valve_voltage" in diagnosis.unexplained.dependence.signals
