"""PI servo that holds the speed of rotation through the motor's voltage."""

from typing import Annotated, Any, NamedTuple

from controllers.interface import Controller, Reference
from plants.equation import Scalar, equation
from plants.interface import Measurement

CROSSOVER = 0.5
"""Crossover of the loop, as a share of the winding's rate constant R_m/L_m: damping 0.71 (magnitude optimum)."""


class Settings(NamedTuple):
    """The voltage believed to hold the wanted speed, to which the servo adds."""

    bias: Annotated[float, "V"] = 0.0


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


def design(settings: Settings, belief: Any, sample_time: float) -> Gains:
    """PI control by the magnitude optimum: its zero at the slow pole, its gain as the winding admits.

    With the winding taken as instantaneous, J domega/dt = K_t (V - K_b omega)/R_m - B omega has the rate constant
    a = (K_t K_b / R_m + B)/J and the gain b = K_t/(R_m J). K_p = omega_c/b and K_i = a K_p leave the loop
    omega_c/s (1 + s L_m/R_m).
    """
    motor = belief.motor
    inertia = motor.rotary_inertia
    damping = belief.friction.positive.viscous * motor.piston_radius**2
    rate = (motor.torque_constant * motor.back_emf_constant / motor.motor_resistance + damping) / inertia
    gain = motor.torque_constant / (motor.motor_resistance * inertia)
    proportional = CROSSOVER * motor.motor_resistance / motor.motor_inductance / gain
    return Gains(proportional, rate * proportional, settings.bias)


SPEED_SERVO = Controller(
    name="speed_servo",
    summary="PI servo of the speed of rotation",
    Settings=Settings,
    Gains=Gains,
    State=State,
    design=design,
    step=step,
    commit=commit,
    start=start,
)
