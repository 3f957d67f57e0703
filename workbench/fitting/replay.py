"""What the declared plant would have shown on a record: simulated from measured inputs, through its sensors' filters.

A fit asks for the same records many times; those of the same `key` share one simulation.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np
from scipy.interpolate import PchipInterpolator

from plants.equation import fields, from_array, replaced, to_array
from plants.interface import SENSORS, Measurement, Plant
from workbench.errors import UserError
from workbench.fitting.threads import in_parts
from workbench.records.experiment import Experiment
from workbench.records.friction import averaged
from workbench.records.reading import Record
from workbench.records.sampling.sight import SLOW, window_points
from workbench.simulation.references import Moving, Signal
from workbench.simulation.run import Run
from workbench.simulation.sensors import Channel, Sensors
from workbench.simulation.setup import Feed, Integrator, Numbers, Setup
from workbench.simulation.simulate import LANES, largest_distance, simulate, simulate_together

FIT_RATE = 100.0
"""Hz. Records are compared as means over 1 / FIT_RATE; their noise is in the means' scatter."""

FINE, CURVED = 0.01, 10
"""s between the samples of a simulation along a slow record, and points of a curve through each of its samples."""

WINDOW, WARM = 6.0, 3.0
"""s of a `SLOW` record, in which a position that is integrated from its inputs drifts: so long a simulation is compared
before it starts anew, and for which it runs before that. What a plant remembers of its inputs is then right, and of the
position only an offset is not, which every fit finds."""

BRISTLES, BENT = "bristle_deflection", 1e-9
"""The state of a contact that carries a force at rest, linear in it; and by how much (m) it is bent to see so."""

FIRST = 20
"""Samples of which the mean is what a record begins with."""

PRESSURES = ("pressure_1", "pressure_2", "load_pressure")
"""States of a plant: of its chambers, or the one less the other."""

SURELY, LEAST = 5.0, 1e-3
"""Standard deviations of that mean by which pressures differ from those of a plant at rest if they are surely others,
and the least share of them.
"""

INTEGRATORS = (Integrator("rk4", 1e-4), Integrator())
"""Fixed steps come first: their error is as smooth in the parameters as the solution, where that of an error-controlled
method jumps, and a difference quotient takes the jumps for information. The second is for stiffer plants."""

LONG_STEP, NEAR = Integrator("rk4", 1e-3), 1e-4
"""Ten times longer steps serve a slow record if, halved, they move its plant by less than this share of the way."""


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
    """A record as it is compared: `measured` by output, means of `count` samples, NaN over gaps; and its setup.

    It may be a window of the record `of`: `time` is that one's, and the first `warm` values are none of the window.
    Every so many samples (`every`) of the simulation is one of the record. The command is `held` from sample to sample,
    or a straight line, as all that is measured.
    """

    record: Record
    of: Record
    warm: int
    time: np.ndarray
    measured: Mapping[str, np.ndarray]
    count: int
    setup: Setup
    key: bytes
    every: int = 1
    integrators: Sequence[Integrator] = INTEGRATORS
    held: bool = False

    def predicted(self, experiment: Experiment, changes: Mapping[str, float]) -> dict[str, np.ndarray] | None:
        """What the plant with changed parameters shows in place of `measured`; None where it diverges.

        Raises:
            UserError: impossible parameters.
        """
        return self.predicted_each(experiment, [changes])[0]

    def predicted_each(
        self, experiment: Experiment, several: Sequence[Mapping[str, float]]
    ) -> list[dict[str, np.ndarray] | None]:
        """The same of several changes, some at once.

        Raises:
            UserError: impossible parameters.
        """
        return in_parts(partial(self._together, experiment), several, LANES)

    def _together(
        self, experiment: Experiment, several: Sequence[Mapping[str, float]]
    ) -> list[dict[str, np.ndarray] | None]:
        """The same of as many as are solved at once: their runs take much memory."""
        setups = [self._changed(experiment, changes) for changes in several]
        runs, left = dict[int, Run](), list(range(len(setups)))
        for integrator in self.integrators:
            runs |= zip(left, simulate_together([replace(setups[k], integrator=integrator) for k in left]), strict=True)
            left = [k for k in left if runs[k].diverged]
            if not left:
                break
        return [None if k in left else self._shown(runs[k]) for k in range(len(setups))]

    def _changed(self, experiment: Experiment, changes: Mapping[str, float]) -> Setup:
        parameters = experiment.parameters(changes)
        state, inputs = _start(experiment, self.record, parameters)
        return replace(self.setup, parameters=parameters, state=state, inputs=inputs)

    def _shown(self, run: Run) -> dict[str, np.ndarray]:
        shown, places = run.measurements[:: self.every], Measurement._fields
        return {name: averaged(shown[:, places.index(name)], self.count) for name in self.measured}


def observe(record: Record, experiment: Experiment, *, held: bool = False) -> Observed:
    """A record ready to be compared with the plant, whose command is `held` or a straight line from sample to sample.

    Raises:
        UserError: it holds no input of the plant, or nothing that the plant's sensors measure.
    """
    driven = [item.name for item in fields(experiment.plant.Inputs)]
    channels = dict(record.channels)
    if "command" in channels:
        channels.setdefault(experiment.plant.command, channels["command"])
    holds = {experiment.plant.command} if held else set[str]()
    feeds = tuple(Feed(name, _input(record, channels[name]), name not in holds) for name in driven if name in channels)
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
    every = int(np.ceil(record.sample_time / FINE)) if record.sample_time > SLOW else 1
    setup = Setup(
        experiment.plant,
        parameters,
        state,
        inputs,
        duration,
        feeds=feeds,
        sensors=Sensors(filters),
        sample_time=record.sample_time / every,
    )
    measured = {name: averaged(np.where(record.valid, channels[name], np.nan), count) for name in outputs}
    inputs_key = b"".join(feed.signal(record.time)[0].tobytes() for feed in feeds)
    pressures = [float(getattr(state, name)) for name in PRESSURES if name in state._fields]
    about = (record.rpm, round(float(state.position), 3), float(state.velocity), *pressures, outputs, held)
    key = inputs_key + repr(about).encode()
    time = averaged(record.time, count)
    return Observed(record, record, 0, time, measured, count, setup, key, every, held=held)


def observe_all(record: Record, experiment: Experiment) -> Iterator[Observed]:
    """The record as a fit compares it: as a whole, or a slow one in windows.

    Raises:
        UserError: as `observe`.
    """
    if record.sample_time <= SLOW:
        yield observe(record, experiment)
        return
    size, integrators = record.time.size, _integrators(observe(record, experiment).setup)
    warm = round(WARM / record.sample_time)
    start = min(warm, size // 2)
    edges = np.linspace(start, size, max(round((size - start) * record.sample_time / WINDOW), 1) + 1).astype(int)
    for first, last in zip(edges[:-1].tolist(), edges[1:].tolist(), strict=True):
        begin = max(first - warm, 0)
        part = replace(
            record,
            time=record.time[begin:last] - record.time[begin],
            channels={name: values[begin:last] for name, values in record.channels.items()},
            valid=record.valid[begin:last] & (np.arange(begin, last) >= first),
        )
        if np.any(part.valid):
            yield replace(
                observe(part, experiment),
                of=record,
                warm=first - begin,
                time=record.time[begin:last],
                integrators=integrators,
            )


def _integrators(setup: Setup) -> Sequence[Integrator]:
    """With long steps if these serve the plant as it is declared."""
    run = simulate(replace(setup, integrator=LONG_STEP))
    off = largest_distance(run, simulate(replace(setup, integrator=LONG_STEP.finer())))
    serves = off is not None and off < NEAR * float(np.ptp(run.state("position")))
    return (LONG_STEP, *INTEGRATORS) if serves else INTEGRATORS


def _input(record: Record, values: np.ndarray) -> Sampled:
    """A measured input between its samples: a straight line, or in a slow record a curve without overshoot."""
    line = _line(record, values)
    if record.sample_time <= SLOW:
        return line
    points = np.linspace(line.times[0], line.times[-1], CURVED * (record.time.size - 1) + 1)
    return Sampled(points, PchipInterpolator(line.times, line.values)(points))


def straight(record: Record, name: str) -> Sampled:
    """A measured input, or the command in its place, on straight lines between its samples."""
    return _line(record, record.channels[name if name in record.channels else "command"])


def _line(record: Record, values: np.ndarray) -> Sampled:
    """Values of a record where they are known."""
    known = np.isfinite(values)
    return Sampled(record.time[known], values[known])


def _slope(time: np.ndarray, values: np.ndarray) -> float:
    """Rate of a line through the values that are known."""
    known = np.isfinite(values)
    return float(np.polyfit(time[known], values[known], 1)[0]) if np.sum(known) > 1 else 0.0


def _start(experiment: Experiment, record: Record, parameters: Numbers) -> tuple[Any, Any]:
    """The plant at rest (turning, where the record's rpm says so) where the record begins; fed inputs count from 0."""
    surface = 0.0
    if experiment.plant.rotary_command:
        surface = record.rpm * 2.0 * np.pi / 60.0 * experiment.values["piston_radius"]
    state, inputs = experiment.plant.equilibrium(parameters, surface)
    position = record.channels.get("position")
    if position is not None:
        # To the millimetre: the rest is an offset that every fit finds, and repeats can share a simulation.
        state = state._replace(position=round(float(np.nanmean(position[:FIRST])), 3))
        if record.piece:  # it begins wherever the record before it was lost, and not at rest
            first = slice(window_points(record.sample_time))
            state = state._replace(velocity=_slope(record.time[first], position[first]))
    if pressures := _pressures(record, state):
        held = _carrying(experiment.plant, parameters, state._replace(**pressures), inputs)
        state = state if held is None else held  # a sensor's offset may be more than any contact holds
    fed = {item.name: 0.0 for item in fields(experiment.plant.Inputs) if item.name in record.channels}
    fed |= {experiment.plant.command: 0.0}
    fed |= dict.fromkeys(experiment.plant.delayed, _first_command(experiment, record))
    return state, replaced(inputs, fed)


def _pressures(record: Record, state: Any) -> dict[str, float]:
    """Pressures (Pa) of a plant that a record shows where it begins, if they are surely none that balance the load: a
    closed valve holds any.
    """
    first = slice(min(FIRST, window_points(record.sample_time)))
    shown = {name: record.channels[name][first] for name in PRESSURES[:2] if name in record.channels}
    if len(shown) == 2:
        shown[PRESSURES[2]] = shown[PRESSURES[0]] - shown[PRESSURES[1]]
    begin, surely = dict[str, float](), False
    for name, values in shown.items():
        known = values[np.isfinite(values)]
        if name in state._fields and known.size:
            begin[name] = float(np.mean(known))
            off = abs(begin[name] - getattr(state, name))
            surely |= off > max(SURELY * float(np.std(known)) / known.size**0.5, LEAST * abs(begin[name]))
    unknown = [name for name in PRESSURES if name in state._fields and name not in begin]
    return begin if surely and not unknown else {}


def _carrying(plant: Plant, parameters: Numbers, state: Any, inputs: Any) -> Any:
    """The state of a plant with bristles that carry what pressures and load leave to them: the mass rests; None where
    that is more than breaks it away.
    """
    names, x = [item.name for item in fields(plant.State)], to_array(state)
    if BRISTLES not in names:
        return state
    place = names.index(BRISTLES)

    def accelerated(bend: float) -> float:
        x[place] = bend
        bent = from_array(plant.State, x.tolist())
        return float(plant.derivatives(0.0, bent, inputs, parameters).velocity)

    first = float(x[place])
    at_first, beside = accelerated(first), accelerated(first + BENT)
    x[place] = first if beside == at_first else first - BENT * at_first / (beside - at_first)
    values = dict(zip([item.name for item in fields(plant.Parameters)], to_array(parameters).tolist(), strict=True))
    return from_array(plant.State, x.tolist()) if abs(x[place]) <= breakaway_bend(values) else None


def breakaway_bend(values: Mapping[str, float]) -> float:
    """(F_c + F_s) / sigma0 (m), at which bristles break away; infinite of a contact without."""
    stiffness = values.get("bristle_stiffness", 0.0)
    return (values["coulomb"] + values["stribeck"]) / stiffness if stiffness > 0.0 else np.inf


def _first_command(experiment: Experiment, record: Record) -> float:
    """The first command (SI) of a record: before it nothing is known, and a delayed one goes on from there."""
    names = [name for name in (experiment.plant.command, "command") if name in record.channels]
    values = record.channels[names[0]]
    return float(values[np.argmax(np.isfinite(values))])
