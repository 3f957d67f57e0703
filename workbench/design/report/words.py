"""A design in words: the motion, what it decides, and what remains open."""

import math
from collections.abc import Sequence
from itertools import groupby

import numpy as np

from workbench.design.pieces import Condition, Piece, shaped
from workbench.design.power import Told
from workbench.design.result import BETTER, HARDLY, SURE, Design
from workbench.parameters.sets import known_units
from workbench.publish.along import SHOWN
from workbench.publish.tables import shown_number
from workbench.publish.words import listed, plain_name

COMMAND = "workbench design"


def motion_words(design: Design) -> str:
    """The pieces in their order: "12 s of slow strokes of 5 mm at 2 mm/s, then 8 s of steps of 0.5 mm with ..."."""
    said = []
    conditions = len({piece.condition for piece in design.pieces}) > 1
    for _, group in groupby(design.pieces, key=lambda piece: (piece.condition, piece.kind)):
        pieces = list(group)
        at = f" {_at(design, pieces[0].condition)}" if conditions or any(pieces[0].condition) else ""
        said.append(f"{_number(sum(piece.duration for piece in pieces))} s of {_kind(design, pieces)}{at}")
    return ", then ".join(said)


def _kind(design: Design, pieces: Sequence[Piece]) -> str:
    numbers = [shaped(piece, design.rig.reach).numbers for piece in pieces]

    def over(key: str, speed: bool = False) -> str:
        values = [one[key] for one in numbers]
        return _span(design, min(values), max(values), speed=speed)

    def hertz(low: str, high: str) -> str:
        return _plain_span(min(one[low] for one in numbers), max(one[high] for one in numbers), "Hz")

    match pieces[0].kind:
        case "steps":
            holds = _plain_span(min(one["hold"] for one in numbers), max(one["hold"] for one in numbers), "s")
            return f"steps of {over('amplitude')} with holds of {holds}"
        case "sines":
            return f"sums of sines up to {over('amplitude')} from {hertz('frequency', 'frequency')} on"
        case "sweep":
            return f"sweeps of {over('amplitude')} from {hertz('from', 'from')} to {hertz('to', 'to')}"
        case kind:
            return f"{kind} of {over('amplitude')} at {over('speed', speed=True)}"


def _span(design: Design, low: float, high: float, *, speed: bool) -> str:
    """A length, a speed or a command, or from one to another."""
    shown, rig = SHOWN[design.rig.axis], design.rig
    if rig.steering is None:
        return _plain_span(low, high, rig.along.plant.command_unit + ("/s" if speed else ""))
    return _plain_span(shown.factor * low, shown.factor * high, shown.speed_unit if speed else shown.unit)


def _plain_span(low: float, high: float, unit: str) -> str:
    first, last = _number(low), _number(high)
    return f"{last} {unit}" if first == last else f"{first} to {last} {unit}"


def _number(value: float) -> str:
    return f"{float(f'{value:.2g}'):g}"


def _at(design: Design, condition: Condition) -> str:
    rotation, load = condition
    said = [f"{rotation * 30.0 / math.pi:.0f} rpm"] if design.rig.along.plant.rotary_command else []
    said += [f"a load of {load:g} {SHOWN[design.rig.axis].force_unit}"] if load else []
    return f"at {listed(said)}" if said else "without a further load"


def answer(design: Design) -> str:
    """The motion, and whether it is worth it."""
    motion = f"Record {_number(design.duration)} s: {motion_words(design)}."
    if design.tells:
        return motion
    return f"No motion was found that settles what is open; the best of {_number(design.duration)} s is this. {motion}"


def verdicts(design: Design) -> list[str]:
    """Of each pair how surely the motion tells it, and of each parameter how well it shows it."""
    said = [f"All hypotheses have {listed([plain_name(name) for name in design.common])}."] if design.common else []
    for one in design.told:
        true, rival = (design.name_of(k) for k in (one.true, one.rival))
        share = f"in {_percent(one.power)} of records ({_percent(one.low)} to {_percent(one.high)})"
        if design.is_nested(one):
            said.append(f"If it is {true}, {rival} is not claimed {share}.")
            continue
        sure = "surely" if one.power >= SURE else "hardly" if one.power < HARDLY else "not surely"
        said.append(f"If it is {true}, this tells it from {rival} {sure}: {share}.")
    for known in design.known:
        before, after = (_share(std, known.value) for std in (known.before, known.after))
        said.append(f"{plain_name(known.name)}: a standard deviation of {after} of its value; before, it is {before}.")
    return said


def _percent(share: float) -> str:
    return f"{100.0 * share:.0f} %"


def _share(std: float, value: float) -> str:
    if not math.isfinite(std) or value == 0.0:
        return "an unknown share"
    return f"{shown_number(100.0 * std / abs(value), 2)} %"


def shapes(design: Design) -> list[str]:
    """The shapes of effects over which shares are means."""
    said = []
    for number, one in enumerate(design.hypotheses):
        shapes = [
            " and ".join(f"{plain_name(name)} {_shown(design, name, value)}" for name, value in shape.items())
            for shape in design.shapes_of(one)
        ]
        if shapes:
            said.append(
                f"Nothing tells yet in which shape {design.name_of(number)} would be there. The motion is for all of "
                f"these, and its share of records is the mean over them: {listed(shapes, 'or')}."
            )
    return said


def _shown(design: Design, name: str, value: float) -> str:
    """A parameter's value with its unit."""
    shown, unit = SHOWN[design.rig.axis], known_units(design.rig.axis).get(name, "1")
    if unit == design.rig.axis:
        return shown.length(value)
    return shown_number(value, 3) + (f" {unit}" if unit != "1" else "")


def undecided(design: Design) -> list[str]:
    """What remains open after the motion, and why."""
    unknown = [
        f"{plain_name(one.name)} is known hardly better after this motion. A longer one, wider limits, other speeds of "
        "rotation or loads in [design], or a finer sensor would show more."
        for one in design.known
        if not one.after < BETTER * one.before
    ]
    return [*(_why(design, one) for one in design.undecided), *unknown]


def _why(design: Design, one: Told) -> str:
    true, rival = (design.name_of(k) for k in (one.true, one.rival))
    taken = [plain_name(name) for name in design.taken_up_by(one)]
    makes_up = f", mostly since {listed(taken)} make{'s' * (len(taken) == 1)} up for it" if taken else ""
    return (
        f"{true} remains hard to tell from {rival}: refitted, this is off by {math.sqrt(one.distance):.1f} standard "
        f"deviations of the sensors' noise over the whole motion{makes_up}. A longer motion, wider limits, other "
        "speeds of rotation or loads in [design], or a finer sensor would tell more."
    )


def _reach(design: Design) -> str:
    """Between which ends the whole reference is, and how fast."""
    legs, rig = [leg.reference for leg in design.legs], design.rig
    low, high = min(float(leg.min()) for leg in legs), max(float(leg.max()) for leg in legs)
    speed = max(float(np.max(np.abs(np.diff(leg)))) for leg in legs) / rig.sample_time
    unit = SHOWN[rig.axis].unit if rig.steering is not None else rig.along.plant.command_unit
    factor = SHOWN[rig.axis].factor if rig.steering is not None else 1.0
    ends = f"{shown_number(factor * low, 3)} and {shown_number(factor * high, 3)} {unit}"
    steps = any(piece.kind == "steps" for piece in design.pieces)
    fast = "" if steps else f", at up to {shown_number(factor * speed, 3)} {unit}/s"
    return f"Over all pieces, and on the way from one to the next, it is between {ends}{fast}."


def _loop(design: Design) -> list[str]:
    """The controller by which the rig follows."""
    if design.rig.steering is None:
        return []
    table = ", ".join(f"{name} = {value}" for name, value in design.rig.steering.table.items())
    is_asked = "controller" in design.experiment.design
    whose = "that of [design.controller]" if is_asked else "a plain one that swings under no hypothesis"
    return [f"The loop is {whose}: {table}."]


def _not_used(design: Design) -> list[str]:
    """The speeds of rotation and loads at which no piece does more."""
    used = {piece.condition for piece in design.pieces}
    rest = [_at(design, one) for one in design.rig.conditions if one not in used]
    return [f"Pieces {listed(rest, 'or')} were tried too; none does more."] if rest else []


def how_run(design: Design) -> list[str]:
    """How the rig is to be driven."""
    rig = design.rig
    kind = "the command itself, in open loop" if rig.steering is None else "the reference of the closed loop"
    said = [f"reference.csv is {kind}, a sample every {1e3 * rig.sample_time:g} ms."]
    if len(design.legs) > 1:
        said = [f"reference_1.csv to reference_{len(design.legs)}.csv are {kind}, one for each speed or load."]
    said += [
        _reach(design),
        *_loop(design),
        *_not_used(design),
        "workbench run study.toml simulates it under every hypothesis.",
    ]
    if any(piece.condition.load for piece in design.pieces):
        said.append(
            "Records under a further load are records of another plant: declare its load_force in an experiment of "
            "their own."
        )
    return said
