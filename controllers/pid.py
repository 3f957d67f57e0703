"""P, PI, PD, PID with velocity feed-forward, anti-windup and a jump over a dead band: one law, each term optional."""

from typing import Annotated, NamedTuple

import numpy as np

from controllers.belief import velocity_gain
from controllers.interface import Controller, Reference
from controllers.settings import DECADES, SHARE, About, Needs, Tuned
from controllers.velocity import (
    Estimator,
    EstimatorState,
    JerkDensity,
    PositionNoise,
    TimeConstant,
    VelocityKind,
    at_rest,
    design_estimator,
    estimate_velocity,
)
from plants.equation import Scalar, equation, select
from plants.interface import Measurement

ProportionalGain = Annotated[float, "command/m", About("gain on the position error"), DECADES]
IntegralGain = Annotated[float, "command/(m s)", About("gain on the integral of the error"), DECADES]
DerivativeGain = Annotated[float, "command s/m", About("gain on the error of the velocity"), DECADES]
Feedforward = Annotated[float, "1", About("share of the reference's velocity that is fed forward"), SHARE]
FeedforwardLead = Annotated[
    float, "1", About("share of the valve's lag that the feed-forward inverts"), SHARE, Needs("feedforward")
]
DeadBandShare = Annotated[float, "1", About("share of the believed dead band that the command jumps over"), SHARE]
DeadBandSmoothing = Annotated[
    float,
    "1",
    About("command, in dead bands, over which the jump is spread", above=True),
    Tuned(0.01, 1.0),
    Needs("dead_band"),
]
TrackingTime = Annotated[float, "s", About("time constant of the anti-windup; 0: K_p / K_i"), Needs("ki")]


class Settings(NamedTuple):
    """What a user sets. Terms are left out by their 0.

    `feedforward` is the share of the reference's velocity that is fed forward through the believed velocity gain
    K_q. `lead` is the share of the believed valve's lag that it inverts: what a valve inversion may do, plain control
    may too, since nothing but the reference's acceleration is needed for it. `dead_band` is the share of the believed
    valve's dead band that is added to the command, and `dead_band_smoothing` how small a command, as a share of that
    band, gets all of it: the jump's slope is 1/smoothing, by which the loop's gain is higher there. `tracking_time` is
    the time constant of the anti-windup, 0 for K_p / K_i. The Kalman filter's defaults: the repeatability of the
    thesis's potentiometer, and a jerk of 30 m/s^3 that lasts 10 ms.
    """

    kp: ProportionalGain
    ki: IntegralGain = 0.0
    kd: DerivativeGain = 0.0
    feedforward: Feedforward = 0.0
    tracking_time: TrackingTime = 0.0
    velocity: Annotated[VelocityKind, Needs("kd")] = "filter"
    velocity_time_constant: TimeConstant = 2e-3
    position_noise: PositionNoise = 13e-6
    jerk_density: JerkDensity = 10.0
    lead: FeedforwardLead = 0.0
    dead_band: DeadBandShare = 0.0
    dead_band_smoothing: DeadBandSmoothing = 0.1


class Gains(NamedTuple):
    """Gains, in units of the command (V or N) per metre. `tracking` is the rate of the anti-windup (1/s).

    `lead` is what of the valve's time constant the feed-forward inverts, `feedforward_ratio` the feed-forward of
    negative velocities over that of positive ones. `dead_band` is what is added to a positive command beyond
    `dead_band_width`.
    """

    proportional: Annotated[float, "command/m"]
    integral: Annotated[float, "command/(m s)"]
    derivative: Annotated[float, "command s/m"]
    feedforward: Annotated[float, "command s/m"]
    tracking: Annotated[float, "1/s"]
    estimator: Estimator
    lead: Annotated[float, "s"] = 0.0
    feedforward_ratio: Annotated[float, "1"] = 1.0
    dead_band: Annotated[float, "command"] = 0.0
    dead_band_negative: Annotated[float, "command"] = 0.0
    dead_band_width: Annotated[float, "command"] = 1.0
    dead_band_width_negative: Annotated[float, "command"] = 1.0


class State(NamedTuple):
    integral: Annotated[float, "command"]
    command: Annotated[float, "command"]
    error: Annotated[float, "m"]
    estimator: EstimatorState


@equation
def fed_forward(velocity: Scalar, gain: Scalar, ratio: Scalar) -> Scalar:
    """The command that a wanted velocity takes. `ratio`: the gain of negative velocities over that of positive ones."""
    return gain * select(velocity >= 0.0, 1.0, ratio) * velocity


@equation
def beyond_dead_band(command: Scalar, gains: Gains) -> Scalar:
    """u + d sat(u / w): the valve's dead band d is jumped over, by a line within +-w."""
    up = gains.dead_band * np.minimum(command / gains.dead_band_width, 1.0)
    down = gains.dead_band_negative * np.maximum(command / gains.dead_band_width_negative, -1.0)
    return command + select(command >= 0.0, up, down)


@equation
def step(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """u = K_p e + K_d (dr - v^) + I + K_ff (dr + T_l ddr), with e = r - x and v^ the estimated velocity; then the jump.

    T_l = lead tau, tau the valve's lag: (1 + tau s) of the reference's velocity is what the valve makes that velocity
    of again.
    """
    error = reference.position - measurement.position
    velocity, estimator = estimate_velocity(measurement.position, state.estimator, gains.estimator)
    wanted = reference.velocity + gains.lead * reference.acceleration
    linear = (
        gains.proportional * error
        + gains.derivative * (reference.velocity - velocity)
        + state.integral
        + fed_forward(wanted, gains.feedforward, gains.feedforward_ratio)
    )
    command = beyond_dead_band(linear, gains)
    return command, State(state.integral, command, error, estimator)


@equation
def commit(realised: Scalar, state: State, gains: Gains, sample_time: Scalar) -> State:
    """I <- I + h (K_i e + (u_realised - u) / T_t): back-calculation, so that I follows a saturated command."""
    excess = realised - state.command
    rate = gains.integral * state.error + gains.tracking * excess
    return State(state.integral + sample_time * rate, state.command, state.error, state.estimator)


def start(measurement: Measurement, gains: Gains) -> State:
    """At rest, the integral empty."""
    return State(0.0, 0.0, 0.0, at_rest(measurement.position))


def design(settings: Settings, belief: object, sample_time: float) -> Gains:
    """Gains from settings, with K_ff = feedforward / K_q of either direction and T_l = lead tau.

    Raises:
        ValueError: feed-forward, or a dead band, for a plant whose belief has no velocity gain; a setting out of range.
    """
    feedforward, ratio, lead, bands, widths = 0.0, 1.0, 0.0, (0.0, 0.0), (1.0, 1.0)
    if settings.feedforward:
        known = velocity_gain(belief, "feedforward")
        feedforward, ratio = settings.feedforward / known.forward, known.forward / known.backward
        lead = settings.lead * known.lag
    if settings.dead_band:
        if settings.dead_band_smoothing <= 0.0:
            raise ValueError(f"dead_band_smoothing is {settings.dead_band_smoothing:g}, expected a value above 0")
        known = velocity_gain(belief, "dead_band")
        whole = known.dead_band, known.dead_band_negative
        bands = settings.dead_band * whole[0], settings.dead_band * whole[1]
        widths = settings.dead_band_smoothing * whole[0] or 1.0, settings.dead_band_smoothing * whole[1] or 1.0
    tracking = 0.0
    if settings.ki:
        tracking_time = settings.tracking_time or abs(settings.kp / settings.ki)
        tracking = 1.0 / max(tracking_time, sample_time)
    estimator = design_estimator(settings, sample_time)
    linear = settings.kp, settings.ki, settings.kd, feedforward, tracking, estimator, lead, ratio
    return Gains(*linear, *bands, *widths)


SUMMARY = "P, PI, PD, PID with velocity feed-forward, anti-windup and a jump over a dead band"

PID = Controller("pid", SUMMARY, Settings, Gains, State, design, step, commit, start)
