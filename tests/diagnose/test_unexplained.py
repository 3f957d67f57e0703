"""On which signals a balance's residual depends: means over one at a time, or over one in each direction of motion."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from driven import driven_shooting

from workbench.diagnose.residuals.motion import Motion, motion_of
from workbench.diagnose.selection.unexplained import dependence

PLACE, WIDTH = 0.02, 0.01
"""m: within a way of 0.2 m."""


def moving(motion: Motion) -> Motion:
    """A motion that comes by each place many times, in both directions."""
    time = motion.record.time
    position = 0.07 * np.sin(2.0 * np.pi * 0.9 * time) + 0.03 * np.sin(2.0 * np.pi * 0.31 * time)
    return motion_of(replace(motion.record, channels={**motion.record.channels, "position": position}))


def _depends(folder: Path, made: Callable[[Motion], np.ndarray]) -> Any:
    """On what a residual depends that is so much at each instant, in floors, with a tenth of noise."""
    motions = [moving(motion) for motion in driven_shooting(folder, 5e-6, 12.0)[1]]
    draw = np.random.default_rng(1)
    balance: Any = SimpleNamespace(
        name="force",
        floor=1.0,
        motions=motions,
        known=lambda motion: motion.thinned.valid,
        residuals=lambda motion, _: [made(motion.thinned) + 0.1 * draw.standard_normal(motion.thinned.time.size)],
    )
    return dependence(balance, {})


@pytest.mark.parametrize("turns", [False, True])
def test_what_is_at_one_place_alone_is_seen_whether_it_turns_with_the_motion_or_not(
    tmp_path: Path, turns: bool
) -> None:
    """Friction at a place cancels in a mean over both directions."""

    def bump(motion: Motion) -> np.ndarray:
        ways = np.sign(motion.velocity) if turns else 1.0
        return np.asarray(20.0 * ways * np.exp(-(((motion.position - PLACE) / WIDTH) ** 2)))

    found = _depends(tmp_path, bump)
    assert found is not None
    assert found.signals[0] == "position"
    assert found.shares["position"] > 0.5


def test_a_force_that_steps_once_depends_on_time(tmp_path: Path) -> None:
    """A block that is left out is all that there is of its time: those beside it foretell it, but where it steps."""
    found = _depends(tmp_path, lambda motion: 20.0 * (motion.time > 6.0))
    assert found is not None
    assert found.signals[0] == "time"
    assert found.shares["time"] > 0.8


def test_noise_depends_on_no_signal(tmp_path: Path) -> None:
    draw = np.random.default_rng(2)
    assert _depends(tmp_path, lambda motion: 5.0 * draw.standard_normal(motion.time.size)) is None
