"""A machine far from noise by what no effect is: a curve of its balance leads the simulated one to its records."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from diagnoses import balances_with_effects
from experiments import CHANNELS, save_record

from controllers.pid import PID, Settings
from plants.effects.attach import meant
from plants.effects.curves import CURVES
from plants.registry import plants
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residual_stage import ResidualStage, baselines, with_floors
from workbench.diagnose.residuals.fit import NEAR_NOISE
from workbench.diagnose.selection.balance_curves import curve_of, fitted_curve
from workbench.diagnose.selection.selection import BalanceResult
from workbench.diagnose.simulation.by_curve import curved, in_its_place
from workbench.diagnose.simulation.fits import Fitting, Simulated
from workbench.diagnose.simulation.reached import simulated_baseline
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.progress import silent
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.reading import read_records
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Loop, Setup
from workbench.simulation.simulate import simulate

TRUE = {**read_parameters(named_sets()["owen2001_simulation"]), "viscous": 2000.0}

PLACE, WIDTH, WAY = 4e-3, 4e-3, 15e-3
"""m: of a force at one place, how wide that is, and to either side of what its curve goes."""

STEP = 2e-3
"""s."""

EXPERIMENT = f"""\
title = "a force at a place"
[plant]
model = "non_rotating"
parameters = "owen2001_simulation"
{CHANNELS}[[records]]
file = "record.parquet"
"""


def machine(
    folder: Path, acting: Mapping[str, float], *, searched: bool = True
) -> tuple[Experiment, ResidualStage, Simulated]:
    """An actuator on which more acts than is declared, the balances of its record, in which effects are `searched` or
    not, and it simulated without that.
    """
    bare = plants()["two_chamber"]
    plant = bare.with_effects(*meant(bare, list(acting)))
    parameters = build(plant.Parameters, {**TRUE, **acting})
    state, inputs = plant.equilibrium(parameters, 0.0)
    loop = Loop(PID, PID.design(Settings(kp=200.0), parameters, STEP))
    motion = Multisine(WAY, 0.1, (1, 3, 7))
    run = simulate(Setup(plant, parameters, state, inputs, 10.0, loop=loop, reference=motion, sample_time=STEP))
    save_record(folder / "record.parquet", run, seed=1)
    path = folder / "experiment.toml"
    path.write_text(EXPERIMENT, encoding="utf-8")
    experiment = read_experiment(path)
    motions = motions_of(experiment, read_records(experiment))
    plain = baselines(experiment, motions, declared_values(experiment), None, silent)
    stage = balances_with_effects(path) if searched else with_floors(plain, experiment, silent)
    base = simulated_baseline(experiment, motions, stage.simulation_start([]), silent)
    assert base is not None
    return experiment, stage, base


def at_a_place(force: float) -> dict[str, float]:
    """A curve over the position with so much (N) at one place."""
    values = force * np.exp(-(((np.linspace(-WAY, WAY, 12) - PLACE) / WIDTH) ** 2))
    return dict(zip(CURVES["force", "position"].own_names, [1.0, -WAY, WAY, *values], strict=True))


def without_effects(stage: ResidualStage) -> BalanceResult:
    """The balance of forces as if nothing had been found."""
    (force,) = (result for result in stage.results if result.balance.name == "force")
    return force.withdrawn()


@pytest.mark.thorough
def test_what_no_effect_is_becomes_a_curve_beside_the_effects_of_other_balances(tmp_path: Path) -> None:
    """The floor was that of parameters that make up for the force, and hid it. An effect of the flow is no number that
    is held: what is written has it, and its deviation.
    """
    overlap = {"valve_overlap": 20e-6, "valve_overlap_negative": 20e-6}
    experiment, stage, base = machine(tmp_path, {**at_a_place(-60.0), **overlap})
    given = {effect: own for result in stage.results for effect, own in result.effects.items()}
    assert base.is_astray
    assert given == {"valve_deadband": ("valve_overlap",)}
    (curve,) = stage.curves
    start = stage.simulation_start([])
    _, them, found = curved(experiment, base, None, stage.curves, given, start, silent)
    assert found is not None
    assert them is not None
    assert them.fit.excess > NEAR_NOISE, "without the curve it stays far"
    assert found.simulated.fit.rms < 1.5
    assert found.dependence.signals == [curve.signal] == ["position"]
    assert found.gain > 1000.0
    assert found.effects == given
    true, values, deviations = {**TRUE, **overlap}, found.own.values, found.own.deviations
    for name in found.own.names:
        assert values[name] == pytest.approx(true[name], abs=4.0 * deviations[name] + 0.05 * true[name]), name
    assert values["valve_overlap"] == pytest.approx(20e-6, rel=1e-3)
    assert 0.0 < deviations["valve_overlap"] < 1e-7
    heights = [values[name] for name in curve.nodes]
    low, high = (values[name] for name in curve.effect.own_names[1:3])
    force = -60.0 * np.exp(-(((np.linspace(low, high, 12) - PLACE) / WIDTH) ** 2))
    assert heights == pytest.approx(force, abs=3.0)
    assert in_its_place(experiment, found, start) is None
    told = found.unexplained(without_effects(stage).after, [])
    assert told.term.fit is not None
    assert told.term.fit.after < 0.1 * told.term.fit.before
    assert told.term.held_out is None


def test_an_effect_that_does_in_the_place_of_a_curve_is_found(tmp_path: Path) -> None:
    experiment, stage, base = machine(tmp_path, {"spring_stiffness": 4e3}, searched=False)
    curve = curve_of(experiment, without_effects(stage), stage.baseline, stage.declared)
    assert curve is not None
    _, _, found = curved(experiment, base, None, [curve], {}, stage.simulation_start([]), silent)
    assert found is not None
    instead = in_its_place(experiment, found, stage.simulation_start([]))
    assert instead is not None
    plant, effects = instead
    assert effects == {"spring_load": ("spring_stiffness",)}
    assert plant.fit.values["spring_stiffness"] == pytest.approx(4e3, rel=0.02)
    assert plant.fit.rms < 1.1


def test_a_curve_that_is_not_needed_has_led_the_plant_to_its_records(tmp_path: Path) -> None:
    experiment, stage, base = machine(tmp_path, {}, searched=False)
    assert base.fit.rms < 1.1
    astray = Fitting(base.fit.balance.motions, base.fit.names, {}).begun(base.how, {**base.fit.values, "viscous": 1e4})
    assert astray.is_astray
    astray = replace(astray, fit=replace(astray.fit, names=base.fit.names))
    curve = fitted_curve(
        experiment, without_effects(stage).before, "position", CURVES["force", "position"], stage.baseline, {**TRUE}
    )
    nearer, _, found = curved(experiment, astray, None, [curve], {}, stage.simulation_start([]), silent)
    assert found is None
    assert nearer.fit.rms < 1.1
