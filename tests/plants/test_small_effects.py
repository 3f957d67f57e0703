"""Effects smaller than a solver can follow act in proportion, as larger ones do; and a rate that jumps ends no run."""

import numpy as np
import pytest
from effect_machines import at_rest, having

from workbench.simulation.references import Multisine
from workbench.simulation.simulate import Feed, Integrator, Run, Setup, simulate

LARGE = {"valve_hysteresis": 1e-3, "command_delay": 1e-4, "position_sensor_lag": 1e-4, "memory_time": 1e-4}
"""Where they are in proportion on this rig: lags as short as the shortest that is simulated."""

NOTHING = dict.fromkeys(LARGE, 0.0)


def run_with(values: dict[str, float], tolerance: float) -> Run:
    """An open-loop run of the thesis's rig whose plant has the effects."""
    plant, p = having("two_chamber", values)
    state, inputs = at_rest(plant, p)
    feeds = (Feed(plant.command, Multisine(3.0, 0.7, (1, 2, 3))),)
    return simulate(Setup(plant, p, state, inputs, 1.5, feeds=feeds, integrator=Integrator(tolerance=tolerance)))


@pytest.mark.parametrize("name", LARGE)
@pytest.mark.parametrize("share", [1e-2, 1e-4])
def test_a_small_effect_acts_in_proportion(name: str, share: float) -> None:
    """What a play or a lag changes goes to 0 with it: what a solver needs to follow one leaves nothing of its own."""
    sizes = (0.0, LARGE[name], share * LARGE[name])
    without, large, small = (run_with({**NOTHING, name: size}, 1e-12).measurements[:, 0] for size in sizes)
    changed = np.linalg.norm(large - without)
    assert changed > 0.0
    assert np.linalg.norm((small - without) / share - (large - without)) < 0.05 * changed


def test_a_rate_that_jumps_ends_no_run_at_any_tolerance() -> None:
    """Backlash and a spool that sticks: a step that is short enough crosses the jump, and the motion is the same."""
    values = {"backlash_width": 5e-5, "spool_stiction": 0.01}
    coarse, fine = run_with(values, 1e-8), run_with(values, 1e-11)
    assert coarse.outcome == fine.outcome == "completed"
    assert fine.steps > 2 * coarse.steps
    assert coarse.state("position") == pytest.approx(fine.state("position"), abs=1e-7)
