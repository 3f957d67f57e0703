"""The limit cycle that a describing function predicts for friction under PID control.

The loop is split into a linear part, plant without friction levels and PID, and a static friction law of velocity:

    v = H(s) (-F),   F(v) = g(|w|) v / |w|,   |w| = sqrt(v^2 + w_surface^2),   g of thesis (3.32)

A cycle is predicted where H(jw) = -1/N(A), with N(A) the gain of F for the sine A sin(wt). Without rotation F is a
relay with static friction. Its N is real, so that a cycle needs H(jw) on the negative real axis. For a mass under
continuous PID control H gets there only where the loop without friction is unstable [derived here]: nothing is
predicted for any gains that stabilise it, although static friction does hunt there (Armstrong and Amin 1996). Behind a
valve and soft hoses H crosses that axis, and a cycle is predicted for stabilising gains too.

Do not trust it alone: it knows neither sticking nor presliding, which are what hunting lives on, nor harmonics, nor
an offset of the oscillation. Left out besides: sampling, the lag of the velocity estimator, limits, anti-windup, the
valve's flow away from the closed spool, and the difference between directions (friction is the mean of both).
"""

from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

import control
import numpy as np
from scipy.optimize import root
from scipy.special import dawsn

from controllers.pid import Gains
from plants.equation import NEGATIVE, replaced
from plants.friction import LuGre, stribeck_level
from plants.interface import Plant
from workbench.linear.linearise import linearise

AMPLITUDES = np.logspace(-9, 3, 61)
"""m/s. Amplitudes of velocity among which intersections are looked for."""

FREQUENCIES, BEYOND = 600, 100.0
"""Number of frequencies, and by what factor they go beyond the slowest and the fastest pole."""

EXACT = 1e-9
"""|1 + H N| below which an intersection counts as found."""

LEVELS = ("coulomb", "stribeck", "bristle_stiffness", "bristle_damping")
"""Numbers of LuGre's friction without which it is viscous alone."""

STILL = 1e-9
"""rad/s. A pole below it is one at 0."""


Nonlinearity: TypeAlias = control.DescribingFunctionNonlinearity


@dataclass(frozen=True)
class Intersection:
    """Where H(jw) N(A) = -1: amplitude A of the nonlinearity's input, and w (rad/s).

    `stable`: a larger oscillation shrinks and a smaller one grows, to first order.
    """

    amplitude: float
    frequency: float
    stable: bool


@dataclass(frozen=True)
class Prediction:
    """A predicted limit cycle: peak to peak of the position (m), and period (s)."""

    amplitude: float
    period: float


class SteadyFriction(control.DescribingFunctionNonlinearity):
    """Friction (N) of steady sliding at a velocity (m/s), without its viscous part, at rest and under rotation.

    Without rotation the sine's first harmonic is known in closed form [derived here], D being Dawson's integral:

        N(A) = 4 / (pi A) (a0 + a1 D(k) / k),   k = A / v_s

    from 2/pi times the integral over a half period of sin(q) exp(-(k sin q)^2). With a1 = 0 it is the relay's. With
    rotation python-control integrates.
    """

    def __init__(self, friction: LuGre, surface_speed: float = 0.0) -> None:
        super().__init__()
        self._friction = friction
        self._surface_speed = surface_speed

    def __call__(self, velocity: float) -> float:
        """F(v) = g(|w|) v / |w|, 0 at rest."""
        speed = float(np.hypot(velocity, self._surface_speed))
        return float(stribeck_level(speed, self._friction)) * velocity / speed if speed else 0.0

    def _isstatic(self) -> bool:
        return True

    def describing_function(self, amplitude: float) -> float:
        """N (N s/m) at `amplitude` (m/s).

        Raises:
            NotImplementedError: with rotation; python-control then integrates over a period.
        """
        if self._surface_speed:
            raise NotImplementedError
        p, ratio = self._friction, amplitude / self._friction.stribeck_velocity
        return float(4.0 / (np.pi * amplitude) * (p.coulomb + p.stribeck * dawsn(ratio) / ratio))


def _gain(nonlinearity: Nonlinearity, amplitude: float) -> complex:
    return complex(control.describing_function(nonlinearity, [amplitude])[0])


def intersections(linear: control.StateSpace, nonlinearity: Nonlinearity) -> list[Intersection]:
    """All A and w with H(jw) N(A) = -1 for y = H u, u = -f(y).

    Intersections outside `AMPLITUDES` are not found, nor those beyond `BEYOND` times the poles' frequencies.
    """
    poles = np.abs(control.poles(linear))
    poles = poles[poles > STILL]
    omega = np.geomspace(poles.min() / BEYOND, poles.max() * BEYOND, FREQUENCIES)
    gains = np.asarray(control.describing_function(nonlinearity, AMPLITUDES))
    guesses = _crossings(np.asarray(linear(1j * omega)), gains, omega)
    refined = [_refined(linear, nonlinearity, *guess) for guess in guesses]
    return [found for found in refined if found is not None]


def _crossings(responses: np.ndarray, gains: np.ndarray, omega: np.ndarray) -> list[tuple[float, float]]:
    """A and w about where the Nyquist curve, H at these w, crosses that of -1/N: of straight lines between points."""
    with np.errstate(divide="ignore", invalid="ignore"):
        line, other = responses[:, None], -1.0 / gains[None, :]
        along, across, gap = np.diff(line, axis=0), np.diff(other), other[:, :-1] - line[:-1]
        area = (along.conj() * across).imag
        first, second = (gap.conj() * across).imag / area, (gap.conj() * along).imag / area
    places = np.argwhere((first >= 0.0) & (first <= 1.0) & (second >= 0.0) & (second <= 1.0))
    return [
        (
            float(AMPLITUDES[k] + second[i, k] * (AMPLITUDES[k + 1] - AMPLITUDES[k])),
            float(omega[i] + first[i, k] * (omega[i + 1] - omega[i])),
        )
        for i, k in places
    ]


def _refined(
    linear: control.StateSpace, nonlinearity: Nonlinearity, amplitude: float, frequency: float
) -> Intersection | None:
    """The root of 1 + H(jw) N(A) near a guess; None where there is none."""

    def residual(logarithms: np.ndarray) -> list[float]:
        a, w = np.exp(logarithms)
        value = 1.0 + complex(linear(1j * w)) * _gain(nonlinearity, a)
        return [value.real, value.imag]

    solution = root(residual, np.log([amplitude, frequency]), tol=1e-13)
    if abs(complex(*residual(solution.x))) > EXACT:
        return None
    a, w = (float(value) for value in np.exp(solution.x))
    s, h, ds = 1j * w, complex(linear(1j * w)), 1e-6j * w
    slope = (complex(linear(s + ds)) - complex(linear(s - ds))) / (2.0 * ds)
    above, below = (_gain(nonlinearity, a * factor) for factor in (1.0 + 1e-4, 1.0 - 1e-4))
    change = (above - below) / (2e-4 * a)
    growth = -change * h / (_gain(nonlinearity, a) * slope)  # ds/dA along 1 + N(A) H(s) = 0
    return Intersection(a, w, growth.real < 0.0)


def friction_loop(plant: Plant, parameters: NamedTuple, gains: Gains) -> control.StateSpace:
    """H(s): from a force (N) that pushes the piston to its velocity (m/s), PID loop closed, without friction levels.

    Viscous friction stays in. The PID is continuous: command = -(K_p + K_i / s) x - K_d v, with v itself.
    """
    linear = linearise(plant, _without_levels(parameters), outputs=("position", "velocity"))
    kept = _influential(linear.A, linear.C)
    a, b, c = linear.A[np.ix_(kept, kept)], linear.B[kept], linear.C[:, kept]
    command, force = (b[:, [plant.input_index(name)]] for name in (plant.command, plant.disturbance))
    position, velocity = c[[0]], c[[1]]
    closed = a - command @ (gains.proportional * position + gains.derivative * velocity)
    if not gains.integral:
        return control.ss(closed, -force, velocity, 0.0)
    zero = np.zeros((1, 1))
    whole = np.block([[closed, -gains.integral * command], [position, zero]])
    return control.ss(whole, -np.vstack([force, zero]), np.hstack([velocity, zero]), 0.0)


def _without_levels(parameters: NamedTuple) -> NamedTuple:
    """Parameters whose friction along the rod is viscous alone, in both directions."""
    return replaced(parameters, {name: 0.0 for level in LEVELS for name in (level, f"{level}_{NEGATIVE}")})


def _influential(a: np.ndarray, c: np.ndarray) -> np.ndarray:
    """Indices of the states that reach the outputs: not a bristle without stiffness, nor the motor."""
    reached = np.any(c != 0.0, axis=0)
    for _ in range(a.shape[0]):
        reached = reached | np.any(a[reached] != 0.0, axis=0)
    return np.flatnonzero(reached)


def predict(plant: Plant, parameters: Any, gains: Gains, surface_speed: float = 0.0) -> Prediction | None:
    """The largest stable limit cycle of `plant` under a PID; None where the describing function predicts none.

    Args:
        plant: one with a contact that follows the LuGre law, `parameters.friction`.
        parameters: its parameters (SI).
        gains: of `controllers.pid`.
        surface_speed: of the rod's surface through rotation (m/s), taken as constant.
    """
    sides = zip(*parameters.friction, strict=True)
    friction = LuGre(*(0.5 * (forward + backward) for forward, backward in sides))
    found = intersections(friction_loop(plant, parameters, gains), SteadyFriction(friction, surface_speed))
    cycles = [
        Prediction(2.0 * each.amplitude / each.frequency, 2.0 * np.pi / each.frequency) for each in found if each.stable
    ]
    return max(cycles, key=lambda each: each.amplitude, default=None)
