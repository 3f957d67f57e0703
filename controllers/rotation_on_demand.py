"""Rotation only when it is needed: while the piston moves slowly along, or rests.

Thesis 6.2 proposes it without a law. A piston that moves fast enough along has left the Stribeck range by itself; only
around its reversals, and at rest, must rotation keep the contact sliding. Two demands: scheduled, which keeps the
helical speed at a minimum, and switched, the coarser one, on or off. Both go to the servo of `controllers.speed_servo`,
or where the plant's surface speed is imposed, there.
"""

from collections.abc import Callable
from typing import Annotated, NamedTuple, TypeAlias

import numpy as np

from controllers import speed_servo
from controllers.belief import Turned
from controllers.believed_friction import measured_rotation
from controllers.interface import Controller, Reference, Step
from controllers.velocity import Estimator, EstimatorState, at_rest, estimate_velocity, filtered_differentiator
from plants.equation import Scalar, equation, select
from plants.interface import Measurement

MARGIN = 1.01
"""The schedule aims this much above the minimum: for the lag of velocity estimate and motor."""

HYSTERESIS = 1.5
"""Rotation that is on goes off at this many times the speed at which it came on."""


class Settings(NamedTuple):
    """What a user sets.

    `bias` is the current believed to hold the `speed` of a piston at rest. `surface_acceleration` limits how fast the
    surface speed may change: 5 m/s^2 is 25 times the acceleration of a sine of 20 mm at 0.5 Hz, and takes 170 N at
    the surface of the simulation plant's 34 kg, less than its friction. Below the estimated speed `switch_speed` along
    the rod switched rotation comes on; a schedule has no use for it.
    """

    speed: Annotated[float, "rad/s"] = 0.0
    bias: Annotated[float, "A"] = 0.0
    surface_acceleration: Annotated[float, "m/s^2"] = 5.0
    velocity_time_constant: Annotated[float, "s"] = 2e-3
    switch_speed: Annotated[float, "m/s"] = 0.03


class Gains(NamedTuple):
    """Of the servo; piston radius, largest change of speed in a sample, where it switches, velocity estimator."""

    servo: speed_servo.Gains
    radius: Annotated[float, "m"]
    largest_change: Annotated[float, "rad/s"]
    switch_on: Annotated[float, "m/s"]
    switch_off: Annotated[float, "m/s"]
    estimator: Estimator


class State(NamedTuple):
    """`demanded` is the speed that the servo is asked for; `on` is 1 while rotation is asked for, 0 while it is not."""

    servo: speed_servo.State
    estimator: EstimatorState
    demanded: Annotated[float, "rad/s"]
    on: Annotated[float, "1"]


Demand: TypeAlias = Callable[[Scalar, Scalar, Scalar, Gains], Scalar]
"""The speed (rad/s) to ask for, of the wanted one, the velocity along, whether rotation is on, and the gains."""


@equation
def scheduled(speed: Scalar, velocity: Scalar, on: Scalar, gains: Gains) -> Scalar:
    """omega_s = sqrt(max((m omega_min)^2 - (v^/R)^2, 0)) (rad/s), omega_min = `speed`, m the `MARGIN` [derived here].

    `speed` is the minimum helical speed over R. When a piston that was faster than the minimum brakes by a (m/s^2), a
    surface speed that changes by r (m/s^2) lets the helical speed fall to sqrt(1 - (a/r)^2) of what was aimed at.
    """
    along = velocity / gains.radius
    return np.sqrt(np.maximum((MARGIN * speed) ** 2 - along**2, 0.0))


@equation
def switched(speed: Scalar, velocity: Scalar, on: Scalar, gains: Gains) -> Scalar:
    """`speed` (rad/s) while on, 0 while off:  on <- |v^| < v_on, where it was off; |v^| < 1.5 v_on, where it was on.

    [derived here]
    """
    threshold = select(on > 0.0, gains.switch_off, gains.switch_on)
    return select(np.abs(velocity) < threshold, speed, 0.0)


def _steps(demand: Demand) -> dict[str, Step[State, Gains]]:
    """The steps that ask for a demand, by the input of the plant that they drive; `reference.position` is `speed`."""

    @equation
    def ask(speed: Scalar, position: Scalar, state: State, gains: Gains) -> tuple[Scalar, Scalar, EstimatorState]:
        velocity, estimator = estimate_velocity(position, state.estimator, gains.estimator)
        wanted = demand(speed, velocity, state.on, gains)
        change = np.minimum(np.maximum(wanted - state.demanded, -gains.largest_change), gains.largest_change)
        return state.demanded + change, select(wanted > 0.0, 1.0, 0.0), estimator

    @equation
    def motor_voltage(
        reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
    ) -> tuple[Scalar, State]:
        demanded, on, estimator = ask(reference.position, measurement.position, state, gains)
        # At constant helical speed the rotary friction F_h w / v_h is proportional to the speed of rotation.
        share = demanded / np.maximum(reference.position, 1e-12)
        bias = gains.servo.bias * share
        voltage, following = speed_servo.follow(demanded, bias, measurement, state.servo, gains.servo)
        return voltage, State(following, estimator, demanded, on)

    @equation
    def surface_speed(
        reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
    ) -> tuple[Scalar, State]:
        demanded, on, estimator = ask(reference.position, measurement.position, state, gains)
        return gains.radius * demanded, State(state.servo, estimator, demanded, on)

    return {"motor_voltage": motor_voltage, "surface_speed": surface_speed}


@equation
def commit(realised: Scalar, state: State, gains: Gains, sample_time: Scalar) -> State:
    """The servo's integral goes on."""
    servo = speed_servo.commit(realised, state.servo, gains.servo, sample_time)
    return State(servo, state.estimator, state.demanded, state.on)


def start(measurement: Measurement, gains: Gains) -> State:
    """The piston at rest along and rotation on, from the speed that is measured (0 where it is not)."""
    turning = measured_rotation(measurement.rotation_speed)
    return State(speed_servo.start(measurement, gains.servo), at_rest(measurement.position), turning, 1.0)


def design(settings: Settings, belief: Turned, sample_time: float) -> Gains:
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
        settings.surface_acceleration * sample_time / radius,
        settings.switch_speed,
        HYSTERESIS * settings.switch_speed,
        filtered_differentiator(settings.velocity_time_constant, sample_time),
    )


def _controllers(name: str, summary: str, demand: Demand) -> dict[str, Controller]:
    return {
        driven: Controller(f"{name}_{driven}", summary, Settings, Gains, State, design, step, commit, start)
        for driven, step in _steps(demand).items()
    }


SCHEDULED_ROTATION = _controllers("scheduled", "rotation that keeps a minimum helical speed", scheduled)
SWITCHED_ROTATION = _controllers("switched", "rotation while the piston moves slowly along", switched)
"""The rotary controllers by the input of the plant that they drive."""
