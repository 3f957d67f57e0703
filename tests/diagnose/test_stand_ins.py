"""Whether effects stand in for what no effect is: a spring that is none, and one that is, on a mass that it holds."""

from pathlib import Path

import numpy as np
import pytest
from driven import driven_shooting

from plants.effects.curves import CURVES
from workbench.diagnose.residuals.fit import Fit
from workbench.diagnose.selection.sets import Asked
from workbench.diagnose.simulation.fits import Fitting
from workbench.diagnose.simulation.lacking import dependence_of, lacking
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.stand_ins import Place, standing_in

SPRING, WAY = 2e4, 0.04
"""N/m, of the straight one, and m, within which the mass moves."""

SPRINGS = {"straight": lambda way: SPRING * way, "hardening": lambda way: SPRING * way**3 / (0.5 * WAY) ** 2}

Found = tuple[Shooting, Fit, Asked]


def found_of(folder: Path, spring: str) -> Found:
    """A mass with a spring, of which a fit has found a straight one."""
    values = -SPRINGS[spring](np.linspace(-WAY, WAY, 12))
    curve = dict(zip(CURVES["force", "position"].own_names, [1.0, -WAY, WAY, *values], strict=True))
    how, motions, declared = driven_shooting(folder, 5e-6, 4.0, acting=curve)
    fitting = Fitting(motions, ("coulomb", "viscous", "spring_stiffness"), {})
    fitted = fitting.final(fitting.found(how, {**declared, "spring_stiffness": SPRING}))
    return fitted.how, fitted.fit, Asked(declared, {}, len(how.effects), {})


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
