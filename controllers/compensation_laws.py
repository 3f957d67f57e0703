"""How a friction estimate reaches the actuator.

A law is one equation, `law(wanted, friction, state, gains, sample_time) -> (command, state)`.
"""

from collections.abc import Callable
from typing import Annotated, NamedTuple, TypeAlias

import numpy as np

from controllers.pid import fed_forward
from controllers.settings import DECADES, SHARE, About, Needs, Tuned
from plants.authority import Authority, speed_of_opening
from plants.equation import Scalar, equation, select

_FEEDBACK, _INVERSION = Needs("law", "acceleration_feedback"), Needs("law", "valve_inversion")

ProportionalGain = Annotated[float, "command/m", About("gain on the position error"), DECADES, _FEEDBACK]
DerivativeGain = Annotated[float, "command s/m", About("gain on the error of the velocity"), DECADES, _FEEDBACK]
AccelerationGain = Annotated[float, "command s^2/m", About("gain on the error of the acceleration"), DECADES, _FEEDBACK]
Feedforward = Annotated[float, "1", About("share of the reference's velocity that is fed forward"), SHARE, _FEEDBACK]
PositionRate = Annotated[
    float, "1/s", About("rate at which an error of the position is to vanish"), Tuned(5.0, 200.0), _INVERSION
]
ForceRate = Annotated[
    float,
    "1/s",
    About("rate at which an error of the force is to vanish"),
    Tuned(0.0, 50.0, logarithmic=False),
    _INVERSION,
]
Washout = Annotated[
    float,
    "1/s",
    About("rate at which a lasting error of the force is forgotten"),
    Tuned(0.1, 100.0),
    Needs("force_rate"),
]
Compression = Annotated[
    float, "1", About("share of the flow that compresses the oil as the wanted force changes"), SHARE, _INVERSION
]
Lead = Annotated[
    float,
    "1",
    About("share of the valve's lag that is inverted"),
    SHARE,
    Needs("law", "valve_inversion", "acceleration_feedback"),
]

LOWEST_DROP = 0.05
"""Smallest share of the force at which a piston stalls that a valve inversion counts on: the root must not vanish."""

FORCE_STIFFNESS, FORCE_DAMPING = 3600.0, 84.0
"""1/s^2 and 1/s: error dynamics of the ideal force source (60 rad/s, damping ratio 0.7)."""


class Wanted(NamedTuple):
    """The reference and what is known of the motion, at a sample."""

    error: Annotated[float, "m"]
    reference_velocity: Annotated[float, "m/s"]
    reference_acceleration: Annotated[float, "m/s^2"]
    velocity: Annotated[float, "m/s"]
    applied_force: Annotated[float, "N"]


class LawState(NamedTuple):
    """The spool and the wanted force (0: none yet) of the sample before, and what of the force's error is forgotten."""

    previous_spool: Annotated[float, "m"]
    previous_target: Annotated[float, "N"] = 0.0
    lasting: Annotated[float, "N"] = 0.0


class LawGains(NamedTuple):
    """Gains, with a feed-forward for either direction, and what is believed of mass, valve and fluid."""

    proportional: Annotated[float, "command/m"]
    derivative: Annotated[float, "command s/m"]
    acceleration: Annotated[float, "command s^2/m"]
    feedforward: Annotated[float, "command s/m"]
    feedforward_ratio: Annotated[float, "1"]
    position_rate: Annotated[float, "1/s"]
    force_rate: Annotated[float, "1/s"]
    washout: Annotated[float, "1/s"]
    compression: Annotated[float, "1"]
    lead: Annotated[float, "1"]
    mass: Annotated[float, "kg"]
    valve: Authority
    drive_gain: Annotated[float, "N/command"] = 1.0


Law: TypeAlias = Callable[[Wanted, Scalar, LawState, LawGains, Scalar], tuple[Scalar, LawState]]
"""What makes a command of what is wanted and of the estimated friction (N)."""


@equation
def acceleration_feedback(
    wanted: Wanted, friction: Scalar, state: LawState, g: LawGains, sample_time: Scalar
) -> tuple[Scalar, LawState]:
    """V = K_p e + K_d (dr - v^) + K_a (ddr - a^) + K_ff (dr + lead tau ddr),  a^ = (F_app - F^) / M.

    Thesis 2.7 to 2.10 names the feedback of position, velocity and acceleration; the sum, and the lead of the
    feed-forward over the valve's lag tau, are derived here.
    """
    acceleration = (wanted.applied_force - friction) / g.mass
    leading = wanted.reference_velocity + g.lead * g.valve.time_constant * wanted.reference_acceleration
    command = (
        g.proportional * wanted.error
        + g.derivative * (wanted.reference_velocity - wanted.velocity)
        + g.acceleration * (wanted.reference_acceleration - acceleration)
        + fed_forward(leading, g.feedforward, g.feedforward_ratio)
    )
    return command, state


@equation
def valve_inversion(
    wanted: Wanted, friction: Scalar, state: LawState, g: LawGains, sample_time: Scalar
) -> tuple[Scalar, LawState]:
    """The voltage whose flow moves the piston as wanted against the estimated friction [derived here].

        v_d = dr + k_p e + (c dF_d/dt + lam (E - E_l)) / k,  F_d = M ddr + F^
        E = F_d - F_app,  dE_l/dt = w (E - E_l)
        x_s = v_d / (c_v sqrt(F_stall - sgn(v_d) F^))
        V   = (x_s + lead tau dx_s/dt) / K_sv

    k is the stiffness of the fluid, c_v and F_stall are the valve's (`plants.authority`), each of the direction of v_d;
    what is left of the stall force is at least `LOWEST_DROP` of it. A force loop around the estimate (large lam)
    runs away: the valve's lag acts as added mass.
    """
    target = g.mass * wanted.reference_acceleration + friction
    missing = target - wanted.applied_force
    lasting = state.lasting - np.expm1(-g.washout * sample_time) * (missing - state.lasting)
    rise = g.compression * select(state.previous_target == 0.0, 0.0, target - state.previous_target) / sample_time
    compressing = (rise + g.force_rate * (missing - lasting)) / g.valve.stiffness
    velocity = wanted.reference_velocity + g.position_rate * wanted.error + compressing
    spool = velocity / speed_of_opening(velocity, friction, LOWEST_DROP, g.valve)
    rate = (spool - state.previous_spool) / sample_time
    return (spool + g.lead * g.valve.time_constant * rate) / g.valve.position_gain, LawState(spool, target, lasting)


@equation
def force_source(
    wanted: Wanted, friction: Scalar, state: LawState, g: LawGains, sample_time: Scalar
) -> tuple[Scalar, LawState]:
    """F = M (ddr + 84 (dr - v^) + 3600 e) + F^: computed force for a drive that gives any force at once.

    The command is F over the force of a unit of it: 1 of a drive that is commanded in N.
    """
    acceleration = (
        wanted.reference_acceleration
        + FORCE_DAMPING * (wanted.reference_velocity - wanted.velocity)
        + FORCE_STIFFNESS * wanted.error
    )
    return (g.mass * acceleration + friction) / g.drive_gain, state
