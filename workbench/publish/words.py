"""Names and powers as a reader sees them."""

from workbench.publish.tables import shown_number


def plain_name(name: str) -> str:
    """The name of a controller, scenario or reference as a reader sees it."""
    return name.replace("_", " ")


def watts(power: float) -> str:
    """A power (W) with two digits, in kW from 1 kW on."""
    return f"{shown_number(power / 1e3, 2)} kW" if abs(power) >= 995.0 else f"{shown_number(power, 2)} W"
