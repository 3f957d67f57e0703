"""Which column is which channel: by names and units, then by how the numbers move with each other."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from workbench.errors import UserError, nearest
from workbench.records.importing.columns import (
    SECONDS,
    Column,
    Motion,
    correlation,
    step_of,
    time_of,
    time_unit,
    without_copies,
)
from workbench.records.importing.proposal import Ask, Question
from workbench.records.importing.units import BY_UNIT, KINDS, unit_for
from workbench.records.importing.words import is_reference, scores
from workbench.records.sampling.sight import sample_time_mistake

LEAST = 0.6
"""Score of a name from which it is believed."""

SMOOTH = 0.1
"""Share of a column that smoothing takes away, below which it may be a position."""

FOLLOWS = 0.85
"""Correlation of a position's slope with what it follows."""

TAKES_SIDES = 0.4
"""Correlation with the way that a rod moves from which a column is a pressure or a force."""

COMMANDS = ("command", "valve_voltage", "pump_speed")

VOLTS = KINDS["valve_voltage"]
"""Units of what only a command has."""


@dataclass(frozen=True, eq=False)
class Found:
    """A channel and its column: SI value = unit of (scale * number + offset)."""

    channel: str
    column: Column
    unit: str
    scale: float
    reason: str
    questions: tuple[Question, ...] = ()

    def turned(self, why: str) -> "Found":
        """With the other sign."""
        return replace(self, scale=-self.scale, reason=f"{self.reason}; turned, since {why}")


def answered(found: Found, columns: Sequence[Column], ask: Ask | None) -> Found:
    """A channel as a user answers the questions on it; as it is where nobody can be asked.

    Raises:
        UserError: an answer that names no column, or is no number.
    """
    if ask is None:
        return found
    for question in found.questions:
        if question.key == "column":
            keys = {str(one.key): one for one in columns}
            answer = ask(question.words, str(found.column.key))
            if answer not in keys:
                raise UserError(f'{found.channel}: no column "{answer}"; {nearest(answer, keys)}')
            found = replace(found, column=keys[answer])
        elif question.key == "unit":
            found = replace(found, unit=ask(question.words, found.unit))
        else:
            answer = ask(question.words, f"{found.scale:g}")
            try:
                found = replace(found, scale=float(answer))
            except ValueError:
                raise UserError(f'{found.channel}: got "{answer}", expected a number, such as 0.025') from None
    return replace(found, questions=())


def channels_in(columns: Sequence[Column], path: Path) -> tuple[dict[str, Found], list[str], Motion]:
    """The channels in a log, what became of the other columns in words, and its motion.

    Raises:
        UserError: no time.
    """
    clocks = sorted(columns, key=lambda one: -scores(one.name).get("time", 0.0))
    time = time_of(columns, [one for one in clocks if scores(one.name).get("time", 0.0) >= LEAST], path)
    unit, why = time_unit(time)
    found = {"time": Found("time", time, unit, 1.0, why)}
    if wrong := sample_time_mistake(step_of(time, SECONDS[unit])):
        raise UserError(f"{path}: {wrong}")
    motion = Motion(time, SECONDS[unit])
    wanted = _references([one for one in columns if one is not time])
    rest, copies = without_copies([one for one in columns if one is not time and one not in wanted], _is_other)
    unused = [f"{one.key}: what was wanted, by its name" for one in wanted]
    unused += [f"{key}: {other.key} in other units, it seems" for key, other in copies.items()]
    named = _by_name(rest)
    rest = [one for one in rest if one not in [each for each, _ in named.values()]]
    by_motion = dict(_by_motion({name: one for name, (one, _) in named.items()}, rest, motion))
    for channel, (column, why) in {**named, **by_motion}.items():
        guess = unit_for(channel, column)
        asked = guess.questions
        if channel in by_motion:
            asked = (Question(f"{channel}: is it {_called(column)}? {why}", "column"), *asked)
        found[channel] = Found(channel, column, guess.unit, guess.scale, f"{why}; {guess.reason}", asked)
    taken = [one.column for one in found.values()]
    unused += [f"{one.key}: {one.said}, of no channel that is known" for one in rest if one not in taken]
    return _signed(_velocity(found, motion), motion), unused, motion


def _references(columns: Sequence[Column]) -> list[Column]:
    """The columns of what was wanted and not measured; a wanted voltage is a command, where no other column is one."""
    wanted = [one for one in columns if is_reference(one.name)]
    drives = [one for one in columns if one not in wanted and (one.unit in VOLTS or _is_command(one))]
    if drives:
        return wanted
    volts = next((one for one in wanted if one.unit in VOLTS), None)
    return [one for one in wanted if one is not volts]


def _is_command(column: Column) -> bool:
    return any(scores(column.name).get(name, 0.0) >= LEAST for name in COMMANDS)


def _is_other(first: Column, second: Column) -> bool:
    """Whether two columns are called two channels: pressures of both chambers may mirror each other."""
    return _is_named(first) and _is_named(second) and _best(first) != _best(second)


def _best(column: Column) -> str:
    found = scores(column.name)
    return max(found, key=lambda channel: found[channel])


def _called(column: Column) -> str:
    return f"column {column.key}" if isinstance(column.key, int) else str(column.key)


def _by_name(columns: Sequence[Column]) -> dict[str, tuple[Column, str]]:
    """The best column of each channel by name and unit, the surest first; each column is one channel."""
    ranked = []
    for place, one in enumerate(columns):
        for channel, score in scores(one.name).items():
            if channel == "time" or (one.unit and one.unit not in KINDS[channel]):
                continue
            ranked.append((-score - bool(one.unit), place, channel, one, f'called "{one.name}"'))
        for rank, channel in enumerate(BY_UNIT.get(one.unit, ())):
            ranked.append((-LEAST + 0.01 * rank, place, channel, one, f'in {one.unit}, though called "{one.name}"'))
    found: dict[str, tuple[Column, str]] = {}
    for score, _, channel, one, why in sorted(ranked, key=lambda each: each[:2]):
        taken = any(one is other for other, _ in found.values())
        if -score >= LEAST - 0.05 and channel not in found and not taken:
            found[channel] = (one, why)
    return found


def _by_motion(
    named: Mapping[str, Column], rest: Sequence[Column], motion: Motion
) -> Iterator[tuple[str, tuple[Column, str]]]:
    """Channels that no name gives, among the columns that are left: what moves smoothly and has a slope that another
    column follows is a position; what takes sides with its motion is a pressure or a force.
    """
    left, position = [one for one in rest if not _is_named(one)], named.get("position")
    others = [*named.values(), *left]
    if position is None:
        pairs = [
            (correlation(motion.slope(one), motion.smooth(other)), -(one.low < -0.05 * one.high), -place, one, other)
            for place, one in enumerate(reversed(left))
            if motion.roughness(one) < SMOOTH
            for other in others
            if other is not one
        ]
        rates = {id(other) for share, *_, one, other in pairs if abs(share) > FOLLOWS}
        pairs = [each for each in pairs if id(each[-2]) not in rates] or pairs  # a rate of another one is no position
        if not pairs:
            return
        share, *_, position, other = max(
            pairs, key=lambda each: (abs(round(each[0], 2)), each[0] > 0.0, each[1], each[2])
        )
        yield "position", (position, f"its slope goes with {_called(other)} (correlation {share:.2f})")
    left = [one for one in left if one is not position]
    slope, way = motion.slope(position), motion.way(position)
    if not any(name in named for name in (*COMMANDS, "velocity", "force", "torque")):
        both = [one for one in left if one.low < 0.0 < one.high]  # it changes its sign as a velocity does
        follows = [(correlation(slope, motion.smooth(one)), one) for one in both]
        share, driver = max(follows, key=lambda each: abs(each[0]), default=(0.0, position))
        if abs(share) > FOLLOWS:
            channel = "pump_speed" if driver.size > 200.0 else "command"
            yield channel, (driver, f"the position's slope follows it (correlation {share:.2f})")
            like = [one for one in left if one is not driver and one.low >= 0.0]
            yield from _chambers(like, way, motion, named)
            return
        yield from _pushed(left, way, motion, named)


def _is_named(column: Column) -> bool:
    """Whether a column's name says what it is, if only that it is none of the channels."""
    return max(scores(column.name).values(), default=0.0) >= LEAST and not isinstance(column.key, int)


def _sided(columns: Sequence[Column], way: np.ndarray, motion: Motion) -> list[tuple[float, Column]]:
    """Columns by how they go with the way that a rod moves."""
    return sorted(((correlation(way, motion.smooth(one)), one) for one in columns), key=lambda each: each[0])


def _chambers(
    columns: Sequence[Column], way: np.ndarray, motion: Motion, named: Mapping[str, Column]
) -> Iterator[tuple[str, tuple[Column, str]]]:
    """Two pressures, of which one is high one way and the other one the other way."""
    sided = _sided(columns, way, motion)
    if "pressure_1" in named or len(sided) < 2:
        return
    (falls, second), (rises, first) = sided[0], sided[-1]
    if rises > TAKES_SIDES and falls < -TAKES_SIDES:
        yield "pressure_1", (first, f"high on the way forward (correlation {rises:.2f})")
        yield "pressure_2", (second, f"high on the way back (correlation {falls:.2f})")


def _pushed(
    columns: Sequence[Column], way: np.ndarray, motion: Motion, named: Mapping[str, Column]
) -> Iterator[tuple[str, tuple[Column, str]]]:
    """A force, the largest of what takes sides, and the pressure that it works against."""
    sided = [(share, one) for share, one in _sided(columns, way, motion) if abs(share) > TAKES_SIDES]
    sided.sort(key=lambda each: -each[1].size)
    if sided:
        share, force = sided[0]
        yield "force", (force, f"it changes with the way that the position moves (correlation {share:.2f})")
        if len(sided) > 1 and "pressure_1" not in named and sided[1][1].low >= 0.0:
            yield "pressure_1", (sided[1][1], f"it too, and is never negative (correlation {sided[1][0]:.2f})")


def _velocity(found: dict[str, Found], motion: Motion) -> dict[str, Found]:
    """A velocity's unit by the slope of the position, where its file has none; none of a pump or a motor."""
    velocity, position = found.get("velocity"), found.get("position")
    if velocity is None or position is None:
        return found
    straight = position.unit not in ("deg", "rad", "turn")
    if velocity.column.unit in ("rpm", "rad/s", "deg/s") and straight:
        rest = {name: one for name, one in found.items() if name != "velocity"}
        if "pressure_1" in found and "pump_speed" not in found:
            rest["pump_speed"] = replace(velocity, channel="pump_speed", reason=f"{velocity.reason}; of a pump")
        return rest
    if velocity.column.unit:
        return found
    ratio = float(np.std(motion.smooth(velocity.column)) / max(np.std(motion.slope(position.column)), 1e-300))
    power = round(float(np.log10(max(ratio, 1e-12))))
    names = {0: f"{position.unit}/s", -3: "m/s" if position.unit == "mm" else ""}
    unit = names.get(power, "")
    if not unit:
        return found
    reason = f"{ratio:.3g} times the slope of the position"
    return {**found, "velocity": replace(velocity, unit=unit, reason=reason, questions=())}


def _signed(found: dict[str, Found], motion: Motion) -> dict[str, Found]:
    """Channels with the signs that plants have: a positive command and pressure_1 move forward, and a force that drives
    goes with the motion.
    """
    position = found.get("position")
    if position is None:
        return found
    way = motion.way(position.column)

    def goes(*names: str) -> float:
        parts = [found[name].scale * motion.smooth(found[name].column) for name in names]
        total = parts[0] if len(parts) == 1 else parts[0] / np.std(parts[0]) - parts[1] / np.std(parts[1])
        return correlation(np.sign(found["position"].scale) * way, total)

    force = next((name for name in ("force", "torque") if name in found), "")
    if "pressure_1" in found and "pressure_2" in found:
        if (share := goes("pressure_1", "pressure_2")) < -TAKES_SIDES:
            why = f"pressure_1 is the higher one on the way back (correlation {share:.2f})"
            found = {**found, "position": position.turned(why)}
    elif "pressure_1" in found and force:
        mean = float(np.mean(found[force].column.known))
        if mean > float(np.std(found[force].column.known)):
            found = {**found, force: found[force].turned("it holds against pressure_1, which drives forward")}
        if (share := goes(force)) < 0.0:
            found = {**found, "position": position.turned(f"friction opposes the motion (correlation {share:.2f})")}
    elif force and goes(force) < -TAKES_SIDES:
        found = {**found, force: found[force].turned("a force that drives goes with the motion")}
    for name in COMMANDS:
        if name in found and (share := goes(name)) < -TAKES_SIDES:
            found = {**found, name: found[name].turned(f"the position moves against it (correlation {share:.2f})")}
    return found
