"""Units as FMI defines them: a factor, and whole exponents of the SI's base units and the radian."""

from xml.etree import ElementTree as ET

from workbench.toml.units import base_units

SYMBOLS = {
    "kilogram": "kg",
    "meter": "m",
    "second": "s",
    "ampere": "A",
    "kelvin": "K",
    "mole": "mol",
    "candela": "cd",
    "radian": "rad",
}
"""FMI's names of base units, by pint's."""


def unit_definitions(units: list[str]) -> ET.Element:
    """The element UnitDefinitions. A unit with a broken exponent (Pa^0.5) has its name alone: FMI has whole ones."""
    element = ET.Element("UnitDefinitions")
    for unit in units:
        defined = ET.SubElement(element, "Unit", name=unit)
        factor, exponents = base_units(unit)
        if all(exponent == int(exponent) for exponent in exponents.values()):
            base = {SYMBOLS[name]: str(int(exponent)) for name, exponent in sorted(exponents.items())}
            ET.SubElement(defined, "BaseUnit", {**base, **({"factor": repr(factor)} if factor != 1.0 else {})})
    return element
