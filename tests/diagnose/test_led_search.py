"""Effects far from noise are found while a loop leads the plant along its record; free runs tell their size."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from driven import TRUE, driven_experiment
from scipy.signal import lfilter

from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.fit import NEAR_NOISE
from workbench.diagnose.selection.search import Found
from workbench.diagnose.simulation import led_search, stage
from workbench.diagnose.simulation.fits import ASTRAY, Fitting
from workbench.diagnose.simulation.fits import NOISE as AT_NOISE
from workbench.diagnose.simulation.led_search import CARRIES, FoundLed, carried, found_led
from workbench.diagnose.simulation.nearer import crossovers
from workbench.diagnose.simulation.reached import SimulationStart
from workbench.diagnose.simulation.setup import shooting_of
from workbench.progress import silent
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.reading import read_records

NAMES = ("coulomb", "stribeck", "viscous")

NOISE, DURATION = 2e-4, 6.0
"""m: so much that half a sample of the command does not show; s."""


def found(folder: Path, gradient: float, slow: float = 0.0) -> tuple[float, FoundLed | None]:
    """How far from noise a mass is whose friction grows along the stroke, seen with `slow` noise (m) too, and what is
    found.
    """
    acting = {"friction_gradient": gradient} if gradient else {}
    path = driven_experiment(folder, 0.0, NOISE, DURATION, stroke=1.0, acting=acting)
    if slow:
        record = pd.read_parquet(folder / "record.parquet")
        wandering = lfilter([1.0], [1.0, -0.99], np.random.default_rng(2).standard_normal(len(record)))
        record["position"] += slow * wandering / np.std(wandering)
        record.to_parquet(folder / "record.parquet", index=False)
    experiment = read_experiment(path)
    motions = motions_of(experiment, read_records(experiment))
    how, declared = shooting_of(experiment, motions), declared_values(experiment)
    assert how is not None
    fitting = Fitting(motions, NAMES, experiment.bounds)
    base = fitting.final(fitting.found(how, declared))
    start = SimulationStart(NAMES, declared, declared, declared, {}, {})
    return base.fit.excess, found_led(experiment, motions, base, start)


@pytest.mark.thorough
def test_friction_that_grows_along_the_stroke_is_found_far_from_noise(tmp_path: Path) -> None:
    excess, led = found(tmp_path, 0.5)
    assert excess > ASTRAY
    assert led is not None
    assert led.effects == {"position_dependent_friction": ("friction_gradient",)}
    assert led.simulated.fit.rms == pytest.approx(1.0, abs=0.1), "of a free run"
    assert led.simulated.fit.values["friction_gradient"] == pytest.approx(0.5, rel=0.02)
    for name in ("coulomb", "viscous"):
        assert led.simulated.fit.values[name] == pytest.approx(TRUE[name], rel=0.02), name
    assert [step.added for step in led.steps] == [("position_dependent_friction",)]
    (round_that_added,) = led.steps
    assert led.gains["position_dependent_friction"] > max(one.asked for one in round_that_added.candidates)


@pytest.mark.thorough
def test_what_loops_do_not_bring_nearer_has_its_numbers(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(led_search, "fit_as_sensed", lambda first, *_: first)
    _, led = found(tmp_path, 0.5)
    assert led is not None
    numbers = {number for own in led.effects.values() for number in own}
    assert {*NAMES, "friction_gradient"} <= {*NAMES, *numbers} == {*led.simulated.fit.names}
    assert {*led.simulated.fit.deviations} == {*led.simulated.fit.names}


@pytest.mark.thorough
def test_nothing_is_sought_beside_a_loop_that_leaves_no_less(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Noise that wanders slowly is far from white, and a loop follows it; what it hides no loop shows."""

    def never(*_: object) -> None:
        raise AssertionError("a search that can find nothing")

    monkeypatch.setattr(led_search, "search", never)
    excess, led = found(tmp_path, 0.0, slow=3e-3)
    assert excess > NEAR_NOISE
    assert led is None


def test_nothing_is_found_where_nothing_is_missing(tmp_path: Path) -> None:
    _, led = found(tmp_path, 0.0)
    assert led is None


Beside = tuple[Experiment, Fitting, FoundLed | None, float]


def beside_loops(folder: Path, pitch: float) -> Beside:
    """A drive with a force of 150 N that repeats every 5 cm, with one of some pitch that was found beside the quickest
    loop (rad/s), and what that leads to beside weaker ones.
    """
    acting = {"cogging_cosine": 150.0, "cogging_pitch": 0.05}
    experiment = read_experiment(driven_experiment(folder, 0.0, NOISE, 0.5 * DURATION, stroke=1.0, acting=acting))
    motions = motions_of(experiment, read_records(experiment))
    how, values = shooting_of(experiment, motions), {**declared_values(experiment), "coulomb": TRUE["coulomb"]}
    assert how is not None
    how = replace(how, effects=("cogging", "spring_load"))
    fitting, quickest = Fitting(motions, ("viscous",), {}), next(crossovers(how, motions, values))
    led = fitting.final(fitting.found(how.led(motions, values, quickest), values))
    own = Fitting(motions, ("viscous", "cogging_cosine"), {})
    with_it = own.final(own.found(led.how, {**values, **acting, "cogging_pitch": pitch}))
    found = Found(with_it.fit, {"cogging": ("cogging_cosine",)}, [], {"cogging": 50.0}, {}, {})
    return experiment, fitting, carried(how, fitting, led, found), quickest


def test_what_was_found_beside_a_loop_counts_beside_the_weakest(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    experiment, fitting, kept, quickest = beside_loops(tmp_path, 0.05)
    assert kept is not None
    weakest, alone = kept.simulated.how.crossover, kept.alone
    assert weakest is not None
    assert alone is not None
    assert weakest == alone.how.crossover
    assert weakest <= quickest / CARRIES
    assert kept.simulated.fit.excess < AT_NOISE < alone.fit.excess
    assert kept.simulated.fit.values["cogging_cosine"] == pytest.approx(150.0, rel=0.02)
    declared, motions = declared_values(experiment), fitting.motions
    base = fitting.begun(replace(alone.how, setups=shooting_of(experiment, motions).setups, crossover=None), declared)
    assert base.is_astray
    monkeypatch.setattr(stage, "found_led", lambda *_: kept)
    start = SimulationStart(fitting.names, declared, declared, declared, {}, {})
    ended = stage.simulation_stage(experiment, start, base, None, None, silent)
    assert set(ended.effects) == {"cogging"}
    assert ended.loop == weakest
    assert ended.lacks is None
    assert ended.before.excess > AT_NOISE
    assert ended.along(experiment, motions).crossover == weakest


def test_what_leads_the_plant_beside_one_loop_alone_is_no_finding(tmp_path: Path) -> None:
    """A force of another pitch."""
    assert beside_loops(tmp_path, 0.06)[2] is None
