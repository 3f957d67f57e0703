"""Extended Kalman filter of the believed plant: velocity, load pressure and bristle from position and pressures.

    gains = design_ekf(belief, EkfSettings(), sample_time)
    state = ekf_at_rest(measurement, gains)
    velocity, load_pressure, friction, state = ekf_update(measurement, realised, state, gains, sample_time)

The model over a sample is the local linearisation of the plant's equations (Ozaki 1992): with J the Jacobian of the
rates f at the estimate, the deviation from it obeys d(delta)/dt = J delta + f, which is solved exactly. So the
discrete Jacobian is exp(J h), and the step is stable however fast the bristle, the oil column (1207 rad/s in the
thesis's simulations) or the valve's flow relax. Position follows as the integral of velocity. The spool is no state
with noise: it is advanced exactly through the believed lag with the voltage that the amplifier gave.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.belief import Sliding
from controllers.believed_friction import Turning, believed_turning, contact, saturated_sign
from controllers.kalman_algebra import (
    Column,
    Covariance,
    Matrix,
    Noise,
    Row,
    corrected,
    floored,
    hold,
    predicted_covariance,
    scaled,
)
from plants import hydraulics as hyd
from plants.anisotropic import Levels, level_fall
from plants.authority import authority, velocity_gains
from plants.equation import Scalar, equation, select
from plants.friction import TINY, Friction, LuGre, helical_speed, stribeck_slope
from plants.hydraulics import Cylinder, Hydraulics, Mass
from plants.interface import Measurement

FASTEST_BRISTLE = 50.0
"""Bristles are believed to relax by at most exp(-50) a sample; faster ones are slowed to it, at the same steady
deflection. Keeps the exponential accurate where g(v) is next to nothing."""

LEAST_DROP = 0.02
"""Share of the supply pressure below which the valve's pressure drop does not count in the slope of its flow, which
is infinite at 0."""

STEEPEST = 2.0
"""The slope of the bristle's rate over velocity counts at most so many steady deflections g/sigma0. An estimate bent
far beyond them would give the linearised damping force a negative slope without bound."""

GUIDE_SPEED = 1e-3
"""m/s. Half width of the line through rest of the friction of a guide that does not turn."""

ESTIMATE_RANGE = 3.0
"""Bounds of the estimates: so many static deflections (a0 + a1) / sigma0, so many no-load velocities at full spool."""


class EkfSettings(NamedTuple):
    """Standard deviations a sample: of a position and of each chamber pressure as measured; of the force, flow and
    bristle force that the model does not know, each renewed at every sample.

    A large `friction_noise` lets the friction follow another level than the believed one, which the bristle would
    forget within a few samples at speed. A small `flow_noise` takes the velocity from the pressures and the valve, a
    large one from the position; the default is 0.8 mm/s of the simulation plant's piston.
    """

    position_noise: Annotated[float, "m"] = 13e-6
    pressure_noise: Annotated[float, "Pa"] = 2e3
    force_noise: Annotated[float, "N"] = 5.0
    flow_noise: Annotated[float, "m^3/s"] = 5e-7
    friction_noise: Annotated[float, "N"] = 150.0


class EkfGains(NamedTuple):
    """The believed plant, the noise, and what the model needs beside them."""

    hydraulics: Hydraulics
    body: Mass
    friction: Friction
    turning: Turning
    noise: Noise
    oil_stiffness: Annotated[float, "Pa/m^3"]
    fastest_relaxation: Annotated[float, "1/s"]
    largest_velocity: Annotated[float, "m/s"]
    largest_bristle: Annotated[float, "m"]


class EkfState(NamedTuple):
    position: Annotated[float, "m"]
    velocity: Annotated[float, "m/s"]
    load_pressure: Annotated[float, "Pa"]
    bristle: Annotated[float, "m"]
    spool: Annotated[float, "m"]
    covariance: Covariance


@equation
def relaxation_slope(
    velocity: Scalar, surface_speed: Scalar, along: LuGre, around: LuGre, levels: Levels, turning: Turning
) -> Scalar:
    """(dr/dv) / r (s/m) of the bristle's relaxation r = sigma0 w / S_a^2; the blend of the two sets is held.

    dw/dv = (S_a^2 v + (S_a S_a' v^2 + S_r S_r' w_r^2) v/v_h) / w,   (dr/dv) / r = (dw/dv) / w - 2 (v/v_h) S_a' / S_a

    w_r is the surface speed, a dash the derivative over the helical speed. [derived here]
    """
    speed = helical_speed(velocity, surface_speed)
    cosine = velocity / speed
    fall = level_fall(speed, along, turning.film, turning.guide)
    slope = select(stribeck_slope(speed, along) < 0.0, -fall * levels.axial / speed, 0.0)
    bent = levels.axial * slope * velocity**2 + levels.rotary * stribeck_slope(speed, around) * surface_speed**2
    sliding_slope = (levels.axial**2 * velocity + bent * cosine) / levels.sliding
    return sliding_slope / levels.sliding - 2.0 * cosine * slope / levels.axial


@equation
def believed_friction(
    velocity: Scalar, bristle: Scalar, gains: EkfGains, surface_speed: Scalar = 0.0
) -> tuple[Scalar, Scalar, Row, Row]:
    """Friction (N), bristle rate (m/s), and the slopes of both over velocity, load pressure (none) and bristle.

        dz/dt = kappa (v - r z),  F = sigma0 z + sigma1 exp(-(v_h/v_s)^2) dz/dt + a2 v

    r = sigma0 |v| / g without rotation, and what `controllers.lugre_observer` has for a rod that turns at
    `surface_speed` (m/s), and for a guide. The damping fades with speed as there. With the constant one a larger
    bristle is a *smaller* force where sigma1 |v| > g, and the filter would correct a wrong level the wrong way. kappa
    is 1 but for bristles faster than `FASTEST_BRISTLE`.
    """
    f, around, levels = contact(velocity, surface_speed, bristle, gains.friction, gains.turning)
    own = 1.0 - levels.guide_share
    stiffness = own * f.bristle_stiffness
    ratio = helical_speed(velocity, surface_speed) / f.stribeck_velocity
    bell = np.exp(-(ratio**2))
    bell_slope = -2.0 * velocity / f.stribeck_velocity**2 * bell
    relaxation = stiffness * levels.sliding / levels.axial**2
    steeper = relaxation_slope(velocity, surface_speed, f, around, levels, gains.turning)
    slowed = np.minimum(relaxation, gains.fastest_relaxation)
    steady = velocity / (relaxation + TINY)
    rate = select(relaxation > slowed, slowed * (steady - bristle), velocity - relaxation * bristle)
    most = STEEPEST * levels.axial / stiffness
    bent = np.minimum(np.maximum(bristle, -most), most)
    rate_slope = select(
        relaxation > slowed,
        slowed * (1.0 - velocity * steeper) / (relaxation + TINY),
        1.0 - bent * relaxation * steeper,
    )
    damping = own * f.bristle_damping * bell
    guided = levels.guide * saturated_sign(velocity, GUIDE_SPEED)
    force = stiffness * bristle + damping * rate + f.viscous * velocity + guided
    guide_slope = select(np.abs(velocity) < GUIDE_SPEED, levels.guide / GUIDE_SPEED, 0.0)
    force_slope = own * f.bristle_damping * bell_slope * rate + damping * rate_slope + f.viscous + guide_slope
    return (
        force,
        rate,
        Row(force_slope, 0.0, stiffness - damping * slowed),
        Row(rate_slope, 0.0, -slowed),
    )


@equation
def believed_rates(
    velocity: Scalar,
    load_pressure: Scalar,
    bristle: Scalar,
    spool: Scalar,
    gains: EkfGains,
    surface_speed: Scalar = 0.0,
) -> tuple[Row, Matrix]:
    """Rates of velocity, load pressure and bristle, and their Jacobian. Thesis (3.36) to (3.38), inside the stroke."""
    h, mass = gains.hydraulics, gains.body.mass
    force, bristle_rate, force_slopes, bristle_slopes = believed_friction(velocity, bristle, gains, surface_speed)
    area, stiffness = hyd.piston_area(h), gains.oil_stiffness
    drop = h.supply_pressure - h.tank_pressure - np.sign(spool) * load_pressure
    counted = h.flow_pressure_share * np.maximum(drop, LEAST_DROP * h.supply_pressure)
    opening = np.abs(hyd.valve_opening(spool, h))
    yielding = 0.5 * h.valve_flow_gain * opening * h.flow_pressure_share / np.sqrt(counted)
    leaking = h.leakage_coefficient + 0.25 * (h.external_leakage_1 + h.external_leakage_2)
    rates = Row(
        (hyd.pressure_force(load_pressure, h) - force - gains.body.load_force) / mass,
        hyd.load_pressure_rate(hyd.load_flow(spool, load_pressure, h), velocity, load_pressure, h),
        bristle_rate,
    )
    jacobian = Matrix(
        scaled(Row(0.0, area / mass, 0.0), -1.0 / mass, force_slopes),
        Row(-stiffness * area, -stiffness * (yielding + leaking), 0.0),
        bristle_slopes,
    )
    return rates, jacobian


@equation
def ekf_update(
    measurement: Measurement,
    realised: Scalar,
    state: EkfState,
    gains: EkfGains,
    sample_time: Scalar,
    surface_speed: Scalar = 0.0,
) -> tuple[Scalar, Scalar, Scalar, EkfState]:
    """Estimates at a sample from its measurement and the voltage (V) realised over the sample before it.

    Position and load pressure P1 - P2 are corrected one after the other, which for independent noise is the same as
    together. `surface_speed` (m/s) of the rod's rotation is an input, taken as it is measured.

    Returns:
        velocity (m/s), load pressure (Pa), friction (N), and the next state, which holds the bristle's deflection.
    """
    h, noise = gains.hydraulics, gains.noise
    target = np.minimum(np.maximum(h.valve_position_gain * realised, -h.spool_limit), h.spool_limit)
    left = state.spool - target
    keep = np.exp(-sample_time / h.valve_time_constant)
    spool = target + left * (1.0 - keep) * h.valve_time_constant / sample_time  # its mean over the sample
    rates, jacobian = believed_rates(state.velocity, state.load_pressure, state.bristle, spool, gains, surface_speed)
    power, step, travel, rest = hold(rates, jacobian, sample_time)
    mean = Column(
        state.position + sample_time * state.velocity + rest,
        state.velocity + step.v,
        state.load_pressure + step.p,
        state.bristle + step.z,
    )
    c = predicted_covariance(state.covariance, power, travel, noise)
    with_position = Column(c.xx, c.xv, c.xp, c.xz)
    mean, c = corrected(mean, c, with_position, c.xx, measurement.position, mean.x, noise.measured_position)
    with_pressure, reading = Column(c.xp, c.vp, c.pp, c.pz), measurement.pressure_1 - measurement.pressure_2
    mean, c = corrected(mean, c, with_pressure, c.pp, reading, mean.p, noise.measured_load_pressure)
    velocity = np.minimum(np.maximum(mean.v, -gains.largest_velocity), gains.largest_velocity)
    bristle = np.minimum(np.maximum(mean.z, -gains.largest_bristle), gains.largest_bristle)
    friction, _, _, _ = believed_friction(velocity, bristle, gains, surface_speed)
    following = EkfState(mean.x, velocity, mean.p, bristle, target + left * keep, floored(c, noise))
    return velocity, mean.p, friction, following


def design_ekf(belief: Sliding, settings: EkfSettings, sample_time: float, rotation: str = "measured") -> EkfGains:
    """Numbers of the filter from the believed plant (hydraulics, body, friction) and the noise.

    `rotation` "ignored": the rod's surface speed counts for nothing.

    Raises:
        ValueError: a standard deviation that is not above 0, or a belief without a valve.
    """
    known: Any = belief
    h = _symmetric(known)
    for name, value in settings._asdict().items():
        if not value > 0.0:
            raise ValueError(f"{name} is {value:g}, expected a value above 0")
    mass, sets = belief.body.mass, belief.friction
    sides = (sets.positive, sets.negative)
    softest = min(side.bristle_stiffness for side in sides)
    oil_stiffness = 4.0 * h.bulk_modulus / float(hyd.oil_volume(h))
    push = settings.force_noise * sample_time / mass
    noise = Noise(
        settings.position_noise**2,
        2.0 * settings.pressure_noise**2,
        (0.5 * sample_time * push) ** 2,
        push**2,
        (settings.flow_noise * oil_stiffness * sample_time) ** 2,
        (settings.friction_noise / softest) ** 2,
    )
    fastest = ESTIMATE_RANGE * max(velocity_gains(authority(known))) * h.spool_limit / h.valve_position_gain
    largest = ESTIMATE_RANGE * max(side.coulomb + side.stribeck for side in sides) / softest
    turning = believed_turning(belief, rotation)
    return EkfGains(
        h, belief.body, sets, turning, noise, oil_stiffness, FASTEST_BRISTLE / sample_time, fastest, largest
    )


def _symmetric(belief: Any) -> Hydraulics:
    """The cylinder that the filter believes in, with one load pressure: dead volumes and edges' gains at their means.

    Raises:
        ValueError: it has unequal areas, or no oil at all.
    """
    if not hasattr(belief, "hydraulics"):
        raise ValueError("the extended Kalman filter needs a hydraulic plant with measured pressures; take another one")
    h, own = belief.hydraulics, getattr(belief, "cylinder", Cylinder())
    if h.piston_area_1 != h.piston_area_2:
        raise ValueError(
            "the extended Kalman filter believes in one load pressure, of equal piston areas, and "
            f"{h.piston_area_1:g} and {h.piston_area_2:g} m^2 differ; take another one"
        )
    (forward, _), (backward, _), *_ = authority(belief)
    (even, _), *_ = authority(belief._replace(cylinder=Cylinder()) if hasattr(belief, "cylinder") else belief)
    return h._replace(
        hose_volume=h.hose_volume + 0.5 * (own.dead_volume_1 + own.dead_volume_2),
        valve_flow_gain=h.valve_flow_gain * 0.5 * (forward + backward) / even,
    )


def ekf_at_rest(measurement: Measurement, gains: EkfGains) -> EkfState:
    """State for a plant at rest with a closed valve: the bristle carries what force the pressures leave.

    Unsure of the bristle by its whole range, of the rest by its sensor, or by the process noise of a sample.
    """
    noise, stiffness = gains.noise, gains.friction.positive.bristle_stiffness
    pressure = measurement.pressure_1 - measurement.pressure_2
    force = hyd.pressure_force(pressure, gains.hydraulics) - gains.body.load_force
    bristle = np.minimum(np.maximum(force / stiffness, -gains.largest_bristle), gains.largest_bristle)
    covariance = Covariance(
        *(noise.measured_position, 0.0, 0.0, 0.0),
        *(noise.velocity, 0.0, 0.0),
        *(noise.measured_load_pressure, 0.0),
        gains.largest_bristle**2,
    )
    return EkfState(measurement.position, 0.0, pressure, bristle, 0.0, covariance)
