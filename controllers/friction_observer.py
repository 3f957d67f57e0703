"""What friction estimators have in common: what they see, what they remember, what they believe.

A friction estimator is one equation, `estimate(seen, memory, belief, sample_time) -> (force, memory)`. All share one
memory and one belief, so that any of them goes with any law of `controllers.compensation_laws`.
"""

import math
from collections.abc import Callable
from typing import Annotated, NamedTuple, TypeAlias

from controllers.believed_friction import Turning
from plants.equation import Scalar
from plants.friction import Friction, Tustin


class Seen(NamedTuple):
    """What an estimator is given at a sample: nothing that a rig does not measure or command.

    `gauge` alone is no rig's: the reading of the hypothetical friction gauge, NaN for all but `friction_gauge`.
    """

    velocity: Annotated[float, "m/s"]
    previous_velocity: Annotated[float, "m/s"]
    applied_force: Annotated[float, "N"]
    sliding: Annotated[float, "m/s"]
    surface_speed: Annotated[float, "m/s"] = 0.0
    gauge: Annotated[float, "N"] = math.nan
    reference_velocity: Annotated[float, "m/s"] = 0.0


class Memory(NamedTuple):
    """State of the estimators.

    Friedland-Park's level, or the filtered load force; LuGre's bristle, its adaptive factor, the momentum.
    """

    level: Annotated[float, "N"]
    bristle: Annotated[float, "m"]
    theta: Annotated[float, "1"]
    momentum: Annotated[float, "N s"]
    previous_velocity: Annotated[float, "m/s"]


class Belief(NamedTuple):
    """What an estimator believes of mass and friction, and its own settings."""

    mass: Annotated[float, "kg"]
    friction: Friction
    turning: Turning
    map: Tustin
    reversal_speed: Annotated[float, "m/s"]
    blend_velocity: Annotated[float, "m/s"]
    observer_gain: Annotated[float, "N s/m"]
    exponent: Annotated[float, "1"]
    injection: Annotated[float, "1"]
    adaptation: Annotated[float, "1/J"]
    pressure_gain: Annotated[float, "1"]


Estimate: TypeAlias = Callable[[Seen, Memory, Belief, Scalar], tuple[Scalar, Memory]]
"""A friction estimator: the estimated force (N) and what it remembers."""
