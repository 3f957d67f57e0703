"""The unit of a column that a channel was found for: as its file says, or as its numbers look."""

from collections.abc import Mapping
from typing import NamedTuple

from workbench.records.importing.columns import Column
from workbench.records.importing.proposal import Question
from workbench.records.importing.words import words_of

COUNTS = 20.0
"""Size above which whole numbers without a unit are taken for counts of a converter."""

KINDS: Mapping[str, frozenset[str]] = {
    "time": frozenset(("s", "ms", "us", "ns", "min")),
    "position": frozenset(("m", "mm", "cm", "um", "inch", "deg", "rad", "turn")),
    "velocity": frozenset(("m/s", "mm/s", "cm/s", "inch/s", "deg/s", "rad/s", "rpm")),
    "acceleration": frozenset(("m/s^2", "mm/s^2")),
    "command": frozenset(("V", "mV", "A", "mA", "N", "kN", "N m", "percent")),
    "valve_voltage": frozenset(("V", "mV", "percent", "mA", "A")),
    "pump_speed": frozenset(("rpm", "rad/s", "deg/s")),
    **dict.fromkeys(
        ("pressure_1", "pressure_2", "supply_pressure"), frozenset(("Pa", "hPa", "kPa", "MPa", "bar", "mbar", "psi"))
    ),
    "force": frozenset(("N", "kN", "lbf")),
    "torque": frozenset(("N m",)),
    "motor_current": frozenset(("A", "mA")),
}
"""Units in which a channel may be."""

ANGLES = frozenset(("deg", "rad", "turn"))

BY_UNIT: Mapping[str, tuple[str, ...]] = {
    "bar": ("pressure_1", "pressure_2"),
    "mm": ("position",),
    "m": ("position",),
    "inch": ("position",),
    "deg": ("position",),
    "V": ("command",),
    "N": ("force",),
    "kN": ("force",),
    "lbf": ("force",),
    "N m": ("torque",),
    "psi": ("pressure_1", "pressure_2"),
    "kPa": ("pressure_1", "pressure_2"),
    "Pa": ("pressure_1", "pressure_2"),
    "m/s": ("velocity",),
    "mm/s": ("velocity",),
    "deg/s": ("velocity",),
    "m/s^2": ("acceleration",),
}
"""What a column of a unit is where its name says nothing, the likeliest first."""

TURNS = frozenset(("angle", "winkel", "theta", "phi", "angolo", "angulo", "joint", "rot"))


class Unit(NamedTuple):
    """A unit, the scale of raw numbers, the reason, and what is asked."""

    unit: str
    scale: float
    reason: str
    questions: tuple[Question, ...] = ()


def unit_for(channel: str, column: Column) -> Unit:
    """The unit of a channel's column."""
    if channel == "valve_voltage" and column.unit in ("A", "mA"):
        asked = Question(f"{channel}: {column.key} is a current: how many V stand for one {column.unit}?", "scale")
        return Unit("V", 1.0, f"{column.said}; a plant's valve has a voltage", (asked,))
    if column.unit in KINDS[channel] and column.unit != "percent":
        return Unit(column.unit, 1.0, f"{column.said}, as the file says")
    if column.unit == "percent":
        asked = Question(f"{channel}: how many volts are 100 % of {column.key}? scale is a hundredth of them", "scale")
        return Unit("V", 0.1, f"{column.said}: 10 V at 100 % assumed", (asked,))
    unit, why = _by_numbers(channel, column)
    numbers = f"{column.low:.4g} to {column.high:.4g}"
    if column.whole and column.size > COUNTS and channel != "pump_speed":
        asked = Question(
            f"{channel}: {column.key} looks like counts ({numbers}): how many {unit} is one? And which offset has it?",
            "scale",
        )
        return Unit(unit, 1.0, f"whole numbers, {numbers}", (asked,))
    asked = Question(f"{channel}: is {column.key} ({numbers}) in {unit}?", "unit")
    return Unit(unit, 1.0, f"{numbers}: {why}", (asked,))


def _by_numbers(channel: str, column: Column) -> tuple[str, str]:
    """The likeliest unit by size, and why."""
    size, span = column.size, column.high - column.low
    if channel == "position":
        if TURNS & set(words_of(column.name)):
            return ("deg", "too much for rad") if span > 7.0 else ("rad", "no more than a turn")
        return ("m", f"a way of {span:.3g} is too short for mm") if span < 2.0 else ("mm", "too much for m")
    if channel.endswith(("pressure", "_1", "_2")):
        if size > 2e4:
            return "Pa", "so large"
        return ("kPa", "too much for bar") if size > 700.0 else ("bar", "the size of bar")
    if channel in ("velocity", "acceleration"):
        return {"velocity": "m/s", "acceleration": "m/s^2"}[channel], "assumed"
    if channel == "pump_speed":
        return ("rpm", "too fast for rad/s") if size > 400.0 else ("rad/s", "too slow for rpm")
    return {"force": "N", "torque": "N m", "motor_current": "A"}.get(channel, "V"), "assumed"
