"""Rotation switched on and off: the rod turns while the piston moves slowly along or rests, and stands while it moves.

The coarser of the two forms that thesis 6.2 leaves open; `controllers.scheduled_rotation` is the finer one.
"""

from collections.abc import Callable
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers import speed_servo
from controllers.interface import Controller, Reference
from controllers.velocity import Estimator, EstimatorState, at_rest, estimate_velocity, filtered_differentiator
from plants.equation import Scalar, equation, select
from plants.interface import Measurement

HYSTERESIS = 1.5
"""Rotation that is on goes off at this many times the speed at which it came on."""


class Settings(NamedTuple):
    """What a user sets.

    `bias` is the current believed to hold the `speed` of a piston at rest; below the estimated speed `switch_speed`
    along the rod rotation comes on. `surface_acceleration` limits how fast it comes and goes, as that of
    `controllers.scheduled_rotation`.
    """

    speed: Annotated[float, "rad/s"] = 0.0
    bias: Annotated[float, "A"] = 0.0
    switch_speed: Annotated[float, "m/s"] = 0.03
    surface_acceleration: Annotated[float, "m/s^2"] = 5.0
    velocity_time_constant: Annotated[float, "s"] = 2e-3


class Gains(NamedTuple):
    """Of the servo; piston radius, speeds along at which it switches, largest change in a sample, estimator."""

    servo: speed_servo.Gains
    radius: Annotated[float, "m"]
    switch_on: Annotated[float, "m/s"]
    switch_off: Annotated[float, "m/s"]
    largest_change: Annotated[float, "rad/s"]
    estimator: Estimator


class State(NamedTuple):
    """`on` is 1 while rotation is on, 0 while it is off."""

    servo: speed_servo.State
    estimator: EstimatorState
    commanded: Annotated[float, "rad/s"]
    on: Annotated[float, "1"]


@equation
def switch(speed: Scalar, position: Scalar, state: State, gains: Gains) -> tuple[Scalar, Scalar, EstimatorState]:
    """The speed (rad/s) to turn with, whether rotation is on, and the estimator's next state [derived here].

    on <- |v^| < v_on, where it was off;  |v^| < 1.5 v_on, where it was on
    omega_c moves towards `speed` where on, towards 0 where off, by at most `largest_change` in a sample
    """
    velocity, estimator = estimate_velocity(position, state.estimator, gains.estimator)
    threshold = select(state.on > 0.0, gains.switch_off, gains.switch_on)
    on = select(np.abs(velocity) < threshold, 1.0, 0.0)
    change = np.minimum(np.maximum(on * speed - state.commanded, -gains.largest_change), gains.largest_change)
    return state.commanded + change, on, estimator


@equation
def step_voltage(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """Motor voltage (V): the servo of `controllers.speed_servo` on omega_c; `reference.position` is the speed when on.

    Its bias counts by the share omega_c / omega.
    """
    commanded, on, estimator = switch(reference.position, measurement.position, state, gains)
    share = commanded / np.maximum(reference.position, 1e-12)
    voltage, following = speed_servo.follow(commanded, gains.servo.bias * share, measurement, state.servo, gains.servo)
    return voltage, State(following, estimator, commanded, on)


@equation
def step_surface_speed(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """Surface speed (m/s) R omega_c, for a plant on which it is imposed; `reference.position` is the speed when on."""
    commanded, on, estimator = switch(reference.position, measurement.position, state, gains)
    return gains.radius * commanded, State(state.servo, estimator, commanded, on)


@equation
def commit(realised: Scalar, state: State, gains: Gains, sample_time: Scalar) -> State:
    """The servo's integral goes on."""
    servo = speed_servo.commit(realised, state.servo, gains.servo, sample_time)
    return State(servo, state.estimator, state.commanded, state.on)


def start(measurement: Measurement, gains: Gains) -> State:
    """The piston at rest along and rotation on, from the speed that is measured (0 where it is not)."""
    turning = float(np.nan_to_num(measurement.rotation_speed))
    return State(speed_servo.start(measurement, gains.servo), at_rest(measurement.position), turning, 1.0)


def design(settings: Settings, belief: Any, sample_time: float) -> Gains:
    """Gains from settings and the believed motor.

    Raises:
        ValueError: a speed, acceleration or time constant that is not above 0.
    """
    for name in ("switch_speed", "surface_acceleration", "velocity_time_constant"):
        if getattr(settings, name) <= 0.0:
            raise ValueError(f"{name} is {getattr(settings, name):g}, expected a value above 0")
    radius = belief.motor.piston_radius
    return Gains(
        speed_servo.design(speed_servo.Settings(settings.speed, settings.bias), belief, sample_time),
        radius,
        settings.switch_speed,
        HYSTERESIS * settings.switch_speed,
        settings.surface_acceleration * sample_time / radius,
        filtered_differentiator(settings.velocity_time_constant, sample_time),
    )


def _controller(name: str, summary: str, step: Callable[..., Any]) -> Controller:
    return Controller(name, summary, Settings, Gains, State, design, step, commit, start)


SWITCHED_ROTATION = {
    "motor_voltage": _controller(
        "switched_rotation", "rotation while the piston moves slowly along, by the motor's voltage", step_voltage
    ),
    "surface_speed": _controller(
        "switched_surface_speed", "rotation while the piston moves slowly along, imposed", step_surface_speed
    ),
}
"""The rotary controller by the input of the plant that it drives."""
