"""Whether a plant is stiff along a record: then a linearly implicit method simulates it in a fraction of the steps.

A contact that slides relaxes at the rate sigma0 |v| / g(v), and of a bristle that is hardly seen nothing else bounds
the stiffness: explicit steps are stable up to about 3.3 over that rate, however smooth the motion is. What swings has
to be followed by every method, a mass on the bristles of a contact that sticks as well; there the explicit one, of
higher order, needs fewer steps.
"""

import numpy as np

from plants.equation import fields, to_array
from workbench.diagnose.residuals.along import Along
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.residuals.walk import NUDGE
from workbench.simulation.integrators.dormand_prince import DORMAND_PRINCE
from workbench.simulation.integrators.ros34pw2 import ROS34PW2

STABLE = 3.3
"""Where the stability region of the explicit method ends on the negative real axis."""

STIFF, FOLLOWED = 8.0, 2.0
"""Times the steps by which a motion is followed that stability asks for where a plant is stiff; and steps of the
implicit method for each radian of what swings."""


def method_for(along: Along, motion: Motion, values: Values) -> str:
    """The name of the method that simulates a plant with `values` along a record in less time."""
    damped, swings = _fastest(along, motion, values)
    step = motion.record.sample_time
    stiff = damped * step / STABLE > STIFF * max(1.0, FOLLOWED * swings * step)
    return ROS34PW2.name if stiff else DORMAND_PRINCE.name


def _fastest(along: Along, motion: Motion, values: Values) -> tuple[float, float]:
    """The fastest rate (1/s) at which a plant relaxes that slides at the mean speed of a motion, and the fastest one
    (rad/s) at which it swings, sliding or at rest, by the eigenvalues of its Jacobian there. What does nothing of its
    effects does not count.
    """
    state, inputs = map(to_array, along.at_rest(motion, values))
    nudges, parameters = NUDGE * along.magnitudes(motion, values), along.parameters(values)
    acting = [along.names.index(item.name) for item in fields(along.having(along.acts(values), alone=True).State)]

    def linearised() -> tuple[np.ndarray, np.ndarray]:
        states = np.vstack([state, state + np.diag(nudges)])
        rates = along.rates(np.zeros(len(states)), states, np.tile(inputs, (len(states), 1)), parameters)
        return rates[0], ((rates[1:] - rates[0]) / nudges[:, None]).T

    def eigenvalues() -> np.ndarray:
        own = linearised()[1][np.ix_(acting, acting)]
        return np.linalg.eigvals(own) if np.all(np.isfinite(own)) else np.zeros(1)

    resting = eigenvalues()
    state[along.names.index("velocity")] = float(np.mean(np.abs(motion.velocity[motion.valid])))
    rates, jacobian = linearised()
    for place, name in enumerate(along.names):
        if name in along.contact and jacobian[place, place] < 0.0:  # a bristle's rate is linear in how far it is bent
            state[place] -= rates[place] / jacobian[place, place]
    sliding = eigenvalues()
    relaxes = np.max(np.abs(sliding[~_swings(sliding)]), initial=0.0)
    return float(relaxes), float(max(np.max(np.abs(each[_swings(each)]), initial=0.0) for each in (sliding, resting)))


def _swings(eigenvalues: np.ndarray) -> np.ndarray:
    """Which of them swing by more than a radian before they have settled."""
    return np.abs(eigenvalues.imag) > np.abs(eigenvalues.real)
