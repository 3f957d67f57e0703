"""Velocity from position. Each estimator that can run in a loop is one linear recursion of three numbers.

    s <- A s + B x,   v^ = C s + D x        (C, D applied with s before the update)

`filtered_differentiator` and `kalman` fill in the coefficients; `fir_differentiator` is not causal and serves
records only.
"""

import functools
from typing import Annotated, NamedTuple, Protocol

import numpy as np

from controllers.settings import About, Needs, Tuned
from plants.equation import Scalar, equation

VelocityKind = Annotated[str, "filter", "thesis_filter", "kalman", About("how the velocity is had from the position")]
TimeConstant = Annotated[
    float,
    "s",
    About("time constant of the differentiator", above=True),
    Tuned(5e-4, 2e-2),
    Needs("velocity", "filter", "thesis_filter"),
]
PositionNoise = Annotated[
    float, "m", About("standard deviation of a position sample", above=True), Needs("velocity", "kalman")
]
JerkDensity = Annotated[
    float, "m^2/s^5", About("spectral density of the jerk that is believed in", above=True), Needs("velocity", "kalman")
]


class EstimatorState(NamedTuple):
    first: Annotated[float, "m"]
    second: Annotated[float, "m/s"]
    third: Annotated[float, "m/s^2"]


class Estimator(NamedTuple):
    """Coefficients of the recursion, row by row."""

    a11: Annotated[float, "1"]
    a12: Annotated[float, "s"]
    a13: Annotated[float, "s^2"]
    a21: Annotated[float, "1/s"]
    a22: Annotated[float, "1"]
    a23: Annotated[float, "s"]
    a31: Annotated[float, "1/s^2"]
    a32: Annotated[float, "1/s"]
    a33: Annotated[float, "1"]
    b1: Annotated[float, "1"]
    b2: Annotated[float, "1/s"]
    b3: Annotated[float, "1/s^2"]
    c1: Annotated[float, "1/s"]
    c2: Annotated[float, "1"]
    c3: Annotated[float, "s"]
    d: Annotated[float, "1/s"]


@equation
def estimate_velocity(position: Scalar, state: EstimatorState, e: Estimator) -> tuple[Scalar, EstimatorState]:
    """Velocity estimate (m/s) from a position sample (m), and the estimator's next state."""
    x, v, a = state.first, state.second, state.third
    velocity = e.c1 * x + e.c2 * v + e.c3 * a + e.d * position
    following = EstimatorState(
        e.a11 * x + e.a12 * v + e.a13 * a + e.b1 * position,
        e.a21 * x + e.a22 * v + e.a23 * a + e.b2 * position,
        e.a31 * x + e.a32 * v + e.a33 * a + e.b3 * position,
    )
    return velocity, following


def at_rest(position: float) -> EstimatorState:
    """State of any of these estimators after a long time at `position` (m)."""
    return EstimatorState(position, 0.0, 0.0)


def filtered_differentiator(time_constant: float, sample_time: float) -> Estimator:
    """The filtered derivative s / (T_v s + 1), exact for a position that moves linearly between samples.

        v^ <- E v^ + (1 - E) (x - x_before) / h,  E = exp(-h/T_v)        thesis (2.10), sampled

    A ramp comes out with gain 1 and a lag of T_v. (The form v^ = (x - x_f)/T_v with an exponential update of x_f
    has the gain (h/T_v)/(1 - E) instead: 27 % too much at T_v = 2 ms and 1 kHz.)

    Args:
        time_constant: T_v (s), above 0.
        sample_time: h (s).
    """
    keep = float(np.exp(-sample_time / time_constant))
    gain = (1.0 - keep) / sample_time
    return Estimator(
        *(0.0, 0.0, 0.0),
        *(-gain, keep, 0.0),
        *(0.0, 0.0, 0.0),
        *(1.0, gain, 0.0),
        *(-gain, keep, 0.0),
        gain,
    )


def thesis_filter(time_constant: float, sample_time: float) -> Estimator:
    """v^ = (x - x_f)/T_v,  x_f <- x_f + (1 - exp(-h/T_v)) (x - x_f): thesis (2.10) sampled as it is printed.

    Its gain on a ramp is (h/T_v) / (1 - exp(-h/T_v)), 1.27 at T_v = 2 ms and 1 kHz: to reproduce results that were had
    with it, not for use.
    """
    keep = float(np.exp(-sample_time / time_constant))
    return Estimator(
        *(keep, 0.0, 0.0),
        *(0.0, 0.0, 0.0),
        *(0.0, 0.0, 0.0),
        *(1.0 - keep, 0.0, 0.0),
        *(-1.0 / time_constant, 0.0, 0.0),
        1.0 / time_constant,
    )


@functools.cache
def kalman(position_noise: float, jerk_density: float, sample_time: float) -> Estimator:
    """Constant-acceleration Kalman filter in its steady state: the same gain at every sample.

    The covariance of model and noise does not depend on the data, so the gain settles; filterpy iterates to it.

    Args:
        position_noise: standard deviation of a position sample (m), above 0.
        jerk_density: spectral density of the white jerk that moves the model ((m/s^3)^2/Hz), above 0.
        sample_time: h (s).

    Raises:
        ArithmeticError: the gain does not settle.
    """
    from filterpy.common import Q_continuous_white_noise  # a second of imports that no other estimator needs
    from filterpy.kalman import KalmanFilter

    h = sample_time
    model = KalmanFilter(dim_x=3, dim_z=1)
    model.F = np.array([[1.0, h, 0.5 * h * h], [0.0, 1.0, h], [0.0, 0.0, 1.0]])
    model.H = np.array([[1.0, 0.0, 0.0]])
    model.R = np.array([[position_noise**2]])
    model.Q = Q_continuous_white_noise(dim=3, dt=h, spectral_density=jerk_density)
    model.P = np.diag([position_noise**2, 1.0, 1e4])
    gain = np.zeros((3, 1))
    for _ in range(200_000):
        model.predict()
        model.update(np.zeros(1))
        settled = np.allclose(model.K, gain, rtol=1e-12, atol=0.0)
        gain = model.K.copy()
        if settled:
            break
    else:
        raise ArithmeticError(
            f"the Kalman gain does not settle for position noise {position_noise} m "
            f"and jerk density {jerk_density} m^2/s^6/Hz"
        )
    correct = (np.eye(3) - gain @ model.H) @ model.F  # s+ = correct s + gain x
    numbers = [*correct.ravel(), *gain.ravel(), *correct[1], gain[1, 0]]
    return Estimator._make(float(number) for number in numbers)


class EstimatorSettings(Protocol):
    """What a controller's settings say of its velocity estimator: which one, and what it needs."""

    @property
    def velocity(self) -> str:
        """Which one."""

    @property
    def velocity_time_constant(self) -> float:
        """T_v (s) of the filters."""

    @property
    def position_noise(self) -> float:
        """Standard deviation (m) for the Kalman filter."""

    @property
    def jerk_density(self) -> float:
        """Density of the jerk (m^2/s^5) for the Kalman filter."""


def design_estimator(settings: EstimatorSettings, sample_time: float) -> Estimator:
    """The estimator of that kind: "filter", "thesis_filter" or "kalman".

    Raises:
        ValueError: a time constant, noise or density that is not above 0.
    """
    needed = ("position_noise", "jerk_density") if settings.velocity == "kalman" else ("velocity_time_constant",)
    for name in needed:
        if getattr(settings, name) <= 0.0:
            raise ValueError(f"{name} is {getattr(settings, name):g}, expected a value above 0")
    if settings.velocity == "filter":
        return filtered_differentiator(settings.velocity_time_constant, sample_time)
    if settings.velocity == "thesis_filter":
        return thesis_filter(settings.velocity_time_constant, sample_time)
    return kalman(settings.position_noise, settings.jerk_density, sample_time)


def fir_differentiator(positions: np.ndarray, sample_time: float, order: int = 16) -> np.ndarray:
    """Velocity (m/s) of a whole record of positions (m, 1-D) by a non-causal FIR filter: for records, not loops.

    Least-squares slope of a straight line over order + 1 samples centred on each instant (thesis chapter 4 uses
    order 16). Near the ends, where the window does not fit, the first and the last whole window are held.

    Raises:
        ValueError: the order is odd or below 2, or the record is shorter than order + 1.
    """
    if order < 2 or order % 2:
        raise ValueError(f"order {order}: expected an even number of at least 2")
    if positions.size <= order:
        raise ValueError(f"a record of {positions.size} samples: order {order} needs at least {order + 1}")
    half = order // 2
    offsets = np.arange(-half, half + 1)
    weights = offsets / (sample_time * np.sum(offsets**2))
    inner = np.correlate(positions, weights, mode="valid")
    return np.pad(inner, half, mode="edge")
