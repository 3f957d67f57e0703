"""A record on the bench: the plant of an experiment, driven by what was measured, beside what it did."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np

from workbench.bench.loop import BenchLoop
from workbench.errors import UserError
from workbench.fitting.replay import observe
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.reading import Record, read_records
from workbench.simulation.run import Run
from workbench.simulation.setup import Setup
from workbench.study.resolve import Resolved
from workbench.toml.reading import read_toml

RECORD = "record"
"""The key of the choice among the records."""

RECORDED = "recorded_"
"""What stands before the name of a channel in the signals of a run beside its record."""

PLANT_FILE = "plant.toml"
"""What an identification and a diagnosis write."""

FORCE = "force"
"""The channel of a measured force, or torque."""

ROTATION = {"motor": "voltage", "ideal": "ideal"}
"""How a study calls what an experiment says of the rod's rotation."""


@dataclass(frozen=True)
class MeasuredLoop(BenchLoop):
    """A plant that the inputs of a record drive, in open loop; `chosen` is the number of the record among all."""

    experiment: Experiment = field(kw_only=True)
    records: tuple[Record, ...] = field(kw_only=True)
    chosen: int = 0

    @property
    def record(self) -> Record:
        """The record at hand."""
        return self.records[self.chosen]

    @cached_property
    def _observed(self) -> Setup:
        return observe(self.record, self.experiment).setup

    @cached_property
    def resolved(self) -> Resolved:
        """The plant with what was changed, driven as the record says, from where it begins.

        Raises:
            UserError: values that do not serve the plant, or a record without its input.
        """
        base, driven = self.parsed.resolve(), self._observed
        start = base.setup.state._replace(position=driven.state.position, velocity=driven.state.velocity)
        fed = {feed.input for feed in driven.feeds}
        inputs = base.setup.inputs._replace(**{name: getattr(driven.inputs, name) for name in fed})
        setup = replace(
            base.setup,
            state=start,
            inputs=inputs,
            duration=driven.duration,
            sample_time=driven.sample_time,
            feeds=driven.feeds,
            sensors=driven.sensors,
            reference=None,
            rotary=None,
        )
        return replace(base, setup=setup)

    def with_record(self, name: str) -> "MeasuredLoop":
        """The same beside another record."""
        place = [record.name for record in self.records].index(name)
        return replace(self, chosen=place, content={**self.content, **_turning(self.records[place])})

    def signals(self, run: Run) -> Mapping[str, np.ndarray]:
        """What the record shows at the instants of a run, by signal, and what the plant's position lacks of it."""
        record, shown = self.record, {}
        for name, values in record.channels.items():
            known = np.isfinite(values)
            shown[f"{RECORDED}{name}"] = np.interp(run.time, record.time[known], values[known])
        if f"{RECORDED}position" in shown:
            shown["error"] = shown[f"{RECORDED}position"] - run.signals["position"]
        return shown


def _turning(record: Record) -> dict[str, Any]:
    return {"axes": {"rpm": [record.rpm]}} if record.rpm else {}


def measured_loop(path: Path) -> MeasuredLoop:
    """The first record of an experiment on the bench, with the plant that is declared there.

    Raises:
        UserError: the experiment or its records cannot be used, or no set or file has the plant's parameters.
    """
    experiment = read_experiment(path)
    records = tuple(_driven(record, experiment) for record in read_records(experiment, None))
    data = read_toml(path)[0]
    given = data.get("plant", {})
    table: dict[str, Any] = dict(given) if isinstance(given, Mapping) else {}
    if not table.get("parameters"):
        raise UserError(f"{path}: plant.parameters: the bench needs a set or a file; [plant] set alone does not do")
    if "rotation" in table or table.get("turned"):
        table["rotation"] = ROTATION[str(table.get("rotation", "motor"))]
    content = {
        "title": experiment.title,
        "plant": table,
        "controllers": {"record": {"type": "open_loop", "input": experiment.plant.command}},
        "simulation": {"duration": max(float(records[0].time[-1]), 1e-3), "sample_time": records[0].sample_time},
        **_turning(records[0]),
    }
    return MeasuredLoop(content, path.parent, experiment=experiment, records=records)


def _driven(record: Record, experiment: Experiment) -> Record:
    """The record with a measured force for the plant's command, where that is what drives it."""
    command, channels = experiment.plant.command, record.channels
    if command in channels or "command" in channels or FORCE not in channels:
        return record
    return replace(record, channels={**channels, command: channels[FORCE]})


def corrected(loop: MeasuredLoop, path: Path) -> MeasuredLoop:
    """The loop with the parameters of a file: of a corrected plant, or of the folder that holds one as plant.toml.

    Raises:
        UserError: no such file.
    """
    file = path / PLANT_FILE if path.is_dir() else path
    if not file.exists():
        raise UserError(
            f"{file}: no such file; expected the folder of a diagnosis or an identification, or a plant.toml"
        )
    changed = loop.changed({"plant.parameters": str(file.resolve())})
    assert isinstance(changed, MeasuredLoop)
    return changed
