"""A finished diagnosis as files: report.json, report.html, plant.toml, tables and figures."""

import json
import math
from pathlib import Path

from workbench.diagnose.report import tables as diagnosis_tables
from workbench.diagnose.report.figures.every import pictures_of
from workbench.diagnose.report.names import listed_names
from workbench.diagnose.report.offered import offered_entries
from workbench.diagnose.report.page import page
from workbench.diagnose.report.parameters import (
    not_held,
    parameter_rows,
    parameters_of,
    plant_of,
)
from workbench.diagnose.report.sureness import sureness
from workbench.diagnose.report.verdict import verdict_sentence
from workbench.diagnose.result import Diagnosis, FittedParameter
from workbench.parameters.corrected import Entry, parameter_file
from workbench.parameters.sets import NEUTRAL
from workbench.publish.contents import CONTENTS, Contents, write_contents
from workbench.publish.folders import ResultFolder
from workbench.publish.pictures import save_all
from workbench.publish.run_record import made_by
from workbench.publish.tables import Table, write_frame

RESULT = "report.json"
PAGE = "report.html"
PLANT = "plant.toml"


def _is_diagnosis(path: Path) -> bool:
    try:
        return "verdict" in json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False


FOLDER = ResultFolder("diagnosis", (RESULT, PAGE, PLANT, "tables", "figures", CONTENTS), _is_diagnosis)
claimed_folder = FOLDER.claimed


def write_diagnosis(diagnosis: Diagnosis, folder: Path) -> None:
    """Write everything. Whenever this is stopped, report.json is whole or is not there."""
    FOLDER.write(folder, lambda beside: _write(diagnosis, beside))


def _write(diagnosis: Diagnosis, folder: Path) -> None:
    tables, pictures = tables_of(diagnosis), pictures_of(diagnosis)
    notes = [verdict_sentence(diagnosis)]
    for name, table in tables.items():
        write_frame(name, Table(table.title, table.cells, notes), folder / "tables")
    save_all(pictures, folder / "figures")
    experiment = diagnosis.experiment
    contents = Contents(
        title=experiment.title,
        question=f"What does the plant {experiment.plant.name} lack, by its records?",
        answer=[*notes, f"{PLANT} is {plant_words(diagnosis)}."],
        notes=[f"Declared: {experiment.declared}.", *sureness(diagnosis)],
        command=f"workbench diagnose {experiment.path.name}",
        tables=list(tables),
        figures=list(pictures),
        details=[],
        provenance=made_by("workbench/diagnose"),
        file=experiment.path.name,
        text=experiment.path.read_text(encoding="utf-8"),
    )
    write_contents(contents, folder)
    (folder / PLANT).write_text(plant_file(diagnosis), encoding="utf-8")
    html = page(diagnosis, pictures, tables, plant_words(diagnosis), folder)
    (folder / PAGE).write_text(html, encoding="utf-8")
    (folder / RESULT).write_text(json.dumps(diagnosis.to_json(), indent=2, allow_nan=False) + "\n", encoding="utf-8")


def tables_of(diagnosis: Diagnosis) -> dict[str, Table]:
    """Tables by name; none that is empty."""
    rejected = diagnosis.is_rejected
    tables = {
        "effects": Table(
            f"Effects that were {'rejected' if rejected else 'found'}", diagnosis_tables.effects_table(diagnosis)
        ),
        "error": Table("Error before and after", diagnosis_tables.error_table(diagnosis)),
        "parameters": Table("Parameters, declared and fitted", diagnosis_tables.parameter_table(diagnosis)),
        "evidence": Table("Every candidate of every round", diagnosis_tables.evidence_table(diagnosis)),
    }
    return {name: table for name, table in tables.items() if not table.cells.empty}


def summary(diagnosis: Diagnosis) -> str:
    """The verdict, the effects and the error before and after, for a terminal."""
    tables = tables_of(diagnosis)
    parts = [diagnosis.experiment.title, verdict_sentence(diagnosis)]
    chosen = [tables[name].cells for name in ("effects", "error") if name in tables]
    parts += [cells.to_markdown(index=False, disable_numparse=True) for cells in chosen]
    return "\n\n".join(
        [*parts, "\n".join(f"- {line}" for line in sureness(diagnosis)), f"plant.toml: {plant_words(diagnosis)}"]
    )


def plant_words(diagnosis: Diagnosis) -> str:
    """What plant.toml is."""
    model = plant_of(diagnosis).name
    if diagnosis.is_rejected:
        return f"the plant as declared; a study names it with model = {model}"
    if lost := not_held(diagnosis):
        return (
            f"the declared plant, fitted without effects, for model = {model}, which cannot hold {listed_names(lost)}"
        )
    named = f"a study names it with model = {model}"
    curve = ""
    if diagnosis.simulation is not None and diagnosis.simulation.curved is not None:
        curve = " go with the curve for what no known effect explains: it is off"
    if diagnosis.effects:
        return f"the corrected plant{', whose parameters' + curve if curve else ''}; {named}"
    lacks = "; it lacks what no known effect explains" if diagnosis.unexplained is not None else ""
    lacks = f", which{curve}" if curve else lacks
    return f"the declared plant with its own parameters fitted{lacks}; {named}"


def plant_file(diagnosis: Diagnosis) -> str:
    """The corrected plant as a parameter file: what was fitted with its source, the rest as declared; all if rejected.

    The values of a fit belong together, and together they were tested: one that is not identified is written too, but
    without a deviation. Where the model cannot hold an effect, its plant was fitted without any: values that lack what
    was fitted beside them would be of no fit.
    """
    experiment, plant, lost = diagnosis.experiment, plant_of(diagnosis), not_held(diagnosis)
    known, rows, model = parameters_of(plant), parameter_rows(diagnosis), plant.name
    source = f"workbench diagnose: {experiment.title}; for model {model}"
    if diagnosis.is_rejected:
        title, fitted = "as declared: what was found was rejected on held-out records", {}
    elif lost:
        title = f"fitted by {experiment.path.name} without {listed_names(lost)}: not the corrected plant"
        source += f"; {model} cannot hold {listed_names(lost)}: the values are those of the fit without effects"
        fitted = {name: row.baseline for name, row in rows.items() if row.baseline is not None}
    else:
        title = f"{'corrected' if diagnosis.effects else 'fitted'} by {experiment.path.name}"
        if diagnosis.unexplained is not None:
            source += "; something is missing that no effect explains, and no deviation here counts what it moves"
        fitted = {name: row.final for name, row in rows.items() if _acts(name, row.final.value)}
    entries = []
    for name in dict.fromkeys([*experiment.values, *(name for name in fitted if name in known)]):
        if name in fitted:
            entries.append(_entry(name, fitted[name], f"workbench diagnose, {experiment.path.name}"))
        else:
            entries.append(Entry(name, experiment.values[name], None, experiment.source_of(name)))
    if not diagnosis.is_rejected and not lost:
        written_by = f"workbench diagnose, {experiment.path.name}"
        offered = offered_entries(diagnosis.unexplained, plant, experiment.values, written_by)
        entries = [*(entry for entry in entries if entry.name not in {each.name for each in offered}), *offered]
    return parameter_file(f"{experiment.declared}, {title}", source, entries, experiment.plant.axis)


def _entry(name: str, fitted: FittedParameter, source: str) -> Entry:
    if fitted.doubt:
        return Entry(
            name, fitted.value, None, f"{source}: not identified, {fitted.doubt}; it goes with the other values"
        )
    return Entry(name, fitted.value, fitted.std if math.isfinite(fitted.std) else None, source)


def _acts(name: str, value: float) -> bool:
    """Whether a value is not that at which an effect does nothing; a file cannot hold all of those."""
    return name not in NEUTRAL or value != NEUTRAL[name]
