"""Whether effects stand in for what no effect is: a spring that is none, and one that is, on a mass that it holds."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from driven import driven_shooting
from made_up_balances import made_balance, made_motion

from plants.effects.curves import CURVES
from workbench.diagnose.residuals.balance import SIMULATION
from workbench.diagnose.residuals.fit import NEAR_NOISE, Fit, fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.selection.likelihood import gained, left_by
from workbench.diagnose.selection.search import LEVEL, Found
from workbench.diagnose.selection.sets import Asked, without_effects
from workbench.diagnose.selection.unexplained import Dependence
from workbench.diagnose.simulation import believed
from workbench.diagnose.simulation.fits import Fitting
from workbench.diagnose.simulation.lacking import Lacking, dependence_of, lacking
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.stand_ins import Place, standing_in

SPRING, WAY = 2e4, 0.04
"""N/m, of the straight one, and m, within which the mass moves."""

SPRINGS = {
    "straight": lambda way: SPRING * way,
    "hardening": lambda way: SPRING * way**3 / (0.5 * WAY) ** 2,
    "weak": lambda way: 3e-5 * SPRING * way,
}


def found_of(folder: Path, spring: str) -> tuple[Shooting, Fit, Asked]:
    """A mass with a spring, of which a fit has found a straight one."""
    values = -SPRINGS[spring](np.linspace(-WAY, WAY, 12))
    curve = dict(zip(CURVES["force", "position"].own_names, [1.0, -WAY, WAY, *values], strict=True))
    how, motions, declared = driven_shooting(folder, 5e-6, 4.0, acting=curve)
    fitting = Fitting(motions, ("coulomb", "viscous", "spring_stiffness"), {})
    fitted = fitting.final(fitting.found(how, {**declared, "spring_stiffness": SPRING}))
    return fitted.how, fitted.fit, Asked(declared, {}, len(how.effects), {})


def named(folder: Path, spring: str) -> tuple[Shooting, Found, Fit, Asked]:
    """What a search found of it, which gains 40, and the fit without."""
    how, fitted, ask = found_of(folder, spring)
    effects = {"spring_load": ("spring_stiffness",)}
    return how, Found(fitted, effects, [], {"spring_load": 40.0}, {}, {}), without_effects(fitted, effects, ask), ask


@pytest.mark.parametrize("price", [6.0, None])
def test_a_curve_does_in_the_place_of_a_spring_that_is_none(tmp_path: Path, price: float | None) -> None:
    how, fitted, ask = found_of(tmp_path, "hardening")
    taken = {"spring_load": ("spring_stiffness",)}
    told = dependence_of(standing_in(how, Place.of(fitted, taken, 1e4, ask), lacking(how, fitted), price))
    assert told is not None
    assert told.gain is not None
    assert told.gain > 1e4, "more than the spring"
    assert (told.balance, told.signals[0]) == ("force", "position")


def test_no_curve_does_in_the_place_of_a_spring(tmp_path: Path) -> None:
    """It would cost more: nothing is left beside the spring that it could gain."""
    how, fitted, ask = found_of(tmp_path, "straight")
    assert fitted.rms == pytest.approx(1.0, abs=0.1)
    taken = {"spring_load": ("spring_stiffness",)}
    for price in (ask.of("spring_load", taken["spring_load"], fitted.balance), 15.0):
        assert standing_in(how, Place.of(fitted, taken, 1e4, ask), lacking(how, fitted), price) == []


@pytest.mark.parametrize("more", [-1.0, 1.0])
def test_effects_are_not_named_where_one_curve_beside_the_plant_is_likelier(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, more: float
) -> None:
    """By odds that data can tell, with what is asked of each: first order beside the effects need not see it."""
    how, found, without, ask = named(tmp_path, "weak")
    fitted = found.fit
    worth = gained(fitted.balance, left_by(fitted), left_by(ask.settled(without)))
    worth -= ask.of("spring_load", found.effects["spring_load"], fitted.balance)
    assert worth > 10.0
    assert without.excess < NEAR_NOISE
    curve = Lacking("force", "velocity", 16.0 + worth + LEVEL + more, 16.0, np.zeros((fitted.residual.size, 1)))
    monkeypatch.setattr(believed, "standing_in", lambda *_: [])
    monkeypatch.setattr(believed, "lacking", lambda _, of: [] if of is fitted else [curve])
    kept, lacks = believed.believed(how, found, without, ask)
    assert (not kept.effects, lacks is not None) == (more > 0.0, more > 0.0)
    assert kept.fit is fitted or kept.fit.names == without.names


@pytest.mark.parametrize("more", [-1.0, 1.0])
def test_effects_are_not_named_where_more_is_left_beside_than_they_gain(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, more: float
) -> None:
    how, found, without, ask = named(tmp_path, "straight")
    fitted = found.fit
    assert without.excess > NEAR_NOISE
    curve = Lacking("force", "velocity", 40.0 + more, 16.0, np.zeros((fitted.residual.size, 1)))
    monkeypatch.setattr(believed, "standing_in", lambda *_: [])
    monkeypatch.setattr(believed, "lacking", lambda *_: [curve])
    kept, lacks = believed.believed(how, found, without, ask)
    assert lacks is not None
    assert kept.fit is (without if more > 0.0 else fitted)
    assert bool(kept.effects) is (more < 0.0)


def pulled(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """A spring and a load."""
    return np.asarray(values["spring_stiffness"] * motion.position + values["load_force"])


@pytest.mark.parametrize(
    ("stiffness", "left", "kept"),
    [(2e4, 20.0, ["spring_load"]), (2e4, 2000.0, None), (200.0, 20.0, None)],
    ids=["strong", "beside_much", "not_far_off"],
)
def test_a_strong_effect_is_named_beside_what_is_left(stiffness: float, left: float, kept: list[str] | None) -> None:
    """A load that only stood in for what is left is not."""
    truth = {"spring_stiffness": stiffness, "load_force": 0.2}
    start = dict.fromkeys(truth, 0.0)
    balance = replace(made_balance([made_motion()], pulled, truth), name=SIMULATION)
    fitted, plain = (fit(balance, start, names) for names in ([*truth], []))
    effects = {"spring_load": ("spring_stiffness",), "constant_load": ("load_force",)}
    found = Found(
        fitted, effects, [], {"spring_load": 5000.0, "constant_load": 30.0}, {name: [] for name in effects}, {}
    )
    ask = Asked(start, {}, 10, {}, settle=lambda one: one)
    strong = believed.strong_of(found, Dependence("force", {"time": 1.0}, left), plain, ask)
    assert (None if strong is None else list(strong.effects)) == kept
    if strong is not None:
        assert strong.fit.names == ("spring_stiffness",)
        assert strong.fit.values["load_force"] == 0.0
