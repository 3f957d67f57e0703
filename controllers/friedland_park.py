"""Friedland and Park's observer of the Coulomb level, as Tafazoli modified it: filtered velocity, pressure force."""

import numpy as np

from controllers.friction_observer import Belief, Memory, Seen
from controllers.static_map import saturated_sign
from plants.equation import Scalar, equation, select

REVERSAL_SPEED = 1e-4
"""m/s. Slower, the level is held and the estimate goes through 0 on a straight line."""

LARGEST_LEVEL = 2000.0
"""N. The estimate stays within 0 and this."""


@equation
def friedland_park(seen: Seen, memory: Memory, belief: Belief, sample_time: Scalar) -> tuple[Scalar, Memory]:
    """F^ = a^ sat(v^/eps)  (N), a^ the estimated level of friction while it moves.

        a^ += (1 - exp(-lam h)) (sgn(v_m) (F_app - M dv^/h) - a^),  lam = (k mu / M) |v_m|^(mu - 1)

    with v_m the mean of the velocity before and now, and a^ held while |v_m| is below `REVERSAL_SPEED`. This is the
    sampled form of a^ = z - k |v|^mu, dz/dt = (k mu / M) |v|^(mu-1) (F_app - a^ sgn v) sgn v (thesis 2.2.1.2) that is
    safe at rest [derived here]: the error falls as de/dt = -lam e. mu < 1 is singular at rest, mu > 1 freezes there.
    """
    middle = 0.5 * (seen.velocity + seen.previous_velocity)
    speed = np.maximum(np.abs(middle), REVERSAL_SPEED)
    rate = belief.observer_gain * belief.exponent / belief.mass * speed ** (belief.exponent - 1.0)
    acceleration = (seen.velocity - seen.previous_velocity) / sample_time
    wanted = np.sign(middle) * (seen.applied_force - belief.mass * acceleration)
    updated = memory.level - np.expm1(-rate * sample_time) * (wanted - memory.level)
    limited = np.minimum(np.maximum(updated, 0.0), LARGEST_LEVEL)
    level = select(np.abs(middle) > REVERSAL_SPEED, limited, memory.level)
    following = Memory(level, memory.bristle, memory.theta, memory.momentum, seen.velocity)
    return level * saturated_sign(seen.velocity, REVERSAL_SPEED), following
