"""What the loop on the bench is asked to do, through which sensors, and how long it is simulated."""

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from plants.axis import unit_along
from plants.equation import fields
from workbench.bench.knobs import Choice, Control, Knob, ranged
from workbench.bench.loop import BenchLoop
from workbench.bench.measured import RECORD, MeasuredLoop
from workbench.publish.words import plain_name as words_of
from workbench.study.reference_tables import REFERENCES
from workbench.study.sensor_tables import CHANNEL_UNITS
from workbench.toml.units import si, unit_written

LENGTHS = ("amplitude", "offset")
UNITS = {"phase": "rad", "dwell": "s", "sweep": "s", "start": "s", "stop": "s"}
SPEEDS = ("rate", "speed")


def reference_controls(loop: BenchLoop) -> list[Control]:
    """What the position is asked to do."""
    known = loop.content.get("references", {})
    kinds = [(name, words_of(name)) for name in known]
    kinds += [(name, words_of(name)) for name in STARTING if name not in known]
    name = loop.reference_name
    controls: list[Control] = [Choice("reference", "reference", name, kinds)]
    if not name:
        return controls
    table, plant, fed = loop.case.tables["references"][name], loop.resolved.setup.plant, loop.parsed.controller.fed
    unit = next((item.unit for item in fields(plant.Inputs) if item.name == fed), plant.axis)
    model = REFERENCES.working()[str(table["kind"])].table
    for item in model.model_fields:
        if item not in table or isinstance(table[item], list) or item in ("kind", "file", "time", "value"):
            continue
        si_unit = unit if item in LENGTHS else f"{unit}/s" if item in SPEEDS else _unit_of(item)
        if not si_unit:
            continue
        value = table[item]
        knob = Knob(f"references.{name}.{item}", words_of(item), si(value, si_unit), si_unit)
        controls.append(ranged(replace(knob, shown=unit_written(value) or "")))
    return controls


def _unit_of(item: str) -> str:
    return UNITS.get(item, "Hz" if "frequency" in item else "")


STARTING: Mapping[str, Mapping[str, object]] = {
    "sine": {"frequency": 0.5},
    "steps": {"dwell": 2.0},
    "triangle": {"frequency": 0.25},
    "multisine": {"frequency": 0.1, "harmonics": [1, 3, 7]},
    "chirp": {"start_frequency": 0.1, "end_frequency": 5.0, "sweep": 5.0},
}
"""References that are offered beside those of the study (SI); how far they go is how far the present one goes."""

SHARE = 0.1
"""Of the travel, how far a reference goes where there is none yet."""


def starting_table(loop: BenchLoop, kind: str) -> dict[str, object]:
    """A table for a reference of another kind, as far as the present one goes."""
    if kind not in STARTING:
        return {}  # one of the study's own
    far = _reach(loop)
    going = {"levels": [far, 0.0, -far, 0.0]} if kind == "steps" else {"amplitude": far}
    return {"kind": kind, **going, **STARTING[kind]}


def _reach(loop: BenchLoop) -> float:
    """How far (m, or rad) the reference goes from the middle."""
    setup = loop.resolved.setup
    if setup.reference is not None:
        far = float(np.max(np.abs(setup.reference(np.linspace(0.0, setup.duration, SAMPLES))[0])))
        if far > 0.0:
            return float(f"{far:.3g}")
    travel = float(setup.plant.travel(setup.parameters))
    return SHARE * travel if math.isfinite(travel) else SHARE


SAMPLES = 1000


def record_controls(loop: BenchLoop) -> list[Control]:
    """Which of the records is beside the plant, and how exactly that is simulated."""
    assert isinstance(loop, MeasuredLoop)
    options = [(one.name, f"{one.name} ({'held out' if one.use == 'held_out' else 'fit'})") for one in loop.records]
    tolerance = loop.parsed.tables.simulation.tolerance
    return [
        Choice(RECORD, "record", loop.record.name, options, "held out: no fit has seen it"),
        Knob("simulation.tolerance", "tolerance", tolerance, "1", 1e-10, 1e-2, True),
    ]


def sensor_controls(loop: BenchLoop) -> list[Control]:
    """Noise, resolution and delay of the sensors that the plant has."""
    tables, plant, setup = loop.parsed.tables, loop.resolved.setup.plant, loop.resolved.setup
    controls: list[Control] = [
        Knob(
            "sensors.delay", "delay", tables.sensors.delay, "s", 0.0, max(0.02, 2.0 * tables.sensors.delay), shown="ms"
        )
    ]
    for name, straight in CHANNEL_UNITS.items():
        if name not in plant.channels:
            continue
        unit = unit_along(straight, plant.axis)
        channel = setup.sensors.channels[name]
        size = NOISES.get(unit, 1.0)
        shown = [("noise", channel.noise)]
        if getattr(tables.sensors, name).bits is None:  # else the converter's range says it
            shown.append(("resolution", channel.resolution))
        for item, value in shown:
            low, high = size / 100.0, max(size * 100.0, 3.0 * value)
            key, label = f"sensors.{name}.{item}", f"{words_of(name)} {item}"
            controls.append(Knob(key, label, value, unit, low, high, True, True, shown=SMALL_UNITS.get(unit, "")))
    return controls


NOISES = {"m": 1e-5, "rad": 1e-4, "Pa": 2e3, "rad/s": 0.1, "A": 0.01}
SMALL_UNITS = {"m": "um", "rad": "mrad", "Pa": "kPa", "A": "mA"}
"""A usual noise of a sensor (SI), and the unit in which one speaks of it."""


def run_controls(loop: BenchLoop) -> list[Control]:
    """How long, how often sampled, with which noise, how exactly."""
    table = loop.parsed.tables.simulation
    return [
        Knob("simulation.duration", "duration", table.duration, "s", 0.5, max(60.0, 2.0 * table.duration), True),
        Knob("simulation.transient", "left out at the start", table.transient, "s", 0.0, 0.9 * table.duration),
        Knob("simulation.sample_time", "sample time", table.sample_time, "s", 1e-4, 2e-2, True, shown="ms"),
        Knob("simulation.tolerance", "tolerance", table.tolerance, "1", 1e-10, 1e-2, True),
    ]
