"""A design as a study that simulates it under every hypothesis, with its references and the hypotheses' plants."""

import math
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import tomli_w

from plants.axis import name_along
from plants.equation import fields
from workbench.design.hypotheses import Hypothesis
from workbench.design.report.words import COMMAND, answer
from workbench.design.result import Design
from workbench.design.steering import NAME
from workbench.diagnose.residuals.balances import richest
from workbench.parameters.corrected import Entry, parameter_file
from workbench.parameters.sets import FLOW_SHARE, NEUTRAL
from workbench.publish.along import SHOWN
from workbench.toml import reading as files

STUDY = "study.toml"
TURNS = ("turned", "bristle", "rotation", "flow")
"""Keys of an experiment's [plant] that a study's has too."""

DIGITS = "%.9g"


def write_study(design: Design, folder: Path) -> list[str]:
    """Write the study and all that it names; returns the names of the files."""
    references = _references(design)
    for name, table in references.items():
        _write_reference(design, folder / f"{name}.csv", table)
    plants = {f"hypothesis_{number}.toml": one for number, one in enumerate(design.hypotheses, 1)}
    for name, hypothesis in plants.items():
        (folder / name).write_text(_plant(design, hypothesis), encoding="utf-8")
    (folder / STUDY).write_text(tomli_w.dumps(_study(design, list(plants), list(references))), encoding="utf-8")
    return [STUDY, *(f"{name}.csv" for name in references), *plants]


def _references(design: Design) -> dict[str, np.ndarray]:
    """The reference of each leg, by name."""
    count = len(design.legs)
    return {"reference" + (f"_{i}" if count > 1 else ""): leg.reference for i, leg in enumerate(design.legs, 1)}


def _column(design: Design) -> str:
    rig = design.rig
    return (
        f"position_{rig.axis}"
        if rig.steering is not None
        else f"command_{rig.along.plant.command_unit}".replace(" ", "_")
    )


def _write_reference(design: Design, path: Path, values: np.ndarray) -> None:
    time = design.rig.sample_time * np.arange(values.size)
    header = f"time_s,{_column(design)}"
    np.savetxt(path, np.column_stack([time, values]), fmt=DIGITS, delimiter=",", header=header, comments="")


def _plant(design: Design, hypothesis: Hypothesis) -> str:
    """A hypothesis's plant as a parameter file."""
    plant = richest(design.experiment.plant)
    free = {u.name for u in hypothesis.unknowns}
    known = {item.name for item in fields(design.rig.along.plant.Parameters)} - {FLOW_SHARE}
    said = {name: value for name, value in hypothesis.values.items() if name in known | {*design.experiment.values}}
    entries = [
        Entry(
            name,
            value,
            None,
            f"{COMMAND}, {hypothesis.name}" if name in free else design.experiment.source_of(name),
        )
        for name, value in said.items()
        if NEUTRAL.get(name) != value
    ]
    source = f"{COMMAND}: {design.experiment.title}; for model {plant.name}"
    return parameter_file(f"hypothesis: {hypothesis.name}", source, entries, plant.axis)


def _study(design: Design, plants: list[str], references: list[str]) -> dict[str, Any]:
    rig, experiment = design.rig, design.experiment
    plant, closed = richest(experiment.plant), rig.steering is not None
    given: Mapping[str, Any] = files.read_toml(experiment.path)[0]["plant"]  # type: ignore[assignment]
    load = name_along("load_force", rig.axis)
    cases: dict[str, Any] = {}
    for name, leg in zip(references, design.legs, strict=True):
        case: dict[str, Any] = {
            "axes": {"plant.parameters": plants, "reference": [name]},
            "simulation": {"duration": f"{_duration(design, leg.reference):.9g} s"},
        }
        if leg.condition.rotation:
            case["axes"]["rpm"] = [leg.condition.rotation * 30.0 / math.pi]
        if leg.condition.load:
            loaded = design.hypotheses[0].values.get(load, 0.0) + leg.condition.load
            case["plant"] = {"set": {load: f"{loaded:.9g} {SHOWN[rig.axis].force_unit}"}}
        cases[name] = case
    controller = dict(rig.steering.table) if rig.steering is not None else {"type": "open_loop"}
    return {
        "title": f"What to record next: {experiment.title}",
        "source": COMMAND,
        "question": " ".join([answer(design), *_hypotheses(design)]),
        "records": [plant.command, *(f"measured_{name}" for name in rig.channels)],
        "plant": {
            "model": plant.name,
            "parameters": plants[0],
            **{key: given[key] for key in TURNS if key in given},
            **({"start_position": f"{rig.reach.middle:.9g} {rig.axis}"} if closed and rig.reach.middle else {}),
        },
        "belief": {"parameters": plants[0]},
        "simulation": {
            "duration": "1 s",
            "sample_time": f"{rig.sample_time:.9g} s",
            "seed": 1,
            "tolerance": rig.tolerance,
        },
        "sensors": {name: {"noise": f"{std:.6g} {_unit(rig.axis, name)}"} for name, std in rig.noise.items()},
        "controllers": {NAME: controller},
        "references": {
            name: {"kind": "recorded", "file": f"{name}.csv", "time": "time_s", "value": _column(design)}
            for name in references
        },
        "cases": cases,
    }


def _hypotheses(design: Design) -> list[str]:
    """What each hypothesis is."""
    return [f"Hypothesis {number}: {one.name}." for number, one in enumerate(design.hypotheses, 1)]


def _duration(design: Design, reference: np.ndarray) -> float:
    return design.rig.sample_time * (reference.size - 1)


def _unit(axis: str, channel: str) -> str:
    return {"position": axis, "rotation_speed": "rad/s", "motor_current": "A"}.get(channel, "Pa")
