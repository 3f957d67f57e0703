"""PI servo that holds the speed of rotation through the motor's voltage."""

from typing import Annotated, NamedTuple

from controllers.interface import Controller, Reference
from plants.equation import Scalar, equation
from plants.interface import Measurement
from plants.motor import Motor

DAMPING = 1.0
BANDWIDTH_RATIO = 3.0
"""Closed-loop natural frequency, as a multiple of the motor's own mechanical rate constant."""


class Gains(NamedTuple):
    proportional: Annotated[float, "V s/rad"]
    integral: Annotated[float, "V/rad"]
    bias: Annotated[float, "V"]


class State(NamedTuple):
    integral: Annotated[float, "V"]
    error: Annotated[float, "rad/s"]


@equation
def step(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """V_m = bias + K_p (omega_ref - omega) + I; `reference.position` is the wanted speed (rad/s)."""
    error = reference.position - measurement.rotation_speed
    return gains.bias + gains.proportional * error + state.integral, State(state.integral, error)


@equation
def commit(realised: Scalar, state: State, gains: Gains, sample_time: Scalar) -> State:
    """I <- I + h K_i e."""
    return State(state.integral + sample_time * gains.integral * state.error, state.error)


def start(measurement: Measurement, gains: Gains) -> State:
    """The integral empty: the bias holds the speed."""
    return State(0.0, 0.0)


def place_poles(motor: Motor, viscous: float, bias: float) -> Gains:
    """Gains for two equal poles at `BANDWIDTH_RATIO` times the motor's own rate constant.

    With the winding taken as instantaneous, J domega/dt = K_t (V - K_b omega)/R_m - B omega has the rate constant
    a = (K_t K_b / R_m + B)/J and the gain b = K_t/(R_m J); PI control gives s^2 + (a + b K_p) s + b K_i.

    Args:
        motor: believed motor.
        viscous: believed viscous friction at the surface (N s/m).
        bias: voltage (V) believed to hold the wanted speed.
    """
    inertia = motor.rotary_mass * motor.piston_radius**2
    damping = viscous * motor.piston_radius**2
    rate = (motor.torque_constant * motor.back_emf_constant / motor.motor_resistance + damping) / inertia
    gain = motor.torque_constant / (motor.motor_resistance * inertia)
    natural = BANDWIDTH_RATIO * rate
    return Gains((2.0 * DAMPING * natural - rate) / gain, natural**2 / gain, bias)


SPEED_SERVO = Controller(
    name="speed_servo",
    summary="PI servo of the speed of rotation",
    Gains=Gains,
    State=State,
    step=step,
    commit=commit,
    start=start,
)
