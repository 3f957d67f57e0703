"""A finished diagnosis as files: report.json, report.html, plant.toml, tables and figures."""

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np

from workbench.diagnose.diagnose import Diagnosis
from workbench.diagnose.report import tables as diagnosis_tables
from workbench.diagnose.report.figures import pictures_of
from workbench.diagnose.report.names import REJECTED, listed, plain
from workbench.diagnose.report.page import Table, page
from workbench.diagnose.report.parameters import (
    Fitted,
    not_held,
    parameter_rows,
    parameters_of,
    plant_of,
)
from workbench.diagnose.report.words import sureness, verdict_sentence
from workbench.diagnose.residuals.unknowns import NEUTRAL
from workbench.parameters.corrected import Entry, parameter_file
from workbench.publish.folders import ResultFolder
from workbench.publish.pictures import save
from workbench.publish.style import figure_style
from workbench.publish.tables import write_frame

RESULT = "report.json"
PAGE = "report.html"
PLANT = "plant.toml"


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
    return "\n\n".join(
        [*parts, "\n".join(f"- {line}" for line in sureness(found)), f"plant.toml: {plant_words(found)}"]
    )


def plant_words(found: Diagnosis) -> str:
    """What plant.toml is."""
    model = plant_of(found)
    if found.report["verdict"] == REJECTED:
        return f"the plant as declared; a study names it with model = {model}"
    if lost := not_held(found):
        return f"the declared plant, fitted without effects, for model = {model}, which cannot hold {_names(lost)}"
    return f"the corrected plant; a study names it with model = {model}"


def plant_file(found: Diagnosis) -> str:
    """The corrected plant as a parameter file: what was fitted with its source, the rest as declared; all if rejected.

    The values of a fit belong together, and together they were tested: one that is not identified is written too, but
    without a deviation. Where the model cannot hold an effect, its plant was fitted without any: values that lack what
    was fitted beside them would be of no fit.
    """
    experiment, model, lost = found.experiment, plant_of(found), not_held(found)
    known, rows = parameters_of(model), parameter_rows(found)
    source = f"workbench diagnose: {experiment.title}; for model {model}"
    if found.report["verdict"] == REJECTED:
        title, fitted = "as declared: what was found was rejected on held-out records", {}
    elif lost:
        title = f"fitted by {experiment.path.name} without {_names(lost)}: not the corrected plant"
        source += f"; {model} cannot hold {_names(lost)}: the values are those of the fit without effects"
        fitted = {name: row.baseline for name, row in rows.items() if row.baseline is not None}
    else:
        title = f"corrected by {experiment.path.name}"
        fitted = {name: row.final for name, row in rows.items() if _acts(name, row.final.value)}
    entries = []
    for name in dict.fromkeys([*experiment.values, *(name for name in fitted if name in known)]):
        if name in fitted:
            entries.append(_entry(name, fitted[name], f"workbench diagnose, {experiment.path.name}"))
        else:
            entries.append(Entry(name, experiment.values[name], None, f"as declared: {experiment.declared}"))
    return parameter_file(f"{experiment.declared}, {title}", source, entries)


def _names(effects: list[str]) -> str:
    return listed([plain(name) for name in effects])


def _entry(name: str, one: Fitted, source: str) -> Entry:
    if one.doubt:
        return Entry(name, one.value, None, f"{source}: not identified, {one.doubt}; it goes with the other values")
    return Entry(name, one.value, one.std if math.isfinite(one.std) else None, source)


def _acts(name: str, value: float) -> bool:
    """Whether a value is not that at which an effect does nothing; a file cannot hold all of those."""
    return name not in NEUTRAL or value != NEUTRAL[name]
