"""A step that is held: the motion on which it is judged whether a loop hunts at rest."""

from dataclasses import replace

import numpy as np

from workbench.simulation.references import Steps
from workbench.study.resolve import Resolved

HOLD_SHARE = 0.25
"""Of the largest level that any reference asks for: the step after which a rest is judged."""


def held(case: Resolved, level: float, duration: float) -> Resolved:
    """A case that steps to a level (m) from where it starts, and is held there for a duration (s)."""
    setup = replace(case.setup, reference=Steps((level,), duration), duration=duration)
    return replace(case, setup=setup, transient=0.0)


def largest_level(case: Resolved) -> float:
    """The largest level (m) that a case's reference asks for, from where it starts."""
    setup = case.setup
    assert setup.reference is not None
    times = setup.sample_time * np.arange(round(setup.duration / setup.sample_time) + 1)
    return float(np.max(np.abs(setup.reference(times)[0] - setup.state.position)))
