"""P, PI, PD, PID with velocity feed-forward and anti-windup: one law, each term optional."""

from typing import Annotated, NamedTuple

from controllers.belief import velocities
from controllers.interface import Controller, Reference
from controllers.settings import DECADES, SHARE, About, Needs
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
TrackingTime = Annotated[float, "s", About("time constant of the anti-windup; 0: K_p / K_i"), Needs("ki")]


class Settings(NamedTuple):
    """What a user sets. Terms are left out by their 0.

    `feedforward` is the share of the reference's velocity that is fed forward through the believed velocity gain
    K_q. `lead` is the share of the believed valve's lag that it inverts: what a valve inversion may do, plain control
    may too, since nothing but the reference's acceleration is needed for it. `tracking_time` is the time constant of
    the anti-windup, 0 for K_p / K_i. The Kalman filter's defaults: the repeatability of the thesis's potentiometer, and
    a jerk of 30 m/s^3 that lasts 10 ms.
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


class Gains(NamedTuple):
    """Gains, in units of the command (V or N) per metre. `tracking` is the rate of the anti-windup (1/s).

    `lead` is what of the valve's time constant the feed-forward inverts. The feed-forward has a gain for either
    direction of the reference.
    """

    proportional: Annotated[float, "command/m"]
    integral: Annotated[float, "command/(m s)"]
    derivative: Annotated[float, "command s/m"]
    feedforward: Annotated[float, "command s/m"]
    tracking: Annotated[float, "1/s"]
    estimator: Estimator
    lead: Annotated[float, "s"] = 0.0
    feedforward_backward: Annotated[float, "command s/m"] = 0.0


class State(NamedTuple):
    integral: Annotated[float, "command"]
    command: Annotated[float, "command"]
    error: Annotated[float, "m"]
    estimator: EstimatorState


@equation
def step(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """u = K_p e + K_d (dr - v^) + I + K_ff (dr + T_l ddr), with e = r - x and v^ the estimated velocity.

    T_l = lead tau, tau the valve's lag: (1 + tau s) of the reference's velocity is what the valve makes that velocity
    of again.
    """
    error = reference.position - measurement.position
    velocity, estimator = estimate_velocity(measurement.position, state.estimator, gains.estimator)
    fed = select(reference.velocity >= 0.0, gains.feedforward, gains.feedforward_backward)
    command = (
        gains.proportional * error
        + gains.derivative * (reference.velocity - velocity)
        + state.integral
        + fed * (reference.velocity + gains.lead * reference.acceleration)
    )
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
    """Gains from settings, with K_ff = feedforward / K_q and T_l = lead tau.

    Raises:
        ValueError: feed-forward for a plant whose belief has no velocity gain, or an estimator's setting.
    """
    forward, backward, lead = 0.0, 0.0, 0.0
    if settings.feedforward:
        known = velocities(belief)
        if known is None:
            raise ValueError("feedforward needs a plant with a velocity gain (one with a valve); leave it out here")
        forward, backward = settings.feedforward / known.forward, settings.feedforward / known.backward
        lead = settings.lead * known.time_constant
    tracking = 0.0
    if settings.ki:
        tracking_time = settings.tracking_time or abs(settings.kp / settings.ki)
        tracking = 1.0 / max(tracking_time, sample_time)
    estimator = design_estimator(settings, sample_time)
    return Gains(settings.kp, settings.ki, settings.kd, forward, tracking, estimator, lead, backward)


SUMMARY = "P, PI, PD, PID with velocity feed-forward and anti-windup"

PID = Controller("pid", SUMMARY, Settings, Gains, State, design, step, commit, start)
