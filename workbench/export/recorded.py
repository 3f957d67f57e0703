"""A controller recorded: what its equations compute at the start, in a step and in a commit, and what of it counts."""

import math
from collections.abc import Collection, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeAlias

from controllers.interface import Controller, Reference
from plants.equation import from_array, leaves
from plants.interface import Measurement
from workbench.errors import UserError
from workbench.export.walk import Path, number_paths
from workbench.recording.symbols import INPUT, Recording, UnrecordableError, needed

GAINS, BEFORE, REFERENCE, MEASUREMENT = "gains->", "before.", "reference->", "measurement->"
"""How C reaches what the equations are given; the state as it was before a call."""

SAMPLE_TIME, REALISED = "settings->sample_time", "realised"

Function: TypeAlias = dict[str, int]
"""What a C function gives: a place of the recording for each place in C that it sets, "" for what it returns."""

STATE = "state->"


class Used(NamedTuple):
    """Which numbers of each tuple count: their paths, in their order."""

    gains: tuple[Path, ...]
    state: tuple[Path, ...]
    reference: tuple[Path, ...]
    measurement: tuple[Path, ...]


@dataclass(frozen=True)
class RecordedController:
    """A controller's three functions over one recording. State on which nothing depends is left out.

    A function is its places in C with those of the recording, "" for what it returns.
    """

    controller: Controller
    recording: Recording
    start: Function
    step: Function
    commit: Function
    used: Used


def recorded(controller: Controller, channels: Collection[str]) -> RecordedController:
    """Record a controller's equations, for a plant that measures these channels: of the others it is given no number.

    Raises:
        UserError: one of them cannot be written as C, and why.
    """
    recording = Recording()

    def given(cls: type[NamedTuple], prefix: str) -> Any:
        return from_array(cls, [recording.input(prefix + in_c(path)) for path in number_paths(cls)])

    gains, before = given(controller.Gains, GAINS), given(controller.State, BEFORE)
    reference, measured = given(Reference, REFERENCE), given(Measurement, MEASUREMENT)
    measurement = measured._replace(**{name: math.nan for name in Measurement._fields if name not in channels})
    sample_time, realised = recording.input(SAMPLE_TIME), recording.input(REALISED)
    with _told(controller, "start"), recording.sources():
        started = _places(recording, controller.start(measurement, gains))
    with _told(controller, "step"), recording.sources():
        command, following = controller.step(reference, measurement, before, gains, sample_time)
        command_place, stepped = recording.place(command), _places(recording, following)
    with _told(controller, "commit"), recording.sources():
        committed = _places(recording, controller.commit(realised, before, gains, sample_time))
    states = number_paths(controller.State)
    own = _places(recording, before)
    kept = _counting(recording, own, command_place, stepped, committed)

    def function(places: Sequence[int], changed_alone: bool) -> Function:
        return {STATE + in_c(states[i]): places[i] for i in sorted(kept) if not (changed_alone and places[i] == own[i])}

    start, step = function(started, False), {**function(stepped, True), "": command_place}
    commit = function(committed, True)
    inputs = _inputs(recording, [*start.values(), *step.values(), *commit.values()])

    def counted(cls: type[NamedTuple], prefix: str) -> tuple[Path, ...]:
        return tuple(path for path in number_paths(cls) if prefix + in_c(path) in inputs)

    used = Used(
        counted(controller.Gains, GAINS),
        tuple(states[i] for i in sorted(kept)),
        counted(Reference, REFERENCE),
        counted(Measurement, MEASUREMENT),
    )
    return RecordedController(controller, recording, start, step, commit, used)


def in_c(path: Path) -> str:
    """A path as C has it."""
    return ".".join(path)


def _counting(
    recording: Recording, own: Sequence[int], command: int, stepped: Sequence[int], committed: Sequence[int]
) -> set[int]:
    """Which numbers of the state count: those on which a command depends, and those that are kept to be seen.

    Of the latter only what takes no further measurement: a rig need not measure what is only looked at.
    """
    kept, read = set[int](), _inputs(recording, [command])
    while more := {i for i, place in enumerate(own) if recording.instructions[place].text in read} - kept:
        kept |= more
        read |= _inputs(recording, (places[i] for i in more for places in (stepped, committed)))
    measured = {text for text in read if text.startswith(MEASUREMENT)}
    for i, place in enumerate(own):
        changed = {stepped[i], committed[i]} - {place}
        seen = {text for text in _inputs(recording, changed) if text.startswith((MEASUREMENT, BEFORE))}
        if changed and seen <= measured | {recording.instructions[own[j]].text for j in (*kept, i)}:
            kept.add(i)
    return kept


def _inputs(recording: Recording, places: Iterable[int]) -> set[str]:
    """What is read, to compute these."""
    found = (recording.instructions[place] for place in needed(recording, places))
    return {instruction.text for instruction in found if instruction.operation == INPUT}


def _places(recording: Recording, values: tuple[object, ...]) -> list[int]:
    return [recording.place(value) for value in leaves(values)]


@contextmanager
def _told(controller: Controller, function: str) -> Iterator[None]:
    """Raises UserError where an equation of a controller cannot be recorded."""
    try:
        yield
    except UnrecordableError as error:
        raise UserError(f'controller "{controller.name}" cannot be written as C: its "{function}" {error}') from None
