"""A plant as an FMU: one archive of its description, its sources and a binary for this platform."""

import hashlib
import io
import re
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from importlib.metadata import version
from importlib.resources import files

from workbench.export.fmi.compiling import compiled, why_not
from workbench.export.fmi.description import Model, build_description, description
from workbench.export.fmi.equations import equations_of
from workbench.export.fmi.model_header import model_header
from workbench.export.fmi.variables import variables_of
from workbench.fmu.platforms import binary_place
from workbench.simulation.setup import Setup

VERSIONS = (2, 3)

DATE = (1980, 1, 1, 0, 0, 0)
"""Of every file in the archive, so that the same plant gives the same bytes."""


@dataclass(frozen=True)
class Exported:
    """An FMU's bytes; `lacking` says why it has no binary, "" where it has one."""

    archive: bytes
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    parameters: int
    lacking: str


def exported(setup: Setup, fmi: int, title: str) -> Exported:
    """The plant of `setup`, with its effects, parameters and start, as an FMU of version `fmi` (2 or 3).

    Raises:
        UserError: gcc cannot compile it.
    """
    plant = setup.plant
    equations = equations_of(plant)
    variables = variables_of(setup, equations)
    compiled_files = ("machine.c", "plant.c", f"fmi{fmi}.c")
    model = Model(
        plant.name,
        re.sub(r"\W", "_", plant.name),
        title,
        f"Friction Workbench {version('friction-workbench')}",
        setup.duration,
        setup.sample_time,
        setup.integrator.tolerance,
        compiled_files,
    )
    folder = files("workbench.export.fmi") / "sources"
    sources = {name: (folder / name).read_bytes() for name in ("machine.h", "machine.c", f"fmi{fmi}.h", f"fmi{fmi}.c")}
    sources["plant.c"] = equations.code.encode()
    token = _token(
        [model_header(setup, equations, "").encode(), *sources.values(), description(fmi, model, variables, "")]
    )
    sources["model.h"] = model_header(setup, equations, token).encode()
    content = {"modelDescription.xml": description(fmi, model, variables, token)}
    if not (lacking := why_not()):
        content[binary_place(fmi, model.identifier)] = compiled(sources)
    content |= {f"sources/{name}": sources[name] for name in sorted(sources)}
    if fmi == 3:
        content["sources/buildDescription.xml"] = build_description(model)
    named = {kind: tuple(item.name for item in variables if item.causality == kind) for kind in ("input", "output")}
    states = tuple(item.name for item in variables if item.causality == "output" and item.start is not None)
    parameters = sum(item.causality == "parameter" for item in variables)
    outputs = tuple(name for name in named["output"] if name not in states)
    return Exported(archive_of(content), states, named["input"], outputs, parameters, lacking)


def _token(parts: list[bytes]) -> str:
    """A hash of all that makes the FMU, in the form of a GUID."""
    digest = hashlib.sha256(b"\0".join(parts)).hexdigest()
    return "{" + "-".join((digest[:8], digest[8:12], digest[12:16], digest[16:20], digest[20:32])) + "}"


def archive_of(content: Mapping[str, bytes]) -> bytes:
    """A zip archive of files by their places in it: the same content gives the same bytes."""
    buffer = io.BytesIO()
    with zipfile.ZipFile(buffer, "w") as archive:
        for place, data in content.items():
            info = zipfile.ZipInfo(place, DATE)
            info.compress_type = zipfile.ZIP_DEFLATED
            info.external_attr = 0o644 << 16
            archive.writestr(info, data)
    return buffer.getvalue()
