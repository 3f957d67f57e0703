"""Opponents of the friction estimates: what a gauge reads, with no friction model behind it."""

from controllers.friction_observer import Belief, Memory, Seen
from plants.equation import Scalar, equation


@equation
def load_pressure(seen: Seen, memory: Memory, belief: Belief, sample_time: Scalar) -> tuple[Scalar, Memory]:
    """A P_L = A1 P1 - A2 P2 (N), measured: friction, inertia and load together, whatever they are.

    What a valve inversion asks for is the pressure that the load takes, and a friction estimate over A stands in for
    it; here it is measured, through a low-pass of `pressure_time_constant`. Raw pressure inverts the very root by which
    a valve damps the oil column: with the valve's whole lag inverted too, nothing is left of that damping, and the loop
    rings at the oil's resonance after a jump of the reference's velocity. [found here]
    """
    force = memory.level + belief.pressure_gain * (seen.applied_force - memory.level)
    return force, Memory(force, memory.bristle, memory.theta, memory.momentum, seen.velocity)


@equation
def friction_gauge(seen: Seen, memory: Memory, belief: Belief, sample_time: Scalar) -> tuple[Scalar, Memory]:
    """The true friction (N) from a gauge that no rig has: what a perfect friction model would be worth."""
    return seen.gauge, memory
