"""What a diagnosis is told with: names and units for a reader, numbers with as many digits as say something."""

import math
from collections.abc import Iterable

from plants.axis import LINEAR
from workbench.parameters.sets import known_units
from workbench.publish.along import SHOWN
from workbench.publish.tables import shown_number
from workbench.publish.words import listed, plain_name
from workbench.toml.units import factor

ERRORS = {
    "force_rms_N": ("residual of the force balance", "N", "N"),
    "flow_rms_m3_per_s": ("residual of the flow balance", "m^3/s", "cm^3/s"),
    "flow_rms_kg_per_s": ("residual of the flow balance", "kg/s", "g/s"),
    "rotation_rms_N_m": ("residual of the balance of torques", "N m", "N m"),
    "motor_rms_V": ("residual of the motor's balance of voltages", "V", "V"),
    "velocity_rms_m_per_s": ("residual of the balance of velocities", "m/s", "mm/s"),
    "pump_speed_rms_rad_per_s": ("pump speed on plateaus", "rad/s", "rpm"),
    "position_rms_m": ("position, simulated against measured", "m", "mm"),
    "torque_rms_N_m": ("residual of the torque balance", "N m", "N m"),
    "position_rms_rad": ("position, simulated against measured", "rad", "deg"),
    "load_pressure_rms_Pa": ("load pressure, simulated against measured", "Pa", "kPa"),
}
"""Figures of the error: in words, the unit that they have, the unit that is shown."""

MOST_DECIMALS, READABLE = 9, 1e7
"""Decimals, and a size, up to which a number is written out."""

_COARSE = {"Pa": 1e6, "s": 0.1}


def shown_unit(unit: str, value: float) -> str:
    """The unit in which a parameter of this size is read most easily."""
    large = abs(value) >= _COARSE.get(unit, 0.0)
    if unit in SHOWN:
        return SHOWN[unit].scaled(abs(value))[1]
    units = {
        "Pa": "MPa" if large else "kPa",
        "s": "s" if large else "ms",
        **{si: name for shown in SHOWN.values() for si, name in shown.units.items()},
        "m^3/s": "cm^3/s",
        "m^2": "cm^2",
        "m^3": "cm^3",
        "m^3/rad": "cm^3/rad",
        "m^3/(s Pa)": "cm^3/(s bar)",
        "Pa s/m^3": "kPa s/cm^3",
        "N/Pa": "N/bar",
        "N/m": "N/mm",
    }
    return units.get(unit, unit)


def quantity(name: str, value: float, std: float | None = None, axis: str = LINEAR) -> str:
    """Of a plant along that axis, a parameter's value with its unit, and its standard deviation in the same unit."""
    unit = known_units(axis).get(name, "1")
    shown = shown_unit(unit, value)
    scale = factor(unit, shown)
    text = within(scale * value, 0.0 if std is None else scale * std)
    if std is not None:
        text += f" ± {shown_number(scale * std, 2)}"
    return text if shown == "1" else f"{text} {shown}"


def percent(share: float, digits: int = 0) -> str:
    """A share in per cent, with more digits where fewer would make 100 % of nearly all."""
    text = f"{100.0 * share:.{digits}f}"
    while abs(float(text)) == 100.0 != abs(100.0 * share) and digits < MOST_DECIMALS:
        digits += 1
        text = f"{100.0 * share:.{digits}f}"
    return f"{'0' if float(text) == 0.0 else text} %"


def _decimals(spread: float) -> int:
    """Decimals with which two digits of a spread are shown."""
    return max(1 - math.floor(math.log10(spread)), 0) if math.isfinite(spread) and spread > 0.0 else 0


def within(value: float, half: float) -> str:
    """A value with four digits, or as many as its interval has: the one is to lie in the other."""
    text, decimals = shown_number(value, 4), _decimals(half)
    more = len(text.partition(".")[2]) < decimals <= MOST_DECIMALS and "e" not in text
    return f"{value:.{decimals}f}" if more else text


def interval(value: float, half: float) -> str:
    """From `value - half` to `value + half`, with two digits of the half width at least."""
    if not (math.isfinite(half) and half > 0.0):
        return ""
    decimals = _decimals(half)
    if decimals > MOST_DECIMALS or abs(value) + half >= READABLE:
        return f"{shown_number(value - half, 4)} to {shown_number(value + half, 4)}"
    return f"{value - half:.{decimals}f} to {value + half:.{decimals}f}"


def listed_names(names: Iterable[str], last: str = "and") -> str:
    """Names as a reader sees them, in a row."""
    return listed([plain_name(name) for name in names], last)
