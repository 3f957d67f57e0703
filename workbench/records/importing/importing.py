"""From logs to a proposal: channels, a plant that fits them, parameters to begin with, and records."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np

from plants.equation import fields
from plants.interface import Plant
from workbench.errors import UserError
from workbench.parameters.sets import parameter_path, read_parameters
from workbench.records.channels import FORCE, TORQUE, unit_of
from workbench.records.importing.channels import Found, answered, channels_in
from workbench.records.importing.columns import SECONDS, Column, columns_of
from workbench.records.importing.plants import given, plant_for
from workbench.records.importing.proposal import Ask, Line, Proposal
from workbench.records.importing.values import free_for, values_for
from workbench.records.sampling.clock import stamps_of
from workbench.records.sampling.pieces import Series, pieces_of
from workbench.records.sampling.sight import sight_note
from workbench.toml.units import QuantityError, factor

AXIAL = (("position", "pressure_1", "pressure_2"), ("position", "force"))
"""Channels that show friction, of which the thesis's method needs one set."""

STILL = 1e-12
"""In its own unit, by which a position at least moves."""

CENTRED = 1.05
"""Share of half the stroke up to which a position is counted from its middle."""


def proposal_for(
    logs: Sequence[Path], model: str | None, parameters: str | None, folder: Path, ask: Ask | None = None
) -> Proposal:
    """What an experiment of these logs may be, the first one deciding; `folder` is that of the experiment file.

    What nobody can know is asked, if there is somebody to `ask`, and else stands as a question in the proposal.

    Raises:
        UserError: a log cannot be read, has no time, or no plant fits it.
    """
    columns = columns_of(logs[0])
    found, unused, motion = channels_in(columns, logs[0])
    for log in logs[1:]:
        _check_alike(log, logs[0], found)
    if "position" not in found:
        names = ", ".join(str(one.key) for one in columns)
        raise UserError(f"{logs[0]}: none of its columns looks like a position: {names}; write the experiment by hand")
    way = float(np.ptp(motion.smooth(found["position"].column)))
    if not way > STILL:
        key = found["position"].column.key
        raise UserError(f'{logs[0]}: the position "{key}" moves by {way:g}: nothing to import; take a log of a motion')
    found = {name: answered(one, columns, ask) for name, one in found.items()}
    own = None if parameters is None else read_parameters(parameter_path(parameters, folder))
    plant, line = plant_for(found, model, own, motion.step, ask)
    found = _for_plant(found, plant)
    _check_units(found, plant)
    values = [] if parameters is not None else [each.asked(ask) for each in values_for(plant, found, motion)]
    stroke = own.get("stroke", np.inf) if own is not None else _stroke(plant, values)
    channels = [_line(one, *_offset(one, stroke, plant, own is not None)) for one in found.values()]
    free = free_for(plant, found, motion, own)
    listed = "[" + ", ".join(f'"{name}"' for name in free) + "]"
    method = _method(plant, found)
    fit = [Line("free", {"": listed}, "friction, and what the log tells beside it")] if free else []
    fit += method
    last = len(logs) - 1 if len(logs) > 1 else len(logs)
    records = [
        (log, "held_out" if place == last else "fit", _clock(columns_of(log), found, log))
        for place, log in enumerate(logs)
    ]
    declared = "" if parameters is None else parameters
    return Proposal(f"Imported from {logs[0].name}", line, declared, values, fit, channels, records, tuple(unused))


def _method(plant: Plant, found: Mapping[str, Found]) -> list[Line]:
    """How parameters are found, where one of the two methods cannot."""
    if not any(all(name in found for name in names) for names in AXIAL):
        return [Line("method", {"": "simulation"}, "friction shows in no force or pressures")]
    if given(plant, found) not in (plant.command, "command"):
        return [Line("method", {"": "thesis"}, f"nothing but the force itself gives {plant.command}")]
    return []


def _check_units(found: Mapping[str, Found], plant: Plant) -> None:
    """Whether the units, which a user may have answered, are those of the channels."""
    for name, one in found.items():
        unit = unit_of(FORCE if name == TORQUE else name, plant)
        try:
            factor(one.unit, unit)
        except QuantityError:
            raise UserError(f'{name}: got "{one.unit}", expected a unit such as "{unit}"') from None


def _check_alike(log: Path, first: Path, found: Mapping[str, Found]) -> None:
    there = {one.key for one in columns_of(log)}
    lacking = [str(one.column.key) for one in found.values() if one.column.key not in there]
    if lacking:
        raise UserError(
            f"{log}: no numbers that change in {', '.join(lacking)}, which {first} has; import logs of one kind"
        )


def _for_plant(found: Mapping[str, Found], plant: Plant) -> dict[str, Found]:
    """The channels as the plant calls them; a command that it does not take is left to its reader's eye."""
    command = given(plant, found)
    renamed = {}
    for name, one in found.items():
        if name == "motor_current" and command == name:
            name = "command"
        renamed[name] = one
    return renamed


def _stroke(plant: Plant, values: Sequence[Line]) -> float:
    """The stroke (SI) by which a position's zero is judged; infinite without one."""
    if "stroke" not in [item.name for item in fields(plant.Parameters)]:
        return np.inf
    own = [str(line.values[""]) for line in values if line.name == "stroke"]
    return float(own[0].split()[0]) if own else np.inf


def _offset(one: Found, stroke: float, plant: Plant, known: bool) -> tuple[float, str]:
    """What moves a position's zero to the middle of the stroke, in its unit, and why; 0 where it is near it.

    A position that stays within a `known` stroke from 0 on is counted from one of its ends. Else the middle of the way
    is all that there is.
    """
    if one.channel != "position" or not np.isfinite(stroke):
        return 0.0, ""
    low, high = sorted((one.scale * one.column.low, one.scale * one.column.high))
    half = 0.5 * stroke / factor(one.unit, unit_of("position", plant))
    if max(-low, high) <= CENTRED * half:
        return 0.0, ""
    for side in (1.0, -1.0):
        if known and min(side * low, side * high) >= (1.0 - CENTRED) * half and max(-low, high) <= CENTRED * 2.0 * half:
            return -side * float(f"{half:.6g}"), "counted from an end of the stroke, whose middle is 0 here"
    return -float(f"{0.5 * (low + high):.4g}"), "0 is the middle of the way"


def _line(one: Found, offset: float, why: str) -> Line:
    values: dict[str, str | float | int] = {"column": one.column.key, "unit": one.unit}
    if one.scale != 1.0 or any(question.key == "scale" for question in one.questions):
        values["scale"] = one.scale
    reason = one.reason
    if offset:
        values["offset"] = offset
        reason += f"; {why}"
    return Line(one.channel, values, reason, one.questions)


def _clock(columns: Sequence[Column], found: Mapping[str, Found], path: Path) -> str:
    """What is to be said of a log's clock."""
    clock = found["time"]
    time = next(one for one in columns if one.key == clock.column.key)
    stamps = stamps_of(path, SECONDS[clock.unit] * time.values)
    pieces, notes = pieces_of(path, [Series(stamps, {"time": stamps.time})], None)
    told = [note for note in (*notes, sight_note(pieces[0].step)) if note]
    return f"{1.0 / pieces[0].step:.4g} Hz" + "".join(f"; {note}" for note in told)
