"""LuGre observers: the bristle advanced along the measured motion, with a fixed or an adapted level of friction."""

import numpy as np

from controllers.believed_friction import contact, saturated_sign
from controllers.friction_observer import Belief, Memory, Seen
from plants.equation import Scalar, equation, select
from plants.friction import helical_speed

SLOWEST_ADAPTATION = 2e-3
"""m/s. Slower, theta is frozen: near rest the residual says more about presliding than about the level."""

SATURATED_BRISTLE = 0.8
"""Share of its steady deflection that the bristle must have for theta to move."""

THETA_RANGE = (0.4, 2.5)
RESIDUAL_RATE = 50.0
"""1/s. Bandwidth of the momentum residual."""


@equation
def decay_share(exponent: Scalar) -> Scalar:
    """(1 - exp(-a)) / a for a >= 0, smooth at 0, where it is 1."""
    safe = np.maximum(exponent, 1e-12)
    return select(exponent > 1e-6, -np.expm1(-safe) / safe, 1.0 - 0.5 * exponent)


@equation
def _advance(
    seen: Seen, bristle: Scalar, theta: Scalar, belief: Belief, sample_time: Scalar
) -> tuple[Scalar, Scalar, Scalar]:
    """Friction estimate (N), next bristle (m) and relaxation rate r (1/s), v^ held over the sample.

    The exact solution of dz/dt = v^ - theta r z + k s over one sample; explicit Euler at 1 ms would be unstable above
    some 0.13 m/s. r = sigma0 |v^| / g without rotation, sigma0 v_h / g(v_h) of a rod that turns, and sigma0 w / S_a^2
    where its friction differs along and around (`plants.anisotropic`). The bristle's damping fades with speed, sigma1
    exp(-(v_h/v_s)^2), which keeps the observer passive. A guide that does not turn has its steady level.
    """
    v = seen.velocity
    p, _, levels = contact(v, seen.surface_speed, bristle, belief.friction, belief.turning)
    own = 1.0 - levels.guide_share
    stiffness = own * p.bristle_stiffness
    relaxation = stiffness * levels.sliding / levels.axial**2
    exponent = theta * relaxation * sample_time
    drive = v + belief.injection * seen.sliding
    following = bristle * np.exp(-exponent) + drive * sample_time * decay_share(exponent)
    fading = np.exp(-((helical_speed(v, seen.surface_speed) / p.stribeck_velocity) ** 2))
    damped = own * p.bristle_damping * fading * (following - bristle) / sample_time
    guided = levels.guide * saturated_sign(v, belief.reversal_speed)
    return stiffness * following + damped + p.viscous * v + guided, following, relaxation


@equation
def lugre_observer(seen: Seen, memory: Memory, belief: Belief, sample_time: Scalar) -> tuple[Scalar, Memory]:
    """F^ = sigma0 z^ + sigma1(v^) dz^/dt + a2 v^  (N) with the believed parameters. Thesis 2.11, sampled."""
    force, bristle, _ = _advance(seen, memory.bristle, memory.theta, belief, sample_time)
    return force, Memory(memory.level, bristle, memory.theta, memory.momentum, seen.velocity)


@equation
def friction_feedforward(seen: Seen, memory: Memory, belief: Belief, sample_time: Scalar) -> tuple[Scalar, Memory]:
    """F^ of the same law (N) along the reference's motion, as if it were followed: nothing is fed back.

    What is known beforehand may be differentiated: a law may feed forward the flow that compresses the oil.
    """
    wanted = Seen(seen.reference_velocity, seen.reference_velocity, seen.applied_force, 0.0, seen.surface_speed)
    force, bristle, _ = _advance(wanted, memory.bristle, memory.theta, belief, sample_time)
    return force, Memory(memory.level, bristle, memory.theta, memory.momentum, seen.velocity)


@equation
def lugre_adaptive(seen: Seen, memory: Memory, belief: Belief, sample_time: Scalar) -> tuple[Scalar, Memory]:
    """The same with theta adapted; steady friction is g/theta, so that a larger theta is less friction.

        d theta/dt = -gamma r z^ res,   d p/dt = F_app - F^ - res,   res = L (p - M v^)

    res is the momentum residual: what force the estimate lacks, through a low-pass of L = `RESIDUAL_RATE`. Frozen
    near rest and while the bristle is far from its steady deflection, and projected to `THETA_RANGE`: without these
    guards theta drifts the wrong way at low speed. [derived here from the Lyapunov form with z - z^ for res]
    """
    force, bristle, relaxation = _advance(seen, memory.bristle, memory.theta, belief, sample_time)
    residual = RESIDUAL_RATE * (memory.momentum - belief.mass * seen.velocity)
    momentum = memory.momentum + sample_time * (seen.applied_force - force - residual)
    steady = np.abs(seen.velocity) / np.maximum(memory.theta * relaxation, 1e-12)
    step = -sample_time * belief.adaptation * relaxation * bristle * residual
    moved = np.minimum(np.maximum(memory.theta + step, THETA_RANGE[0]), THETA_RANGE[1])
    saturated = select(np.abs(bristle) > SATURATED_BRISTLE * steady, moved, memory.theta)
    theta = select(np.abs(seen.velocity) > SLOWEST_ADAPTATION, saturated, memory.theta)
    return force, Memory(memory.level, bristle, theta, momentum, seen.velocity)
