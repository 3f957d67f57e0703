"""Effects that nobody understands: what a balance lacks, as a curve over a signal.

A curve has a switch (`_share`, 0: off), the range of its signal and values at even distances over it, in the unit and
with the sign of the balance's residual: above 0 more acts than the plant explains. Beyond the range it is constant.
No cause is named, and no diagnosis looks for one: it is what a diagnosis offers for what no effect explains.

Between the nodes runs a cubic with the slopes of Fritsch and Carlson (1980; harmonic means of the rises on either
side): continuous in value and slope, which an integrator with error control asks for and lines do not give, and nowhere
beyond its nodes, which a spline would be. Written as a sum over the intervals, of which each is 0 before and constant
behind its own, it needs no search for the interval, and runs in NumPy, compiled and in CasADi alike.
"""

from collections.abc import Callable, Mapping
from typing import Annotated, Any

import numpy as np

from plants.axis import AXES
from plants.effects.interface import DISTURBANCE, FREE, Effect, Moment, Number
from plants.effects.maps import FORCE_MAP
from plants.effects.maps import NODES as MAP_NODES
from plants.effects.scales import Scales, duration, force, pressure, travel, voltage
from plants.equation import Equation, Scalar, equation, named_tuple, select
from plants.hydraulics import oil_volume, oil_volumes
from plants.laws.interface import Nothing

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


def _flow_over(signal: Equation, taken: Equation) -> Equation:
    @equation
    def lacking(rate: Scalar, moment: Moment, memory: Nothing, p: Any, own: Any) -> Scalar:
        """dP/dt + Q / C (Pa/s), C the capacity to which the residual of the balance is referred."""
        return rate + own[0] * curve(signal(moment), own) / taken(p)

    return lacking


# --- effects --------------------------------------------------------------------------------------------------


def speed(scales: Scales) -> float:
    """m/s."""
    return scales.speed


def flow(scales: Scales) -> float:
    """m^3/s."""
    return scales.flow


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

BALANCES: Mapping[str, tuple[str, Scale, tuple[str, ...]]] = {
    "force": ("N", force, ("position", "velocity", "load_pressure", "time")),
    "flow": ("m^3/s", flow, ("pressure_1", "pressure_2", "valve_voltage", "position")),
}
"""Of each balance the unit, its scale and the signals over which there are curves. The flow is that into the first
chamber, or where a plant has a load pressure alone that which changes it: the first residual of the balance."""


def nodes_of(name: str) -> tuple[str, ...]:
    """The names of the values of a curve, or of the map."""
    return MAP_NODES if name == FORCE_MAP.name else tuple(f"{name}_{k:02d}" for k in range(1, NODES + 1))


def _curve(balance: str, signal: str) -> Effect:
    name = f"{signal}_{balance}_curve"
    (unit, at, scale, needed), (own_unit, size, _) = SIGNALS[signal], BALANCES[balance]
    is_force, over = balance == "force", signal.replace("_", " ")
    units = {
        f"{name}_{SHARE}": "1",
        f"{name}_{LOW}": unit,
        f"{name}_{HIGH}": unit,
        **dict.fromkeys(nodes_of(name), own_unit),
    }
    members: dict[str, Any] = {each: Annotated[float, own] for each, own in units.items()}
    return Effect(
        name=name,
        balance=balance,
        words=WORDS.format(balance=balance, signal=over),
        source="Fritsch and Carlson 1980",
        numbers={
            f"{name}_{SHARE}": Number(0.0, 1.0, 1.0),
            **dict.fromkeys((f"{name}_{LOW}", f"{name}_{HIGH}"), Number(-FREE, FREE, 1.0, scale)),
            **dict.fromkeys(nodes_of(name), Number(-FREE, FREE, 0.02, size)),
        },
        sought=False,
        requires=needed if is_force else ("hydraulics", *needed),
        Own=named_tuple(
            "".join(part.capitalize() for part in name.split("_")),
            __name__,
            members,
            {each: 1.0 if each == f"{name}_{HIGH}" else 0.0 for each in units},
            f"Share that acts (0: off), the range of the {over}, and values at {NODES} even places over it.",
        ),
        inputs={DISTURBANCE: _force_over(at)} if is_force else {},
        rates={} if is_force else {"pressure_1": _flow_over(at, capacity_1), "load_pressure": _flow_over(at, capacity)},
    )


CURVES: Mapping[tuple[str, str], Effect] = {
    (balance, signal): _curve(balance, signal) for balance, (_, _, signals) in BALANCES.items() for signal in signals
}
"""By balance and signal, in the order in which they act."""


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
