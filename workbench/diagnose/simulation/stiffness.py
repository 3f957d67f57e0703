"""Whether a plant is stiff along a record: then a linearly implicit method simulates it in a fraction of the steps.

A contact that slides relaxes at the rate sigma0 |v| / g(v), and of a bristle that is hardly seen nothing else bounds
the stiffness: explicit steps are stable up to about 3.3 over that rate, however smooth the motion is. What swings has
to be followed by every method, a mass on the bristles of a contact that sticks as well; there the explicit one, of
higher order, needs fewer steps.
"""

from functools import lru_cache

import numpy as np

from plants.equation import fields, to_array
from workbench.diagnose.residuals.along import REMEMBERED, Along
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.residuals.walk import NUDGE
from workbench.simulation.integrators.dormand_prince import DORMAND_PRINCE
from workbench.simulation.integrators.ros34pw2 import ROS34PW2

STABLE = 3.3
"""Where the stability region of the explicit method ends on the negative real axis."""

STIFF, FOLLOWED, COARSE = 8.0, 2.0, 1e-6
"""Times the steps by which a motion is followed that stability asks for where a plant is stiff; and steps of the
implicit method, of order 3, for each radian of what swings or settles otherwise, with that tolerance.
"""


def method_for(along: Along, motion: Motion, values: Values, tolerance: float) -> str:
    """The name of the method that simulates a plant with `values` along a record in less time.

    The plant relaxes as it does that slides at the mean speed of the motion, and swings as fast as it does sliding or
    at rest, by the eigenvalues of its Jacobian there. What relaxes far slower is followed, since a command that holds
    from sample to sample excites it in each. What does nothing of its effects does not count.
    """
    return _method_for(along, motion, tuple(values.items()), tolerance)


@lru_cache(REMEMBERED)
def _method_for(along: Along, motion: Motion, known: tuple[tuple[str, float], ...], tolerance: float) -> str:
    """See `method_for`: the same for simulations that differ in where they start alone."""
    values = dict(known)
    linear, step = _Linearised(along, motion, values), motion.record.sample_time
    sliding = linear.eigenvalues(linear.sliding())
    relaxing = np.abs(sliding[~_swings(sliding)]) * step
    relaxes = np.max(relaxing, initial=0.0)
    if relaxes <= STABLE * STIFF:
        return DORMAND_PRINCE.name
    both = np.concatenate([sliding, linear.eigenvalues(linear.rest)])
    followed = np.concatenate([np.abs(both[_swings(both)]) * step, relaxing[relaxing < relaxes / STIFF]])
    steps = max(1.0, FOLLOWED * np.max(followed, initial=0.0)) * (COARSE / tolerance) ** (1.0 / 3.0)
    return ROS34PW2.name if relaxes > STABLE * STIFF * steps else DORMAND_PRINCE.name


class _Linearised:
    """A plant with `values` along a record, linearised beside its rest."""

    def __init__(self, along: Along, motion: Motion, values: Values) -> None:
        self._along, self._speed, self._parameters = along, motion.mean_speed, along.parameters(values)
        self.rest, self._inputs = map(to_array, along.at_rest(motion, values))
        self._nudges = NUDGE * along.magnitudes(motion, values)
        alone = along.having(along.acts(values), alone=True)
        self._acting = [along.names.index(item.name) for item in fields(alone.State)]

    def sliding(self) -> np.ndarray:
        """The state in which the plant slides at the mean speed, its contact bent as far as it stays."""
        state, along = self.rest.copy(), self._along
        state[along.names.index("velocity")] = self._speed
        rates, jacobian = self._at(state)
        for place, name in enumerate(along.names):
            if name in along.contact and jacobian[place, place] < 0.0:  # a bristle's rate is linear in how far it bends
                state[place] -= rates[place] / jacobian[place, place]
        return state

    def eigenvalues(self, state: np.ndarray) -> np.ndarray:
        """Of the Jacobian (1/s) at a state, of what acts."""
        own = self._at(state)[1][np.ix_(self._acting, self._acting)]
        return np.linalg.eigvals(own) if np.all(np.isfinite(own)) else np.zeros(1)

    def _at(self, state: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The rates at a state, and their Jacobian."""
        states = np.vstack([state, state + np.diag(self._nudges)])
        inputs = np.tile(self._inputs, (len(states), 1))
        rates = self._along.rates(np.zeros(len(states)), states, inputs, self._parameters)
        return rates[0], ((rates[1:] - rates[0]) / self._nudges[:, None]).T


def _swings(eigenvalues: np.ndarray) -> np.ndarray:
    """Which of them swing by more than a radian before they have settled."""
    return np.abs(eigenvalues.imag) > np.abs(eigenvalues.real)
