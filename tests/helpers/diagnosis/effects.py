"""Effects by name: what a strength from 0 (silent) to 1 (strong) means in physical numbers.

0.3 is clear but modest, 0.03 is meant to go unnoticed. Where an effect has a sign or a form, the seed draws it. The
unlisted effects have no name that diagnosis could give: it is to say that something is unexplained, and on which
signals it depends.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from .physics import Rig

Draw = np.random.Generator
Change = Callable[[Rig, float, Draw], dict[str, float]]
"""(rig without effect, strength, draw) -> what changes in the rig."""

TYPICAL_SPEED = 0.1
"""m/s. The speed at which the strengths are stated: the largest of a record."""


def _sign(draw: Draw) -> float:
    return 1.0 if draw.random() < 0.5 else -1.0


def direction_asymmetry(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """Retracting, the level is 1 - 0.4 s of its value (2 of 5 draws), the viscosity 1 + 1.5 s (2 of 5), or both."""
    form = draw.random()
    level = {"retracting_level": 1.0 - 0.4 * s} if form < 0.4 or form >= 0.8 else {}
    viscous = {"retracting_viscous": 1.0 + 1.5 * s} if form >= 0.4 else {}
    return level | viscous


def position_dependent_friction(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """Level times 1 + 0.5 s xi, 1 - 0.5 s xi or 1 + s xi^2 with xi = 2 x / stroke (|xi| stays below 0.65)."""
    form = draw.random()
    return {"level_quadratic": s} if form < 0.4 else {"level_linear": 0.5 * s * _sign(draw)}


def pressure_dependent_friction(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """Level + c |P1 - P2|, 60 % more for s = 1 at the pressure that slides the piston: c = 0.6 / 1.6 A s."""
    return {"level_pressure": s * 0.6 / 1.6 * rig.area_1}


def frictional_memory(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """The level follows the velocity 60 s ms late (Hess and Soom 1990)."""
    return {"memory": 0.06 * s}


def rising_static_friction(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """Stribeck friction times 1 + 2 s (1 - exp(-t/1 s)) after a dwell of t; sliding 0.2 mm resets it."""
    return {"dwell_growth": 2.0 * s}


def quadratic_drag(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """200 s N at 0.1 m/s."""
    return {"quadratic_drag": 200.0 * s / TYPICAL_SPEED**2}


def viscous_drift(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """Viscosity times 1 +- s t / 60 s, never below a tenth; each record starts anew."""
    return {"viscous_drift": _sign(draw) * s / 60.0}


def constant_load(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """200 s N."""
    return {"load": 200.0 * s * _sign(draw)}


def spring_load(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """200 s N at 20 mm, towards the middle."""
    return {"spring": 200.0 * s / 0.02}


def rotation_periodic_force(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """100 s N cos(theta + phi); the rod turns at a constant 20 to 60 rpm."""
    return {
        "rotary_force": 100.0 * s,
        "rotary_phase": draw.uniform(0.0, 2.0 * np.pi),
        "rotation_speed": draw.uniform(20.0, 60.0) * 2.0 * np.pi / 60.0,
        "rotation_start": draw.uniform(0.0, 2.0 * np.pi),
    }


def valve_deadband(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """Half width 25 s um of the spool's 600."""
    return {"overlap": 25e-6 * s}


def internal_leakage(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """At 0.5 MPa the flow of 5 s mm/s."""
    return {"leakage": s * 5e-3 * rig.area_1 / 0.5e6}


def supply_droop(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """15 s % of the supply pressure at 0.1 m/s."""
    return {"supply_resistance": s * 0.15 * rig.supply_pressure / (TYPICAL_SPEED * rig.area_1)}


def entrained_air(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """2 s % of the volume at atmospheric pressure, isothermal."""
    return {"air": 0.02 * s}


def unequal_areas(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """A2 = (1 - 0.3 s) A1, declared equal."""
    return {"area_2": (1.0 - 0.3 * s) * rig.area_1}


def command_delay(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """15 s ms."""
    return {"delay": 15e-3 * s}


def backlash(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """The position sensor follows with a play of 60 s um (full width)."""
    return {"backlash": 60e-6 * s}


def pressure_sensor_offset(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """100 s kPa on pressure 1."""
    return {"pressure_1_offset": 1e5 * s * _sign(draw)}


@dataclass(frozen=True)
class Effect:
    """A change of the rig, and the balance of which it is a term; of an unlisted one also the signals it depends on."""

    change: Change
    balance: str
    signals: tuple[str, ...] = ()


def _listed(balance: str, *changes: Change) -> dict[str, Effect]:
    return {change.__name__: Effect(change, balance) for change in changes}


EFFECTS: Mapping[str, Effect] = {
    **_listed(
        "force",
        direction_asymmetry,
        position_dependent_friction,
        pressure_dependent_friction,
        frictional_memory,
        rising_static_friction,
        quadratic_drag,
        viscous_drift,
        constant_load,
        spring_load,
        rotation_periodic_force,
    ),
    **_listed("flow", valve_deadband, internal_leakage, supply_droop, entrained_air, unequal_areas),
    **_listed("valve", command_delay),
    **_listed("sensor", backlash, pressure_sensor_offset),
}
"""Every effect that diagnosis may name."""


def cushion(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """Beyond 9 mm a spring back to the middle, 300 s N at 17 mm."""
    return {"cushion_start": 9e-3, "cushion_stiffness": 300.0 * s / 8e-3}


def cogging(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """80 s N sin(2 pi x / 4 mm)."""
    return {"cogging": 80.0 * s}


def external_leakage(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """From chamber 1 to the tank; at 0.5 MPa the flow of 0.5 s mm/s."""
    return {"external_leakage": s * 0.5e-3 * rig.area_1 / 0.5e6}


def valve_hysteresis(rig: Rig, s: float, draw: Draw) -> dict[str, float]:
    """The ports follow the spool with a play of 30 s um (full width) of its 600."""
    return {"spool_play": 15e-6 * s}


UNLISTED: Mapping[str, Effect] = {
    "cushion": Effect(cushion, "force", ("position",)),
    "cogging": Effect(cogging, "force", ("position",)),
    "external_leakage": Effect(external_leakage, "flow", ("pressure_1",)),
    "valve_hysteresis": Effect(valve_hysteresis, "flow", ("valve_voltage", "spool_position", "command")),
}
"""Effects without a name. `signals`: naming any of these is right."""
