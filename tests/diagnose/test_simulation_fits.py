"""A plant that is simulated along a record: declared values that are far off, and wrong starts, are found again."""

from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from deadband import OVERLAP
from driven import driven_shooting
from scipy.signal import lfilter

import workbench.diagnose.simulation.shooting as shooting_module
import workbench.diagnose.simulation.together as together
from plants.registry import plants
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.fit import fit
from workbench.diagnose.residuals.motion import Motion, motion_of
from workbench.diagnose.residuals.null import QUICKEST
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.simulation.fits import (
    NOISE,
    Fitting,
    Simulated,
    afresh,
    exactly,
    fit_simulation,
    left_of_pieces,
)
from workbench.diagnose.simulation.lacking import dependence_of, lacking
from workbench.diagnose.simulation.leading import FILTERED, SHAKES
from workbench.diagnose.simulation.nearer import (
    crossovers,
    fit_as_sensed,
    fit_evolved,
    fit_farther,
    fit_led,
    fit_over_hollows,
)
from workbench.diagnose.simulation.setup import FINER, as_coloured, as_simulated, follows, is_coloured, shooting_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.fitting.replay import Sampled
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records
from workbench.simulation.references import Multisine
from workbench.simulation.run import Run
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

TRUTH = {**read_parameters(named_sets()["owen2001_simulation"]), "spring_stiffness": 2e4}
POSITION_NOISE = 5e-6
"""m."""

NAMES = ("mass", "coulomb", "viscous")

DRIVE = """\
title = "a drive"
[plant]
model = "drive_force"
parameters = "owen2001_simulation"
[plant.set]
spring_stiffness = "20000 N/m"
[channels]
time = { column = "time", unit = "s" }
command = { column = "force", unit = "N" }
position = { column = "position", unit = "m" }
[[records]]
file = "record.parquet"
"""

Made = tuple[Shooting, list[Motion], dict[str, float]]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """6 s of a mass that a force of 900 N drives against a spring, how it is simulated, and its true parameters."""
    folder, plant = tmp_path_factory.mktemp("drive"), plants()["drive_force"]
    parameters = build(plant.Parameters, TRUTH)
    state, inputs = plant.equilibrium(parameters, 0.0)
    feed = Feed(plant.command, Multisine(900.0, 0.5, (1, 2, 3)))
    run = simulate(Setup(plant, parameters, state, inputs, 6.0, feeds=(feed,)))
    position = run.measurements[:, 0] + POSITION_NOISE * np.random.default_rng(1).standard_normal(run.time.size)
    force = run.inputs[:, plant.input_index(plant.command)]
    pd.DataFrame({"time": run.time, "force": force, "position": position}).to_parquet(folder / "record.parquet")
    (folder / "experiment.toml").write_text(DRIVE)
    experiment = read_experiment(folder / "experiment.toml")
    motions = motions_of(experiment, read_records(experiment))
    how = shooting_of(experiment, motions, held=False)  # the force of this record is no computer's
    assert how is not None
    return how, motions, declared_values(experiment)


def test_of_the_true_plant_the_sensor_s_noise_is_left(made: Made) -> None:
    how, motions, truth = made
    begun = Fitting(motions, (), {}).begun(how, truth)
    assert begun.fit.rms == pytest.approx(1.0, abs=0.1)
    assert begun.is_near
    assert follows(how, motions, truth)


def test_what_was_simulated_is_remembered_and_nothing_else(made: Made) -> None:
    how, motions, truth = made
    (motion,) = motions
    first, again = how.errors(motion, truth), replace(how).errors(motion, dict(truth))
    assert all(one is other for one, other in zip(first, again, strict=True))
    moved = np.zeros(len(how.along.names))
    assert how.errors(motion, truth, moved)[0] is first[0]
    moved[how.along.names.index("position")] = 1e-4
    others = (
        how.errors(motion, {**truth, "coulomb": 1.01 * truth["coulomb"]}),
        how.errors(motion, truth, moved),
        how.with_tolerance(1e-9).errors(motion, truth),
        replace(how, length=1.0).errors(motion, truth),
    )
    assert not any(np.array_equal(first[0], other[0]) for other in others)


def test_a_plant_in_which_no_effect_acts_is_simulated_without_any(made: Made) -> None:
    how, motions, truth = made
    (motion,) = motions
    finer = how.with_tolerance(1e-10)
    plant, parameters = how.along.acting(truth)
    assert plant is how.along.plant.bare
    assert type(parameters) is plant.Parameters
    acts = {**truth, "drag_coefficient": 1e-9}
    assert how.along.acting(acts)[0] is how.along.plant
    without, with_one = (finer.simulated(motion, values)["position"] for values in (truth, acts))
    assert np.max(np.abs(without - with_one)) < 1e-3 * POSITION_NOISE


def test_of_a_long_record_the_effects_that_act_are_simulated_alone_to_the_same_bits(
    made: Made, monkeypatch: pytest.MonkeyPatch
) -> None:
    how, motions, truth = made
    (motion,) = motions
    acts = {**truth, "drag_coefficient": 50.0, "backlash_width": 1e-4, "memory_time": 0.02}
    plant, _ = how.along.acting(acts, alone=True)
    assert set(plant.effects) == {"quadratic_drag", "frictional_memory", "backlash"}
    among_all, gap = how.simulated(motion, acts)["position"], how.with_backlash_of(motion, acts)
    monkeypatch.setattr(shooting_module, "LONG", 0)
    np.testing.assert_array_equal(how.simulated(motion, acts)["position"], among_all)
    np.testing.assert_array_equal(how.with_backlash_of(motion, acts).slack[0], gap.slack[0])
    assert np.ptp(gap.slack[0]) > 0.5


@pytest.mark.parametrize("factors", [(2.0, 0.5, 2.0)])
def test_values_that_are_off_by_2_times_are_found_again(made: Made, factors: tuple[float, ...]) -> None:
    how, motions, truth = made
    declared = {**truth, **{name: factor * truth[name] for name, factor in zip(NAMES, factors, strict=True)}}
    assert not follows(how, motions, declared)
    fitting = Fitting(motions, NAMES, {})
    found = fit_farther(fit_simulation(how, fitting, [declared]), fitting, declared)
    assert found.is_near
    assert found.fit.rms == pytest.approx(1.0, abs=0.1)
    for name in NAMES:
        assert found.fit.values[name] == pytest.approx(truth[name], rel=2e-3), name
        assert abs(found.fit.values[name] - truth[name]) < 4.0 * found.fit.deviations[name], name
        assert 0.0 < found.fit.deviations[name] < 1e-3 * truth[name], name


def test_steps_over_hollows_find_values_that_are_off_by_2_times(made: Made) -> None:
    """From a fit that ended there; from one at noise they lead no farther away."""
    how, motions, truth = made
    off = {**truth, "mass": 2.0 * truth["mass"], "coulomb": 0.5 * truth["coulomb"], "viscous": 2.0 * truth["viscous"]}
    fitting = Fitting(motions, NAMES, {})
    ended = Simulated(how, fit(how.balance(motions, ()), off, ()))
    assert ended.fit.excess > 100.0
    over = fit_over_hollows(ended, fitting)
    assert over.fit.rms == pytest.approx(1.0, abs=0.1)
    for name in NAMES:
        assert over.fit.values[name] == pytest.approx(truth[name], abs=5.0 * over.fit.deviations[name])
    assert fit_over_hollows(over, fitting).fit.rms <= over.fit.rms


def test_a_fit_whose_start_made_up_for_something_is_begun_afresh(made: Made) -> None:
    how, motions, truth = made
    fitting = Fitting(motions, NAMES, {})
    good = fitting.final(fitting.found(how, truth))
    assert afresh(good, fitting) is good
    beside = np.zeros((1, len(how.along.names)))
    beside[:, how.along.names.index("velocity")] = 0.05
    wrong = replace(how, begins={motions[0].record: beside})
    bad = Simulated(wrong, fit(wrong.balance(motions, ()), good.fit.values, ()))
    assert bad.fit.rms > 1.2
    assert afresh(bad, fitting).fit.rms == pytest.approx(good.fit.rms, rel=1e-3)


@pytest.fixture(scope="module")
def drifting(tmp_path_factory: pytest.TempPathFactory) -> Made:
    """12 s of a mass that nothing holds, from rest: what its force is off by adds up to the end."""
    how, motions, declared = driven_shooting(tmp_path_factory.mktemp("drifting"), POSITION_NOISE, 12.0)
    return how, motions, {**declared, "coulomb": TRUTH["coulomb"]}


@pytest.mark.parametrize("led_by", [fit_led, fit_as_sensed])
def test_a_plant_that_goes_astray_is_led_back(
    drifting: Made, led_by: Callable[[Simulated, Fitting, Values], Simulated]
) -> None:
    how, motions, truth = drifting
    fitting = Fitting(motions, ("coulomb", "viscous"), {})
    start = {**truth, "coulomb": 1.1 * truth["coulomb"], "viscous": 0.8 * truth["viscous"]}
    first = fitting.begun(how, start)
    assert first.fit.excess > 100.0
    found = led_by(first, fitting, start)
    assert not found.how.is_led(motions[0]), "no loop is left"
    assert found.fit.rms == pytest.approx(1.0, abs=0.1)
    for name in fitting.names:
        assert abs(found.fit.values[name] - truth[name]) < 3.0 * found.fit.deviations[name], name
        assert found.fit.deviations[name] < 1e-3 * truth[name], name


def test_a_free_run_is_found_about_a_fit_beside_a_loop(drifting: Made) -> None:
    how, motions, truth = drifting
    fitting = Fitting(motions, ("coulomb", "viscous"), {})
    start = {**truth, "coulomb": 1.1 * truth["coulomb"], "viscous": 0.8 * truth["viscous"]}
    first = fitting.begun(how, start)
    assert first.fit.excess > 100.0
    led = fitting.final(fitting.found(how.led(motions, start, next(crossovers(how, motions, start))), start))
    found = fit_evolved(first, fitting, led.fit)
    assert not found.how.is_led(motions[0])
    assert found.fit.rms == pytest.approx(1.0, abs=0.1)
    for name in fitting.names:
        assert abs(found.fit.values[name] - truth[name]) < 3.0 * found.fit.deviations[name], name
    assert fit_evolved(found, fitting, led.fit) is found, "it is near noise"


def test_the_quickest_loop_makes_no_force_of_noise_that_shakes_a_contact(drifting: Made) -> None:
    how, (motion,), truth = drifting
    crossover = how.quickest(motion, truth)
    assert crossover < QUICKEST / motion.sample_time
    shaken = crossover**2 * truth["mass"] * 2.0 / FILTERED * motion.sensed["position"]
    assert shaken == pytest.approx(SHAKES * truth["coulomb"], rel=1e-6)


def test_a_record_that_begins_at_rest_is_followed_from_rest(drifting: Made) -> None:
    how, motions, truth = drifting
    rested = how.rested(motions, truth)
    (begins,) = rested.begins.values()
    assert begins[0, how.along.names.index("position")] == 0.0
    assert np.any(begins != 0.0), "what was measured has noise in its velocity"
    (motion,) = motions
    state, reach = how.along.at_rest(motion, truth)[0], how.reach(motion, truth)
    assert np.all(np.abs(begins) <= reach)
    assert state.velocity == 0.0
    assert fit(rested.balance(motions, ()), truth, ()).excess < NOISE


def test_a_start_that_smoothing_missed_is_found(drifting: Made) -> None:
    """Before a record nothing is known: what begins with a jump may be as fast there as it never is later."""
    how, (motion,), truth = drifting
    velocity = motion.velocity.copy()
    velocity[0] += 5.0 * np.std(velocity)
    bent = replace(motion, velocity=velocity)
    assert fit(how.balance([bent], ()), truth, ()).excess > 100.0
    assert Fitting([bent], (), {}).begun(how, truth).fit.excess < NOISE


def test_starts_that_are_wrong_are_found(made: Made) -> None:
    """0.2 mm beside where the record begins, in each of 6 pieces of 1 s."""
    how, motions, truth = made
    pieces = replace(how, length=1.0)
    count, states = len(pieces.starts(motions[0])), len(how.along.names)
    assert count >= 6
    wrong = np.zeros((count, states))
    wrong[:, how.along.names.index("position")] = 2e-4
    off = replace(pieces, begins={motions[0].record: wrong})
    fitting = Fitting(motions, (), {})
    before = float(np.sqrt(np.mean(off.balance(motions, ()).stacked(truth) ** 2)))
    assert before > 10.0
    found = fitting.found(off, truth)
    assert found.fit.rms < NOISE
    assert not found.is_near, "in pieces nothing is known of the long run"


def test_values_and_starts_that_are_both_wrong_are_found_together(made: Made) -> None:
    how, motions, truth = made
    pieces = replace(how, length=1.0)
    wrong = np.zeros((len(pieces.starts(motions[0])), len(how.along.names)))
    wrong[:, how.along.names.index("position")] = 1e-4
    off = replace(pieces, begins={motions[0].record: wrong})
    found = Fitting(motions, ("coulomb",), {}).found(off, {**truth, "coulomb": 1.05 * truth["coulomb"]})
    assert found.fit.rms < NOISE
    assert found.fit.values["coulomb"] == pytest.approx(truth["coulomb"], rel=1e-3)


def test_a_piece_that_went_astray_does_not_decide_where_parameters_go(made: Made) -> None:
    """One of 12 starts is 50 mm off, of which no fit of starts finds back: what is left of the others counts."""
    how, motions, truth = made
    pieces = replace(how, length=0.5)
    wrong = np.zeros((len(pieces.starts(motions[0])), len(how.along.names)))
    wrong[5, how.along.names.index("position")] = 0.05
    off = replace(pieces, begins={motions[0].record: wrong})
    balance = off.balance(motions, ())
    astray, groups = fit(balance, truth, ()), off.groups(motions)
    assert astray.rms > 1000.0
    assert left_of_pieces(astray, groups) < 5.0, "12 pieces that each left twice the noise would come to 2.2"
    fitting = Fitting(motions, NAMES, {})
    declared = {**truth, "coulomb": 1.05 * truth["coulomb"]}
    once = fitting._once(Simulated(off, fit(balance, declared, ())))
    assert once.fit.values["coulomb"] == pytest.approx(truth["coulomb"], rel=0.02)


def test_what_acts_at_one_place_alone_is_told_over_a_fine_curve(made: Made) -> None:
    """A force of 20 N over 4 % of the way, of which the record's channel knows nothing."""
    how, motions, truth = made
    (motion,) = motions
    width, centre = 0.02 * float(np.ptp(motion.position)), float(np.median(motion.position))
    bump = 20.0 * np.exp(-(((motion.position - centre) / width) ** 2))
    setups = {
        record: replace(
            setup,
            feeds=tuple(
                replace(feed, signal=Sampled(record.time, feed.signal(record.time)[0] + bump)) for feed in setup.feeds
            ),
        )
        for record, setup in how.setups.items()
    }
    fitting = Fitting(motions, NAMES, {})
    fitted = fitting.final(fitting.found(replace(how, setups=setups), truth))
    curves = lacking(fitted.how, fitted.fit)
    told = dependence_of(curves)
    assert told is not None
    assert (told.balance, told.signals[0]) == ("force", "position")
    places = [curve for curve in curves if curve.signal == "position"]
    assert places[0].gain > 1.2 * min(places, key=lambda one: one.asked).gain, "a coarse one misses half of it"
    nothing = fitting.final(fitting.found(how, truth))
    assert dependence_of(lacking(nothing.how, nothing.fit)) is None


def test_a_long_run_finds_back_from_a_start_that_made_up_for_wrong_values(made: Made) -> None:
    how, motions, truth = made
    wrong = np.zeros((1, len(how.along.names)))
    wrong[:, how.along.names.index("position")] = 2e-3
    wrong[:, how.along.names.index("velocity")] = 0.1
    begun = Fitting(motions, (), {}).begun(replace(how, begins={motions[0].record: wrong}), truth)
    assert begun.fit.rms == pytest.approx(1.0, abs=0.1)


def test_no_start_is_farther_from_what_was_measured_than_the_record_varies(made: Made) -> None:
    how, motions, truth = made
    declared = {**truth, "coulomb": 10.0 * truth["coulomb"]}
    begun = Fitting(motions, (), {}).begun(replace(how, length=0.5), declared)
    position, velocity, bristle = (
        how.along.names.index(name) for name in ("position", "velocity", "bristle_deflection")
    )
    begins = np.abs(begun.how.begins[motions[0].record])
    assert np.any(begins > 0.0)
    assert np.all(begins[:, position] <= np.std(motions[0].position))
    assert np.all(begins[:, velocity] <= np.std(motions[0].velocity))
    breaks_away = (declared["coulomb"] + declared["stribeck"]) / declared["bristle_stiffness"]
    assert np.all(begins[:, bristle] <= 3.0 * breaks_away), "a simulation from far beyond it takes minutes"


def test_a_solver_is_as_fine_as_the_noise_shows(made: Made) -> None:
    """Of a sensor that is ten thousand times finer what the solver is off by would be told as an effect."""
    how, motions, truth = made
    fitting = Fitting(motions, (), {})

    def tolerance(finer: float) -> float:
        begun = fitting.begun(how, truth)
        weighing = begun.fit.weighing.times(finer)
        fitted = fit(begun.fit.balance, truth, (), weighing=weighing)
        return exactly(Simulated(begun.how, fitted), fitting).how.tolerance

    assert tolerance(1.0) == how.tolerance
    assert tolerance(1e4) < 0.2 * how.tolerance


def test_what_is_over_noise_is_told_whatever_its_colour(made: Made) -> None:
    how, motions, truth = made
    fitted = Fitting(motions, (), {}).begun(how, truth).fit
    assert fitted.excess == pytest.approx(fitted.rms, rel=0.05)
    time = np.arange(fitted.residual.size)
    drifting = replace(fitted, residual=10.0 * np.sin(2.0 * np.pi * time / time.size))
    assert drifting.excess == pytest.approx(drifting.rms, rel=1e-6)
    loud = replace(fitted, residual=1.5 * fitted.residual)
    assert loud.excess == pytest.approx(1.0, abs=0.1)


def noisy(made: Made, noise: np.ndarray) -> tuple[Shooting, Motion]:
    """The same with further noise of the position."""
    how, (motion,), _ = made
    record = motion.record
    other = replace(record, channels={**record.channels, "position": record.channels["position"] + noise})
    return replace(how, setups={other: how.setups[record]}), motion_of(other)


def test_in_coloured_noise_a_fit_looks_more_often_and_sees_more_of_what_is_fast(made: Made) -> None:
    """Noise that falls above 2 Hz, 100 um of it, and 3 um at 60 Hz in it: beyond the means over 10 ms."""
    _, (motion,), truth = made
    draw, size = np.random.default_rng(2), motion.measured["position"].size
    slow = lfilter([1.0], [1.0, -np.exp(-2.0 * np.pi * 2.0 * motion.sample_time)], draw.standard_normal(size))
    slow *= 1e-4 / np.std(slow)
    ripple = 3e-6 * np.sin(2.0 * np.pi * 60.0 * np.arange(size) * motion.sample_time)
    seen = []
    for looks in (1, FINER):
        fits = []
        for noise in (slow, slow + ripple):
            how, other = noisy(made, noise)
            (looked,) = as_coloured([other]) if looks > 1 else [other]
            fitting = Fitting([looked], (), {})
            fits.append(fitting.final(fitting.begun(how, truth)).fit)
        assert is_coloured(fits[0])
        seen.append(np.linalg.norm(fits[0].weighing(fits[1].residual - fits[0].residual)))
    assert seen[1] > 2.0 * seen[0]


def test_white_noise_is_not_coloured(made: Made) -> None:
    how, motions, truth = made
    fitting = Fitting(motions, (), {})
    assert not is_coloured(fitting.final(fitting.begun(how, truth)).fit)
    (finer,) = as_coloured(motions)
    assert (motions[0].thinning, finer.thinning, finer.grain) == (10, 2, 10)


def test_no_start_is_followed_that_shakes_far_more_than_its_plant(
    experiment: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A step of a start out of reason shook 0.8 s of a rod for two million steps: longer than all else took."""
    steps = list[int]()

    def counted(setups: Sequence[Setup]) -> list[Run]:
        runs = [simulate(setup) for setup in setups]
        steps.extend(run.steps for run in runs)
        return runs

    monkeypatch.setattr(together, "simulate_together", counted)
    read = read_experiment(experiment)
    motions = as_simulated(read, motions_of(read, read_records(read, "fit")))
    how = shooting_of(read, motions, held=True)
    assert how is not None
    values = {**declared_values(read), "valve_overlap": OVERLAP, "valve_flow_gain": 2.93e-4}
    begun = Fitting(motions, (), {}).begun(how, values)
    assert np.isfinite(begun.fit.rms)
    assert max(steps) < 1_000_000
    assert np.isinf(begun.how.setups[motions[0].record].most_steps), "what follows is bounded by itself"
