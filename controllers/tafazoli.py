"""Tafazoli's model-based estimate: the modified Tustin map, blended into a balance of forces near rest."""

import numpy as np

from controllers.friction_observer import Belief, Memory, Seen
from plants.equation import Scalar, equation
from plants.friction import Friction, LuGre, Tustin, modified_tustin, steady_friction

SLOWEST, FASTEST = 1e-3, 0.25
"""m/s. Range over which the map is fitted to the believed friction."""

FIT_POINTS = 500


@equation
def tafazoli(seen: Seen, memory: Memory, belief: Belief, sample_time: Scalar) -> tuple[Scalar, Memory]:
    """F^ = F_dyn + (F_app - F_dyn) exp(-(v^/D_v)^2)  (N); F_app within +- the believed static friction.

    Thesis 2.7 to 2.9, where the estimate switches from F_dyn to F_app at |v^| = D_v and jumps by 37 % of their
    difference; here it is blended everywhere [derived here].
    """
    positive = belief.friction.positive
    static = positive.coulomb + positive.stribeck
    held = np.minimum(np.maximum(seen.applied_force, -static), static)
    moving = modified_tustin(seen.velocity, belief.map)
    return moving + (held - moving) * np.exp(-((seen.velocity / belief.blend_velocity) ** 2)), memory


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
