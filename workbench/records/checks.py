"""Whether the numbers of a record can be what they are called: stuck and saturated channels, wrong units."""

import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from workbench.errors import UserError
from workbench.publish.along import SHOWN
from workbench.records.channels import ChannelSpec
from workbench.records.experiment import Experiment
from workbench.records.sampling.clock import spans

SATURATED_SHARE = 0.05
"""Share of samples at the very same largest or smallest value from which a channel is saturated."""

BEYOND = 1.05
"""A position, pressure or command beyond its range by more than a sensor's error: 5 %."""

FOLLOWED = ("valve_voltage", "pump_speed")
"""Inputs that the velocity follows, whatever the load: a flow has nowhere else to go."""

AGAINST = -0.5
"""Sum of input times velocity over that of their sizes, below which the one goes against the other."""

PACE = 0.05
"""s over which a velocity is told for that, a sample at least: noise of the position is small beside what is moved in
it."""

SWEEP, TOO_FAST = 0.5, 100.0
"""s over which a way is taken, in which noise of the position counts for little; and times that it is longer than a
valve can send the rod in that time, as it is declared, with the whole supply at one edge."""

VALVE = ("valve_flow_gain", "valve_position_gain", "supply_pressure")
AREAS = ("piston_area_1", "piston_area_2")
"""Parameters by which a valve sends the rod."""

LEAST_PRESSURE = {1: 1e-3, 2: 0.02}
"""Share of the supply pressure that the pressures reach, of one channel and of both chambers: one of them is fed."""

LEAST_POWER = 2
"""Of ten, from which on a channel's numbers are so far off that the message says how far."""

ARRIVAL = 0.01
"""s before a channel rests at its extreme, a sample at least: in them one that was held there creeps, one cut off still
moves."""

MOVING = ("position", "pressure_1", "pressure_2", "rotation_angle", "force")
"""Channels that cannot be constant to the last digit unless they are stuck."""


_STROKE, _OPEN = "an end of the stroke, or of the sensor's range?", "an open chamber, or the end of the sensor's range?"
RESTS: Mapping[str, Mapping[str, str]] = {
    "position": {"largest": _STROKE, "smallest": _STROKE},
    "pressure_1": {"smallest": _OPEN},
    "pressure_2": {"smallest": _OPEN},
}
"""Channels that may rest at an extreme, and why."""


def alive_notes(path: Path, name: str, values: np.ndarray, step: float) -> Iterator[str]:
    """A stuck channel has one value; a saturated one rests at its extreme and nowhere near it.

    A position may, and a chamber that is open: nothing in a record tells that from the end of a sensor's range.

    Raises:
        UserError: the channel is stuck or saturated.
    """
    before = max(round(ARRIVAL / step), 1)
    known = values[np.isfinite(values)]
    low, high = float(np.min(known)), float(np.max(known))
    if low == high:
        if name in MOVING:
            raise UserError(f"{path}: {name} is stuck: {low:g} throughout; is this its column?")
        return
    if name not in MOVING:
        return
    for extreme, word in ((high, "largest"), (low, "smallest")):
        at = values == extreme
        first, last = max(spans(at), key=lambda span: span[1] - span[0])
        longest = last - first
        beside = np.unique(known)
        held = abs(values[max(first - before, 0)] - extreme) < 2.5 * float(np.min(np.diff(beside)))
        next_to = float(beside[-2] if extreme == high else beside[1])
        # Slow motion rests at a converter's step, but at the next one as long; what is cut off piles up at its wall.
        crowded = np.sum(at) > 5 * max(1, int(np.sum(known == next_to)))
        if longest <= SATURATED_SHARE * values.size or not crowded or held:
            continue
        if why := RESTS.get(name, {}).get(word):
            yield f"{name} is at its {word} value {extreme:g} for {longest} samples on end: {why}"
        else:
            raise UserError(
                f"{path}: {name} is saturated: at its {word} value {extreme:g} for {longest} samples on end; "
                "use a sensor or an amplifier of larger range, or cut the record"
            )


def check_ranges(path: Path, channels: Mapping[str, np.ndarray], experiment: Experiment) -> None:
    """Positions outside the stroke, pressures above supply or far below it, commands that no amplifier gives: mostly
    wrong units.

    Raises:
        UserError: one of these.
    """
    values, axis = experiment.values, experiment.plant.axis
    if "position" in channels and np.isfinite(values.get("stroke", np.inf)):
        span = float(np.nanmax(channels["position"]) - np.nanmin(channels["position"]))
        if span > BEYOND * values["stroke"]:
            raise UserError(
                f"{path}: the position spans {span:g} {axis}, and the stroke is {values['stroke']:g} {axis}; "
                f"is the unit of channel position right?{_length_hint(span, values['stroke'])}"
            )
        _check_origin(path, channels["position"], values["stroke"], experiment.channels["position"], axis)
    supply = values.get("supply_pressure")
    for name in ("pressure_1", "pressure_2"):
        if supply is None or name not in channels:
            continue
        largest = float(np.nanmax(np.abs(channels[name])))
        if largest > BEYOND * supply:
            raise UserError(
                f"{path}: {name} reaches {largest:g} Pa, and the supply is {supply:g} Pa; "
                f"is the unit of channel {name} right?{_unit_hint(largest, supply)}"
            )
        both = [channels[other] for other in ("pressure_1", "pressure_2") if other in channels]
        if max(float(np.nanmax(np.abs(values))) for values in both) < LEAST_PRESSURE[len(both)] * supply:
            raise UserError(
                f"{path}: {name} stays below {largest:g} Pa, and the supply is {supply:g} Pa; "
                f"is the unit of channel {name} right?{_unit_hint(largest, supply)}"
            )

    _check_command(path, channels, experiment)


def _check_origin(path: Path, position: np.ndarray, stroke: float, channel: ChannelSpec, axis: str) -> None:
    """Whether the position is counted from the middle of the stroke, as the plants count it."""
    low, high, half = float(np.nanmin(position)), float(np.nanmax(position)), 0.5 * stroke
    if max(-low, high) <= BEYOND * half:
        return
    near = 1.0 - BEYOND
    if low >= near * stroke and high <= BEYOND * stroke:  # counted from an end: that is known better than a middle
        middle = half
    elif high <= -near * stroke and low >= -BEYOND * stroke:
        middle = -half
    else:
        middle = 0.5 * (low + high)
    scale, unit = SHOWN[axis].factor, SHOWN[axis].unit
    raise UserError(
        f"{path}: the position goes from {scale * low:.4g} to {scale * high:.4g} {unit}, and a stroke of "
        f"{scale * stroke:.4g} {unit} from {-scale * half:.4g} to {scale * half:.4g} {unit}: 0 is its middle; give "
        f'channel position offset = "{scale * (channel.offset - middle):.4g} {unit}", if that is the middle here'
    )


def _check_command(path: Path, channels: Mapping[str, np.ndarray], experiment: Experiment) -> None:
    """Whether the amplifier can give what was recorded of the plant's command."""
    plant = experiment.plant
    limit = plant.command_limit(experiment.parameters())
    for name in (plant.command, "command"):
        largest = float(np.nanmax(np.abs(channels[name]))) if name in channels else 0.0
        if largest > BEYOND * limit:
            raise UserError(
                f"{path}: {name} reaches {largest:.4g} {plant.command_unit}, and its limit is {limit:g} "
                f"{plant.command_unit}; is the unit of channel {name} right?"
            )


def check_directions(path: Path, pieces: Sequence[Mapping[str, np.ndarray]], step: float) -> None:
    """Whether the rod moves where valve or pump send it, by the channels of a record's pieces; `step` (s) is the time
    between samples.

    Raises:
        UserError: it moves against them.
    """
    points = max(round(PACE / step), 1)
    if "position" not in pieces[0]:
        return
    for name in FOLLOWED:
        if name not in pieces[0]:
            continue
        driven = np.concatenate([_driven(channels["position"], channels[name], points) for channels in pieces])
        total = float(np.sum(np.abs(driven)))
        if total > 0.0 and np.sum(driven) < AGAINST * total:
            raise UserError(
                f"{path}: the rod moves against {name} on most of its way; is the sign of channel {name} wrong, or "
                "that of position? scale = -1 turns a channel"
            )


def check_pace(path: Path, pieces: Sequence[Mapping[str, np.ndarray]], step: float, experiment: Experiment) -> None:
    """Whether the valve can send the rod as far as it goes, by its largest voltage: v A <= K x sqrt(P_s).

    Raises:
        UserError: the rod goes a hundred times as far.
    """
    values, points = experiment.known_values(), max(round(SWEEP / step), 1)
    if not {*VALVE, *AREAS} <= set(values) or not {"position", "valve_voltage"} <= set(pieces[0]):
        return
    gain, travel, supply = (values[name] for name in VALVE)
    largest = max(_largest(channels["valve_voltage"]) for channels in pieces)
    way = max(_largest(channels["position"][points:] - channels["position"][:-points]) for channels in pieces)
    sent = SWEEP * gain * travel * largest * math.sqrt(supply) / min(values[name] for name in AREAS)
    if 0.0 < TOO_FAST * sent < way:
        raise UserError(
            f"{path}: the rod goes {1e3 * way:.3g} mm in {SWEEP:g} s, and the valve as declared sends it "
            f"{1e3 * sent:.3g} mm at most by {largest:.3g} V; is the unit of channel valve_voltage right?"
            f"{_unit_hint(sent, way)}"
        )


def _largest(values: np.ndarray) -> float:
    return float(np.max(np.abs(np.nan_to_num(values)), initial=0.0))


def _driven(position: np.ndarray, values: np.ndarray, points: int) -> np.ndarray:
    """What an input and the way (m) over so many points have in common, where both are known."""
    if position.size <= points:
        return np.empty(0)
    way = position[points:] - position[:-points]
    driven = way * values[points // 2 :][: way.size]
    return np.asarray(driven[np.isfinite(driven)])


def _unit_hint(got: float, expected: float) -> str:
    return _times_off(_power(got, expected))


def _length_hint(span: float, stroke: float) -> str:
    """A record may use a small part of the stroke, and units of length are thousands apart: m, mm, um."""
    power = _power(span, stroke)
    return _times_off(3 * math.ceil(power / 3)) if power >= LEAST_POWER else ""


MOST_POWER = 300
"""Of ten, that is told."""


def _power(got: float, expected: float) -> int:
    """The nearest power of ten of their ratio."""
    return round(min(max(math.log10(got) - math.log10(expected), -MOST_POWER), MOST_POWER))


def _times_off(power: int) -> str:
    return f" (it seems {10.0**power:g} times off)" if abs(power) >= LEAST_POWER else ""
