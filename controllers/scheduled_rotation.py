"""Rotation only when it is needed: the helical speed is kept at a minimum while the piston moves slowly along.

Thesis 6.2 proposes it without a law. A piston that moves fast enough along has left the Stribeck range by itself; only
around its reversals, and at rest, must rotation keep the contact sliding.
"""

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers import speed_servo
from controllers.interface import Controller, Reference
from controllers.velocity import Estimator, EstimatorState, at_rest, estimate_velocity, filtered_differentiator
from plants.equation import Scalar, equation
from plants.interface import Measurement

MARGIN = 1.01
"""The schedule aims this much above the minimum: for the lag of velocity estimate and motor."""


class Settings(NamedTuple):
    """What a user sets.

    `bias` is the current believed to hold the `speed` of a piston at rest. `surface_acceleration` limits how fast the
    surface speed may change: 5 m/s^2 is 25 times the acceleration of a sine of 20 mm at 0.5 Hz, and takes 170 N at
    the surface of the simulation plant's 34 kg, less than its friction.
    """

    speed: Annotated[float, "rad/s"] = 0.0
    bias: Annotated[float, "A"] = 0.0
    surface_acceleration: Annotated[float, "m/s^2"] = 5.0
    velocity_time_constant: Annotated[float, "s"] = 2e-3


class Gains(NamedTuple):
    """Of the servo; piston radius, largest change of speed in a sample, velocity estimator."""

    servo: speed_servo.Gains
    radius: Annotated[float, "m"]
    largest_change: Annotated[float, "rad/s"]
    estimator: Estimator


class State(NamedTuple):
    servo: speed_servo.State
    estimator: EstimatorState
    scheduled: Annotated[float, "rad/s"]


@equation
def schedule(minimum: Scalar, position: Scalar, state: State, gains: Gains) -> tuple[Scalar, EstimatorState]:
    """The wanted speed of rotation (rad/s) and the estimator's next state [derived here].

        omega_s = sqrt(max((m omega_min)^2 - (v^/R)^2, 0)),  changed by at most `largest_change` in a sample

    `minimum` omega_min (rad/s) is the minimum helical speed over R, m the `MARGIN`. When a piston that was faster than
    the minimum brakes by a (m/s^2), a surface speed that changes by r (m/s^2) lets the helical speed fall to
    sqrt(1 - (a/r)^2) of what was aimed at.
    """
    velocity, estimator = estimate_velocity(position, state.estimator, gains.estimator)
    along = velocity / gains.radius
    wanted = np.sqrt(np.maximum((MARGIN * minimum) ** 2 - along**2, 0.0))
    change = np.minimum(np.maximum(wanted - state.scheduled, -gains.largest_change), gains.largest_change)
    return state.scheduled + change, estimator


@equation
def step_voltage(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """Motor voltage (V): the servo of `controllers.speed_servo` on omega_s; `reference.position` is omega_min.

    Its bias is scaled by omega_s / omega_min: at constant helical speed the rotary friction F_h w / v_h is proportional
    to the speed of rotation [derived here].
    """
    scheduled, estimator = schedule(reference.position, measurement.position, state, gains)
    share = scheduled / np.maximum(reference.position, 1e-12)
    voltage, following = speed_servo.follow(scheduled, gains.servo.bias * share, measurement, state.servo, gains.servo)
    return voltage, State(following, estimator, scheduled)


@equation
def step_surface_speed(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """Surface speed (m/s) R omega_s, for a plant on which it is imposed; `reference.position` is omega_min."""
    scheduled, estimator = schedule(reference.position, measurement.position, state, gains)
    return gains.radius * scheduled, State(state.servo, estimator, scheduled)


@equation
def commit(realised: Scalar, state: State, gains: Gains, sample_time: Scalar) -> State:
    """The servo's integral goes on."""
    return State(speed_servo.commit(realised, state.servo, gains.servo, sample_time), state.estimator, state.scheduled)


def start(measurement: Measurement, gains: Gains) -> State:
    """The piston at rest along, turning as it was measured to (0 where that is not measured)."""
    turning = float(np.nan_to_num(measurement.rotation_speed))
    return State(speed_servo.start(measurement, gains.servo), at_rest(measurement.position), turning)


def design(settings: Settings, belief: Any, sample_time: float) -> Gains:
    """Gains from settings and the believed motor.

    Raises:
        ValueError: an acceleration or time constant that is not above 0.
    """
    for name in ("surface_acceleration", "velocity_time_constant"):
        if getattr(settings, name) <= 0.0:
            raise ValueError(f"{name} is {getattr(settings, name):g}, expected a value above 0")
    radius = belief.motor.piston_radius
    return Gains(
        speed_servo.design(speed_servo.Settings(settings.speed, settings.bias), belief, sample_time),
        radius,
        settings.surface_acceleration * sample_time / radius,
        filtered_differentiator(settings.velocity_time_constant, sample_time),
    )


def _controller(name: str, summary: str, step: Callable[..., Any]) -> Controller:
    return Controller(name, summary, Settings, Gains, State, design, step, commit, start)


SCHEDULED_ROTATION = {
    "motor_voltage": _controller(
        "scheduled_rotation", "rotation that keeps a minimum helical speed, by the motor's voltage", step_voltage
    ),
    "surface_speed": _controller(
        "scheduled_surface_speed", "rotation that keeps a minimum helical speed, imposed", step_surface_speed
    ),
}
"""The rotary controller by the input of the plant that it drives."""
