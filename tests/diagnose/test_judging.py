"""Whether a set that was fitted is taken: what happens once is in one block, and no other foresees it."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from made_up_balances import made_balance, made_motion
from scipy.signal import lfilter

from workbench.diagnose.residuals.balance import SIMULATION
from workbench.diagnose.residuals.fit import Fit, fit, weighing_at
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.selection.judging import BEYOND, NEARER, choose
from workbench.diagnose.selection.likelihood import Proposal
from workbench.diagnose.selection.search import search
from workbench.diagnose.selection.sets import Asked, certainty_of, fitted_with, numbers_of
from workbench.diagnose.selection.trials import Trial
from workbench.fitting.least_squares import Search

EXACT = Search(flat=1e-14)
LOAD = Proposal((Trial("constant_load", ("load_force",)),), (), 0.0, 0.0, {"load_force": 0.1})
START = {"spring_stiffness": 0.0, "load_force": 0.0}


def once(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """A spring, and a load that acts in the first second of twenty, and hardly after it."""
    acts = np.where(motion.time < 1.0, 1.0, 0.02)
    return np.asarray(values["spring_stiffness"] * motion.position + values["load_force"] * acts)


def taken(load: float, simulated: bool) -> tuple[bool, float, float]:
    """Whether a load of so many N is taken, what it gains, and what is asked of it."""
    balance = made_balance([made_motion()], once, {"spring_stiffness": 2000.0, "load_force": load})
    first = fit(balance, START, ["spring_stiffness"], None, EXACT)
    current = fit(balance, START, ["spring_stiffness"], None, EXACT, weighing_at(first))
    settle = (lambda found: found) if simulated else None
    ask = Asked(START, {}, 10, {}, settle=settle)
    tried = fitted_with(current, {}, LOAD, ask)
    best, _ = choose([(LOAD, tried)], current, {}, {}, ask)
    return best is not None, gain(current, tried), ask.price_of(LOAD, {}, balance)


def gain(before: Fit, after: Fit) -> float:
    """In the logarithm of the likelihood."""
    return 0.5 * (before.squares - after.squares)


@pytest.mark.parametrize("simulated", [True, False])
def test_what_happens_once_has_to_gain_more_and_in_a_simulation(simulated: bool) -> None:
    is_taken, gained, asked = taken(0.6, simulated)
    assert gained > (1.0 + BEYOND) * asked
    assert is_taken is simulated


def test_what_happens_once_and_gains_what_is_asked_is_not_taken() -> None:
    is_taken, gained, asked = taken(0.33, simulated=True)
    assert asked < gained < (1.0 + BEYOND) * asked
    assert not is_taken


def along_the_way(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """A force that is a straight line over the way, or a parabola."""
    share = motion.position / 0.04
    return np.asarray(100.0 * (values["friction_gradient"] * share + values["friction_curvature"] * share**2))


@pytest.mark.parametrize(("bends", "needed"), [(0.0, False), (0.01, True)])
def test_an_effect_with_more_of_its_numbers_is_another_set(bends: float, needed: bool) -> None:
    """What it leaves less is hardly seen in an rms, and certain by its likelihood."""
    start = {"friction_gradient": 0.0, "friction_curvature": 0.0}
    balance = made_balance([made_motion()], along_the_way, {"friction_gradient": 0.2, "friction_curvature": bends})
    current = fit(balance, start, ["friction_gradient"], None, EXACT)
    effects = {"position_dependent_friction": ("friction_gradient",)}
    trial = Trial("position_dependent_friction", ("friction_curvature",))
    more = Proposal((trial,), (), 0.0, 0.0, {"friction_curvature": 0.01})
    ask = Asked(start, {}, 10, {}, settle=lambda found: found)
    tried = fitted_with(current, effects, more, ask)
    assert tried.rms > NEARER * current.rms
    best, _ = choose([(more, tried)], current, effects, {numbers_of(effects): current.rms}, ask)
    assert (best is not None) is needed


def scattered(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """A spring, a load, and slow noise of which a fit that weighs all samples alike knows nothing."""
    slow = lfilter([1.0], [1.0, -0.98], np.random.default_rng(5).standard_normal(motion.time.size))
    way = values["spring_stiffness"] * motion.position
    return np.asarray(way + values["load_force"] + values.get("scatter", 0.0) * slow)


@pytest.mark.parametrize(("load", "certain"), [(0.0, False), (5.0, True)])
def test_an_effect_is_certain_by_its_own_deviations_too(load: float, certain: bool) -> None:
    """Slow noise gains far more than is asked, as a load; its own deviation, which knows of slow noise, says so."""
    truth = {"spring_stiffness": 2000.0, "load_force": load, "scatter": 0.2}
    balance = replace(made_balance([made_motion()], scattered, truth, effects=("constant_load",)), name=SIMULATION)
    first = fit(balance, START, ["spring_stiffness"], None, EXACT)
    current = fit(balance, START, ["spring_stiffness"], None, EXACT, first.weighing)
    ask = Asked(START, {}, 10, {}, settle=lambda found: found)
    tried = fitted_with(current, {}, LOAD, ask)
    assert gain(current, tried) > 2.0 * ask.price_of(LOAD, {}, balance)
    assert (certainty_of(tried, "constant_load", ["load_force"], ask) > 0.0) is certain
    for start, given in ((current, {}), (tried, {"constant_load": ("load_force",)})):
        assert list(search(start, given, ask).effects) == ["constant_load"] * certain
