"""The rig of a design: where a rival begins under the command of another plant."""

import numpy as np
import pytest
from drawn_machines import pneumatic

from plants.registry import plants
from workbench.design.pieces import Condition, Reach
from workbench.design.rig import Limits, Replay, Rig
from workbench.diagnose.residuals.balances import diagnosed_plant
from workbench.diagnose.residuals.weighing import Whitening

NOISE = {"position": 1e-5, "pressure_1": 100.0, "pressure_2": 100.0}


def test_a_rival_begins_where_the_true_plant_does() -> None:
    """A valve that leaks next to nothing has set pressures at rest, one that is tight has any."""
    values = {**pneumatic(3), "leakage_conductance": 1e-18}
    rig = Rig(
        along=diagnosed_plant(plants()["pneumatic_cylinder"], "derived", [*NOISE, "time", "valve_voltage"]),
        steering=None,
        believed=values,
        sample_time=1e-3,
        grain=1,
        noise=NOISE,
        whitening={name: Whitening.of(1.0) for name in NOISE},
        limits=Limits(),
        reach=Reach(-1.0, 1.0, 10.0, 1e-3),
        conditions=[Condition()],
    )
    leaks = rig.driven(values, 4.0 * np.sin(np.linspace(0.0, 6.0, 600)), Condition())
    without = {**values, "leakage_conductance": 0.0}
    asked = [Replay(without, leaks, Condition()), Replay(values, leaks, Condition(), rig.moves()[0])]
    tight, moved = rig.replayed(asked)
    assert tight.state("position") == pytest.approx(leaks.state("position"), abs=1e-9)
    assert np.ptp(leaks.state("position")) > 1e-4
    assert tight.state("pressure_1") == pytest.approx(leaks.state("pressure_1"), abs=1.0)
    assert moved.state("position")[0] == pytest.approx(leaks.state("position")[0] + rig.moves()[0][0])
