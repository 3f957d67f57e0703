"""PI servo that holds the speed of rotation through the motor's voltage."""

from typing import Annotated, Any, NamedTuple

from controllers.interface import Controller, Reference
from plants.equation import Scalar, equation
from plants.interface import Measurement

CROSSOVER = 0.5
"""Crossover of the loop, as a share of the faster pole: damping 0.71 (magnitude optimum)."""

SAMPLED = 0.3
"""Largest rate constant, times the sample time, that the loop may rely on."""


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
    """PI control by the magnitude optimum: its zero at the slow pole, its gain as the fast one admits.

    From voltage to speed, with rotary viscous friction B alone,

        G(s) = b c / ((s + a) (s + c)),   a = (K_t K_b / R_m + B) / J,  b = K_t / (R_m J),  c = R_m / L_m

    K_i = K_p min(a, c) leaves the loop K_p b c / (s (s + max(a, c))), which crosses over at half of max(a, c), or of
    what sampling admits.
    """
    motor = belief.motor
    inertia, winding = motor.rotary_inertia, motor.motor_resistance / motor.motor_inductance
    around = belief.rotary if hasattr(belief, "rotary") else belief.friction.positive
    damping = around.viscous * motor.piston_radius**2
    rate = (motor.torque_constant * motor.back_emf_constant / motor.motor_resistance + damping) / inertia
    slow, fast = min(rate, winding), max(rate, winding)
    gain = motor.torque_constant / (motor.motor_resistance * inertia)
    proportional = CROSSOVER * min(fast, SAMPLED / sample_time) * fast / (gain * winding)
    return Gains(proportional, slow * proportional, settings.bias)


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
