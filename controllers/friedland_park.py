"""Friedland and Park's observer of the Coulomb level, as Tafazoli modified it: filtered velocity, pressure force."""

import numpy as np

from controllers.believed_friction import turned_sign
from controllers.friction_observer import Belief, Memory, Seen
from plants.equation import Scalar, equation, select
from plants.friction import TINY, helical_speed

REVERSAL_SPEED = 1e-4
"""m/s. Slower, the level is held and the estimate goes through 0 on a straight line."""

LARGEST_FORCE = 2000.0
"""N. The estimate stays within 0 and this."""

SLOWEST_SHARE = 2e-3
"""m/s. A rod that turns and moves along no faster than this tells little of the level: it follows more slowly there."""


@equation
def friedland_park(seen: Seen, memory: Memory, belief: Belief, sample_time: Scalar) -> tuple[Scalar, Memory]:
    """F^ = a^ v^ / max(v_h, eps)  (N), a^ the estimated level of friction while it moves.

        a^ += (1 - exp(-lam h)) c (F_app - M dv^/h - a^ c) / max(c^2, c_s^2),  c = v_m / v_h,
        lam = (k mu / M) v_h^(mu - 1),  c_s = 2 mm/s |w| / v_h^2

    with v_m the mean of the velocity before and now, and a^ held while |v_m| is below `REVERSAL_SPEED`. Without
    rotation v_h = |v_m| and c = sgn(v_m): the sampled form of a^ = z - k |v|^mu, dz/dt = (k mu / M) |v|^(mu-1) (F_app -
    a^ sgn v) sgn v (thesis 2.2.1.2) that is safe at rest. The error falls as de/dt = -lam e. mu < 1 is singular at
    rest, mu > 1 freezes there. [derived here]

    Of a rod that turns, a^ is the level along the helix and c the share of it that acts along the rod, where the rod
    that only slides has a sign: F = a v/v_h. From a^ = z - V(v), V' = lam M / c, dz/dt = lam (F_app - a^ c) / c and
    M dv/dt = F_app - a c follows de/dt = -lam e again; below some 2 mm/s it is -lam (c/c_s)^2 e, since there v/v_h is
    small and what is left of the force is noise. No friction model is needed for it, and none used: where friction
    around the rod is less than along, a^ is the larger for it. [derived here]
    """
    middle = 0.5 * (seen.velocity + seen.previous_velocity)
    speed = np.maximum(helical_speed(middle, seen.surface_speed), REVERSAL_SPEED)
    rate = belief.observer_gain * belief.exponent / belief.mass * speed ** (belief.exponent - 1.0)
    acceleration = (seen.velocity - seen.previous_velocity) / sample_time
    share = turned_sign(middle, seen.surface_speed, REVERSAL_SPEED)
    counted = np.maximum(np.abs(share), SLOWEST_SHARE * np.abs(seen.surface_speed) / speed**2)
    missing = seen.applied_force - belief.mass * acceleration - memory.level * share
    updated = memory.level - np.expm1(-rate * sample_time) * missing * share / (counted**2 + TINY)
    limited = np.minimum(np.maximum(updated, 0.0), LARGEST_FORCE / np.maximum(counted, REVERSAL_SPEED))
    level = select(np.abs(middle) > REVERSAL_SPEED, limited, memory.level)
    following = Memory(level, memory.bristle, memory.theta, memory.momentum, seen.velocity)
    return level * turned_sign(seen.velocity, seen.surface_speed, REVERSAL_SPEED), following
