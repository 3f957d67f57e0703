"""Compensation with the velocity and the friction of the extended Kalman filter, by any law for a valve."""

import functools
from typing import Annotated, NamedTuple

from controllers import compensation_laws as laws
from controllers.belief import HydraulicSliding
from controllers.believed_friction import (
    FILTER_TIME,
    RotationTimeConstant,
    RotationUse,
    filtered_rotation,
    measured_rotation,
    rotation_gain,
)
from controllers.compensation import LAWS, law_gains
from controllers.compensation_laws import Law, LawGains, LawState, Wanted
from controllers.extended_kalman import EkfGains, EkfSettings, EkfState, design_ekf, ekf_at_rest, ekf_update
from controllers.interface import Controller, Reference, Step
from controllers.settings import About, Tuned
from plants.equation import Scalar, equation
from plants.interface import Measurement


def _deviation(what: str) -> About:
    return About(f"standard deviation of {what}, a sample", above=True)


class Settings(NamedTuple):
    """Settings of the laws as in `controllers.compensation`, and the noise that the filter believes in."""

    law: Annotated[str, "acceleration_feedback", "valve_inversion", About("how the estimate reaches the actuator")] = (
        "valve_inversion"
    )
    kp: laws.ProportionalGain = 500.0
    kd: laws.DerivativeGain = 0.0
    ka: laws.AccelerationGain = 0.002
    feedforward: laws.Feedforward = 1.0
    position_rate: laws.PositionRate = 34.0
    force_rate: laws.ForceRate = 0.0
    washout: laws.Washout = 0.0
    compression: laws.Compression = 0.0
    lead: laws.Lead = 0.0
    position_noise: Annotated[float, "m", _deviation("a measured position")] = 13e-6
    pressure_noise: Annotated[float, "Pa", _deviation("a measured pressure")] = 2e3
    force_noise: Annotated[float, "N", _deviation("the force that the model lacks")] = 5.0
    flow_noise: Annotated[float, "m^3/s", _deviation("the flow that the model lacks")] = 5e-7
    friction_noise: Annotated[float, "N", _deviation("the bristle force that the model lacks"), Tuned(15.0, 1500.0)] = (
        150.0
    )
    rotation: RotationUse = "measured"
    rotation_time_constant: RotationTimeConstant = FILTER_TIME


class Gains(NamedTuple):
    ekf: EkfGains
    law: LawGains
    area_1: Annotated[float, "m^2"]
    area_2: Annotated[float, "m^2"]
    rotation_gain: Annotated[float, "1"]


class State(NamedTuple):
    """`friction` is the estimate of this sample; it is kept to be seen. `rotation_speed` is the filtered one."""

    ekf: EkfState
    law: LawState
    realised: Annotated[float, "command"]
    friction: Annotated[float, "N"]
    rotation_speed: Annotated[float, "rad/s"]


def combine(law: Law) -> Step[State, Gains]:
    """The step of a controller made of the filter and a law."""

    @equation
    def step(
        reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
    ) -> tuple[Scalar, State]:
        rotation = filtered_rotation(measurement.rotation_speed, state.rotation_speed, gains.rotation_gain)
        around = gains.ekf.turning.radius * rotation
        velocity, _, friction, ekf = ekf_update(measurement, state.realised, state.ekf, gains.ekf, sample_time, around)
        error = reference.position - measurement.position
        force = gains.area_1 * measurement.pressure_1 - gains.area_2 * measurement.pressure_2
        wanted = Wanted(error, reference.velocity, reference.acceleration, velocity, force)
        command, following = law(wanted, friction, state.law, gains.law, sample_time)
        return command, State(ekf, following, state.realised, friction, rotation)

    return step


@equation
def commit(realised: Scalar, state: State, gains: Gains, sample_time: Scalar) -> State:
    """Keeps the realised voltage, which moves the believed spool."""
    return State(state.ekf, state.law, realised, state.friction, state.rotation_speed)


def start(measurement: Measurement, gains: Gains) -> State:
    """At rest along with a closed valve, turning as measured."""
    rotation = measured_rotation(measurement.rotation_speed)
    return State(ekf_at_rest(measurement, gains.ekf), LawState(0.0), 0.0, 0.0, rotation)


def design(settings: Settings, belief: HydraulicSliding, sample_time: float) -> Gains:
    """Gains from settings and the believed plant.

    Raises:
        ValueError: a noise that is not above 0, or a belief without a valve.
    """
    noise = EkfSettings(*(getattr(settings, name) for name in EkfSettings._fields))
    ekf = design_ekf(belief, noise, sample_time, settings.rotation)
    h = ekf.hydraulics
    turning = rotation_gain(settings.rotation_time_constant, sample_time)
    return Gains(ekf, law_gains(settings, belief), h.piston_area_1, h.piston_area_2, turning)


def choose(settings: Settings, belief: object) -> Controller:
    """The compensator for the law that the settings name."""
    return ekf_compensator(settings.law)


@functools.cache
def ekf_compensator(law: str = "valve_inversion") -> Controller:
    """The controller made of the filter and a law."""
    summary = "friction compensation: extended Kalman filter of velocity, load pressure and bristle"
    step = combine(LAWS[law])
    return Controller("ekf", summary, Settings, Gains, State, design, step, commit, start, choose)
