"""A finished identification as files: identified.json, plant.toml, tables and figures."""

import json
import os
import shutil
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from workbench.errors import UserError
from workbench.identify.friction_records import ThesisFit
from workbench.identify.identification import Identification, as_data
from workbench.parameters import UNBOUNDED, known_units
from workbench.report.figures import save
from workbench.report.identification_figures import correlation_figure, record_figures, requested_figures
from workbench.report.identification_published import SHOWN, published_notes, published_table, scale_shown, unit_shown
from workbench.report.tables import shown_number, write_frame
from workbench.units import factor

RESULT = "identified.json"
PLANT = "plant.toml"
WRITTEN = (RESULT, PLANT, "tables", "figures")
DIGITS = 4


def check_folder(folder: Path, overwrite: bool) -> None:
    """Whether an identification may be written there; nothing is changed.

    Raises:
        UserError: it holds one, or files of the same names that no identification wrote.
    """
    ours = (folder / RESULT).exists()
    if ours and not overwrite:
        raise UserError(f"{folder}: holds an identification already; replace it with --overwrite")
    foreign = [name for name in WRITTEN if (folder / name).exists()]
    if foreign and not ours:
        raise UserError(f"{folder}: holds {', '.join(foreign)} that no identification wrote; choose another --out")


def _clear(folder: Path) -> None:
    """Make the folder, empty of an earlier identification."""
    for name in WRITTEN:
        path = folder / name
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
    folder.mkdir(parents=True, exist_ok=True)


def write_identification(found: Identification, folder: Path) -> list[Path]:
    """Write everything; identified.json, which marks it as whole, last. Returns the Markdown tables' paths."""
    experiment, thesis = found.experiment, found.thesis
    frame, notes = table_of(found), notes_of(found)
    figures = {**requested_figures(found), **record_figures(found)}
    if found.simulation is not None and len(found.simulation.estimates) > 1:
        figures["correlation"] = correlation_figure(found.simulation)
    _clear(folder)
    paths = [write_frame("identified", experiment.title, frame, notes, folder / "tables")[1]]
    for spec in experiment.published:
        if thesis is None:
            break
        beside, notes = published_table(spec, thesis, experiment.truth), published_notes(spec, thesis)
        paths.append(write_frame(spec.table, spec.title, beside, notes, folder / "tables")[1])
    for name, figure in figures.items():
        save(figure, name, folder / "figures")
    if found.corrected:
        (folder / PLANT).write_text(plant_file(found), encoding="utf-8")
    temporary = folder / f".{RESULT}.part"
    temporary.write_text(json.dumps(as_data(found), indent=2) + "\n", encoding="utf-8")
    os.replace(temporary, folder / RESULT)
    return paths


def table_of(found: Identification) -> pd.DataFrame:
    """parameter | thesis mean, std | simulation value, std, interval | truth | biases, as text ready to be shown.

    Where records differ in their speed of rotation: rpm | parameter | thesis mean, std, without a truth to hold it to.
    """
    if found.thesis is not None and len(found.thesis.groups) > 1:
        return _by_speed(found.thesis)
    data = as_data(found)["parameters"]
    lines = [_line(found, name, entry) for name, entry in data.items()]
    frame = pd.DataFrame(lines).fillna("")
    return frame.drop(columns=[name for name in frame.columns if not frame[name].any()])


def _by_speed(fit: ThesisFit) -> pd.DataFrame:
    lines = []
    for rpm, group in fit.groups.items():
        for name, one in group.items():
            value, std = (shown_number(scale_shown(name) * number, DIGITS) for number in (one.value, one.std))
            lines.append(
                {"rpm": f"{rpm:g}", "parameter": name, "unit": unit_shown(name), "thesis": value, "thesis std": std}
            )
    return pd.DataFrame(lines).replace("nan", "")


def _line(found: Identification, name: str, entry: Mapping[str, Any]) -> dict[str, str]:
    unit = SHOWN.get(entry["unit"], entry["unit"])
    scale = factor(entry["unit"], unit)
    truth = entry.get("truth")

    def shown(number: float | None) -> str:
        return "" if number is None or number != number else shown_number(scale * number, DIGITS)

    line = {"parameter": name, "unit": unit, "declared": shown(entry["declared"])}
    if thesis := entry.get("thesis"):
        line |= {"thesis": shown(thesis["mean"]), "thesis std": shown(thesis["std"])}
    if simulation := entry.get("simulation"):
        line |= {
            "simulation": shown(simulation["value"]),
            "simulation std": shown(simulation["std"]),
            "95 % interval": f"{shown(simulation['low'])} to {shown(simulation['high'])}",
        }
    elif found.simulation is not None and name in found.simulation.unidentified:
        line |= {"simulation": "not identified"}
    if truth:
        line["truth"] = shown(truth)
        for method, key in (("thesis", "mean"), ("simulation", "value")):
            if value := entry.get(method):
                line[f"{method} bias (%)"] = f"{100.0 * (value[key] / truth - 1.0):+.2f}"
        if simulation and simulation["std"]:
            line["bias / std"] = f"{(simulation['value'] - truth) / simulation['std']:+.2f}"
    return line


def notes_of(found: Identification) -> list[str]:
    """What a reader of the table must know."""
    notes = []
    for record in found.records:
        notes += [f"{record.label}, {record.path.name}: {note}." for note in record.notes]
    if found.thesis is not None:
        count = max(one.count for group in found.thesis.groups.values() for one in group.values())
        notes.append(f"Thesis's method: mean and standard deviation over {count} repeats.")
        notes += [f"{note}." for note in found.thesis.notes]
    fit = found.simulation
    if fit is not None:
        notes += [
            f"{name} cannot be identified from these records and stays as declared: {why}."
            for name, why in fit.unidentified.items()
        ]
        for name, before in fit.before.items():
            unit = "m" if name == "position" else "Pa" if name.startswith("pressure") else "rad/s"
            shown = SHOWN.get(unit, unit)
            values = [shown_number(factor(unit, shown) * value, 3) for value in (before, fit.rms[name])]
            notes.append(f"{name}, simulated against measured: {values[0]} {shown} rms as declared, {values[1]} after.")
        for name, one in fit.sensors.items():
            unit = "Pa" if name.endswith("offset") else "1"
            shown = SHOWN.get(unit, unit)
            texts = [shown_number(factor(unit, shown) * value, 3) for value in (one.value, one.std)]
            notes.append(f"{name}: {texts[0]} (std {texts[1]}){'' if shown == '1' else f' {shown}'}.")
    return notes


def plant_file(found: Identification) -> str:
    """The corrected plant as a parameter file: what was identified, with its std; the rest as declared."""
    experiment, corrected = found.experiment, found.corrected
    lines = [
        f"title = {_text(f'{experiment.declared}, corrected by {experiment.path.name}')}",
        f"source = {_text(f'workbench identify: {experiment.title}')}",
    ]
    for name, value in found.values.items():
        unit = known_units()[name]
        spaced = "" if unit == "1" else f" {unit}"
        lines += ["", f"[parameters.{name}]", f"value = {_quantity(name, value, spaced)}"]
        if name in corrected:
            _, std, source = corrected[name]
            if std is not None:
                lines.append(f"std = {_quantity(name, std, spaced)}")
        else:
            source = f"as declared: {experiment.declared}"
        lines.append(f"source = {_text(source)}")
    return "\n".join(lines) + "\n"


def _quantity(name: str, value: float, unit: str) -> str:
    if name in UNBOUNDED and value == float("inf"):
        return '"inf"'
    return f'"{value:.10g}{unit}"' if unit else f"{value:.10g}"


def _text(text: str) -> str:
    return json.dumps(text, ensure_ascii=False)
