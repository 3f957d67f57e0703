"""Friction compensation: any estimator with any law, as one sampled controller."""

import functools
from collections.abc import Callable
from typing import Annotated, Any, NamedTuple, TypeAlias

import numpy as np

from controllers import compensation_laws as laws
from controllers.belief import HasFriction, Hydraulic, Pneumatic, Sliding, bored, drive_gain, moved_mass
from controllers.believed_friction import (
    FILTER_TIME,
    RotationTimeConstant,
    RotationUse,
    believed_turning,
    filtered_rotation,
    low_pass_gain,
    measured_rotation,
    rotation_gain,
)
from controllers.compensation_laws import (
    Law,
    LawGains,
    LawState,
    Wanted,
    acceleration_feedback,
    force_source,
    valve_inversion,
)
from controllers.estimators import ESTIMATORS, ORACLE, without_use
from controllers.friction_observer import Belief, Estimate, Memory, Seen
from controllers.interface import Controller, Reference, Step
from controllers.settings import About, Needs, Tuned
from controllers.tafazoli import fit_map
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
from plants.authority import NONE, authority, velocity_gains
from plants.equation import Scalar, equation
from plants.interface import Measurement

LAWS: dict[str, Law] = {
    "acceleration_feedback": acceleration_feedback,
    "valve_inversion": valve_inversion,
    "force_source": force_source,
}


class Settings(NamedTuple):
    """What a user sets; each law and each estimator (`controllers.estimators`) uses its own.

    Every estimator has the same law by default, so that they differ in their estimate alone.
    """

    law: Annotated[
        str, "acceleration_feedback", "valve_inversion", "force_source", About("how the estimate reaches the actuator")
    ] = "valve_inversion"
    kp: laws.ProportionalGain = 500.0
    kd: laws.DerivativeGain = 0.0
    ka: laws.AccelerationGain = 0.002
    feedforward: laws.Feedforward = 1.0
    position_rate: laws.PositionRate = 34.0
    force_rate: laws.ForceRate = 0.0
    washout: laws.Washout = 0.0
    compression: laws.Compression = 0.0
    lead: laws.Lead = 0.0
    reversal_speed: Annotated[
        float, "m/s", About("half width of the curve's line through rest", above=True), Tuned(1e-4, 1e-2)
    ] = 1e-3
    blend_velocity: Annotated[
        float, "m/s", About("velocity below which forces are balanced", above=True), Tuned(3e-4, 3e-2)
    ] = 3e-3
    observer_gain: Annotated[float, "N s/m", About("gain k of the observer of the level"), Tuned(170.0, 17000.0)] = (
        1700.0
    )
    exponent: Annotated[float, "1", About("power mu of the speed in the observer's rate", above=True)] = 1.0
    injection: Annotated[float, "1", About("gain k of the tracking error into the bristle"), Tuned(0.01, 1.0)] = 0.1
    sliding_rate: Annotated[
        float, "1/s", About("weight of the position's error in it"), Tuned(2.0, 200.0), Needs("injection")
    ] = 20.0
    adaptation: Annotated[float, "1/J", About("rate gamma of the adaptive theta"), Tuned(5e-3, 0.5)] = 0.05
    velocity: VelocityKind = "filter"
    velocity_time_constant: TimeConstant = 2e-3
    position_noise: PositionNoise = 13e-6
    jerk_density: JerkDensity = 10.0
    rotation: RotationUse = "measured"
    rotation_time_constant: RotationTimeConstant = FILTER_TIME
    pressure_time_constant: Annotated[
        float, "s", About("time constant of the measured load force's low-pass; 0: none"), Tuned(5e-4, 2e-2)
    ] = 2e-3


class Gains(NamedTuple):
    """Numbers of estimator and law. `area_1`, `area_2` (0 where no pressure is measured), or of a drive the force of a
    unit of its command, `drive_gain`, make the applied force.
    """

    estimator: Estimator
    belief: Belief
    law: LawGains
    area_1: Annotated[float, "m^2"]
    area_2: Annotated[float, "m^2"]
    sliding_rate: Annotated[float, "1/s"]
    rotation_gain: Annotated[float, "1"]
    drive_gain: Annotated[float, "N/command"]


class State(NamedTuple):
    """`friction` is the estimate of this sample; it is kept to be seen. `rotation_speed` is the filtered one."""

    estimator: EstimatorState
    memory: Memory
    law: LawState
    realised: Annotated[float, "command"]
    friction: Annotated[float, "N"]
    rotation_speed: Annotated[float, "rad/s"]


Applied: TypeAlias = Callable[[Measurement, Scalar, Gains], Scalar]
"""How a rig knows the force (N) on the mass, from what is measured and what was realised last."""

Gauge: TypeAlias = Callable[[Measurement], Scalar]
"""The friction (N) that is read, of the rod itself."""


@equation
def pressure_force(measurement: Measurement, realised: Scalar, gains: Gains) -> Scalar:
    """Force (N) on the mass as a rig with a cylinder measures it: A1 P1 - A2 P2."""
    return gains.area_1 * measurement.pressure_1 - gains.area_2 * measurement.pressure_2


@equation
def commanded_force(measurement: Measurement, realised: Scalar, gains: Gains) -> Scalar:
    """Force (N) on the mass of a drive that gives any force at once: that of the command that was realised last."""
    return gains.drive_gain * realised


@equation
def no_gauge(measurement: Measurement) -> Scalar:
    """A rig has no gauge of friction: NaN."""
    return np.nan


@equation
def true_friction(measurement: Measurement) -> Scalar:
    """The reading (N) of the hypothetical gauge."""
    return measurement.friction


def combine(estimate: Estimate, law: Law, applied: Applied, gauge: Gauge) -> Step[State, Gains]:
    """The step of a controller made of an estimator, a law, how a rig knows the force, and what gauge there is."""

    @equation
    def step(
        reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
    ) -> tuple[Scalar, State]:
        velocity, estimator = estimate_velocity(measurement.position, state.estimator, gains.estimator)
        force = applied(measurement, state.realised, gains)
        error = reference.position - measurement.position
        sliding = reference.velocity - velocity + gains.sliding_rate * error
        rotation = filtered_rotation(measurement.rotation_speed, state.rotation_speed, gains.rotation_gain)
        around = gains.belief.turning.radius * rotation
        known = gauge(measurement)
        seen = Seen(velocity, state.memory.previous_velocity, force, sliding, around, known, reference.velocity)
        friction, memory = estimate(seen, state.memory, gains.belief, sample_time)
        wanted = Wanted(error, reference.velocity, reference.acceleration, velocity, force)
        command, following = law(wanted, friction, state.law, gains.law, sample_time)
        return command, State(estimator, memory, following, state.realised, friction, rotation)

    return step


@equation
def commit(realised: Scalar, state: State, gains: Gains, sample_time: Scalar) -> State:
    """Keeps the realised command: a drive's applied force."""
    return State(state.estimator, state.memory, state.law, realised, state.friction, state.rotation_speed)


def start(measurement: Measurement, gains: Gains) -> State:
    """At rest along, turning as measured; LuGre's theta at 1, Friedland-Park's level at 0."""
    rotation = measured_rotation(measurement.rotation_speed)
    return State(at_rest(measurement.position), Memory(0.0, 0.0, 1.0, 0.0, 0.0), LawState(0.0), 0.0, 0.0, rotation)


def design(settings: Settings, belief: Sliding, sample_time: float) -> Gains:
    """Gains from settings and the believed plant; the Tustin map is fitted to the believed friction."""
    estimator = design_estimator(settings, sample_time)
    tustin, _ = fit_map(belief.friction)
    believed = Belief(
        moved_mass(belief),
        belief.friction,
        believed_turning(belief, settings.rotation),
        tustin,
        settings.reversal_speed,
        settings.blend_velocity,
        settings.observer_gain,
        settings.exponent,
        settings.injection,
        settings.adaptation,
        low_pass_gain(settings.pressure_time_constant, sample_time),
    )
    cylinder = bored(belief)
    area_1, area_2 = (cylinder.piston_area_1, cylinder.piston_area_2) if cylinder is not None else (0.0, 0.0)
    turning = rotation_gain(settings.rotation_time_constant, sample_time)
    return Gains(
        estimator,
        believed,
        law_gains(settings, belief),
        area_1,
        area_2,
        settings.sliding_rate,
        turning,
        drive_gain(belief),
    )


def law_gains(settings: Any, belief: Sliding) -> LawGains:
    """Numbers of the laws from settings that have theirs, and the believed plant; 0 for what a drive lacks."""
    if not isinstance(belief, Hydraulic | Pneumatic):
        none = (0.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0)
        mass, gain = moved_mass(belief), drive_gain(belief)
        return LawGains(settings.kp, settings.kd, settings.ka, *none, mass, NONE, gain)
    valve = authority(belief)
    forward, backward = velocity_gains(valve)
    return LawGains(
        settings.kp,
        settings.kd,
        settings.ka,
        settings.feedforward / forward,
        forward / backward,
        settings.position_rate,
        settings.force_rate,
        settings.washout,
        settings.compression,
        settings.lead,
        belief.body.mass,
        valve,
    )


@functools.cache
def compensator(name: str, law: str = "valve_inversion", pressures: bool = True) -> Controller:
    """The controller made of the estimator `name` and a law, for a plant with measured pressures or without."""
    return _compensator(name, law, pressures, without_use(name, law, pressures))


@functools.cache
def offered(name: str) -> Controller:
    """The controller of that type as it is offered, before its law is chosen: no law's settings are without use."""
    unused = frozenset.intersection(*(without_use(name, law, True) for law in LAWS))
    return _compensator(name, "valve_inversion", True, unused)


def _compensator(name: str, law: str, pressures: bool, unused: frozenset[str]) -> Controller:
    estimator = ESTIMATORS[name]
    applied = pressure_force if pressures else commanded_force
    gauge = name == ORACLE
    step = combine(estimator.estimate, LAWS[law], applied, true_friction if gauge else no_gauge)
    summary = f"friction compensation: {estimator.summary}"
    chosen = functools.partial(choose, name)
    return Controller(
        name, summary, Settings, Gains, State, design, step, commit, start, chosen, unused=unused, gauge=gauge
    )


def choose(name: str, settings: Settings, belief: object) -> Controller:
    """The compensator for the law that the settings name and the plant that is believed in.

    Raises:
        ValueError: a law that the plant or the estimator has no use for.
    """
    pressures = bored(belief) is not None
    drive = isinstance(belief, HasFriction) and not pressures  # what has neither is told so when the gains are designed
    if settings.law == "valve_inversion" and drive:
        raise ValueError('law = "valve_inversion" needs a valve; for a drive take law = "force_source"')
    if settings.law == "force_source" and pressures:
        raise ValueError('law = "force_source" needs a drive that gives any force at once; here take "valve_inversion"')
    if name == "load_pressure" and settings.law != "valve_inversion":
        raise ValueError(
            f'law = "{settings.law}" needs a friction estimate, and "load_pressure" has none: with F^ = A P_L the '
            'estimated acceleration (A P_L - F^) / M is always 0; take law = "valve_inversion"'
        )
    return compensator(name, settings.law, pressures)
