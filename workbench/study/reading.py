"""Reading a study file, with the machines and scenarios that it names."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from workbench.errors import nearest
from workbench.study.layers import LAYERS, Layer
from workbench.study.schema import OVERRIDES, StudyFile
from workbench.study.sections import file_model
from workbench.study.study import Study
from workbench.toml import reading as files


def read_study(path: Path, allow_fmu: bool | None = None) -> Study:
    """Read and check a study file (not yet its cases); whoever runs it says whether FMUs may be run.

    Raises:
        UserError: unreadable, not TOML, unknown or missing keys.
    """
    return replace(study_of(*files.read_toml(path), path), allow_fmu=allow_fmu)


def study_of(data: Mapping[str, object], text: str, path: Path) -> Study:
    """The study with this content, checked as that of a file (not yet its cases).

    `path` is where it stands, or would: what it names is looked for beside it. `text` is what the file holds, by whose
    lines mistakes are told; "" of a study that was never written.

    Raises:
        UserError: unknown or missing keys.
    """
    study = Study(path, text, files.validate(file_model(data), data, path, text))
    file = study.file
    sections = [layer.section for layer in LAYERS.values()]
    for section in ("cases", *sections):
        for name, overrides in getattr(file, section).items():
            allowed = [key for key in OVERRIDES if not (section in sections and key == "axes")]
            for key in overrides:
                if key not in allowed:
                    raise study.error((section, name, key), f"unknown key; {nearest(key, allowed)}")
    for layer in LAYERS.values():
        wanted = [name for name in _named_on(file, layer.axis) if name not in getattr(file, layer.section)]
        beside = layer.files(path.parent) if wanted else {}
        study = with_files(study, layer, {name: beside[name] for name in wanted if name in beside})
    return study


def _named_on(file: StudyFile, axis: str) -> list[str]:
    """What all axes of that name say, in whatever shape they are."""
    tables = [file.axes, *(overrides.get("axes") for overrides in file.cases.values())]
    lists = [table.get(axis) for table in tables if isinstance(table, dict)]
    return [value for values in lists if isinstance(values, list) for value in values if isinstance(value, str)]


def with_files(study: Study, layer: Layer, paths: Mapping[str, Path]) -> Study:
    """The study with the machines or scenarios of these files, by name, beside its own."""
    known, sources = dict(getattr(study.file, layer.section)), dict(study.sources)
    for name, path in paths.items():
        content, text = layer.read(path)
        known[name], sources[layer.section, name] = content.overrides, (path, text)
    return replace(study, file=study.file.model_copy(update={layer.section: known}), sources=sources)


def layer_trial(layer: Layer, path: Path) -> Study:
    """A study of one case that takes the machine or scenario at `path`: what it would do to the thesis's actuator.

    Raises:
        UserError: unreadable, not TOML, unknown or missing keys.
    """
    content = {
        "title": path.stem,
        "plant": {"model": "non_rotating", "parameters": "owen2001_simulation"},
        "controllers": {"p": {"type": "pid", "kp": "500 V/m"}},
        "references": {"step": {"kind": "steps", "levels": ["5 mm"], "dwell": "1 s"}},
        "simulation": {"duration": "1 s"},
        "axes": {layer.axis: [path.stem]},
    }
    beside = path.resolve().parent.parent / path.name  # where a study that names it stands
    return with_files(Study(beside, "", StudyFile.model_validate(content)), layer, {path.stem: path})
