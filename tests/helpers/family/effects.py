"""Effects by the names that the program gives them: what a strength from 0 to 1 means on a machine, and in which forms.

A strength of 1 is as much as anybody would believe. An effect of several parameters has a column for each; the seed
draws which of them act, and with what sign.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from .machines import AIR, DIFFERENTIAL, EQUAL, HAND, KINDS, ROTARY, Rig, between
from .parameters import Machine

Draw = np.random.Generator
Column = Callable[[float], dict[str, float]]
"""strength -> parameters of the machine that differ."""

FLUID, OIL = (EQUAL, DIFFERENTIAL, AIR), (EQUAL, DIFFERENTIAL)


@dataclass(frozen=True)
class Form:
    """What an effect may be on a rig: a column each parameter, and which of them act, each with its weight."""

    columns: Mapping[str, Column]
    weights: Mapping[str, float]

    def changes(self, strength: float) -> dict[str, float]:
        """What differs in the machine."""
        changed: dict[str, float] = {}
        for name, weight in self.weights.items():
            changed |= self.columns[name](weight * strength)
        return changed


def _one(column: Column, weight: float = 1.0) -> Form:
    return Form({"": column}, {"": weight})


def _sign(draw: Draw) -> float:
    return float(draw.choice([-1.0, 1.0]))


# --- friction --------------------------------------------------------------------------------------------------


def direction_asymmetry(rig: Rig, draw: Draw) -> Form:
    """Negative over positive direction, of Coulomb, Stribeck and viscous friction: 3^(+-s)."""
    names = ("coulomb", "stribeck", "viscous")
    columns = {n: (lambda s, n=n: {f"{n}_ratio": float(3.0**s)}) for n in names}
    acting = (("coulomb",), ("viscous",), ("coulomb", "stribeck"), ("coulomb", "viscous"))[draw.integers(4)]
    way = _sign(draw)
    return Form(columns, {name: way * (1.0 if name != "viscous" else _sign(draw)) for name in acting})


def position_dependent_friction(rig: Rig, draw: Draw) -> Form:
    """Level times 1 + b1 xi + b2 xi^2, xi = 2 x / stroke: up to 0.9, and up to 3 or -0.9."""
    columns: dict[str, Column] = {
        "gradient": lambda s: {"friction_gradient": 0.9 * s},
        "curvature": lambda s: {"friction_curvature": 3.0 * s},
    }
    if draw.random() < 0.5:
        return Form(columns, {"gradient": _sign(draw)})
    return Form(columns, {"curvature": 1.0 if draw.random() < 0.6 else -0.3})


def pressure_dependent_friction(rig: Rig, draw: Draw) -> Form:
    """Level + c |P1 - P2|, c up to half the piston's area."""
    return _one(lambda s: {"friction_per_pressure": 0.5 * s * rig.machine.area_1})


def frictional_memory(rig: Rig, draw: Draw) -> Form:
    """The level follows the velocity by a lag of up to 0.1 s (Hess and Soom 1990)."""
    return _one(lambda s: {"memory_time": 0.1 * abs(s)})


def rising_static_friction(rig: Rig, draw: Draw) -> Form:
    """Stribeck friction times up to 1 + 5 r, dr/dt = (1 - r)/T - |slip| r/D (Dieterich 1979)."""
    time, distance = between(draw, 0.2, 3.0), rig.presliding * draw.uniform(1.5, 6.0)
    return _one(lambda s: {"static_rise": 5.0 * s, "static_rise_time": time, "static_rise_distance": distance})


def viscous_drift(rig: Rig, draw: Draw) -> Form:
    """Viscosity times 1 + d t: by the end up to three times as much more, or nearly none."""
    return _one(lambda s: {"viscous_drift": s / rig.duration}, float(draw.choice([-0.9, 3.0])))


def viscous_warming(rig: Rig, draw: Draw) -> Form:
    """Viscosity times 1 + w (1 - exp(-t/T)), T 15 to 60 % of the record: w down to -0.9 or up to 2."""
    time = rig.duration * draw.uniform(0.15, 0.6)
    return _one(lambda s: {"warming": s, "warming_time": time}, -0.9 if draw.random() < 0.7 else 2.0)


def presliding_curve(rig: Rig, draw: Draw) -> Form:
    """The bristle's rate with Dahl's exponent n, 3^(+-s); LuGre's is 1 (Dahl 1968)."""
    return _one(lambda s: {"dahl_exponent": float(3.0**s)}, _sign(draw))


def maxwell_slip(rig: Rig, draw: Draw) -> Form:
    """A second element in parallel, up to as strong as the first, that gives way after 3 to 20 times its deflection."""
    deflection = rig.presliding * between(draw, 3.0, 20.0)
    return _one(lambda s: {"slip_level": rig.level * s, "slip_stiffness": rig.level * s / deflection})


# --- forces ----------------------------------------------------------------------------------------------------


def quadratic_drag(rig: Rig, draw: Draw) -> Form:
    """Up to the friction at rest, three times, at the largest speed."""
    return _one(lambda s: {"drag": 3.0 * rig.level / rig.speed**2 * s})


def constant_load(rig: Rig, draw: Draw) -> Form:
    """Up to twice the friction at rest."""
    return _one(lambda s: {"load": 2.0 * rig.level * s}, _sign(draw))


def spring_load(rig: Rig, draw: Draw) -> Form:
    """Up to twice the friction at rest at the end of the travel, towards the middle or away from it."""
    return _one(lambda s: {"spring": 2.0 * rig.level / rig.travel * s}, 1.0 if draw.random() < 0.7 else -1.0)


def cogging(rig: Rig, draw: Draw) -> Form:
    """Up to the friction at rest over a pitch: 4 to 30 in the travel, or on a turning axis a turn's part."""
    pitch = 2.0 * np.pi / draw.integers(1, 13) if rig.kind == ROTARY else rig.travel / draw.uniform(4.0, 30.0)
    angle = draw.uniform(0.0, 2.0 * np.pi)
    columns: dict[str, Column] = {
        "cosine": lambda s: {"cogging_cosine": rig.level * s, "cogging_pitch": float(pitch)},
        "sine": lambda s: {"cogging_sine": rig.level * s, "cogging_pitch": float(pitch)},
    }
    return Form(columns, {"cosine": float(np.cos(angle)), "sine": float(np.sin(angle))})


def cushion(rig: Rig, draw: Draw) -> Form:
    """A spring that begins at 40 to 70 % of the travel at one end, up to five times the friction at the travel's end."""
    start = draw.uniform(0.4, 0.7)
    stiffness, place = 5.0 * rig.level / ((1.0 - start) * rig.travel), _sign(draw) * start * rig.travel
    return _one(lambda s: {"cushion_stiffness": stiffness * s, "cushion_start": place})


def compliant_load(rig: Rig, draw: Draw) -> Form:
    """Up to 90 % of the mass hangs on a spring of 3 to 40 Hz, damped by 1 to 10 %."""
    frequency, damping = 2.0 * np.pi * between(draw, 3.0, 40.0), between(draw, 0.01, 0.1)
    return _one(lambda s: {"hung_share": 0.9 * s, "hung_frequency": frequency, "hung_damping": damping})


# --- flow ------------------------------------------------------------------------------------------------------


def _flow(rig: Rig) -> float:
    """Flow of the largest speed (m^3/s)."""
    return rig.machine.area_1 * rig.speed


def valve_deadband(rig: Rig, draw: Draw) -> Form:
    """An overlap of up to 20 % of the spool's way, the same for both directions or not."""
    way = 0.2 * rig.machine.spool_limit
    columns: dict[str, Column] = {
        "positive": lambda s: {"overlap_positive": way * s},
        "negative": lambda s: {"overlap_negative": way * s},
    }
    other = 1.0 if draw.random() < 0.6 else draw.uniform(0.0, 0.8)
    sides = ["positive", "negative"]
    draw.shuffle(sides)
    return Form(columns, {sides[0]: 1.0, sides[1]: other})


def internal_leakage(rig: Rig, draw: Draw) -> Form:
    """Up to 30 % of the flow of the largest speed, at half the supply pressure."""
    return _one(lambda s: {"leakage": 0.6 * _flow(rig) / rig.machine.supply_pressure * s})


def external_leakage(rig: Rig, draw: Draw) -> Form:
    """The same from one of the chambers to the tank; of air the conductance."""
    machine = rig.machine
    most = (
        0.6 * _flow(rig) / machine.supply_pressure if rig.kind != AIR else 0.1 * machine.flow_gain * machine.spool_limit
    )
    columns: dict[str, Column] = {
        "1": lambda s: {"leak_1": most * s},
        "2": lambda s: {"leak_2": most * s},
    }
    return Form(columns, {str(draw.choice(["1", "2"])): 1.0})


def supply_droop(rig: Rig, draw: Draw) -> Form:
    """Half the supply pressure at the flow of the largest speed."""
    return _one(lambda s: {"droop": 0.5 * rig.machine.supply_pressure / _flow(rig) * s})


def entrained_air(rig: Rig, draw: Draw) -> Form:
    """Up to 10 % of the volume at atmospheric pressure, isothermal."""
    return _one(lambda s: {"air": 0.1 * s})


def unequal_areas(rig: Rig, draw: Draw) -> Form:
    """The second area is up to twice or half the declared one."""
    return _one(lambda s: {"area_2": float(rig.machine.area_2 * 2.0**s)}, -1.0 if draw.random() < 0.7 else 1.0)


def valve_gain_curve(rig: Rig, draw: Draw) -> Form:
    """Openings times 1 + c |x| / x_max, c up to 2 or down to -0.8."""
    return _one(lambda s: {"gain_curve": s}, 2.0 if draw.random() < 0.5 else -0.8)


def valve_gain_asymmetry(rig: Rig, draw: Draw) -> Form:
    """The gain of negative openings over that of positive ones: 2.5^(+-s)."""
    return _one(lambda s: {"gain_ratio": float(2.5**s)}, _sign(draw))


def position_dependent_volume(rig: Rig, draw: Draw) -> Form:
    """The share by which chambers that are declared frozen at mid-stroke follow the position."""
    return _one(lambda s: {"following": s})


def position_dependent_area(rig: Rig, draw: Draw) -> Form:
    """Areas times 1 + g xi, g up to 0.5."""
    return _one(lambda s: {"area_gradient": 0.5 * s}, _sign(draw))


def supply_ripple(rig: Rig, draw: Draw) -> Form:
    """Up to 30 % of the supply pressure, a sine of 0.3 to 10 Hz."""
    frequency, most = 2.0 * np.pi * between(draw, 0.3, 10.0), 0.3 * rig.machine.supply_pressure
    phase = draw.uniform(0.0, 2.0 * np.pi)
    columns: dict[str, Column] = {
        "own": lambda s: {"ripple": most * s, "ripple_frequency": frequency, "ripple_phase": phase},
        "beside": lambda s: {"ripple": most * s, "ripple_frequency": frequency, "ripple_phase": phase + 0.5 * np.pi},
    }
    return Form(columns, {"own": 1.0})


# --- valve and sensors -----------------------------------------------------------------------------------------


def command_delay(rig: Rig, draw: Draw) -> Form:
    """Up to 0.1 s."""
    return _one(lambda s: {"delay": 0.1 * s})


def valve_hysteresis(rig: Rig, draw: Draw) -> Form:
    """The command is followed with a play of up to 20 % of its limit."""
    return _one(lambda s: {"play": 0.2 * rig.machine.command_limit * s})


def spool_stiction(rig: Rig, draw: Draw) -> Form:
    """The spool stays until its target is up to 10 % of its way off, then goes there."""
    return _one(lambda s: {"spool_band": 0.1 * rig.machine.spool_limit * s})


def backlash(rig: Rig, draw: Draw) -> Form:
    """The position sensor follows with a play of up to 10 % of the travel (full width)."""
    return _one(lambda s: {"backlash": 0.1 * rig.travel * s})


def pressure_sensor_offset(rig: Rig, draw: Draw) -> Form:
    """Up to 10 % of the supply pressure on pressure 1."""
    return _one(lambda s: {"offset_1": 0.1 * rig.machine.supply_pressure * s}, _sign(draw))


def sensor_nonlinearity(rig: Rig, draw: Draw) -> Form:
    """Up to 10 % of a pitch, once a pitch: 3 to 40 in the travel, of a turning axis a turn."""
    pitch = 2.0 * np.pi if rig.kind == ROTARY else rig.travel / draw.uniform(3.0, 40.0)
    angle = draw.uniform(0.0, 2.0 * np.pi)
    columns: dict[str, Column] = {
        "cosine": lambda s: {"sensor_cosine": 0.1 * pitch * s, "sensor_pitch": float(pitch)},
        "sine": lambda s: {"sensor_sine": 0.1 * pitch * s, "sensor_pitch": float(pitch)},
    }
    return Form(columns, {"cosine": float(np.cos(angle)), "sine": float(np.sin(angle))})


def sensor_lag(rig: Rig, draw: Draw) -> Form:
    """The position sensor follows by a lag of up to 0.1 s."""
    return _one(lambda s: {"sensor_lag": 0.1 * s})


@dataclass(frozen=True)
class Effect:
    """An effect: its forms on a rig, the balance of which it is a term, the kinds of machine that may have it.

    One of a sensor is not told where a hand moves the mass: there the sensor says what the motion was. `own` are the
    program's names of its parameters and the machine's; `signed`, whether either sign may be.
    """

    name: str
    draw: Callable[[Rig, Draw], Form]
    balance: str
    kinds: Sequence[str] = KINDS
    by_hand: bool = True
    signed: bool = False
    own: Mapping[str, str] = ()  # type: ignore[assignment]

    def may_be(self, kind: str, motion: str) -> bool:
        """Whether a machine that is moved in this way may have it, and show it."""
        return kind in self.kinds and (self.by_hand or motion != HAND)


def _listed(*effects: Effect) -> dict[str, Effect]:
    return {effect.name: effect for effect in effects}


def _of(draw: Callable[[Rig, Draw], Form], balance: str, kinds: Sequence[str] = KINDS, **others: object) -> Effect:
    return Effect(draw.__name__, draw, balance, kinds, **others)  # type: ignore[arg-type]


EFFECTS: Mapping[str, Effect] = _listed(
    _of(direction_asymmetry, "force", signed=True),
    _of(
        position_dependent_friction,
        "force",
        FLUID,  # of a drive nobody declares the stroke
        signed=True,
        own={"friction_gradient": "friction_gradient", "friction_curvature": "friction_curvature"},
    ),
    _of(pressure_dependent_friction, "force", FLUID, own={"friction_per_pressure": "friction_per_pressure"}),
    _of(frictional_memory, "force", own={"memory_time": "memory_time"}),
    _of(
        rising_static_friction,
        "force",
        own={n: n for n in ("static_rise", "static_rise_time", "static_rise_distance")},
    ),
    _of(quadratic_drag, "force", own={"drag_coefficient": "drag"}),
    _of(viscous_drift, "force", signed=True, own={"viscous_drift": "viscous_drift"}),
    _of(constant_load, "force", signed=True, own={"load_force": "load", "load_torque": "load"}),
    _of(spring_load, "force", signed=True, own={"spring_stiffness": "spring"}),
    _of(valve_deadband, "flow", FLUID),
    _of(internal_leakage, "flow", OIL, own={"leakage_coefficient": "leakage"}),
    _of(supply_droop, "flow", OIL, own={"droop_resistance": "droop"}),
    _of(entrained_air, "flow", OIL, own={"air_fraction": "air"}),
    _of(unequal_areas, "flow", OIL, signed=True),
    _of(command_delay, "valve", by_hand=False, own={"command_delay": "delay"}),
    _of(backlash, "sensor", by_hand=False, own={"backlash_width": "backlash"}),
    _of(pressure_sensor_offset, "sensor", FLUID, signed=True, own={"pressure_1_offset": "offset_1"}),
    _of(valve_hysteresis, "valve", FLUID, own={"valve_hysteresis": "play"}),
    _of(valve_gain_curve, "flow", FLUID, signed=True),
    _of(valve_gain_asymmetry, "flow", FLUID, signed=True),
    _of(external_leakage, "flow", FLUID),
    _of(position_dependent_volume, "flow", (EQUAL,)),
    _of(position_dependent_area, "flow", FLUID, signed=True),
    _of(sensor_nonlinearity, "sensor", by_hand=False, signed=True),
    _of(sensor_lag, "sensor", by_hand=False),
    _of(cogging, "force", signed=True),
    _of(cushion, "force"),
    _of(presliding_curve, "force", signed=True),
    _of(maxwell_slip, "force"),
    _of(viscous_warming, "force", signed=True),
    _of(spool_stiction, "valve", FLUID),
    _of(supply_ripple, "flow", FLUID, signed=True),
    _of(compliant_load, "force"),
)
"""Every effect that diagnosis may name."""


def true_parameters(name: str, machine: Machine) -> dict[str, float]:
    """The true values (SI) of an effect's parameters, by the program's names as far as they are known here."""
    known = {program: float(getattr(machine, own)) for program, own in dict(EFFECTS[name].own).items()}
    if name == "direction_asymmetry":
        for part in ("coulomb", "stribeck", "viscous"):
            known[f"{part}_negative"] = getattr(machine, part) * getattr(machine, f"{part}_ratio")
    if name == "valve_deadband" and machine.overlap_positive == machine.overlap_negative:
        known["valve_overlap"] = machine.overlap_positive
    return known
