"""A fit that ended in a hollow of a narrow valley gets to its bottom."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import cast

import numpy as np
import pytest
from made_up_balances import made_balance, made_motion

from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.fit import fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.simulation.fits import Fitting, Simulated
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.valleys import along_valley
from workbench.fitting.least_squares import Search

NAMES = ("spring_stiffness", "viscous")
TRUTH = {"spring_stiffness": 2000.0, "viscous": 300.0}
NARROW = Search(flat=1e-3, most_steps=15, rugged=True)
STARTS = ({"spring_stiffness": 1600.0, "viscous": 340.0}, {"spring_stiffness": 2600.0, "viscous": 340.0})


def hollowed(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """A spring and a damper, and a push that comes and goes with every fiftieth of each: hollows beside one another."""
    hollows = sum(np.sin(50.0 * 2.0 * np.pi * np.log(values[name] / TRUTH[name])) ** 2 for name in NAMES)
    push = 3.0 * hollows * np.cos(2.0 * np.pi * motion.time)
    return np.asarray(values["spring_stiffness"] * motion.position + values["viscous"] * motion.velocity + push)


@dataclass(frozen=True)
class Hollowed:
    """In the place of a simulation from end to end."""

    length: float = np.inf

    def bounded(self, motions: Sequence[Motion], values: Values) -> "Hollowed":
        return self

    def balance(self, motions: Sequence[Motion], names: Sequence[str]) -> Balance:
        return made_balance(motions, hollowed, TRUTH, tuple(names))


class Beginning(Fitting):
    """What is fitted begins where it is: there are no states at its starts."""

    def begun(self, how: Shooting, values: Values) -> Simulated:
        return Simulated(how, fit(how.balance(self.motions, ()), values, ()))

    def bettered(self, best: Simulated) -> Simulated:
        return Simulated(best.how, fit(best.how.balance(self.motions, NAMES), best.fit.values, NAMES, {}, NARROW))


@pytest.mark.parametrize("start", STARTS)
def test_a_fit_that_ended_in_a_hollow_gets_to_the_bottom(start: Values) -> None:
    how, fitting = cast(Shooting, Hollowed()), Beginning([made_motion()], NAMES, {})
    ended = fit(how.balance(fitting.motions, NAMES), start, NAMES, {}, NARROW)
    assert ended.rms > 1.5
    found = along_valley(fitting, Simulated(how, ended))
    assert found.fit.rms == pytest.approx(1.0, abs=0.1)
    for name in NAMES:
        assert found.fit.values[name] == pytest.approx(TRUTH[name], rel=0.04), name


def test_a_fit_that_is_at_noise_stays() -> None:
    how, fitting = cast(Shooting, Hollowed()), Beginning([made_motion()], NAMES, {})
    first = Simulated(how, fit(how.balance(fitting.motions, NAMES), TRUTH, NAMES, {}))
    assert along_valley(fitting, first) is first
