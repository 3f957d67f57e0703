"""Tafazoli's model-based estimate: the modified Tustin map, blended into a balance of forces near rest."""

import numpy as np

from controllers.believed_friction import contact, steady_along
from controllers.friction_observer import Belief, Memory, Seen
from plants.equation import Scalar, equation
from plants.friction import TINY, Friction, LuGre, Tustin, helical_speed, modified_tustin, steady_friction

SLOWEST, FASTEST = 1e-3, 0.25
"""m/s. Range over which the map is fitted to the believed friction."""

FIT_POINTS = 500


@equation
def tafazoli(seen: Seen, memory: Memory, belief: Belief, sample_time: Scalar) -> tuple[Scalar, Memory]:
    """F^ = F_dyn + (F_app - F_dyn) exp(-(v_h/D_v)^2)  (N); F_app within +- the believed static friction.

    Thesis 2.8 and 2.9, where the estimate switches from F_dyn to F_app at |v^| = D_v and jumps by 37 % of their
    difference; here it is blended everywhere [derived here].

    Without rotation v_h = |v^| and F_dyn is the map at v^. Of a rod that turns it is T(v_h) F(v^, w) / F(v_h, 0): the
    map at the helical speed, times the believed law's steady friction along the rod over that of a rod that slides as
    fast without turning. Where friction is the same along and around, that is T(v_h) v/v_h. A turning contact is never
    at rest, and its forces are never balanced by sticking: hence v_h in the blend. [derived here]
    """
    positive = belief.friction.positive
    static = positive.coulomb + positive.stribeck
    held = np.minimum(np.maximum(seen.applied_force, -static), static)
    speed = helical_speed(seen.velocity, seen.surface_speed)
    along, _, levels = contact(seen.velocity, seen.surface_speed, seen.velocity, belief.friction, belief.turning)
    share = steady_along(seen.velocity, TINY, along, levels) / steady_friction(speed, along)
    moving = modified_tustin(speed, belief.map) * share
    return moving + (held - moving) * np.exp(-((speed / belief.blend_velocity) ** 2)), memory


def fit_map(friction: Friction) -> tuple[Tustin, float]:
    """The modified Tustin map nearest to the believed friction, and its residual.

    Least squares over `SLOWEST` to `FASTEST`, evenly in velocity, of the mean of both directions of motion (the map
    is odd).

    Returns:
        the map, and the root mean square of its residual (N).
    """
    speeds = np.linspace(SLOWEST, FASTEST, FIT_POINTS)
    sets: tuple[LuGre, LuGre] = (friction.positive, friction.negative)
    wanted = np.mean([steady_friction(speeds, one) for one in sets], axis=0)
    design = np.column_stack([np.ones_like(speeds), np.sqrt(speeds), speeds])
    found = np.linalg.lstsq(design, wanted, rcond=None)[0]
    residual = float(np.sqrt(np.mean((design @ found - wanted) ** 2)))
    return Tustin(*(float(number) for number in found)), residual
