"""A mass that nothing leads: what its command does between samples, and what declared deviations make of its way."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from declared_parameters import write_declared
from driven import EXPERIMENT, FORCE, TRUE

from plants.registry import plants
from workbench.fitting.replay import Sampled
from workbench.identify.identification import identify
from workbench.identify.simulation.found import SimulationFit
from workbench.identify.simulation.method import AS_HELD
from workbench.parameters.sets import build
from workbench.records.experiment import read_experiment
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

SAMPLE_TIME, DURATION, NOISE = 5e-3, 2.0, 2e-6

FREE = '[fit]\nmethod = "simulation"\nfree = ["mass", "coulomb", "viscous"]\n'


def _experiment(folder: Path, truth: Mapping[str, float], off: Mapping[str, float], held: bool = True) -> Path:
    """An experiment with the record of a rough force on a mass of that `truth`; declared is what is `off`, too."""
    plant = plants()["drive_force"]
    parameters = build(plant.Parameters, truth)
    state, inputs = plant.equilibrium(parameters, 0.0)
    time, draw = SAMPLE_TIME * np.arange(round(DURATION / SAMPLE_TIME) + 1), np.random.default_rng(3)
    force = Multisine(FORCE, 0.5, (1, 2, 3))(time)[0] + 0.2 * FORCE * draw.standard_normal(time.size)
    feed = Feed(plant.command, Sampled(time, force), not held)
    run = simulate(Setup(plant, parameters, state, inputs, DURATION, feeds=(feed,), sample_time=SAMPLE_TIME))
    position = run.measurements[:, 0] + NOISE * draw.standard_normal(time.size)
    pd.DataFrame({"time": time, "force": force, "position": position}).to_parquet(folder / "record.parquet")
    write_declared(folder / "declared.toml", plant, {**truth, **off})
    path = folder / "experiment.toml"
    text = EXPERIMENT.format(channel="command").replace("[channels]", f"{FREE}[channels]")
    path.write_text(text, encoding="utf-8")
    return path


@pytest.mark.parametrize("held", [True, False], ids=["a computer's", "a signal's"])
def test_a_fit_finds_whether_a_command_is_held(held: bool, tmp_path: Path) -> None:
    """A rough force on a mass, whose position drifts as far as its command is off between two samples."""
    path = _experiment(tmp_path, {**TRUE, "stroke": 1.0}, {"mass": 1.1 * TRUE["mass"]}, held=held)
    fitted = fit(path)
    assert (AS_HELD in fitted.notes) is held
    assert not fitted.refuted
    for name in ("mass", "coulomb", "viscous"):
        found = fitted.estimates[name]
        assert abs(found.value - TRUE[name]) < 3.0 * found.std < 0.02 * TRUE[name], name


def test_a_machine_as_it_is_declared_is_not_refuted(tmp_path: Path) -> None:
    """Friction that is held is off by its declared deviations: so far that a mass that nothing leads ends elsewhere
    than first order says, which is no fault of the plant.
    """
    off = {"stribeck": 0.6 * TRUE["stribeck"], "bristle_stiffness": 1.4 * TRUE["bristle_stiffness"]}
    path = _experiment(tmp_path, {**TRUE, "stroke": 1.0}, off)
    assert fit(path).refuted, "nothing says that they may be off"
    text = (tmp_path / "declared.toml").read_text(encoding="utf-8")
    for name, unit in (("stribeck", "N"), ("bristle_stiffness", "N/m")):
        text = text.replace(
            f"[parameters.{name}]\n", f'[parameters.{name}]\nstd = "{abs(off[name] - TRUE[name])!r} {unit}"\n'
        )
    (tmp_path / "declared.toml").write_text(text, encoding="utf-8")
    found = fit(path)
    assert not found.refuted
    for name, each in found.estimates.items():
        assert abs(each.value - TRUE[name]) < 3.0 * each.std, name


def fit(path: Path) -> SimulationFit:
    """The fit by simulation."""
    found = identify(read_experiment(path)).simulation
    assert found is not None
    return found
