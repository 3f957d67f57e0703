"""A finished identification as files: identified.json, identified.html, plant.toml, tables and figures."""

import json
from pathlib import Path

import pandas as pd

from plants.axis import unit_along
from workbench.identify.report.figures.every import figures_of
from workbench.identify.report.page import page
from workbench.identify.report.published import (
    SHOWN,
    published_notes,
    published_table,
    remark,
    scale_shown,
    unit_shown,
)
from workbench.identify.result import Corrected, Identification, IdentifiedParameter
from workbench.identify.thesis.records import ThesisFit
from workbench.parameters.corrected import Entry, parameter_file
from workbench.publish.contents import CONTENTS, Contents, write_contents
from workbench.publish.folders import ResultFolder
from workbench.publish.pictures import save
from workbench.publish.run_record import made_by
from workbench.publish.tables import Table, shown_interval, shown_number, write_frame
from workbench.publish.words import listed
from workbench.records.schema import CHANNELS, NUISANCES
from workbench.toml.units import factor

RESULT = "identified.json"
PLANT = "plant.toml"
PAGE = "identified.html"
FOLDER = ResultFolder("identification", (RESULT, PAGE, PLANT, "tables", "figures", CONTENTS))
claimed_folder = FOLDER.claimed
DIGITS = 4

STAYS = " and stays as declared"
TAKEN_FOR_RIGHT = (
    "Simulation: standard deviations are those of noise and sensors; they take for right what was declared without a "
    "deviation and not fitted."
)

LACKING = (
    "The plant lacks something that the records show, or the search did not find it: what stands under simulation fits "
    "best, is not what the machine has, and is in plant.toml without a deviation. workbench diagnose looks for what "
    "is missing"
)


def write_identification(identification: Identification, folder: Path) -> list[Path]:
    """Write everything, whole or not at all. Returns the Markdown tables' paths."""

    def write(beside: Path) -> list[Path]:
        return [path.relative_to(beside) for path in _write(identification, beside)]

    return [folder / path for path in FOLDER.write(folder, write)]


def _write(identification: Identification, folder: Path) -> list[Path]:
    """All files, into an empty folder."""
    experiment, thesis = identification.experiment, identification.thesis
    frame, notes = table_of(identification), notes_of(identification)
    figures, left_out = figures_of(identification)
    notes += [f"Figure {name} is left out: {why}." for name, why in left_out.items()]
    title = experiment.title
    if identification.refuted:
        title = f"Not identified: {identification.refuted}. {title}"
    tables = {"identified": Table(title, frame, notes)}
    for spec in experiment.published:
        if thesis is None:
            break
        beside = published_table(spec, thesis, experiment.truth, experiment.plant.axis)
        tables[spec.table] = Table(spec.title, beside, published_notes(spec, thesis))
    paths = [write_frame(name, table, folder / "tables")[1] for name, table in tables.items()]
    for name, figure in figures.items():
        save(figure, name, folder / "figures")
    write_contents(_contents(identification, [path.stem for path in paths], list(figures)), folder)
    if identification.corrected:
        (folder / PLANT).write_text(plant_file(identification), encoding="utf-8")
    html = page(identification, list(tables.values()), figures, folder)
    (folder / PAGE).write_text(html, encoding="utf-8")
    (folder / RESULT).write_text(json.dumps(identification.to_json(), indent=2) + "\n", encoding="utf-8")
    return paths


def _contents(identification: Identification, tables: list[str], figures: list[str]) -> Contents:
    experiment, refuted = identification.experiment, identification.refuted
    known = [name for name, entry in identification.corrected.items() if entry.std is not None]
    found = f"Identified, with a standard deviation: {listed(known)}." if known else ""
    if refuted:
        found = f"Not identified: {refuted}. {LACKING}."
    elif identification.thesis is not None and len(identification.thesis.groups) > 1:
        found = f"Friction at {len(identification.thesis.groups)} speeds of rotation, by the thesis's method."
    given = f"{PLANT} holds the plant with what was identified." if identification.corrected else ""
    return Contents(
        title=experiment.title,
        question=f"Which parameters of the plant {experiment.plant.name} do the records show?",
        answer=[line for line in (found, given) if line],
        notes=[f"Declared: {experiment.declared}.", *([f"Source: {experiment.source}."] * bool(experiment.source))],
        command=f"workbench identify {experiment.path.name}",
        tables=tables,
        figures=figures,
        details=[],
        provenance=made_by("workbench/identify"),
        file=experiment.path.name,
        text=experiment.path.read_text(encoding="utf-8"),
    )


def table_of(identification: Identification) -> pd.DataFrame:
    """parameter | thesis mean, std | simulation value, std, interval | truth | biases, as text ready to be shown.

    Where records differ in their speed of rotation: rpm | parameter | thesis mean, std, without a truth to hold it to.
    """
    if identification.thesis is not None and len(identification.thesis.groups) > 1:
        return _by_speed(identification.thesis, identification.experiment.plant.axis)
    lines = [_line(identification, name, parameter) for name, parameter in identification.parameters.items()]
    frame = pd.DataFrame(lines).fillna("")
    return frame.drop(columns=[name for name in frame.columns if not frame[name].any()])


def _by_speed(fit: ThesisFit, axis: str) -> pd.DataFrame:
    lines = []
    for rpm, group in fit.groups.items():
        for name, estimate in group.items():
            value, std = (
                shown_number(scale_shown(name, axis) * number, DIGITS) for number in (estimate.value, estimate.std)
            )
            line = {
                "rpm": f"{rpm:g}",
                "parameter": name,
                "unit": unit_shown(name, axis),
                "thesis": value,
                "thesis std": std,
            }
            lines.append({**line, "remark": remark(estimate)})
    frame = pd.DataFrame(lines).replace("nan", "")
    return frame.drop(columns=[name for name in ("remark",) if not frame[name].any()])


def _line(identification: Identification, name: str, parameter: IdentifiedParameter) -> dict[str, str]:
    unit = SHOWN.get(parameter.unit, parameter.unit)
    scale, truth = factor(parameter.unit, unit), parameter.truth
    thesis, simulation = parameter.thesis, parameter.simulation

    def shown(number: float | None) -> str:
        return "" if number is None or number != number else shown_number(scale * number, DIGITS)

    line = {"parameter": name, "unit": unit, "declared": shown(parameter.declared)}
    if identification.thesis is not None and name in identification.thesis.unidentified:
        line |= {"thesis": "not identified"}
        thesis = None
    elif thesis is not None:
        line |= {"thesis": shown(thesis.value), "thesis std": shown(thesis.std_of_repeats)}
    if parameter.bound is not None:
        line |= {"simulation": f"{shown(parameter.bound)}, at its bound"}
        simulation = None
    elif simulation is not None and parameter.refuted:
        line |= {"simulation": f"{shown(simulation.value)}, not identified"}
    elif simulation is not None:
        line |= {
            "simulation": shown(simulation.value),
            "simulation std": shown(simulation.std),
            "95 % interval": ""
            if simulation.low is None or simulation.high is None
            else shown_interval(scale * simulation.low, scale * simulation.high, DIGITS),
        }
    elif identification.simulation is not None and name in identification.simulation.unidentified:
        line |= {"simulation": "not identified"}
    if truth:
        line["truth"] = shown(truth)
        for method, fitted in (("thesis", thesis), ("simulation", simulation)):
            if fitted is not None:
                line[f"{method} bias (%)"] = f"{100.0 * (fitted.value / truth - 1.0):+.2f}"
        if simulation is not None and simulation.std:
            line["simulation bias / std"] = f"{(simulation.value - truth) / simulation.std:+.2f}"
    return line


def notes_of(identification: Identification) -> list[str]:
    """What a reader of the table must know."""
    fit = identification.simulation
    notes = [f"{LACKING}."] * bool(identification.refuted)
    for record in identification.records:
        notes += [f"{record.name}, {record.path.name}: {note}." for note in record.notes]
    if identification.thesis is not None:
        count = max(estimate.count for group in identification.thesis.groups.values() for estimate in group.values())
        repeats = (
            f"mean and standard deviation over {count} records" if count > 1 else "of one record: without a deviation"
        )
        notes.append(f"Thesis's method: {repeats}.")
        notes += [f"{note}." for note in identification.thesis.notes]
        notes += [
            f"{name} is not identified by the thesis's method{STAYS * (fit is None)}: {why}."
            for name, why in identification.thesis.unidentified.items()
        ]
    if fit is not None:
        if not fit.refuted:
            notes.append(TAKEN_FOR_RIGHT)
        notes += [f"{name} is {why}, and has no deviation there." for name, (_, why) in fit.bounded.items()]
        notes += [
            f"{name} cannot be identified from these records and stays as declared: {why}."
            for name, why in fit.unidentified.items()
        ]
        for name, before in fit.before.items():
            unit = unit_along(CHANNELS[name], identification.experiment.plant.axis)
            shown = SHOWN.get(unit, unit)
            values = [shown_number(factor(unit, shown) * value, 3) for value in (before, fit.rms[name])]
            notes.append(f"{name}, simulated against measured: {values[0]} {shown} rms as declared, {values[1]} after.")
        for name, sensor in fit.sensors.items():
            unit = unit_along(NUISANCES[name], identification.experiment.plant.axis)
            shown = SHOWN.get(unit, unit)
            true = identification.experiment.true_sensors.get(name)
            told = {"": sensor.value, "std ": sensor.std, "truth ": true}
            value, *others = [
                f"{what}{shown_number(factor(unit, shown) * number, 3)}"
                for what, number in told.items()
                if number is not None
            ]
            brackets = f" ({'; '.join(others)})" if others else ""
            notes.append(f"{name}: {value}{brackets} {'as a share' if shown == '1' else shown}.")
        notes += [f"{note}." for note in fit.notes]
    return notes


def plant_file(identification: Identification) -> str:
    """The corrected plant as a parameter file: what was identified, with its std; the rest as declared."""
    experiment, corrected = identification.experiment, identification.corrected
    entries = []
    for name, value in identification.values.items():
        entry = corrected.get(name, Corrected(value, None, experiment.source_of(name)))
        entries.append(Entry(name, value, entry.std, entry.source))
    title = f"{experiment.declared}, corrected by {experiment.path.name}"
    return parameter_file(title, f"workbench identify: {experiment.title}", entries, experiment.plant.axis)
