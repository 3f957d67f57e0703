"""The search for what a balance lacks: where a shape that another residual showed is wrong, the right one is found."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from made_up_balances import made_balance, made_motion, ripple

from workbench.diagnose.residuals.balance import SIMULATION
from workbench.diagnose.residuals.fit import AS_IT_IS, fit, weighing_at
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.selection.judging import _is_sure, choose
from workbench.diagnose.selection.likelihood import Proposal
from workbench.diagnose.selection.search import MOST, _gained_by, search
from workbench.diagnose.selection.selection import Candidate, Step
from workbench.diagnose.selection.sets import FAR, Asked, fitted_with, fitted_without
from workbench.diagnose.selection.trials import Shape, Shapes, Trial
from workbench.fitting.least_squares import Search

EXACT = Search(flat=1e-14)
PITCH = 0.01
TRUTH = {"cogging_cosine": 0.3, "cogging_sine": -0.4, "cogging_pitch": PITCH, "load_force": 0.0}
START = {"load_force": 0.0}
WRONG: Shape = (("cogging_pitch", 0.0137),)


def asked(shapes: Shapes) -> Asked:
    return Asked(START, {}, 10, shapes, settle=lambda found: found)


@pytest.mark.parametrize("shapes", [{}, {"cogging": [WRONG]}])
def test_a_shape_that_was_taken_for_the_best_is_not_the_only_one(shapes: Shapes) -> None:
    balance = replace(made_balance([made_motion()], ripple, TRUTH, effects=("cogging",)), name=SIMULATION)
    found = search(fit(balance, START, ["load_force"], None, EXACT), {}, asked(shapes))
    assert list(found.effects) == ["cogging"]
    assert found.fit.values["cogging_pitch"] == pytest.approx(PITCH, rel=1e-2)
    assert abs(found.fit.values["cogging_sine"] + 0.4) < 4.0 * found.fit.deviations["cogging_sine"]


def test_what_an_effect_gained_is_known_of_one_that_was_added_alone() -> None:
    """Beside another it may be worth far more than by itself: the round of both knows nothing of it."""
    current = fit(made_balance([made_motion()], ripple, TRUTH), START, ["load_force"], None, EXACT)
    steps = [
        Step(current, [Candidate("a", ("x",), 9.0, 6.0), Candidate("b", ("y",), 2.0, 6.0)], ("a",)),
        Step(current, [Candidate("c", ("z",), -29.5, 6.0), Candidate("d", ("w",), 24.4, 6.0)], ("c", "d")),
    ]
    assert [_gained_by(effect, steps) for effect in "abcd"] == [9.0, np.inf, np.inf, np.inf]


def test_a_set_that_was_left_is_taken_again_where_it_is_nearer_now() -> None:
    """What was found has led the plant's own parameters out of a hollow: without it they leave as little."""
    balance = replace(made_balance([made_motion()], ripple, {**TRUTH, "load_force": 2.0}), name=SIMULATION)
    whole = ["load_force", "cogging_cosine", "cogging_sine"]
    first = fit(balance, START, whole, None, EXACT)
    current = fit(balance, {**first.values, "cogging_cosine": 0.0}, whole, None, EXACT, weighing_at(first))
    plain = fit(balance, {**current.values, "cogging_cosine": 0.0, "cogging_sine": 0.0}, ["load_force"], None, EXACT)
    taken = {"cogging": ("cogging_cosine", "cogging_sine")}
    drop = Proposal((), ("cogging",), 0.0, 0.0, {})
    ask = replace(asked({}), candidates=10**60)  # so much is asked of it that it is not worth it
    for rms, again in ((10.0 * plain.rms, True), (plain.rms, False)):
        best, _ = choose([(drop, plain)], current, taken, {frozenset(): rms}, ask)
        assert (best is not None) is again


@pytest.mark.parametrize(("load", "sure"), [(0.0, False), (2.0, True)])
def test_what_comes_in_exchange_is_held_against_the_plant_without_either(load: float, sure: bool) -> None:
    """Beside a ripple that is not there a load gains much, whether it is there or not."""
    balance = replace(made_balance([made_motion()], ripple, {"load_force": load}), name=SIMULATION)
    waves = ("cogging_cosine", "cogging_sine")
    bad = fit(balance, {**START, "cogging_cosine": 1.0, "cogging_sine": 1.0}, waves, None, AS_IT_IS)
    found = fit(balance, START, ["load_force"], None, EXACT)
    exchange = Proposal((Trial("constant_load", ("load_force",)),), ("cogging",), 0.0, 0.0, {})
    assert bad.squares - found.squares > 100.0
    assert _is_sure(exchange, found, bad, bad, {"cogging": waves}, asked({})) is sure


def buffer(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """A spring from a place on, and a load."""
    way = motion.position - values.get("cushion_start", 0.0)
    met = np.maximum(way, 0.0) if values.get("cushion_start", 0.0) >= 0.0 else np.minimum(way, 0.0)
    return np.asarray(values.get("cushion_stiffness", 0.0) * met + values.get("load_force", 0.0))


@pytest.mark.parametrize("share", [-0.33, -0.17, 0.04, 0.27, 0.38])
def test_far_from_noise_an_effect_begins_in_the_shape_that_shows_most(share: float) -> None:
    travel = 0.04
    truth = {"cushion_stiffness": 8e5, "cushion_start": share * travel, "load_force": 50.0}
    balance = made_balance([made_motion(travel=travel)], buffer, truth, effects=("cushion", "cogging", "constant_load"))
    start = fit(balance, START, ["load_force"], None, EXACT)
    assert start.rms > FAR
    found = search(start, {}, asked({}))
    assert list(found.effects) == ["cushion"]
    for name, true in truth.items():
        assert found.fit.values[name] == pytest.approx(true, abs=4.0 * found.fit.deviations[name]), name


TURN = 1e3
"""N/m: of a spring whose force turns by a radian along half a way of 40 mm."""


def bending(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """A force that bends with the stiffness of a spring, and turns its sign before long."""
    return np.asarray(100.0 * np.sin(values["spring_stiffness"] / TURN * motion.position / 0.02))


@pytest.mark.parametrize("times", [1.0, 10.0, 30.0])
def test_far_from_noise_a_fit_begins_at_a_part_of_the_way_to_first_order(times: float) -> None:
    start = {"spring_stiffness": 0.0}
    balance = made_balance([made_motion()], bending, {"spring_stiffness": TURN})
    current = fit(balance, start, [], None, EXACT)
    assert current.excess > FAR
    trial = Trial("spring_load", ("spring_stiffness",))
    proposal = Proposal((trial,), (), 0.0, 0.0, {"spring_stiffness": times * TURN})
    found = fitted_with(current, {}, proposal, Asked(start, {}, 10, {}))
    assert found.values["spring_stiffness"] == pytest.approx(TURN, abs=4.0 * found.deviations["spring_stiffness"])


LEVER = 20.0
"""1/m: how much of a spring is as good as a load."""


def turning(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """The same with the sum of a load and a spring, and a little of the spring alone."""
    spring = values.get("spring_stiffness", 0.0)
    both = bending(motion, {"spring_stiffness": LEVER * values["load_force"] + spring})
    return both + 0.01 * spring * motion.position


@pytest.mark.parametrize("times", [1.0, 30.0])
def test_what_an_effect_carried_falls_to_the_own_parameters_without_it(times: float) -> None:
    """Where these begin as they are a fit without it is lost among hollows, and the effect stays for good."""
    balance = made_balance([made_motion()], turning, {"load_force": TURN / LEVER, "spring_stiffness": 0.0})
    load, names = (1.0 - times) * TURN / LEVER, ("spring_stiffness",)
    place = {"load_force": load, "spring_stiffness": times * TURN}
    current = fit(balance, place, ["load_force", *names], None, AS_IT_IS)
    found = fitted_without(current, {"spring_load": names}, ["spring_load"], Asked(START, {}, 10, {}))
    assert found.values["load_force"] == pytest.approx(TURN / LEVER, abs=4.0 * found.deviations["load_force"])
    assert found.rms < 1.1


def winding(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """A load, and a force that is none again after a full turn."""
    turn = np.sin(2.0 * np.pi * values.get("spring_stiffness", 0.0) / TURN)
    return np.asarray(100.0 * turn * motion.position / 0.02 + values["load_force"])


@pytest.mark.parametrize(("spring", "kept"), [(TURN, []), (0.2 * TURN, ["spring_load"])])
def test_an_effect_that_was_given_goes_where_as_little_is_left_without(spring: float, kept: list[str]) -> None:
    """By what a fit without it leaves: first order says that much would be lost."""
    truth = {"load_force": 2.0, "spring_stiffness": spring}
    balance = made_balance([made_motion()], winding, truth, effects=("spring_load",))
    balance = replace(balance, name=SIMULATION)
    found = fit(balance, truth, [*truth], None, EXACT)
    ended = search(found, {"spring_load": ("spring_stiffness",)}, asked({}))
    assert list(ended.effects) == kept
    assert ended.steps[0].dropped == (() if kept else ("spring_load",))
    assert ended.fit.rms == pytest.approx(found.rms, rel=1e-2)


SIZES = {
    "load_force": 3.0,
    "spring_stiffness": 200.0,
    "drag_coefficient": 2e3,
    "viscous_drift": 0.05,
    "friction_gradient": 0.2,
    "backlash_width": 1e-5,
}
"""Each makes about 3 N."""


def many(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """As many forces, none of which is made of the others."""
    waves = [np.sin((1.7 + 0.61 * k) * motion.time) for k in range(len(SIZES))]
    return np.asarray(
        sum(3.0 * values.get(name, 0.0) / SIZES[name] * wave for name, wave in zip(SIZES, waves, strict=True))
    )


@pytest.mark.parametrize("present", [MOST, len(SIZES)])
def test_no_more_are_sought_than_a_plant_may_lack_at_once(present: int) -> None:
    truth = dict(list(SIZES.items())[:present])
    effects = (
        "constant_load",
        "spring_load",
        "quadratic_drag",
        "viscous_drift",
        "position_dependent_friction",
        "backlash",
    )
    balance = replace(made_balance([made_motion()], many, truth, effects=effects), name=SIMULATION)
    start = dict.fromkeys(SIZES, 0.0)
    found = search(fit(balance, start, [], None, EXACT), {}, Asked(start, {}, 10, {}, settle=lambda found: found))
    assert len(found.effects) == MOST
    assert (found.fit.excess < 1.1) is (present == MOST), "what four do not explain is left"


@pytest.mark.parametrize("told", [False, True])
def test_other_numbers_of_an_effect_that_do_as_well_are_told(told: bool) -> None:
    """A leak of one chamber is that of the other, where no pressure tells which."""

    def leaking(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
        other = 1.0 + told * np.sin(motion.position / 0.004)
        one, two = (values.get(f"external_leakage_{chamber}", 0.0) for chamber in (1, 2))
        return np.asarray(1e14 * (one + 2.0 * other * two))

    true = {"external_leakage_1": 5e-14}
    balance = replace(made_balance([made_motion()], leaking, true, effects=("external_leakage",)), name=SIMULATION)
    found = search(fit(balance, {}, [], None, EXACT), {}, Asked({}, {}, 10, {}, settle=lambda one: one))
    (own,) = found.effects.values()
    assert len(own) == 1
    if told:
        assert own == ("external_leakage_1",)
        assert found.otherwise == {}
    else:
        (others,) = found.otherwise.values()
        assert {own, *others} == {("external_leakage_1",), ("external_leakage_2",)}
