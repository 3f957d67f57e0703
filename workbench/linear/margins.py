"""Gain and phase margin of a sampled loop L(z) = C (zI - A)^-1 B, at crossings that are refined, and its stability.

The definitions are those of `control.stability_margins`, whose numbers come out to 1e-5 dB and degrees. That takes 20
to 200 ms a loop, since the polynomials that it prefers for discrete systems span too many decades here and it falls
back, with a warning, to an interpolated response; and it leaves out the Nyquist frequency, where a P loop on an
integrator has its gain margin.
"""

from dataclasses import dataclass

import numpy as np
from scipy.linalg import eig, schur
from scipy.optimize import brentq

LOWEST = 1e-3
"""rad/s. Crossings are sought from here to the Nyquist frequency."""

POINTS_A_DECADE = 60
AROUND_A_POLE = np.linspace(-4.0, 4.0, 33)
"""Further points about a lightly damped pole, in units of its half width."""

LIGHT = 0.3
"""Damping ratio below which a pole has these points."""

UNIT = 1e-9
"""A pole within this of the unit circle is on it."""

INTEGRATORS = 1e-6
"""A closed-loop pole within this of 1 may be one that the loop does not see."""

ROUNDING = 1e-10
"""Share of |L| below which its imaginary part has no sign: at the Nyquist frequency it is 0."""

HIDDEN = 1e-6
"""Share of the largest possible effect below which a mode is not seen, or not moved, by the command."""


@dataclass(frozen=True)
class Margins:
    """How far a loop is from instability, about the rod's sliding at `speed` (m/s).

    `gain_dB`: the smallest change of the loop's gain, up or down, at which it becomes unstable: |20 log10 |L|| where L
    crosses the negative real axis nearest to -1. `phase_deg`: the smallest turn of L, lag or lead, to -1, where |L| is
    1. Of a loop that is not stable both are negative: what is lacking at the nearest crossing. `gain_frequency` and
    `phase_frequency` (rad/s) say where. Without a crossing all are inf (-inf for an unstable loop's margins).
    `note` says what an unstable loop does; "" for a stable one.
    """

    gain_dB: float  # noqa: N815 - the unit's own letters
    phase_deg: float
    gain_frequency: float
    phase_frequency: float
    stable: bool
    speed: float
    note: str = ""


class Response:
    """L over frequency (rad/s), from the complex Schur form A = Q T Q*: a triangular solve for all frequencies at once.

    Unlike eigenvectors this stands the double integrators of a PI loop.
    """

    def __init__(self, a: np.ndarray, b: np.ndarray, c: np.ndarray, sample_time: float) -> None:
        self._triangle, basis = schur(a, output="complex")
        self._b, self._c = (basis.conj().T @ b)[:, 0], (c @ basis)[0]
        self._sample_time = sample_time
        self.poles = np.diag(self._triangle)

    def __call__(self, frequencies: np.ndarray) -> np.ndarray:
        """L(exp(j w h)), shape of `frequencies`."""
        z = np.exp(1j * np.atleast_1d(frequencies) * self._sample_time)
        solution = np.zeros((len(self._b), z.size), dtype=complex)
        for i in reversed(range(len(self._b))):
            known = self._b[i] + self._triangle[i, i + 1 :] @ solution[i + 1 :]
            solution[i] = known / (z - self._triangle[i, i])
        return np.asarray(self._c @ solution)


def margins_of(a: np.ndarray, b: np.ndarray, c: np.ndarray, sample_time: float, speed: float) -> Margins:
    """Margins and stability of the loop closed by u = -y around x+ = A x + B u, y = C x (one input, one output)."""
    if not len(a):
        return Margins(np.inf, np.inf, np.inf, np.inf, True, speed)
    response = Response(a, b, c, sample_time)
    grid = grid_about(response.poles, sample_time)
    values = response(grid)
    gain = _nearest(_gain_distances(response, grid, values))
    phase = _nearest(_phase_distances(response, grid, values))
    stable = is_stable(a, b, c)
    sign, note = (1.0, "") if stable else (-1.0, "the linearised loop is unstable")
    return Margins(sign * gain[0], sign * phase[0], gain[1], phase[1], stable, speed, note)


def is_stable(a: np.ndarray, b: np.ndarray, c: np.ndarray) -> bool:
    """Whether the poles of A - B C are inside the unit circle, those at 1 left out that the loop does not see.

    A mode is hidden if its part in the output, |C v| / (|C| |v|), or the input's part in it, |w B| / (|w| |B|), is
    below 1e-6 (v, w its eigenvectors): an integrator that only feeds a differentiator, as the nominal position in the
    disturbance observer. Closing the loop does not move it, and nothing of it reaches the command. `A`, `B`, `C` are to
    be in units of the states' magnitudes.
    """
    poles, left, right = eig(a - b @ c, left=True, right=True)
    seen = np.abs(c @ right)[0] > HIDDEN * np.linalg.norm(c)
    moved = np.abs(b.T @ left)[0] > HIDDEN * np.linalg.norm(b)
    hidden = (np.abs(poles - 1.0) < INTEGRATORS) & ~(seen & moved)
    return bool(np.all((np.abs(poles) < 1.0 - UNIT) | hidden))


def grid_about(poles: np.ndarray, sample_time: float) -> np.ndarray:
    """A logarithmic grid up to Nyquist, denser about lightly damped poles (rad/s, rising)."""
    nyquist = np.pi / sample_time
    count = int(np.ceil(POINTS_A_DECADE * np.log10(nyquist / LOWEST)))
    s = np.log(np.where(poles == 0.0, 1e-300, poles)) / sample_time
    light = s[(s.imag > LOWEST) & (np.abs(s.real) < LIGHT * s.imag)]
    near = (light.imag[:, None] + np.abs(light.real)[:, None] * AROUND_A_POLE).ravel()
    grid = np.concatenate([np.geomspace(LOWEST, nyquist, count), near])
    return np.unique(grid[(grid >= LOWEST) & (grid <= nyquist)])


def _nearest(distances: list[tuple[float, float]]) -> tuple[float, float]:
    return min(distances, default=(np.inf, np.inf))


def _gain_distances(response: Response, grid: np.ndarray, values: np.ndarray) -> list[tuple[float, float]]:
    """Distance of |L| from 1 (dB) and frequency (rad/s) wherever L crosses the negative real axis, Nyquist included."""
    found = []
    side = np.where(np.abs(values.imag) > ROUNDING * np.abs(values), np.sign(values.imag), 0.0)
    crossing = (side[:-1] * side[1:] < 0.0) & ((values.real[:-1] < 0.0) | (values.real[1:] < 0.0))
    for i in np.flatnonzero(crossing):
        frequency = brentq(lambda w: float(response(w)[0].imag), grid[i], grid[i + 1], xtol=1e-12, rtol=1e-10)
        found.append((frequency, response(frequency)[0]))
    found.append((grid[-1], values[-1]))  # L is real at the Nyquist frequency
    return [(abs(20.0 * float(np.log10(-value.real))), float(w)) for w, value in found if value.real < 0.0]


def _phase_distances(response: Response, grid: np.ndarray, values: np.ndarray) -> list[tuple[float, float]]:
    """Distance of L from -1 along the unit circle (degrees) and frequency (rad/s) wherever |L| is 1."""
    found = []
    excess = np.log(np.maximum(np.abs(values), 1e-300))
    for i in np.flatnonzero(excess[:-1] * excess[1:] < 0.0):
        frequency = brentq(lambda w: float(np.log(np.abs(response(w)[0]))), grid[i], grid[i + 1], rtol=1e-10)
        found.append((abs(float(np.angle(-response(frequency)[0], deg=True))), float(frequency)))
    return found
