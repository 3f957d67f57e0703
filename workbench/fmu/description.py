"""What an FMU says of itself in modelDescription.xml, FMI 2.0 or 3.0."""

import functools
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET
from xml.parsers import expat

from workbench.errors import UserError, shortened
from workbench.fmu.archive import DESCRIPTION, read_description, sha256_of

NUMBERS = {2: "Real", 3: "Float64"}
"""The type of variables that are numbers, by version of FMI."""

BASE = {
    "kg": "kilogram",
    "m": "meter",
    "s": "second",
    "A": "ampere",
    "K": "kelvin",
    "mol": "mole",
    "cd": "candela",
    "rad": "radian",
}
"""Names of base units, by FMI's."""


@dataclass(frozen=True)
class FmuUnit:
    """A unit: a value in base units is factor times a value in it, plus offset; exponents by name of the base unit."""

    factor: float
    offset: float
    exponents: Mapping[str, float]


@dataclass(frozen=True)
class FmuVariable:
    """A variable; `kind` is its type, such as Real, `unit` the name of its unit, "" without. What is `settable` has a
    start value that may be another.
    """

    name: str
    reference: int
    kind: str
    causality: str
    unit: str
    settable: bool


@dataclass(frozen=True, eq=False)
class Fmu:
    """An FMU that offers co-simulation. `fmi` is 2 or 3; `token` ties the description to the binary."""

    path: Path
    sha256: str
    fmi: int
    name: str
    identifier: str
    token: str
    variables: Mapping[str, FmuVariable]
    units: Mapping[str, FmuUnit]
    files: tuple[str, ...]

    def named(self, causality: str) -> list[str]:
        """Names of the number variables with a causality."""
        kind = NUMBERS[self.fmi]
        return [item.name for item in self.variables.values() if item.causality == causality and item.kind == kind]


def read_fmu(path: Path) -> Fmu:
    """An FMU as it describes itself. Nothing of it is run.

    Raises:
        UserError: it cannot be read, is no FMU, of another version of FMI, or has no co-simulation.
    """
    try:
        info = path.stat()
    except OSError as error:
        raise UserError(f"{path}: cannot be read ({error.strerror})") from None
    return _read(path, info.st_mtime_ns, info.st_size)


@functools.lru_cache(maxsize=64)
def _read(path: Path, *_: int) -> Fmu:
    """Once for a file that does not change."""
    digest = sha256_of(path)
    content, files = read_description(path)
    root = _parsed(path, content)
    version = root.get("fmiVersion", "")
    fmi = {"2.0": 2, "3.0": 3}.get(".".join(version.split(".")[:2]).partition("-")[0])
    if root.tag != "fmiModelDescription" or fmi is None:
        raise UserError(f'{path}: FMI "{shortened(version)}", expected 2.0 or 3.0')
    interface = root.find("CoSimulation")
    if interface is None:
        raise UserError(f"{path}: offers no co-simulation; export it with the solver in it")
    try:
        variables = _variables_2(root) if fmi == 2 else _variables_3(root)
        units = {item.attrib["name"]: _unit(item) for item in root.iterfind("UnitDefinitions/Unit")}
        return Fmu(
            path,
            digest,
            fmi,
            root.get("modelName", path.stem),
            interface.attrib["modelIdentifier"],
            root.attrib["guid" if fmi == 2 else "instantiationToken"],
            {item.name: item for item in variables},
            units,
            files,
        )
    except KeyError as error:
        raise UserError(f"{path}: {DESCRIPTION} lacks the attribute {error}") from None
    except ValueError as error:
        raise UserError(f"{path}: {DESCRIPTION}: {shortened(str(error))}") from None


def _parsed(path: Path, content: bytes) -> ET.Element:
    """The root of an XML file without a document type: entities, which may grow without bounds, need one."""

    def refuse(*_: Any) -> None:
        raise UserError(f"{path}: {DESCRIPTION} has a document type; expected none, as FMI has none")

    parser = expat.ParserCreate()
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(content, True)
        return ET.fromstring(content)
    except (expat.ExpatError, ET.ParseError, ValueError, LookupError) as error:
        raise UserError(f"{path}: {DESCRIPTION} is no XML ({shortened(str(error))})") from None


def _variables_2(root: ET.Element) -> list[FmuVariable]:
    types = {item.attrib["name"]: item.find("Real") for item in root.iterfind("TypeDefinitions/SimpleType")}
    units = {name: real.get("unit", "") for name, real in types.items() if real is not None}
    found = []
    for item in root.iterfind("ModelVariables/ScalarVariable"):
        kind = next((child for child in item if child.tag != "Annotations"), None)
        if kind is None:
            raise ValueError(f'variable "{item.get("name")}" has no type')
        unit = kind.get("unit") or units.get(kind.get("declaredType", ""), "")
        found.append(_variable(item, kind.tag, unit, kind.get("start") is not None))
    return found


def _variables_3(root: ET.Element) -> list[FmuVariable]:
    types = root.iterfind("TypeDefinitions/Float64Type")
    units = {item.attrib["name"]: item.get("unit", "") for item in types}
    found = []
    for item in root.iterfind("ModelVariables/*"):
        unit = item.get("unit") or units.get(item.get("declaredType", ""), "")
        kind = item.tag if item.find("Dimension") is None else f"array of {item.tag}"
        found.append(_variable(item, kind, unit, item.get("start") is not None))
    return found


def _variable(item: ET.Element, kind: str, unit: str, starts: bool) -> FmuVariable:
    name, reference, causality = item.attrib["name"], int(item.attrib["valueReference"]), item.get("causality", "local")
    if not 0 <= reference < 2**32:
        raise ValueError(f'variable "{name}" has the valueReference {reference}')
    return FmuVariable(name, reference, kind, causality, unit, starts and item.get("variability") != "constant")


def _unit(element: ET.Element) -> FmuUnit:
    """A unit by its definition; NaN for the factor of one that has none."""
    base = element.find("BaseUnit")
    if base is None:
        return FmuUnit(float("nan"), 0.0, {})
    exponents = {BASE[name]: float(value) for name, value in base.attrib.items() if name in BASE and float(value)}
    factor, offset = float(base.get("factor", "1")), float(base.get("offset", "0"))
    if not (math.isfinite(factor) and math.isfinite(offset)) or factor == 0.0:
        raise ValueError(f'unit "{element.get("name")}" has the factor {factor:g} and the offset {offset:g}')
    return FmuUnit(factor, offset, exponents)
