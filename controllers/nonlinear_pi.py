"""Nonlinear PI: an integral that fills while the piston sticks, rests while it moves and lets go at a reversal.

Thesis 2.2.1 names the nonlinear PI control of Sepehri, Khayyat and Heinrichs (Mechatronics 7(8), 1997, thesis
reference 8) among the answers to stick-slip and gives no equation of it, nor was the paper at hand. What is kept of it
is its kind: a PI controller whose integral is reshaped against stiction, with no model of friction. The law below,
its shape and its defaults are all [derived here].
"""

from typing import Annotated, NamedTuple

import numpy as np

from controllers import pid
from controllers.interface import Controller, Reference
from controllers.pid import Feedforward, IntegralGain, ProportionalGain, TrackingTime, fed_forward
from controllers.settings import About, Needs, Tuned
from controllers.velocity import (
    Estimator,
    EstimatorState,
    JerkDensity,
    PositionNoise,
    TimeConstant,
    VelocityKind,
    at_rest,
    design_estimator,
)
from controllers.velocity import estimate_velocity as estimate
from plants.equation import Scalar, equation, select
from plants.interface import Measurement


class Settings(NamedTuple):
    """What a user sets, with defaults for the simulation plant.

    `sliding_speed` v_0 is far below the Stribeck velocity of 32 mm/s, so that the integral fills at rest and hardly in
    motion. `retained` is the share of the integral that outlives a reversal; with 0 the voltage that holds a constant
    load against leakage is forgotten at each. `error_band` is the repeatability of the thesis's potentiometer;
    `reversal_speed` the velocity beyond which a direction counts. It has to exceed the noise of v^, 0.44 mm/s for each
    um of white noise on the position at the default filter; within the noise false reversals make this a P controller.
    `tracking_time` 0 stands for K_p / K_i.
    """

    kp: ProportionalGain = 500.0
    ki: IntegralGain = 2000.0
    feedforward: Feedforward = 0.0
    sliding_speed: Annotated[
        float,
        "m/s",
        About("speed at which the integral fills at half its rate", above=True),
        Tuned(5e-4, 5e-2),
        Needs("ki"),
    ] = 5e-3
    retained: Annotated[
        float,
        "1",
        About("share of the integral that outlives a reversal", most=1.0),
        Tuned(0.0, 1.0, logarithmic=False),
        Needs("ki"),
    ] = 0.0
    error_band: Annotated[float, "m", About("errors within it have no sign"), Needs("ki")] = 13e-6
    reversal_speed: Annotated[
        float, "m/s", About("velocities within it have no direction"), Tuned(1e-4, 1e-2), Needs("ki")
    ] = 1e-3
    tracking_time: TrackingTime = 0.0
    velocity: Annotated[VelocityKind, Needs("ki")] = "filter"
    velocity_time_constant: TimeConstant = 2e-3
    position_noise: PositionNoise = 13e-6
    jerk_density: JerkDensity = 10.0


class Gains(NamedTuple):
    """Gains in units of the command (V or N) per metre. `tracking` is the rate of the anti-windup (1/s)."""

    proportional: Annotated[float, "command/m"]
    integral: Annotated[float, "command/(m s)"]
    feedforward: Annotated[float, "command s/m"]
    sliding_speed: Annotated[float, "m/s"]
    retained: Annotated[float, "1"]
    error_band: Annotated[float, "m"]
    reversal_speed: Annotated[float, "m/s"]
    tracking: Annotated[float, "1/s"]
    estimator: Estimator
    feedforward_ratio: Annotated[float, "1"] = 1.0


class State(NamedTuple):
    """The integral with its rate; the command; the last clear signs of error and velocity (0: none yet)."""

    integral: Annotated[float, "command"]
    rate: Annotated[float, "command/s"]
    command: Annotated[float, "command"]
    error_sign: Annotated[float, "1"]
    velocity_sign: Annotated[float, "1"]
    estimator: EstimatorState


@equation
def clear_sign(value: Scalar, band: Scalar, before: Scalar) -> Scalar:
    """The sign of `value` beyond +-`band`, within it the sign `before`."""
    return select(np.abs(value) > band, np.sign(value), before)


@equation
def step(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """u = K_p e + I + K_ff dr; at a reversal, of the error or of the velocity, first I <- retained I.

        dI/dt = K_i e / (1 + (v^/v_0)^2)

    Stuck (v^ = 0) the integral fills at its full rate until the piston breaks away; then its rate falls with the square
    of the speed, so that the slip adds little to what is stored. When the error has changed sign, or the piston its
    direction, what is stored pushes the wrong way: it is dropped, where a linear integral would first have to be
    emptied by an error of the other sign, which is how PI control hunts.
    """
    error = reference.position - measurement.position
    velocity, estimator = estimate(measurement.position, state.estimator, gains.estimator)
    error_sign = clear_sign(error, gains.error_band, state.error_sign)
    velocity_sign = clear_sign(velocity, gains.reversal_speed, state.velocity_sign)
    crossed = error_sign * state.error_sign < 0.0
    turned = velocity_sign * state.velocity_sign < 0.0
    kept = select(crossed, gains.retained, 1.0) * select(turned, gains.retained, 1.0)
    integral = kept * state.integral
    rate = gains.integral * error / (1.0 + (velocity / gains.sliding_speed) ** 2)
    fed = fed_forward(reference.velocity, gains.feedforward, gains.feedforward_ratio)
    command = gains.proportional * error + integral + fed
    return command, State(integral, rate, command, error_sign, velocity_sign, estimator)


@equation
def commit(realised: Scalar, state: State, gains: Gains, sample_time: Scalar) -> State:
    """I <- I + h (dI/dt + (u_realised - u) / T_t): back-calculation, so that I follows a saturated command."""
    change = sample_time * (state.rate + gains.tracking * (realised - state.command))
    return State(
        state.integral + change, state.rate, state.command, state.error_sign, state.velocity_sign, state.estimator
    )


def start(measurement: Measurement, gains: Gains) -> State:
    """At rest, the integral empty, no direction yet."""
    return State(0.0, 0.0, 0.0, 0.0, 0.0, at_rest(measurement.position))


def design(settings: Settings, belief: object, sample_time: float) -> Gains:
    """Gains from settings, with feed-forward and anti-windup of the PID family.

    Raises:
        ValueError: a setting out of its range, or feed-forward for a plant without a velocity gain.
    """
    if settings.sliding_speed <= 0.0:
        raise ValueError(f"sliding_speed is {settings.sliding_speed:g}, expected a value above 0")
    if not 0.0 <= settings.retained <= 1.0:
        raise ValueError(f"retained is {settings.retained:g}, expected a share between 0 and 1")
    linear = pid.design(
        pid.Settings(settings.kp, settings.ki, 0.0, settings.feedforward, settings.tracking_time), belief, sample_time
    )
    return Gains(
        settings.kp,
        settings.ki,
        linear.feedforward,
        settings.sliding_speed,
        settings.retained,
        settings.error_band,
        settings.reversal_speed,
        linear.tracking,
        design_estimator(settings, sample_time),
        linear.feedforward_ratio,
    )


SUMMARY = "PI whose integral fills at rest and lets go at reversals (after Sepehri; law derived here)"

NONLINEAR_PI = Controller("nonlinear_pi", SUMMARY, Settings, Gains, State, design, step, commit, start)
