"""What the declared plant would have shown on a record: simulated from measured inputs, through its sensors' filters.

A fit asks for the same records many times; those of the same `key` share one simulation.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plants.equation import fields, replaced
from plants.interface import SENSORS, Measurement
from workbench.errors import UserError
from workbench.records.experiment import Experiment
from workbench.records.friction import averaged
from workbench.records.reading import Record
from workbench.simulation.references import Moving, Signal
from workbench.simulation.sensors import Channel, Sensors
from workbench.simulation.setup import Feed, Integrator, Numbers, Setup
from workbench.simulation.simulate import simulate

FIT_RATE = 100.0
"""Hz. Records are compared as means over 1 / FIT_RATE; their noise is in the means' scatter."""

INTEGRATORS = (Integrator("rk4", 1e-4), Integrator())
"""Fixed steps come first: their error is as smooth in the parameters as the solution, where that of an error-controlled
method jumps, and a difference quotient takes the jumps for information. The second is for stiffer plants."""


@dataclass(frozen=True, eq=False)
class Sampled(Moving):
    """A measured input, a straight line from sample to sample (also over a small gap of the record)."""

    times: np.ndarray
    values: np.ndarray

    def __call__(self, time: np.ndarray) -> Signal:
        zeros = np.zeros(np.shape(time))
        return np.interp(time, self.times, self.values), zeros, zeros


@dataclass(frozen=True, eq=False)
class Observed:
    """A record as it is compared: `measured` by output, means of `count` samples, NaN over gaps; and its setup."""

    record: Record
    time: np.ndarray
    measured: Mapping[str, np.ndarray]
    count: int
    setup: Setup
    key: bytes

    def predicted(self, experiment: Experiment, changes: Mapping[str, float]) -> dict[str, np.ndarray] | None:
        """What the plant with changed parameters shows in place of `measured`; None where it diverges.

        Raises:
            UserError: impossible parameters.
        """
        parameters = experiment.parameters(changes)
        state, inputs = _start(experiment, self.record, parameters)
        for integrator in INTEGRATORS:
            setup = replace(self.setup, parameters=parameters, state=state, inputs=inputs, integrator=integrator)
            run = simulate(setup)
            if not run.diverged:
                break
        if run.diverged:
            return None
        places = Measurement._fields
        return {name: averaged(run.measurements[:, places.index(name)], self.count) for name in self.measured}


def observe(record: Record, experiment: Experiment) -> Observed:
    """A record ready to be compared with the plant.

    Raises:
        UserError: it holds no input of the plant, or nothing that the plant's sensors measure.
    """
    driven = [item.name for item in fields(experiment.plant.Inputs)]
    channels = dict(record.channels)
    if "command" in channels:
        channels.setdefault(experiment.plant.command, channels["command"])
    feeds = tuple(Feed(name, _input(record, channels[name])) for name in driven if name in channels)
    if not any(feed.input == experiment.plant.command for feed in feeds):
        raise UserError(f"{record.path}: a simulation needs the measured {experiment.plant.command}; add its channel")
    outputs = [name for name in SENSORS if name in channels]
    if not outputs:
        raise UserError(f"{record.path}: a fit needs one of {', '.join(SENSORS)}; add its channel")
    count = max(1, round(1.0 / (FIT_RATE * record.sample_time)))
    filters = {name: Channel(anti_alias=experiment.channels[name].anti_alias) for name in outputs}
    parameters = experiment.parameters()
    state, inputs = _start(experiment, record, parameters)
    duration = record.sample_time * (record.time.size - 1)
    setup = Setup(
        experiment.plant,
        parameters,
        state,
        inputs,
        duration,
        feeds=feeds,
        sensors=Sensors(filters),
        sample_time=record.sample_time,
    )
    measured = {name: averaged(np.where(record.valid, channels[name], np.nan), count) for name in outputs}
    inputs_key = b"".join(feed.signal(record.time)[0].tobytes() for feed in feeds)
    key = inputs_key + repr((record.rpm, round(float(state.position), 3), outputs)).encode()
    return Observed(record, averaged(record.time, count), measured, count, setup, key)


def _input(record: Record, values: np.ndarray) -> Sampled:
    known = np.isfinite(values)
    return Sampled(record.time[known], values[known])


def _start(experiment: Experiment, record: Record, parameters: Numbers) -> tuple[Any, Any]:
    """The plant at rest (turning, where the record's rpm says so) where the record begins; fed inputs count from 0."""
    surface = 0.0
    if experiment.plant.rotary_command:
        surface = record.rpm * 2.0 * np.pi / 60.0 * experiment.values["piston_radius"]
    state, inputs = experiment.plant.equilibrium(parameters, surface)
    position = record.channels.get("position")
    if position is not None:
        # To the millimetre: the rest is an offset that every fit finds, and repeats can share a simulation.
        state = state._replace(position=round(float(np.nanmean(position[:20])), 3))
    fed = {item.name: 0.0 for item in fields(experiment.plant.Inputs) if item.name in record.channels}
    return state, replaced(inputs, fed | {experiment.plant.command: 0.0})
