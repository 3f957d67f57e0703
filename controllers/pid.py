"""P, PI, PD, PID with velocity feed-forward and anti-windup: one law, each term optional."""

from typing import Annotated, NamedTuple

from controllers.interface import Controller, Reference
from controllers.velocity import Estimator, EstimatorState, at_rest, estimate_velocity
from plants.equation import Scalar, equation
from plants.interface import Measurement


class Gains(NamedTuple):
    """Gains, in units of the command (V or N) per metre. `tracking` is the rate of the anti-windup (1/s)."""

    proportional: Annotated[float, "command/m"]
    integral: Annotated[float, "command/(m s)"]
    derivative: Annotated[float, "command s/m"]
    feedforward: Annotated[float, "command s/m"]
    tracking: Annotated[float, "1/s"]
    estimator: Estimator


class State(NamedTuple):
    integral: Annotated[float, "command"]
    command: Annotated[float, "command"]
    error: Annotated[float, "m"]
    estimator: EstimatorState


@equation
def step(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """u = K_p e + K_d (dr - v^) + I + K_ff dr, with e = r - x and v^ the estimated velocity."""
    error = reference.position - measurement.position
    velocity, estimator = estimate_velocity(measurement.position, state.estimator, gains.estimator)
    command = (
        gains.proportional * error
        + gains.derivative * (reference.velocity - velocity)
        + state.integral
        + gains.feedforward * reference.velocity
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


PID = Controller(
    name="pid",
    summary="P, PI, PD, PID with velocity feed-forward and anti-windup",
    Gains=Gains,
    State=State,
    step=step,
    commit=commit,
    start=start,
)
