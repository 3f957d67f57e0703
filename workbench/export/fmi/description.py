"""modelDescription.xml of an FMU, in the form of FMI 2.0 or 3.0."""

from collections.abc import Sequence
from dataclasses import dataclass
from xml.etree import ElementTree as ET

from workbench.export.fmi.units import unit_definitions
from workbench.export.fmi.variables import Variable

CAN = {2: ("canGetAndSetFMUstate", "canSerializeFMUstate"), 3: ("canGetAndSetFMUState", "canSerializeFMUState")}


@dataclass(frozen=True)
class Model:
    """What a description tells beside the variables. `identifier` names the binary; times in s."""

    name: str
    identifier: str
    description: str
    tool: str
    duration: float
    sample_time: float
    tolerance: float
    sources: tuple[str, ...]


def description(fmi: int, model: Model, variables: Sequence[Variable], token: str) -> bytes:
    """The file; `token` is what ties it to the binary."""
    root = ET.Element(
        "fmiModelDescription",
        {
            "fmiVersion": f"{fmi}.0",
            "modelName": model.name,
            "guid" if fmi == 2 else "instantiationToken": token,
            "description": model.description,
            "generationTool": model.tool,
            "variableNamingConvention": "flat",
            **({"numberOfEventIndicators": "0"} if fmi == 2 else {}),
        },
    )
    can = dict.fromkeys(CAN[fmi], "true")
    exchange = {"modelIdentifier": model.identifier, **can}
    if fmi == 2:
        exchange["completedIntegratorStepNotNeeded"] = "true"
    own = {"modelIdentifier": model.identifier, "canHandleVariableCommunicationStepSize": "true", **can}
    for kind, attributes in (("ModelExchange", exchange), ("CoSimulation", own)):
        interface = ET.SubElement(root, kind, attributes)
        if fmi == 2:
            files = ET.SubElement(interface, "SourceFiles")
            for source in model.sources:
                ET.SubElement(files, "File", name=source)
    root.append(unit_definitions(sorted({item.unit for item in variables} - {"1"})))
    categories = ET.SubElement(root, "LogCategories")
    ET.SubElement(categories, "Category", name="logStatusError", description="why a call failed")
    ET.SubElement(
        root,
        "DefaultExperiment",
        startTime="0",
        stopTime=_real(model.duration),
        tolerance=_real(model.tolerance),
        stepSize=_real(model.sample_time),
    )
    listed = ET.SubElement(root, "ModelVariables")
    for item in variables:
        listed.append(_variable_2(item) if fmi == 2 else _variable_3(item))
    root.append(_structure(fmi, variables))
    return written(root)


def build_description(model: Model) -> bytes:
    """sources/buildDescription.xml of FMI 3.0: what is to be compiled."""
    root = ET.Element("fmiBuildDescription", fmiVersion="3.0")
    configuration = ET.SubElement(root, "BuildConfiguration", modelIdentifier=model.identifier)
    files = ET.SubElement(configuration, "SourceFileSet", language="C99")
    for source in model.sources:
        ET.SubElement(files, "SourceFile", name=source)
    return written(root)


def written(root: ET.Element) -> bytes:
    """An XML file."""
    ET.indent(root)
    return ET.tostring(root, encoding="UTF-8", xml_declaration=True) + b"\n"


def _real(value: float) -> str:
    """A number as XML spells it."""
    return repr(value).replace("inf", "INF")


def _attributes(item: Variable) -> dict[str, str]:
    attributes = {"name": item.name, "valueReference": str(item.reference), "description": item.description}
    attributes["causality"] = item.causality
    attributes["variability"] = "tunable" if item.causality == "parameter" else "continuous"
    if item.causality in ("output", "local", "parameter"):
        attributes["initial"] = "calculated" if item.start is None else "exact"
    return attributes


def _number(item: Variable) -> dict[str, str]:
    number = {} if item.unit == "1" else {"unit": item.unit}
    if item.nominal is not None:
        number["nominal"] = _real(item.nominal)
    if item.start is not None:
        number["start"] = _real(item.start)
    return number


def _variable_2(item: Variable) -> ET.Element:
    element = ET.Element("ScalarVariable", _attributes(item))
    number = ET.SubElement(element, "Real", _number(item))
    if item.derivative_of is not None:
        number.set("derivative", _place(item.derivative_of))
    return element


def _variable_3(item: Variable) -> ET.Element:
    element = ET.Element("Float64", _attributes(item) | _number(item))
    if item.derivative_of is not None:
        element.set("derivative", str(item.derivative_of))
    return element


def _place(reference: int) -> str:
    """The index of a variable in FMI 2.0's list, which begins with 1, and where time has the reference 0."""
    return str(reference + 1)


def _structure(fmi: int, variables: Sequence[Variable]) -> ET.Element:
    structure = ET.Element("ModelStructure")
    outputs = [item for item in variables if item.causality == "output"]
    rates = [item for item in variables if item.derivative_of is not None]
    initial = [item for item in (*outputs, *rates) if item.start is None]
    lists = (("Outputs", "Output", outputs), ("Derivatives", "ContinuousStateDerivative", rates))
    for kind_2, kind_3, items in (*lists, ("InitialUnknowns", "InitialUnknown", initial)):
        parent = ET.SubElement(structure, kind_2) if fmi == 2 else structure
        for item in items:
            if fmi == 2:
                unknown = ET.SubElement(parent, "Unknown", index=_place(item.reference))
            else:
                unknown = ET.SubElement(parent, kind_3, valueReference=str(item.reference))
            if kind_2 != "InitialUnknowns":
                on = item.depends or ()
                unknown.set("dependencies", " ".join(_place(place) if fmi == 2 else str(place) for place in on))
    return structure
