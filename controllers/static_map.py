"""Friction from velocity alone: the believed Stribeck curve, or nothing."""

from controllers.believed_friction import contact, steady_along
from controllers.friction_observer import Belief, Memory, Seen
from plants.equation import Scalar, equation


@equation
def no_estimate(seen: Seen, memory: Memory, belief: Belief, sample_time: Scalar) -> tuple[Scalar, Memory]:
    """No friction is believed in: what the laws do without compensation."""
    return 0.0, memory


@equation
def static_map(seen: Seen, memory: Memory, belief: Belief, sample_time: Scalar) -> tuple[Scalar, Memory]:
    """F^ = g(v^) sat(v^/eps) + a2 v^ (N), the believed steady friction. Thesis (4.7).

    Of a rod that turns, the believed law's steady axial friction at the helical speed: g(v_h) v/v_h + a2 v where
    friction is the same along and around. Within eps, `belief.reversal_speed`, the curve's jump at rest is a straight
    line, so that F^ does not chatter.
    """
    along, _, levels = contact(seen.velocity, seen.surface_speed, seen.velocity, belief.friction, belief.turning)
    return steady_along(seen.velocity, belief.reversal_speed, along, levels), memory
