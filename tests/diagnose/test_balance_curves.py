"""A curve beside a balance's parameters: whether it is likelier than what was found."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest
from made_up_balances import made_balance, made_motion

from plants.effects.curves import CURVES
from plants.registry import THESIS
from workbench.diagnose.residuals.fit import fit, weighing_at
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.selection.balance_curves import CurveFit
from workbench.diagnose.selection.selection import BalanceResult
from workbench.diagnose.selection.sets import Asked


def pulled(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """What stands for a curve: a force in proportion to the way."""
    return np.asarray(values["spring_stiffness"] * motion.position)


@pytest.mark.parametrize(("stiffness", "likelier"), [(2e4, True), (0.0, False)])
def test_a_curve_is_weighed_by_what_it_leaves_wherever_its_fit_began(stiffness: float, likelier: bool) -> None:
    start, names = {"spring_stiffness": 0.0}, ["spring_stiffness"]
    balance = made_balance([made_motion()], pulled, {"spring_stiffness": stiffness})
    plain = fit(balance, start, [])
    result = BalanceResult(balance, plain, plain, [], {}, {}, {})
    own = fit(balance, start, names)
    for found in (own, replace(own, weighing=weighing_at(own).times(1e-4))):
        curve = CurveFit("position", CURVES["force", "position"], THESIS, found)
        assert curve.is_likelier(result, Asked(start, {}, 10, {})) is likelier
