"""Linear disturbance observer: what the piston lacks against the velocity that its voltage should give.

The classic observer (Ohnishi 1987) d^ = Q (u - v^ / P_n), P_n the nominal plant, Q a low-pass filter, on the velocity
of a valve-controlled piston. Friction, load, pressure drop and a wrong flow gain alike are one disturbance: a voltage.
"""

from typing import Annotated, NamedTuple

import numpy as np

from controllers.belief import velocity_gain as believed_gain
from controllers.interface import Controller, Reference
from controllers.pid import Feedforward, ProportionalGain
from controllers.settings import About, Tuned
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


class Settings(NamedTuple):
    """What a user sets. `observer_time_constant` is T_q of the filter Q; `feedforward` a share of dr / K_q."""

    kp: ProportionalGain = 500.0
    feedforward: Feedforward = 1.0
    observer_time_constant: Annotated[
        float, "s", About("time constant of the observer's filter", above=True), Tuned(2e-3, 0.2)
    ] = 20e-3
    velocity: VelocityKind = "filter"
    velocity_time_constant: TimeConstant = 2e-3
    position_noise: PositionNoise = 13e-6
    jerk_density: JerkDensity = 10.0


class Gains(NamedTuple):
    """`forward` and `backward` K_q, and `time_constant` tau, are the believed valve's.

    `feedforward` is a share of the velocity that is fed forward. `keep` is exp(-h/tau), `update` 1 - exp(-h/T_q).
    """

    proportional: Annotated[float, "V/m"]
    feedforward: Annotated[float, "1"]
    forward: Annotated[float, "m/(s V)"]
    backward: Annotated[float, "m/(s V)"]
    time_constant: Annotated[float, "s"]
    keep: Annotated[float, "1"]
    update: Annotated[float, "1"]
    estimator: Estimator


class State(NamedTuple):
    """Nominal plant: lagged voltage and position. The estimator runs on its lead over the piston. Then d^.

    Under a constant disturbance the lead grows for ever, and only its changes count: so after every sample the nominal
    plant is put back by the estimator's position, which is 0 then. Numbers stay small, in single precision too.
    """

    lagged: Annotated[float, "V"]
    nominal: Annotated[float, "m"]
    estimator: EstimatorState
    disturbance: Annotated[float, "V"]


@equation
def velocity_gain(way: Scalar, gains: Gains) -> Scalar:
    """K_q (m/s per V) in the direction that `way` has by its sign."""
    return select(way >= 0.0, gains.forward, gains.backward)


@equation
def step(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """V = K_p e + dr K_ff + d^, with d^ the voltage that the piston's velocity lacks.

        T_q dd^/dt + d^ = (v_n - v)^ / K_q                       Q = 1 / (T_q s + 1)
        dx_n/dt = v_n = K_q V_l,   tau dV_l/dt + V_l = V         nominal plant, driven by the realised voltage

    Feeding v/K_q back against V itself (P_n = K_q, without lag) makes the valve's lag a disturbance: with G the lag of
    valve and velocity filter the loop is T_q s + G(s) = 0, stable only for T_q > tau T_v / (tau + T_v) = 1.7 ms, with a
    damping ratio of 0.5 sqrt(T_q / tau) above. Here the nominal plant has the valve's lag, and one velocity estimator
    sees the difference x_n - x, so that its own lag F is in both. A plant with rho K_q G_v in place of K_q G_v, G_v the
    lag of the valve, then has V (1 - (1 - rho) Q F G_v) = V_c: since |Q F G_v| <= 1 the loop is stable for every
    0 < rho < 2, and at low frequency V = V_c / rho inverts the plant. At rho = 1 nothing is added [derived here].
    """
    error = reference.position - measurement.position
    lead = state.nominal - measurement.position
    lacking, estimator = estimate_velocity(lead, state.estimator, gains.estimator)
    disturbance = state.disturbance + gains.update * (lacking / velocity_gain(lacking, gains) - state.disturbance)
    fed = gains.feedforward * reference.velocity / velocity_gain(reference.velocity, gains)
    command = gains.proportional * error + fed + disturbance
    beside = EstimatorState(0.0 * estimator.first, estimator.second, estimator.third)
    return command, State(state.lagged, state.nominal - estimator.first, beside, disturbance)


@equation
def commit(realised: Scalar, state: State, gains: Gains, sample_time: Scalar) -> State:
    """The nominal plant over one sample of the realised voltage, exactly: a limited command does not wind d^ up."""
    offset = state.lagged - realised
    moved = realised * sample_time + offset * gains.time_constant * (1.0 - gains.keep)
    return State(
        realised + offset * gains.keep,
        state.nominal + velocity_gain(moved, gains) * moved,
        state.estimator,
        state.disturbance,
    )


def start(measurement: Measurement, gains: Gains) -> State:
    """At rest, the nominal plant where the piston is, no disturbance."""
    return State(0.0, measurement.position, at_rest(0.0), 0.0)


def design(settings: Settings, belief: object, sample_time: float) -> Gains:
    """Gains from settings and the believed valve.

    Raises:
        ValueError: a plant whose belief has no velocity gain, or a time constant that is not above 0.
    """
    known = believed_gain(belief, "disturbance_observer")
    if settings.observer_time_constant <= 0.0:
        raise ValueError(f"observer_time_constant is {settings.observer_time_constant:g}, expected a value above 0")
    return Gains(
        settings.kp,
        settings.feedforward,
        known.forward,
        known.backward,
        known.lag,
        float(np.exp(-sample_time / known.lag)),
        float(-np.expm1(-sample_time / settings.observer_time_constant)),
        design_estimator(settings, sample_time),
    )


SUMMARY = "P with feed-forward and a linear disturbance observer on the velocity"

DISTURBANCE_OBSERVER = Controller("disturbance_observer", SUMMARY, Settings, Gains, State, design, step, commit, start)
