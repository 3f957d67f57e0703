"""What effects promise to first order: exact where a residual is linear, and never more than bounds allow."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from made_up_balances import made_balance, made_motion
from scipy.signal import lfilter
from scipy.stats import chi2

from workbench.diagnose.residuals.balance import SIMULATION
from workbench.diagnose.residuals.fit import Fit, fit, weighed_fit, weighing_at
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.selection.likelihood import FALSE_ALARMS, Outlook, asked, effects_of
from workbench.diagnose.selection.trials import Trial, columns_of
from workbench.fitting.least_squares import Search

EXACT = Search(flat=1e-14)
LOAD, DRAG = Trial("constant_load", ("load_force",)), Trial("quadratic_drag", ("drag_coefficient",))
TRUTH = {"spring_stiffness": 2000.0, "load_force": 5.0, "drag_coefficient": 3e3}
START = {"spring_stiffness": 0.0}


def forces(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """A spring, a load and a drag."""
    return np.asarray(
        values.get("spring_stiffness", 0.0) * motion.position
        + values.get("load_force", 0.0)
        + values.get("drag_coefficient", 0.0) * motion.velocity * np.abs(motion.velocity)
    )


def with_a_spring(truth: Mapping[str, float] = TRUTH) -> Fit:
    """The balance fitted by its spring alone, as its noise weighs."""
    balance = made_balance([made_motion()], forces, truth)
    whole = fit(balance, {**START, **truth}, [*truth], search=EXACT)
    return fit(balance, START, ["spring_stiffness"], None, EXACT, weighing_at(whole))


def refitted(
    before: Fit, names: list[str], bounds: Mapping[str, tuple[float, float]] | None = None, **put: float
) -> Fit:
    """The same with these numbers, some of them elsewhere."""
    return fit(before.balance, {**before.values, **put}, names, bounds, EXACT, before.weighing)


def away(of: Fit, name: str) -> dict[int, float]:
    """How far an unknown is from 0."""
    place = of.names.index(name)
    return {place: of.unknowns[place].place(0.0) - of.places[place]}


@pytest.mark.parametrize("numbers", [1, 2, 3])
def test_more_is_asked_of_one_of_many(numbers: int) -> None:
    prices = [asked(numbers, candidates) for candidates in (1, 2, 10, 100, 1000)]
    assert np.all(np.diff(prices) > 0.0)
    assert asked(numbers + 1, 10) > asked(numbers, 10)
    assert asked(numbers, 0) == asked(numbers, 1)


def test_what_is_asked_is_seldom_gained_by_noise() -> None:
    """Half of chi squared is the gain by noise: of 30 candidates none exceeds it in 99 of 100 machines."""
    price = asked(2, 30)
    assert 1.0 - chi2.cdf(2.0 * price, 2) ** 30 == pytest.approx(FALSE_ALARMS, rel=0.01)
    gains = 0.5 * np.sum(np.random.default_rng(1).standard_normal((20_000, 30, 2)) ** 2, axis=2)
    assert np.mean(np.any(gains > price, axis=1)) == pytest.approx(FALSE_ALARMS, abs=0.003)


@pytest.mark.parametrize("added", [[LOAD], [DRAG], [LOAD, DRAG]], ids=["load", "drag", "both"])
def test_of_a_linear_residual_the_expected_gain_is_that_of_a_fit(added: list[Trial]) -> None:
    before = with_a_spring()
    outlook = Outlook(before, columns_of(before, [LOAD, DRAG], {}))
    proposal = outlook.proposal(added, {}, 3.0)
    after = refitted(before, ["spring_stiffness", *(name for trial in added for name in trial.names)])
    assert proposal.gain == pytest.approx(0.5 * (before.squares - after.squares), rel=1e-3)
    assert proposal.score == proposal.gain - 3.0
    for trial in added:
        (name,) = trial.names
        assert proposal.start[name] == pytest.approx(after.values[name], rel=1e-3)
    assert effects_of(proposal.added) == tuple(trial.effect for trial in added)


def test_beyond_a_bound_nothing_is_promised() -> None:
    before, bounds = with_a_spring(), {"load_force": (-2.0, 2.0)}
    outlook = Outlook(before, columns_of(before, [LOAD], bounds))
    proposal = outlook.proposal([LOAD], {}, 0.0)
    after = refitted(before, ["spring_stiffness", "load_force"], bounds)
    assert proposal.start["load_force"] == pytest.approx(2.0)
    assert proposal.gain == pytest.approx(0.5 * (before.squares - after.squares), rel=1e-3)
    assert proposal.gain < 0.9 * Outlook(before, columns_of(before, [LOAD], {})).gain([LOAD])[0]


def test_a_drag_that_would_push_gains_nothing() -> None:
    """It is at least 0."""
    before = with_a_spring({"spring_stiffness": 2000.0, "drag_coefficient": -3e3})
    proposal = Outlook(before, columns_of(before, [DRAG], {})).proposal([DRAG], {}, 0.0)
    assert proposal.gain == pytest.approx(0.0, abs=1e-9)


def test_what_is_lost_without_an_effect_is_what_a_fit_loses() -> None:
    before = refitted(with_a_spring(), ["spring_stiffness", "load_force"])
    after = refitted(before, ["spring_stiffness"], load_force=0.0)
    lost = -Outlook(before, {}).gain([], away(before, "load_force"))[0]
    assert lost > 100.0
    assert lost == pytest.approx(0.5 * (after.squares - before.squares), rel=1e-3)


def test_an_exchange_of_effects_is_foreseen() -> None:
    """The load dropped, the drag added."""
    before = refitted(with_a_spring(), ["spring_stiffness", "load_force"])
    outlook = Outlook(before, columns_of(before, [DRAG], {}))
    proposal = outlook.proposal([DRAG], {"constant_load": away(before, "load_force")}, 0.0)
    after = refitted(before, ["spring_stiffness", "drag_coefficient"], load_force=0.0)
    assert proposal.dropped == ("constant_load",)
    assert proposal.gain == pytest.approx(0.5 * (before.squares - after.squares), rel=1e-3)


def test_by_noise_alone_a_number_gains_half_of_its_square() -> None:
    """Over many records of noise, twice the gain of one number is chi squared of one: its mean is 1."""
    motion, gains = made_motion(), []
    for seed in range(60):
        noise = np.random.default_rng(100 + seed).standard_normal(motion.thinned.time.size)

        def explained(of: Motion, values: Mapping[str, float], noise: np.ndarray = noise) -> np.ndarray:
            return forces(of, values) + noise * values.get("noise", 0.0)

        balance = made_balance([motion], explained, {"noise": 5.0})
        before = weighed_fit(balance, START, ["spring_stiffness"], search=EXACT)
        gains.append(Outlook(before, columns_of(before, [LOAD], {})).gain([LOAD])[0])
    assert 2.0 * np.mean(gains) == pytest.approx(1.0, abs=0.5)
    assert max(gains) < asked(1, 60)


def coloured(size: int, cutoff: float, seed: int) -> np.ndarray:
    """Noise of the first order below a cutoff (1 over the instants), with a standard deviation of 1."""
    keep = np.exp(-2.0 * np.pi * cutoff)
    return np.asarray(
        lfilter([np.sqrt(1.0 - keep**2)], [1.0, -keep], np.random.default_rng(seed).standard_normal(size))
    )


def of_coloured_noise(load: float, seed: int) -> tuple[float, float]:
    """What a load gains of a simulation whose noise is coloured: in the noise that is left with it, against that which
    is left without it; and in the noise that is left without it.
    """
    motion = made_motion()
    noise = 3.0 * coloured(motion.thinned.time.size, 0.02, seed)

    def explained(of: Motion, values: Mapping[str, float]) -> np.ndarray:
        return forces(of, values) + noise * values.get("noise", 0.0)

    truth = {"spring_stiffness": 2000.0, "load_force": load, "noise": 1.0}
    balance = replace(made_balance([motion], explained, truth), name=SIMULATION)
    before = weighed_fit(balance, START, ["spring_stiffness"], search=EXACT)
    outlook = Outlook(before, columns_of(before, [LOAD], {}))
    return outlook.alone(LOAD, 0.0).gain, outlook.proposal([LOAD], {}, 0.0).gain


def test_what_is_missing_is_told_from_coloured_noise() -> None:
    """A load is as slow as noise can be: a spectrum of both has it as noise, however strong it is."""
    weak, strong = (np.mean([of_coloured_noise(load, seed) for seed in range(8)], axis=0) for load in (1.6, 3.0))
    assert weak[0] > 1.2 * weak[1]
    assert strong[0] > 2.0 * strong[1]
    assert strong[0] > 1.8 * weak[0]


def test_coloured_noise_alone_gains_what_white_noise_does() -> None:
    gains = np.array([of_coloured_noise(0.0, 100 + seed)[0] for seed in range(30)])
    assert 2.0 * np.mean(gains) == pytest.approx(1.0, abs=0.6)
    assert np.max(gains) < asked(1, 30)
