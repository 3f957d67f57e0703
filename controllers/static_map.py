"""Friction from velocity alone: the believed Stribeck curve, or nothing."""

import numpy as np

from controllers.friction_observer import Belief, Memory, Seen
from plants.equation import Scalar, equation
from plants.friction import LuGre, directed, stribeck_level


@equation
def no_estimate(seen: Seen, memory: Memory, belief: Belief, sample_time: Scalar) -> tuple[Scalar, Memory]:
    """No friction is believed in: what the laws do without compensation."""
    return 0.0, memory


@equation
def saturated_sign(velocity: Scalar, reversal_speed: Scalar) -> Scalar:
    """sat(v / eps), eps = `reversal_speed` (m/s): the sign of the velocity with a steep line through rest."""
    return np.minimum(np.maximum(velocity / reversal_speed, -1.0), 1.0)


@equation
def static_map(seen: Seen, memory: Memory, belief: Belief, sample_time: Scalar) -> tuple[Scalar, Memory]:
    """F^ = g(v^) sat(v^/eps) + a2 v^ (N), the believed steady friction. Thesis (4.7).

    Within eps, `belief.reversal_speed`, the curve's jump at rest is a straight line, so that F^ does not chatter.
    """
    p: LuGre = directed(seen.velocity, seen.velocity, belief.friction)
    level = stribeck_level(seen.velocity, p)
    return level * saturated_sign(seen.velocity, belief.reversal_speed) + p.viscous * seen.velocity, memory
