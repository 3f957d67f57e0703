"""What repeats with the mains may be a sensor's hum: what a valve makes of it tells a supply that ripples from it."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from made_up_balances import made_balance, made_motion

from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.fit import Fit, fit, weighing_at
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.selection.hum import humming_at, hums_for, without_hum
from workbench.diagnose.selection.judging import choose
from workbench.diagnose.selection.likelihood import Proposal
from workbench.diagnose.selection.sets import Asked, fitted_with
from workbench.diagnose.selection.trials import Trial, columns_of
from workbench.fitting.least_squares import Search

EXACT = Search(flat=1e-14)
AMPLITUDE = 0.5
"""Of a line, beside noise of 1: over 20 s it gains some hundreds."""


def rippling(frequency: float, *, valve: bool) -> tuple[Balance, dict[str, float]]:
    """A line of that frequency (Hz), as it is or times the opening of a valve; and where a fit begins."""

    def line(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
        angle = 2.0 * np.pi * values["ripple_frequency"] * motion.time
        opening = motion.position / np.max(np.abs(motion.position)) if valve else 1.0
        waves = values["ripple_cosine"] * np.cos(angle) + values["ripple_sine"] * np.sin(angle)
        return np.asarray(opening * waves + values["load_force"])

    truth = {"ripple_cosine": AMPLITUDE, "ripple_sine": -AMPLITUDE, "ripple_frequency": frequency, "load_force": 0.0}
    balance = made_balance([made_motion()], line, truth, effects=("supply_ripple",))
    return balance, {**dict.fromkeys(truth, 0.0), "ripple_frequency": frequency}


def trial(frequency: float) -> Trial:
    return Trial("supply_ripple", ("ripple_cosine", "ripple_sine"), (("ripple_frequency", frequency),))


def judged(balance: Balance, start: dict[str, float], frequency: float) -> tuple[Fit, Fit, bool]:
    """The fit without a ripple of that frequency and with it, which gains far more than is asked; whether it counts."""
    first = fit(balance, start, ["load_force"], None, EXACT)
    current = fit(balance, start, ["load_force"], None, EXACT, weighing_at(first))
    ask = Asked(start, {}, 10, {}, settle=lambda found: found)
    proposal = Proposal((trial(frequency),), (), 0.0, 0.0, {"ripple_cosine": 0.1, "ripple_sine": -0.1})
    tried = fitted_with(current, {}, proposal, ask)
    assert 0.5 * (current.squares - tried.squares) > 2.0 * ask.price_of(proposal, {}, balance)
    best, _ = choose([(proposal, tried)], current, {}, {}, ask)
    return current, tried, best is not None


@pytest.mark.parametrize(
    ("frequency", "valve", "named"),
    [
        pytest.param(60.0, False, False, id="hum"),
        pytest.param(60.0, True, True, id="of the supply, with the mains"),
        pytest.param(7.3, False, True, id="beside the mains"),
    ],
)
def test_what_a_hum_explains_is_no_ripple(frequency: float, valve: bool, named: bool) -> None:
    balance, start = rippling(frequency, valve=valve)
    current, _, counts = judged(balance, start, frequency)
    assert counts is named
    columns = columns_of(current, [trial(frequency)], {})[trial(frequency)]
    left = float(np.linalg.norm(columns.change)) / np.linalg.norm([one.change for one in columns.own])
    assert (left > 0.9) if named else (left < 1e-6)


@pytest.mark.parametrize("hums", [True, False])
def test_a_hum_beside_a_ripple_of_another_frequency_is_no_ripple(hums: bool) -> None:
    """An opening that swings at 0.31 Hz makes of a ripple lines beside its own, one of them at the mains."""
    frequency = 60.05 - 0.31

    def line(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
        opening = motion.position / np.max(np.abs(motion.position))
        angle = 2.0 * np.pi * values["ripple_frequency"] * motion.time
        waves = values["ripple_cosine"] * np.cos(angle) + values["ripple_sine"] * np.sin(angle)
        hum = values["hum"] * np.cos(2.0 * np.pi * 60.05 * motion.time)
        return np.asarray(opening * waves + hum + values["load_force"])

    ripple = 0.0 if hums else AMPLITUDE
    start = {"ripple_cosine": 0.0, "ripple_sine": 0.0, "ripple_frequency": frequency, "load_force": 0.0, "hum": 0.0}
    truth = {**start, "ripple_cosine": ripple, "ripple_sine": -ripple, "hum": AMPLITUDE if hums else 0.0}
    balance = made_balance([made_motion()], line, truth, effects=("supply_ripple",))
    current, tried, counts = judged(balance, start, frequency)
    (found,) = hums_for(balance, "supply_ripple", tried.values, current.residual)
    assert abs(found - 60.05) < (0.02 if hums else 0.2)
    assert counts is not hums


def test_a_hum_is_known_behind_a_slow_sampling_and_by_its_frequency_alone() -> None:
    balance, _ = rippling(7.3, valve=False)
    record = balance.motions[0].record
    slow = replace(record, time=5.3 * record.time)
    folded = replace(balance, motions=[replace(balance.motions[0], record=slow)])
    third = 1.0 / 5.3e-3 - 150.0  # of 50 Hz
    for one, known in ((50.1, 50.1), (51.0, None), (119.9, 119.9), (7.3, None)):
        assert humming_at(balance, "supply_ripple", {"ripple_frequency": one}) == known
    assert humming_at(folded, "supply_ripple", {"ripple_frequency": third}) == third
    assert humming_at(balance, "supply_ripple", {"ripple_frequency": third}) is None
    assert humming_at(balance, "cogging", {"cogging_pitch": 50.0}) is None


def test_a_hum_is_taken_from_each_channel_of_each_record() -> None:
    """Its amplitude and phase are its own there."""
    balance, _ = rippling(60.0, valve=False)
    motions = [balance.motions[0], made_motion(10.0)]
    two = replace(balance, motions=motions, parts=2)
    hum = [
        amplitude * np.cos(2.0 * np.pi * 60.0 * motion.thinned.time + amplitude)
        for motion, own in zip(motions, ((1.0, 3.0), (2.0, 0.5)), strict=True)
        for amplitude in own
    ]
    trend = [0.1 * np.sin(one.thinned.time) for one in motions for _ in range(2)]
    left = without_hum(two, np.concatenate(hum) + np.concatenate(trend), [60.0])
    np.testing.assert_allclose(left, np.concatenate(trend), atol=2e-3)
