"""Effects that nobody understands: what a balance lacks, as a curve over a signal.

A curve has a switch (`_share`, 0: off), the range of its signal and values at even distances over it, in the unit and
with the sign of the balance's residual: above 0 more acts than the plant explains. Beyond the range it is constant.
No cause is named, and no diagnosis names one: it is what a diagnosis offers for what no effect explains.

Between the nodes runs a cubic with the slopes of Fritsch and Carlson (1980; harmonic means of the rises on either
side): continuous in value and slope, which an integrator with error control asks for and lines do not give, and nowhere
beyond its nodes, which a spline would be. Written as a sum over the intervals, of which each is 0 before and constant
behind its own, it needs no search for the interval, and runs in NumPy, compiled and in CasADi alike.
"""

from collections.abc import Callable, Mapping
from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.axis import AXES
from plants.effects.chambers import ATMOSPHERE
from plants.effects.interface import DISTURBANCE, FREE, Effect, Moment, Number
from plants.effects.maps import FORCE_MAP
from plants.effects.maps import NODES as MAP_NODES
from plants.effects.scales import Scales, duration, force, pressure, travel, voltage
from plants.equation import Equation, Scalar, equation, named_tuple, select
from plants.hydraulics import oil_volume, oil_volumes
from plants.laws.interface import Nothing
from plants.pneumatics import NORMAL_DENSITY, air_volumes, specific_energy

NODES = 12
"""Of a curve."""

WORDS = "not understood: what the {balance} balance lacks, over the {signal}"

SHARE, LOW, HIGH = "share", "low", "high"
"""What a curve has beside its values, behind its name."""


# --- equations ------------------------------------------------------------------------------------------------


@equation
def curve(signal: Scalar, own: Any) -> Scalar:
    """The value of a curve (share, low, high, y_1 ... y_12) at a signal.

    y_1 + sum_k D_k t^2 (3 - 2 t) + m_k t (1 - t)^2 - m_(k+1) t^2 (1 - t),  t = clip((x - low)/h - k, 0, 1)

    D_k is the rise over the interval, m_k the slope at its start: 2 D D'/(D + D') of both rises if they have one sign,
    else 0, as at both ends. A range without width has the width of 1 in each interval.
    """
    step = select(own[2] > own[1], (own[2] - own[1]) / (NODES - 1), 1.0)
    place = (signal - own[1]) / step
    value, before = own[3], 0.0 * own[3]
    for k in range(NODES - 1):
        rise = own[4 + k] - own[3 + k]
        ahead = own[min(5 + k, NODES + 2)] - own[4 + k]
        alike = rise * ahead > 0.0
        after = select(alike, 2.0 * rise * ahead / select(alike, rise + ahead, 1.0), 0.0)
        t = np.minimum(np.maximum(place - k, 0.0), 1.0)
        value = value + rise * t * t * (3.0 - 2.0 * t) + before * t * (1.0 - t) ** 2 - after * t * t * (1.0 - t)
        before = after
    return value


@equation
def at_position(moment: Moment) -> Scalar:
    """x (m)."""
    return moment.position


@equation
def at_velocity(moment: Moment) -> Scalar:
    """v (m/s)."""
    return moment.velocity


@equation
def at_time(moment: Moment) -> Scalar:
    """t (s)."""
    return moment.time


@equation
def at_load_pressure(moment: Moment) -> Scalar:
    """P_1 - P_2 (Pa)."""
    return moment.pressure_1 - moment.pressure_2


@equation
def at_pressure_1(moment: Moment) -> Scalar:
    """P_1 (Pa)."""
    return moment.pressure_1


@equation
def at_pressure_2(moment: Moment) -> Scalar:
    """P_2 (Pa)."""
    return moment.pressure_2


@equation
def at_valve_voltage(moment: Moment) -> Scalar:
    """x_s / k_s (V): the voltage that holds the spool where it is."""
    return moment.spool_position / moment.spool_gain


def _force_over(signal: Equation) -> Equation:
    @equation
    def lacking(disturbance: Scalar, moment: Moment, memory: Nothing, p: Any, own: Any) -> Scalar:
        """The force on the mass, off the disturbance that acts against it (N)."""
        return disturbance - own[0] * curve(signal(moment), own)

    return lacking


@equation
def capacity(p: Any) -> Scalar:
    """V_t / (4 beta) (m^3/Pa) of the load pressure."""
    return oil_volume(p.hydraulics) / (4.0 * p.hydraulics.bulk_modulus)


@equation
def capacity_1(p: Any) -> Scalar:
    """V / beta (m^3/Pa) of the first chamber in mid-stroke."""
    return oil_volumes(0.0, p.hydraulics, p.cylinder)[0] / p.hydraulics.bulk_modulus


@equation
def air_capacity_1(p: Any) -> Scalar:
    """V / (n R T) (kg/Pa) of the first chamber in mid-stroke."""
    return air_volumes(0.0, p.pneumatics)[0] / (p.pneumatics.polytropic_exponent * specific_energy(p.pneumatics))


def _flow_over(signal: Equation, taken: Equation) -> Equation:
    @equation
    def lacking(rate: Scalar, moment: Moment, memory: Nothing, p: Any, own: Any) -> Scalar:
        """dP/dt + Q / C (Pa/s), Q a flow (m^3/s; kg/s of air), C the capacity to which the balance's residual is
        referred.
        """
        return rate + own[0] * curve(signal(moment), own) / taken(p)

    return lacking


# --- effects --------------------------------------------------------------------------------------------------


def speed(scales: Scales) -> float:
    """m/s."""
    return scales.speed


def flow(scales: Scales) -> float:
    """m^3/s."""
    return scales.flow


def air_flow(scales: Scales) -> float:
    """kg/s, of air at the supply's pressure."""
    return NORMAL_DENSITY * (1.0 + scales.pressure / ATMOSPHERE) * scales.flow


Scale = Callable[[Scales], float]

SIGNALS: Mapping[str, tuple[str, Equation, Scale, tuple[str, ...]]] = {
    "position": ("m", at_position, travel, ()),
    "velocity": ("m/s", at_velocity, speed, ()),
    "time": ("s", at_time, duration, ()),
    "load_pressure": ("Pa", at_load_pressure, pressure, ("pressure_1", "pressure_2")),
    "pressure_1": ("Pa", at_pressure_1, pressure, ("pressure_1",)),
    "pressure_2": ("Pa", at_pressure_2, pressure, ("pressure_2",)),
    "valve_voltage": ("V", at_valve_voltage, voltage, ("spool_position",)),
}
"""Of each signal, as a diagnosis calls it, the unit, its value at an instant, its scale and what a plant needs to have
it."""


class Kind(NamedTuple):
    """Of which balance curves are, their unit and scale, the signals over which there are some, what of its parameters
    a plant needs for them, and the capacities to which the rate of a first chamber's pressure, and of a load pressure,
    is referred.
    """

    balance: str
    unit: str
    scale: Scale
    signals: tuple[str, ...]
    needs: tuple[str, ...] = ()
    capacities: Mapping[str, Equation] = {}


FLOWS = ("pressure_1", "pressure_2", "valve_voltage", "position", "velocity")

KINDS: Mapping[str, Kind] = {
    "force": Kind("force", "N", force, ("position", "velocity", "load_pressure", "time")),
    "flow": Kind("flow", "m^3/s", flow, FLOWS, ("hydraulics",), {"pressure_1": capacity_1, "load_pressure": capacity}),
    "air_flow": Kind("flow", "kg/s", air_flow, FLOWS, ("pneumatics",), {"pressure_1": air_capacity_1}),
}
"""By what their names say. The flow is that into the first chamber, or where a plant has a load pressure alone that
which changes it: the first residual of the balance."""


def nodes_of(name: str) -> tuple[str, ...]:
    """The names of the values of a curve, or of the map."""
    return MAP_NODES if name == FORCE_MAP.name else tuple(f"{name}_{k:02d}" for k in range(1, NODES + 1))


def _curve(kind: str, signal: str) -> Effect:
    name, of = f"{signal}_{kind}_curve", KINDS[kind]
    unit, at, scale, needed = SIGNALS[signal]
    over = signal.replace("_", " ")
    units = {
        f"{name}_{SHARE}": "1",
        f"{name}_{LOW}": unit,
        f"{name}_{HIGH}": unit,
        **dict.fromkeys(nodes_of(name), of.unit),
    }
    members: dict[str, Any] = {each: Annotated[float, own] for each, own in units.items()}
    return Effect(
        name=name,
        balance=of.balance,
        words=WORDS.format(balance=of.balance, signal=over),
        source="Fritsch and Carlson 1980",
        numbers={
            f"{name}_{SHARE}": Number(0.0, 1.0, 1.0),
            **dict.fromkeys((f"{name}_{LOW}", f"{name}_{HIGH}"), Number(-FREE, FREE, 1.0, scale)),
            **dict.fromkeys(nodes_of(name), Number(-FREE, FREE, 0.02, of.scale)),
        },
        sought=False,
        requires=(*of.needs, *needed),
        Own=named_tuple(
            "".join(part.capitalize() for part in name.split("_")),
            __name__,
            members,
            {each: 1.0 if each == f"{name}_{HIGH}" else 0.0 for each in units},
            f"Share that acts (0: off), the range of the {over}, and values at {NODES} even places over it.",
        ),
        inputs={} if of.capacities else {DISTURBANCE: _force_over(at)},
        rates={state: _flow_over(at, taken) for state, taken in of.capacities.items()},
    )


CURVES: Mapping[tuple[str, str], Effect] = {
    (kind, signal): _curve(kind, signal) for kind, of in KINDS.items() for signal in of.signals
}
"""By kind and signal, in the order in which they act."""


def curves_over(balance: str, signal: str) -> list[Effect]:
    """Those of a balance over a signal: one for each kind of plant."""
    return [effect for (_, over), effect in CURVES.items() if (effect.balance, over) == (balance, signal)]


_SWITCHES = {
    name: effect.along(axis).own_names[0]
    for effect in (*CURVES.values(), FORCE_MAP)
    for axis in AXES
    for name in effect.along(axis).own_names
}
"""The switch of the curve, or of the map, to which a parameter belongs."""


def acting(values: Mapping[str, float]) -> dict[str, float]:
    """Parameters by canonical name, without those of curves and maps that are off: they would cost time for nothing."""
    return {
        name: value
        for name, value in values.items()
        if values.get(_SWITCHES.get(name, name), 0.0) or name not in _SWITCHES
    }
