"""Units as loggers write them, and what they are called in an experiment file."""

import re

SPELLED: dict[str, tuple[str, ...]] = {
    "s": ("s", "sec", "second", "seconds", "sekunden", "sek", "secondes", "secondi", "segundos"),
    "ms": ("ms", "msec", "millisecond", "milliseconds"),
    "us": ("us", "µs", "μs", "usec"),
    "ns": ("ns", "nsec"),
    "min": ("min",),
    "V": ("v", "volt", "volts", "vdc"),
    "mV": ("mv", "millivolt"),
    "A": ("a", "amp", "amps", "ampere", "amperes"),
    "mA": ("ma",),
    "Pa": ("pa", "pascal"),
    "hPa": ("hpa",),
    "kPa": ("kpa",),
    "MPa": ("mpa",),
    "bar": ("bar", "barg", "bara"),
    "mbar": ("mbar",),
    "psi": ("psi", "psig", "psia"),
    "N": ("n", "newton"),
    "kN": ("kn",),
    "lbf": ("lbf", "lb"),
    "N m": ("nm", "n·m", "n*m", "n.m", "n m", "n-m"),
    "mm": ("mm", "millimeter", "millimetre"),
    "cm": ("cm",),
    "um": ("um", "µm", "μm", "micron"),
    "m": ("m", "meter", "metre"),
    "inch": ("in", "inch", "inches", '"'),
    "deg": ("deg", "°", "degree", "degrees", "grad"),
    "rad": ("rad",),
    "turn": ("rev", "turn", "turns", "u"),
    "rpm": ("rpm", "1/min", "u/min", "min-1", "min^-1", "tr/min", "giri/min"),
    "rad/s": ("rad/s",),
    "deg/s": ("deg/s", "°/s"),
    "m/s": ("m/s",),
    "mm/s": ("mm/s",),
    "cm/s": ("cm/s",),
    "inch/s": ("in/s", "ips", "inch/s"),
    "m/s^2": ("m/s2", "m/s^2", "m/s²"),
    "mm/s^2": ("mm/s2", "mm/s^2", "mm/s²"),
    "percent": ("%", "percent", "pct"),
}
"""Names of units in an experiment file, and how loggers write them, in small letters."""

OTHERS = frozenset(
    {"", "-", "1", "hz", "kg", "g", "c", "°c", "degc", "k", "counts", "count", "cnt", "inc", "digit", "digits", "raw"}
    | {"lsb", "n/a", "none", "float", "double", "int", "real", "bool", "date", "datetime", "string"}
)
"""What stands in a row of units and is none of a channel's."""

_UNIT = {spelled: unit for unit, ways in SPELLED.items() for spelled in ways}
_CASED = {"mPa": "", "MPA": "MPa", "mA": "mA", "MA": "", "mN": ""}
"""Where a capital is another unit; "" of what no channel has."""


def unit_named(text: str) -> str:
    """The unit that a logger's text stands for, as an experiment file calls it; "" of none."""
    plain = text.strip().strip("[]() ")
    return _CASED.get(plain, _UNIT.get(plain.lower(), ""))


def is_unit(text: str) -> bool:
    """Whether a text may stand in a row of units."""
    plain = text.strip().strip("[]() ").lower()
    return plain in _UNIT or plain in OTHERS


BEHIND = (r"(.*?)\s*[\[(]\s*([^\[\]()]*?)\s*[\])]\s*", r"(.*\S)\s*,\s*(\S+)", r"(.*\w)[_ ](\w\S+)", r"(.*\w)_([VN])")
"""Ways in which a unit stands behind a name; without bracket or comma it has two letters or more (x_m is no metre), or
is the capital of volts or newtons.
"""


def without_unit(header: str) -> tuple[str, str]:
    """A column's name and the unit that stands behind it: "Weg [mm]", "p_A (bar)", "pressure, psi", "pos_mm"."""
    for pattern in BEHIND:
        parts = re.fullmatch(pattern, header.strip())
        if parts is not None and (unit := unit_named(parts[2])):
            return parts[1], unit
    return header.strip(), ""
