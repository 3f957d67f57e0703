"""A finished diagnosis as files: report.json, report.html, plant.toml, tables and figures."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from plants.equation import fields
from plants.registry import PLANTS
from workbench.diagnose.diagnose import Diagnosis
from workbench.diagnose.unknowns import NEUTRAL
from workbench.folders import ResultFolder
from workbench.parameters import FLOW_SHARE
from workbench.report import diagnosis_tables
from workbench.report.diagnosis_figures import pictures_of
from workbench.report.diagnosis_page import Table, page
from workbench.report.diagnosis_words import REJECTED, plain, sureness, verdict_sentence
from workbench.report.figures import save
from workbench.report.parameter_file import Entry, parameter_file
from workbench.report.style import figure_style
from workbench.report.tables import write_frame

RESULT = "report.json"
PAGE = "report.html"
PLANT = "plant.toml"

HYDRAULIC = "non_rotating"
RICHER = "two_chamber"
"""The plant that holds what a diagnosis of a hydraulic actuator may find."""


def _is_diagnosis(path: Path) -> bool:
    try:
        return "verdict" in json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False


FOLDER = ResultFolder("diagnosis", (RESULT, PAGE, PLANT, "tables", "figures"), _is_diagnosis)
check_folder = FOLDER.check


def write_diagnosis(found: Diagnosis, folder: Path) -> None:
    """Write everything. Whenever this is stopped, report.json is whole or is not there."""
    FOLDER.write(folder, lambda beside: _write(found, beside))


def _write(found: Diagnosis, folder: Path) -> None:
    tables, pictures = tables_of(found), pictures_of(found)
    notes = [verdict_sentence(found)]
    for name, table in tables.items():
        write_frame(name, table.title, table.cells, notes, folder / "tables")
    for name, picture in pictures.items():
        with figure_style():
            picture.figure.draw_without_rendering()
            picture.figure.set_layout_engine("none")  # the same places in every format, and laid out once
        save(picture.figure, name, folder / "figures")
    (folder / PLANT).write_text(plant_file(found), encoding="utf-8")
    (folder / PAGE).write_text(page(found, pictures, tables, plant_words(found)), encoding="utf-8")
    (folder / RESULT).write_text(json.dumps(_plain(found.report), indent=2, allow_nan=False) + "\n", encoding="utf-8")


def _plain(data: Any) -> Any:
    """Data as JSON holds it: no NumPy scalars, null in the place of what is not finite."""
    if isinstance(data, Mapping):
        return {str(key): _plain(value) for key, value in data.items()}
    if isinstance(data, list | tuple):
        return [_plain(value) for value in data]
    if isinstance(data, np.generic):
        data = data.item()
    return None if isinstance(data, float) and not math.isfinite(data) else data


def tables_of(found: Diagnosis) -> dict[str, Table]:
    """Tables by name; none that is empty."""
    rejected = found.report["verdict"] == REJECTED
    tables = {
        "effects": Table(
            f"Effects that were {'rejected' if rejected else 'found'}", diagnosis_tables.effects_table(found)
        ),
        "error": Table("Error before and after", diagnosis_tables.error_table(found)),
        "parameters": Table("Parameters, declared and fitted", diagnosis_tables.parameter_table(found)),
        "evidence": Table("Every candidate of every round", diagnosis_tables.evidence_table(found)),
    }
    return {name: table for name, table in tables.items() if not table.cells.empty}


def summary(found: Diagnosis) -> str:
    """The verdict, the effects and the error before and after, for a terminal."""
    tables = tables_of(found)
    parts = [found.experiment.title, verdict_sentence(found)]
    chosen = [tables[name].cells for name in ("effects", "error") if name in tables]
    parts += [cells.to_markdown(index=False, disable_numparse=True) for cells in chosen]
    return "\n\n".join([*parts, "\n".join(f"- {line}" for line in sureness(found))])


def plant_of(found: Diagnosis) -> str:
    """The model that the corrected plant is for."""
    return RICHER if found.experiment.plant.name == HYDRAULIC else found.experiment.plant.name


def plant_words(found: Diagnosis) -> str:
    """What plant.toml is."""
    if found.report["verdict"] == REJECTED:
        return f"the plant as declared; a study names it with model = {plant_of(found)}"
    return f"the corrected plant; a study names it with model = {plant_of(found)}"


def plant_file(found: Diagnosis) -> str:
    """The corrected plant as a parameter file: what was fitted with its std, the rest as declared; all if rejected."""
    experiment, model = found.experiment, plant_of(found)
    known = {item.name for item in fields(PLANTS.working()[model].Parameters)} - {FLOW_SHARE}
    lost: list[str] = []
    if found.report["verdict"] == REJECTED:
        title, fitted = "as declared: what was found was rejected on held-out records", {}
    else:
        fitted = {name: one for name, one in _fitted(found).items() if _acts(name, one[0])}
        title = f"corrected by {experiment.path.name}"
        lost = [one.name for one in found.found if not set(one.numbers) <= known]
    source = f"workbench diagnose: {experiment.title}; for model {model}"
    if lost:
        source += f"; {model} cannot hold {', '.join(map(plain, lost))}"
    entries = []
    for name in dict.fromkeys([*experiment.values, *(name for name in fitted if name in known)]):
        value, std = fitted.get(name, (experiment.values.get(name, 0.0), None))
        where = f"as declared: {experiment.declared}" if std is None else f"workbench diagnose, {experiment.path.name}"
        entries.append(Entry(name, value, std if std is not None and math.isfinite(std) else None, where))
    return parameter_file(f"{experiment.declared}, {title}", source, entries)


def _fitted(found: Diagnosis) -> dict[str, tuple[float, float | None]]:
    """Every parameter that was fitted: value and standard deviation (SI)."""
    numbers: dict[str, tuple[float, float | None]] = {}
    for one in found.found:
        numbers |= one.numbers
    for result in found.fits:
        numbers |= {name: (result.after.values[name], result.after.deviations[name]) for name in result.after.names}
    return numbers


def _acts(name: str, value: float) -> bool:
    """Whether a value is not that at which an effect does nothing; a file cannot hold all of those."""
    return name not in NEUTRAL or value != NEUTRAL[name]
