"""The same record on a machine of another size: other units of mass, length and time change no verdict."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from rescaled import rescaled

from plants.equation import fields
from plants.registry import plants
from workbench.diagnose.diagnose import diagnose
from workbench.diagnose.result import Diagnosis
from workbench.fitting.replay import Sampled
from workbench.parameters.sets import build, known_units, named_sets, read_parameters
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

STIFFNESS = 2e4
"""N/m: of a spring that nobody declared."""

NOISE, FORCE, DURATION = 5e-6, 900.0, 4.0
"""m, N, s."""

EXPERIMENT = """\
title = "a drive"
[plant]
model = "drive_force"
parameters = "declared.toml"
[channels]
time = { column = "time", unit = "s" }
command = { column = "force", unit = "N" }
position = { column = "position", unit = "m" }
[[records]]
file = "record.parquet"
"""


def made(folder: Path, stiffness: float) -> Path:
    """4 s of a mass that a force drives, maybe against a spring; the friction is declared 1.5 times too
    large.
    """
    plant = plants()["drive_force"]
    truth = {**read_parameters(named_sets()["owen2001_simulation"]), "spring_stiffness": stiffness}
    parameters = build(plant.Parameters, truth)
    state, inputs = plant.equilibrium(parameters, 0.0)
    time = 1e-3 * np.arange(round(1e3 * DURATION) + 1)
    feed = Feed(plant.command, Sampled(time, Multisine(FORCE, 0.5, (1, 2, 3))(time)[0]))
    run = simulate(Setup(plant, parameters, state, inputs, DURATION, feeds=(feed,)))
    noise = NOISE * np.random.default_rng(1).standard_normal(run.time.size)
    force = run.inputs[:, plant.input_index(plant.command)]
    frame = pd.DataFrame({"time": run.time, "force": force, "position": run.measurements[:, 0] + noise})
    frame.to_parquet(folder / "record.parquet", index=False)
    declared = {**truth, "coulomb": 1.5 * truth["coulomb"], "spring_stiffness": 0.0}
    own, units = {item.name for item in fields(plant.Parameters)}, known_units(plant.axis)
    lines = ['title = "a drive"', 'source = "made up"']
    for name, value in declared.items():
        if name in own:
            lines += [f"[parameters.{name}]", f'value = "{value!r} {units[name]}"', 'source = "made up"']
    (folder / "declared.toml").write_text("\n".join(lines) + "\n")
    (folder / "experiment.toml").write_text(EXPERIMENT)
    return folder / "experiment.toml"


def found(diagnosis: Diagnosis) -> tuple[str, list[str]]:
    return diagnosis.verdict, [effect.name for effect in diagnosis.effects]


LARGE = {"mass": 1e3, "length": 20.0}
SLOW = {"time": 3.0}
SMALL = {"mass": 1e-3, "length": 0.05}


@pytest.mark.parametrize("scale", [{**LARGE, **SLOW}, SMALL], ids=["large and slow", "small"])
def test_a_spring_is_found_on_a_machine_of_any_size(scale: dict[str, float], tmp_path: Path) -> None:
    diagnosis = diagnose(rescaled(made(tmp_path, STIFFNESS), tmp_path / "rescaled", **scale))
    assert found(diagnosis) == ("effect_found", ["spring_load"])
    stiffness = STIFFNESS * scale.get("mass", 1.0) / scale.get("time", 1.0) ** 2
    estimate = diagnosis.effects[0].parameters["spring_stiffness"]
    assert estimate.value == pytest.approx(stiffness, rel=1e-4)
    assert abs(estimate.value - stiffness) < 3.0 * estimate.std


def test_nothing_is_found_on_a_complete_machine_of_another_size(tmp_path: Path) -> None:
    path = rescaled(made(tmp_path, 0.0), tmp_path / "rescaled", **SMALL, **SLOW)
    assert found(diagnose(path)) == ("none_missing", [])
