"""Names and powers as a reader sees them."""

from collections.abc import Sequence

from workbench.publish.tables import shown_number


def plain_name(name: str) -> str:
    """The name of a controller, scenario or reference as a reader sees it."""
    return name.replace("_", " ")


def listed(names: Sequence[str], last: str = "and") -> str:
    """Words in a row: a, b and c."""
    return f" {last} ".join(part for part in (", ".join(names[:-1]), names[-1]) if part) if names else ""


def watts(power: float) -> str:
    """A power (W) with two digits, in kW from 1 kW on."""
    return f"{shown_number(power / 1e3, 2)} kW" if abs(power) >= 995.0 else f"{shown_number(power, 2)} W"
