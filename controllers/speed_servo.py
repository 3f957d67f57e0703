"""Servo that holds the speed of rotation against a friction that falls with it, through the motor's voltage.

A current loop inside a speed loop, as a digital servo amplifier has them (the thesis's motor had one).
"""

from typing import Annotated, NamedTuple

import numpy as np

from controllers.belief import Anisotropic, HasFriction, Turned
from controllers.interface import Controller, Reference
from plants.equation import Scalar, equation, select
from plants.friction import LuGre, blended
from plants.interface import Measurement
from plants.motor import current_limit

SAMPLED = 0.7
"""Rate of the speed loop times the sample time. The current follows one sample late: a delay of a sample takes 40
degrees at a crossover of 0.7 / h, and leaves what a friction that falls takes further."""

NEEDED = 2.0
"""The speed loop is this many times faster than the rod may run away by itself, if sampling admits that ..."""

SLOWEST = 400.0
"""1/s. ... and at least so fast, for the friction's rise and fall while the piston reverses. Faster than needed it
would amplify the noise of its sensors, and bear no filters on them."""

INTEGRAL = 0.1
"""Rate of the integral action as a share of that of the speed loop."""

STEEPER = 1.5
"""The fall of friction may be this many times the believed one."""

SLOWER = 0.5
"""Speeds down to this share of the wanted one matter: what the rod may dip to while the piston reverses."""

HELD = 1.5
"""The speed loop has to be this many times faster than the rod runs away by itself; at 1.2 times it is unstable."""


class Settings(NamedTuple):
    """The wanted speed (rad/s), and the current believed to hold it, to which the servo adds."""

    speed: Annotated[float, "rad/s"] = 0.0
    bias: Annotated[float, "A"] = 0.0


class Gains(NamedTuple):
    """Of the speed loop; of the current loop R_m, K_bemf and exp(-R_m h / L_m); largest current, largest speed."""

    proportional: Annotated[float, "A s/rad"]
    integral: Annotated[float, "A/rad"]
    bias: Annotated[float, "A"]
    resistance: Annotated[float, "ohm"]
    back_emf: Annotated[float, "V s/rad"]
    decay: Annotated[float, "1"]
    largest_current: Annotated[float, "A"]
    largest_speed: Annotated[float, "rad/s"]


class State(NamedTuple):
    """The integral, the last error, the voltage asked for and the share of its error that the integral may take."""

    integral: Annotated[float, "A"]
    error: Annotated[float, "rad/s"]
    wanted: Annotated[float, "V"]
    excess: Annotated[float, "A"]


@equation
def step(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """V_m of the next sample; `reference.position` is the wanted speed (rad/s). See `follow`."""
    return follow(reference.position, gains.bias, measurement, state, gains)


@equation
def follow(speed: Scalar, bias: Scalar, measurement: Measurement, state: State, gains: Gains) -> tuple[Scalar, State]:
    """Voltage (V) that holds `speed` (rad/s), which is believed to take the current `bias` (A).

        i_ref = bias + K_p e + I,  e = omega_ref - omega
        V_m   = K_bemf omega + R_m (i_ref - d i) / (1 - d),  d = exp(-R_m h / L_m)

    At constant speed that voltage takes the current from i to i_ref in one sample. [derived here]
    """
    wanted = np.minimum(np.maximum(speed, -gains.largest_speed), gains.largest_speed)
    error = wanted - measurement.rotation_speed
    asked = bias + gains.proportional * error + state.integral
    current = np.minimum(np.maximum(asked, -gains.largest_current), gains.largest_current)
    driving = gains.resistance * (current - gains.decay * measurement.motor_current) / (1.0 - gains.decay)
    voltage = gains.back_emf * measurement.rotation_speed + driving
    return voltage, State(state.integral, error, voltage, asked - current)


@equation
def commit(realised: Scalar, state: State, gains: Gains, sample_time: Scalar) -> State:
    """I <- I + h K_i e, but for an error that asks for still more than current or voltage admit."""
    lacking = state.excess + (state.wanted - realised) / gains.resistance
    grown = state.integral + sample_time * gains.integral * state.error
    return State(select(lacking * state.error > 0.0, state.integral, grown), state.error, realised, state.excess)


def start(measurement: Measurement, gains: Gains) -> State:
    """The integral empty: the bias holds the speed."""
    return State(0.0, 0.0, 0.0, 0.0)


def friction_around(belief: HasFriction) -> LuGre:
    """The believed friction of a rod that turns without moving along, as forces and speeds at the surface."""
    if isinstance(belief, Anisotropic):
        return belief.rotary
    law: LuGre = blended(0.0, 0.0, belief.friction)
    return law


def runaway_rate(belief: Turned, speed: float) -> float:
    """Rate (1/s) at which the rod leaves a constant torque at `speed` (rad/s) or above; not above 0 where it stays.

    The friction falls at most by a1 (2 x / v_s) exp(-x^2) less a2, x = w / v_s, at x = 1/sqrt(2) or, if that is below
    the slowest speed that matters, there. A rod that moves along falls less: the friction around it is
    F_h w / v_h. Rate: that slope times R^2 / J.
    """
    law, motor = friction_around(belief), belief.motor
    slowest = SLOWER * abs(speed) * motor.piston_radius
    x = max(slowest / law.stribeck_velocity, np.sqrt(0.5))
    fall = STEEPER * law.stribeck * 2.0 * x * np.exp(-(x**2)) / law.stribeck_velocity - law.viscous
    return float(fall * motor.piston_radius**2 / motor.rotary_inertia)


def speed_rate(belief: Turned, speed: float, sample_time: float) -> float:
    """Rate (1/s) of the speed loop at `speed` (rad/s)."""
    return min(SAMPLED / sample_time, max(SLOWEST, NEEDED * runaway_rate(belief, speed)))


def holds(belief: Turned, speed: float, sample_time: float) -> bool:
    """Whether the servo holds a rod that turns at `speed` (rad/s) against the steepest fall of its friction."""
    return HELD * runaway_rate(belief, speed) <= speed_rate(belief, speed, sample_time)


def design(settings: Settings, belief: Turned, sample_time: float) -> Gains:
    """The current loop in one sample (deadbeat), and around it

        K_p = lambda J / K_t,  K_i = mu K_p,  lambda = max(400 / s, 2 r) <= 0.7 / h,  mu = lambda / 10

    with r the `runaway_rate`,

    so that e falls with lambda, and with mu what is left. At lambda h = 0.7 the sampled loop is stable for a friction
    whose slope alone would move the rod with rates from -8 / h (viscous, or a bristle that does not slide yet) to
    +0.58 / h (falling), 0.83 lambda; `runaway_rate` says what is believed to be met. [derived here]
    """
    motor = belief.motor
    rate = speed_rate(belief, settings.speed, sample_time)
    proportional = rate * motor.rotary_inertia / motor.torque_constant
    return Gains(
        proportional,
        INTEGRAL * rate * proportional,
        settings.bias,
        motor.motor_resistance,
        motor.back_emf_constant,
        float(np.exp(-motor.motor_resistance * sample_time / motor.motor_inductance)),
        float(current_limit(motor)),
        motor.motor_speed_limit,
    )


SUMMARY = "servo of the speed of rotation: a current loop inside a speed loop"

SPEED_SERVO = Controller("speed_servo", SUMMARY, Settings, Gains, State, design, step, commit, start)
