"""A load that is not rigid: a share of the mass behind a spring."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.interface import DISTURBANCE, Effect, Moment, Number
from plants.equation import Scalar, changed, equation, select
from plants.hydraulics import Mass

MASS = Mass._fields.index("mass")


class Compliance(NamedTuple):
    """Share of the mass behind a spring, its natural frequency with the actuator held, and its damping ratio."""

    compliant_share: Annotated[float, "1"] = 0.0
    compliant_frequency: Annotated[float, "Hz"] = 10.0
    compliant_damping: Annotated[float, "1"] = 0.05


class Load(NamedTuple):
    """By how far, and how fast, the actuator is ahead of the load."""

    load_lead: Annotated[float, "m", 1e-4] = 0.0
    load_velocity: Annotated[float, "m/s", 1e-2] = 0.0


@equation
def acceleration(moment: Moment, memory: Load, own: Compliance) -> Scalar:
    """dv_l/dt (m/s^2) = w^2 d + 2 D w (v - v_l) of the load, d (m) the actuator's lead."""
    frequency = 2.0 * np.pi * own.compliant_frequency
    damping = 2.0 * own.compliant_damping * frequency
    return frequency**2 * memory.load_lead + damping * (moment.velocity - memory.load_velocity)


@equation
def lighter(body: Mass, moment: Moment, memory: Load, p: Any, own: Compliance) -> Mass:
    """M <- (1 - s) M: what moves with the actuator."""
    return changed(body, MASS, body.mass * (1.0 - own.compliant_share))


@equation
def pulled(disturbance: Scalar, moment: Moment, memory: Load, p: Any, own: Compliance) -> Scalar:
    """s M dv_l/dt (N): the spring and the damper that move the load."""
    pull = own.compliant_share * p.body.mass * acceleration(moment, memory, own)
    return disturbance + select(own.compliant_share > 0.0, pull, 0.0)


@equation
def following(slip: Scalar, command: Scalar, moment: Moment, memory: Load, p: Any, own: Compliance) -> Load:
    """dd/dt = v - v_l (m/s),  dv_l/dt (m/s^2); the load rests where there is none.

    Two masses and a spring (Spong 1987). Looks like a force that swings after each change of speed; oil that is soft
    swings with the pressures, and a rigid mass that is wrong goes with the acceleration alone.
    """
    there = own.compliant_share > 0.0
    return Load(
        select(there, moment.velocity - memory.load_velocity, 0.0),
        select(there, acceleration(moment, memory, own), 0.0),
    )


COMPLIANT_LOAD = Effect(
    name="compliant_load",
    balance="force",
    words="a share of the mass is behind a spring",
    source="Spong 1987",
    numbers={
        "compliant_share": Number(0.0, 0.9, 0.05),
        "compliant_frequency": Number(
            0.5, 500.0, 0.0, grid=(2.0, 5.0, 10.0, 20.0, 50.0), frequency_of="time", damped_by="compliant_damping"
        ),
        "compliant_damping": Number(0.001, 1.0, 0.0, grid=(0.02, 0.1, 0.3)),
    },
    apart=(
        ("compliant_share", "compliant_frequency"),
        ("compliant_share", "compliant_frequency", "compliant_damping"),
    ),
    needs=("position",),
    requires=("body",),
    Own=Compliance,
    Memory=Load,
    parameters={"body": lighter},
    inputs={DISTURBANCE: pulled},
    remember=following,
)
"""The whole mass stays the declared one."""
