"""Records by hand: what a filter that knows the machine does not foresee of the position.

What a hand gives is measured, with noise that drives nothing. How likely a record is of a machine is said by what a
Kalman filter with that machine in it does not foresee, sample by sample and each over its standard deviation (Ljung
1999, section 3). It is linearised along the motion without noise, and knows the colour of both sensors' noise. The
machine that made the record foresees all but noise; what another does not is how far it is away.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import block_diag

from .machines import Rig, resting, substeps
from .noise import Noise
from .parameters import Machine
from .physics import HUNG_V, HUNG_X, LAGGED, RESTED, SHORT_MEMORY, SLIP, V, X, Z, gains_along, numbers, unforeseen

NUDGED = 1e-7
"""Of a state's typical size, by which it is moved for a derivative."""


@dataclass(frozen=True, eq=False)
class Filter:
    """Gains (samples, states and noises) by which the states at `places` are corrected and what noises remember, and
    standard deviations (m) of what is not foreseen; `pushed`, `shown` and `turned` are as in `physics.gains_along`.
    """

    places: np.ndarray
    gains: np.ndarray
    spread: np.ndarray
    pushed: np.ndarray
    shown: np.ndarray
    turned: np.ndarray

    def off(
        self, rig: Rig, machine: Machine, start: np.ndarray | None, force: np.ndarray, position: np.ndarray
    ) -> np.ndarray:
        """What it does not foresee of a record with that machine in it, in standard deviations, shape (samples,)."""
        begins = resting(machine) if start is None else start
        known = self.places, self.gains, self.pushed, self.shown, self.turned
        wrong = unforeseen(numbers(machine), begins, force, position, *known, rig.sample_time, substeps(rig))
        return np.asarray(wrong / self.spread)


def filter_along(rig: Rig, machine: Machine, force: np.ndarray) -> Filter:
    """The filter that knows the machine that made a record, under the force (N) without noise."""
    sizes = {X: rig.travel, V: rig.speed, Z: rig.presliding}
    sizes |= {LAGGED: rig.speed} if machine.memory_time >= SHORT_MEMORY * rig.sample_time / substeps(rig) else {}
    sizes |= {RESTED: 1.0} if machine.static_rise else {}
    sizes |= {SLIP: rig.level} if machine.slip_level else {}
    sizes |= {HUNG_X: rig.presliding, HUNG_V: rig.speed} if machine.hung_share else {}
    of_force, of_position = (rig.noises[name] for name in ("force", "position"))
    (first, turned_1, before_1), (second, turned_2, before_2) = (
        _remembered(noise, rig.sample_time) for noise in (of_force, of_position)
    )
    pushed, shown = np.append(first, np.zeros(second.size)), np.append(np.zeros(first.size), second)
    turned, before = block_diag(turned_1, turned_2), block_diag(before_1, before_2)
    places = np.array(list(sizes))
    gains, spread = gains_along(
        numbers(machine),
        resting(machine),
        force,
        places,
        NUDGED * np.array([*sizes.values(), rig.force]),
        pushed,
        shown,
        turned,
        before,
        np.array([of_force.flat, of_position.flat]),
        rig.sample_time,
        substeps(rig),
    )
    return Filter(places, gains, spread, pushed, shown, turned)


def _remembered(noise: Noise, sample_time: float) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """What a noise remembers: how it shows, what becomes of it in a sample, and its covariance."""
    shows, turns, before = list[float](), list[np.ndarray](), list[np.ndarray]()
    if noise.coloured:
        shows.append(1.0)
        turns.append(np.array([[noise.kept(sample_time)]]))
        before.append(np.array([[noise.coloured**2]]))
    for times, amplitude in ((1.0, noise.hum), (3.0, noise.harmonic)):
        if amplitude:
            angle = 2.0 * np.pi * times * noise.mains * sample_time
            shows += [1.0, 0.0]
            turns.append(np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]))
            before.append(0.5 * amplitude**2 * np.eye(2))
    if not shows:
        return np.zeros(0), np.zeros((0, 0)), np.zeros((0, 0))
    return np.array(shows), block_diag(*turns), block_diag(*before)
