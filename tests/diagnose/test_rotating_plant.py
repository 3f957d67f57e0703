"""A rotating plant is diagnosed by its own equations: an effect of the valve and one of friction, nothing declared."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from diagnoses import balances_with_effects
from support import registered

from controllers import pid
from controllers.pid import PID
from plants.effects.attach import meant
from workbench.diagnose.residual_stage import ResidualStage
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Loop
from workbench.simulation.simulate import simulate

TRUTH = read_parameters(named_sets()["owen2001_simulation"])
CHANNELS = {
    "valve_voltage": "V",
    "position": "m",
    "pressure_1": "Pa",
    "pressure_2": "Pa",
    "rotation_speed": "rad/s",
    "motor_current": "A",
}
NOISE = {"position": 5e-6, "pressure_1": 2e3, "pressure_2": 2e3, "rotation_speed": 2e-3, "motor_current": 1e-3}


def stage_of(folder: Path, effects: dict[str, float], duration: float) -> ResidualStage:
    """The residual stage of so many seconds of a turning rod with these effects."""
    setup = registered("rotating_isotropic", rpm=15.0, duration=duration)
    plant = setup.plant.with_effects(*meant(setup.plant, [*effects]))
    parameters = build(plant.Parameters, {**TRUTH, **effects})
    state, inputs = plant.equilibrium(parameters, 15.0 * 2.0 * np.pi / 60.0 * TRUTH["piston_radius"])
    loop = Loop(PID, PID.design(pid.Settings(kp=200.0), parameters, setup.sample_time))
    reference = Multisine(15e-3, 0.1, (1, 2, 3, 7))
    run = simulate(
        replace(setup, plant=plant, parameters=parameters, state=state, inputs=inputs, loop=loop, reference=reference)
    )
    draw = np.random.default_rng(1)
    columns = {"time": run.time, "valve_voltage": run.command}
    for name, deviation in NOISE.items():
        place = ("position", "pressure_1", "pressure_2", "rotation_speed", "motor_current").index(name)
        columns[name] = run.measurements[:, place] + deviation * draw.standard_normal(run.time.size)
    pd.DataFrame(columns).to_parquet(folder / "record.parquet")
    channels = "\n".join(f'{name} = {{ column = "{name}", unit = "{unit}" }}' for name, unit in CHANNELS.items())
    (folder / "experiment.toml").write_text(
        'title = "a rod that turns"\n[plant]\nmodel = "rotating_isotropic"\nparameters = "owen2001_simulation"\n'
        f'[channels]\ntime = {{ column = "time", unit = "s" }}\n{channels}\n[[records]]\nfile = "record.parquet"\n'
    )
    return balances_with_effects(folder / "experiment.toml")


def named(stage: ResidualStage) -> dict[str, dict[str, float]]:
    """What was added, by effect, with the numbers of the last fit."""
    return {
        effect: {name: result.after.values[name] for name in names}
        for result in stage.results
        for effect, names in result.effects.items()
    }


@pytest.mark.thorough
def test_a_valve_s_overlap_and_friction_along_the_stroke_are_named(tmp_path: Path) -> None:
    stage = stage_of(tmp_path, {"valve_overlap": 1e-5, "friction_curvature": 0.8}, 10.0)
    added = named(stage)
    assert set(added) == {"valve_deadband", "position_dependent_friction"}
    assert added["valve_deadband"]["valve_overlap"] == pytest.approx(1e-5, rel=2e-3)
    assert added["position_dependent_friction"]["friction_curvature"] == pytest.approx(0.8, rel=0.2)
    assert [result.balance.name for result in stage.results] == ["flow", "force", "rotation"]


def test_a_rotating_plant_without_effects_is_left_alone(tmp_path: Path) -> None:
    stage = stage_of(tmp_path, {}, 8.0)
    assert named(stage) == {}
    assert all(dependence is None for dependence in stage.dependences)
