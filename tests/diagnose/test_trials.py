"""What is tried of an effect: numbers that size it, shapes to begin with, and periods that stand out."""

from collections.abc import Mapping

import numpy as np
import pytest
from made_up_balances import FORCE, SCALES, made_balance, made_motion, ripple
from scipy.signal import lfilter

from plants.effects.compliant import COMPLIANT_LOAD
from plants.effects.loads import COGGING, CUSHION
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.fit import Fit, fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import unknown
from workbench.diagnose.selection.lines import PEAKS, Band
from workbench.diagnose.selection.trials import UNSEEN, Trial, columns_of, looks, sizing, trials_of

TRAVEL = 0.04
AMPLITUDE = 1.0
"""N, about the noise of one instant."""


def rippled(pitch: float = 0.01, amplitude: float = 0.0, duration: float = 20.0) -> Balance:
    truth = {"cogging_cosine": 0.6 * amplitude, "cogging_sine": -0.8 * amplitude, "cogging_pitch": pitch}
    motion = made_motion(duration, TRAVEL)
    return made_balance([motion], ripple, truth, effects=("cogging", "cushion", "constant_load"))


def unfitted(balance: Balance) -> Fit:
    return fit(balance, {}, ())


@pytest.mark.parametrize("seed", range(6))
def test_a_drawn_pitch_stands_out_of_the_residual(seed: int) -> None:
    draw = np.random.default_rng(seed)
    frequency = draw.uniform(60.0, 400.0)  # 1/m
    trials = [t for t in trials_of(unfitted(rippled(1.0 / frequency, AMPLITUDE)), (), {}) if t.effect == "cogging"]
    assert len(trials) == PEAKS
    assert all(t.sized == ("cogging_cosine", "cogging_sine") for t in trials)
    first = dict(trials[0].shapes)["cogging_pitch"]
    assert abs(1.0 / first - frequency) < 0.5 / TRAVEL, "half of what this way resolves"


@pytest.mark.parametrize("seed", range(6))
def test_a_pitch_stands_out_that_a_plant_shows_late_and_turned(seed: int) -> None:
    """A force that comes behind a lag, turns its sign now and then, and stands in a trend that a parameter takes."""
    draw = np.random.default_rng(seed)
    frequency, motion = draw.uniform(60.0, 400.0), made_motion(20.0, TRAVEL)  # 1/m

    def late(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
        keep = np.exp(-motion.sample_time / 0.05)
        turns = np.sign(np.sin(2.0 * np.pi * 1.7 * motion.time))
        shown = lfilter([1.0 - keep], [1.0, -keep], turns * ripple(motion, {**values, "load_force": 0.0}))
        return np.asarray(shown + values.get("load_force", 0.0) * motion.time)

    truth = {"cogging_cosine": 2.4, "cogging_sine": -3.2, "cogging_pitch": 1.0 / frequency, "load_force": 1.0}
    fitted = fit(made_balance([motion], late, truth, effects=("cogging",)), {"load_force": 0.0}, ["load_force"])
    trials = trials_of(fitted, (), {})
    assert abs(1.0 / dict(trials[0].shapes)["cogging_pitch"] - frequency) < 0.5 / TRAVEL
    known = fitted.balance.known(motion)
    waves = np.exp(2j * np.pi * np.outer(np.linspace(50.0, 410.0, 200), motion.thinned.position[known]))
    power = np.abs(waves @ fitted.weighed[known]) ** 2
    assert abs(np.linspace(50.0, 410.0, 200)[np.argmax(power)] - frequency) > 0.5 / TRAVEL, "no line shows it"


@pytest.mark.parametrize("damping", [0.02, 0.1])
@pytest.mark.parametrize("seed", range(3))
def test_the_band_of_what_swings_stands_out_of_the_residual(seed: int, damping: float) -> None:
    """White noise, and what it makes of a swinging load of that damping."""
    draw, motion = np.random.default_rng(seed), made_motion(20.0, TRAVEL)
    frequency = draw.uniform(5.0, 20.0)
    angle = 2.0 * np.pi * frequency * motion.thinned.sample_time
    keep = np.exp(-damping * angle)
    white = draw.standard_normal(motion.thinned.time.size)
    swinging = lfilter([1.0], [1.0, -2.0 * keep * np.cos(angle), keep**2], white)
    shown = 0.4 * FORCE * swinging / np.std(swinging)

    def swings(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
        return np.asarray(values.get("swings", 0.0) * shown)

    balance = made_balance([motion], swings, {"swings": 1.0}, effects=("compliant_load",))
    tried = [dict(t.shapes) for t in trials_of(unfitted(balance), (), {}) if len(t.shapes) == 2]
    chosen = [one["compliant_frequency"] for one in tried if one["compliant_damping"] == damping]
    grid = COMPLIANT_LOAD.numbers["compliant_frequency"].grid
    assert chosen[: len(grid)] == pytest.approx(list(grid))
    assert abs(chosen[len(grid)] / frequency - 1.0) < 1.5 * damping


@pytest.mark.parametrize("sample_time", [1e-2, 1e-3, 1e-4])
def test_no_frequency_falls_between_those_that_are_looked_at(sample_time: float) -> None:
    band = Band(0.05, 0.25 / sample_time, 8.4)
    most = np.max(np.diff(band.frequencies))
    assert most < 0.5 / band.reach, "half of what records of this length tell apart"


def test_bands_that_are_looked_at_are_as_many_as_their_width_tells_apart() -> None:
    balance = made_balance([made_motion(20.0, TRAVEL)], ripple, {}, effects=("compliant_load",))
    alone = looks(balance, "compliant_load", ("compliant_share", "compliant_frequency"))
    damped = looks(balance, "compliant_load", ("compliant_share", "compliant_frequency", "compliant_damping"))
    assert 10 < alone < damped < 300
    assert looks(balance, "compliant_load", ("compliant_share",)) == 1


def test_frequencies_that_are_tried_can_be_told_apart() -> None:
    trials = [t for t in trials_of(unfitted(rippled()), (), {}) if t.effect == "cogging"]
    frequencies = np.array([1.0 / dict(t.shapes)["cogging_pitch"] for t in trials])
    assert np.min(np.abs(np.subtract.outer(frequencies, frequencies) + 1e9 * np.eye(PEAKS))) > 0.99 / TRAVEL
    assert np.all(frequencies > 0.49 / TRAVEL)


def test_a_shape_that_is_known_is_the_only_one() -> None:
    known = (("cogging_pitch", 0.0123),)
    trials = trials_of(unfitted(rippled()), (), {"cogging": [known]})
    assert [t.shapes for t in trials if t.effect == "cogging"] == [known]


def test_of_a_shape_without_a_period_every_value_of_its_grid_is_tried() -> None:
    trials = [t for t in trials_of(unfitted(rippled()), (), {}) if t.effect == "cushion"]
    grid = CUSHION.numbers["cushion_start"].grid
    assert [dict(t.shapes)["cushion_start"] for t in trials] == pytest.approx([SCALES.travel * g for g in grid])
    assert all(t.names == ("cushion_stiffness", "cushion_start") for t in trials)


def test_numbers_that_size_an_effect_are_counted_without_those_that_shape_it() -> None:
    balance = rippled()
    assert sizing(balance, "constant_load", ("load_force",)) == 1
    assert sizing(balance, "cogging", tuple(COGGING.numbers)) == 2
    assert sizing(balance, "cushion", tuple(CUSHION.numbers)) == 1


def test_every_shape_that_could_be_told_apart_is_a_look() -> None:
    balance = rippled()
    assert looks(balance, "constant_load", ("load_force",)) == 1
    assert looks(balance, "cushion", tuple(CUSHION.numbers)) == len(CUSHION.numbers["cushion_start"].grid)
    assert looks(balance, "cushion", ("cushion_stiffness",)) == 1, "the start is held"
    assert looks(balance, "cogging", ("cogging_cosine", "cogging_sine")) == 1, "the pitch is held"


def test_over_a_way_as_many_periods_are_looked_at_as_it_tells_apart() -> None:
    """From half a period on the way to a quarter of a period from instant to instant, each 1 / way from the next."""
    balance = rippled()
    thin = balance.motions[0].thinned
    way, step = np.ptp(thin.position), np.median(np.abs(np.diff(thin.position)))
    told = looks(balance, "cogging", tuple(COGGING.numbers))
    assert told == pytest.approx(way * (0.25 / step - 0.5 / way), abs=1.0)


def test_what_was_taken_is_not_tried_again() -> None:
    fitted = fit(rippled(), {"load_force": 0.0}, ["load_force"])
    assert "constant_load" not in {t.effect for t in trials_of(fitted, ("constant_load",), {})}
    assert "constant_load" in {t.effect for t in trials_of(unfitted(rippled()), (), {})}


def test_a_column_is_what_a_number_changes() -> None:
    fitted = unfitted(rippled())
    trial = Trial("cogging", ("cogging_cosine", "cogging_sine"), (("cogging_pitch", 0.01),))
    (columns,) = columns_of(fitted, [trial], {}).values()
    motion = fitted.balance.motions[0]
    known, position = fitted.balance.known(motion), motion.thinned.position
    unit = COGGING.numbers["cogging_cosine"].size * SCALES.drive / (FORCE * np.sqrt(np.mean(known)))
    assert columns.block[known, 0] == pytest.approx(-unit * np.cos(2.0 * np.pi * position[known] / 0.01), rel=1e-4)
    assert not np.any(columns.block[~known])
    assert columns.values(np.array([2.0, -1.0])) == pytest.approx(
        {"cogging_cosine": 10.0, "cogging_sine": -5.0, "cogging_pitch": 0.01}
    )


def test_what_no_record_could_show_is_no_candidate() -> None:
    """At its largest plausible size it stays below the noise."""

    def hidden(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
        share = 0.5 * UNSEEN / SCALES.drive / np.sqrt(motion.time.size)
        return np.full(motion.time.size, share * FORCE * values.get("load_force", 0.0))

    balance = made_balance([made_motion()], hidden, {}, effects=("constant_load",))
    fitted = unfitted(balance)
    assert not columns_of(fitted, trials_of(fitted, (), {}), {})


def test_what_repeats_along_the_way_repeats_on_it() -> None:
    """A wave much longer than the way is a spring there, with a number more than that has."""
    pitch = unknown("cogging_pitch", {"cogging_pitch": 0.5 * SCALES.travel}, {}, SCALES)
    assert pitch.value(pitch.high) == pytest.approx(2.0 * SCALES.travel)
    fine = unknown("cogging_pitch", {"cogging_pitch": 0.01 * SCALES.travel}, {}, SCALES)
    assert fine.value(fine.high) == pytest.approx(0.1 * SCALES.travel), "ten times where it begins"


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_where_an_effect_begins_is_sought_up_to_its_neighbours_on_a_machine_of_any_size(size: float) -> None:
    scales = SCALES._replace(travel=size)
    (start,) = (value * size for value in CUSHION.numbers["cushion_start"].grid if value == 0.1)
    place = unknown("cushion_start", {"cushion_start": start}, {}, scales)
    assert place.value(place.low) == pytest.approx(0.0, abs=1e-9 * size)
    assert place.value(place.high) == pytest.approx(0.2 * size)
    outside = unknown("cushion_start", {"cushion_start": 0.7 * size}, {}, scales)
    assert outside.value(outside.low) == pytest.approx(0.6 * size)
    assert outside.value(outside.high) == pytest.approx(0.7 * size)
