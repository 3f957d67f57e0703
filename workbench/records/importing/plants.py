"""Which plant fits the channels of a log: by its inputs, and by what its sensors show."""

from collections.abc import Collection, Mapping
from typing import NamedTuple

from plants.equation import fields
from plants.interface import Plant
from plants.registry import PLANTS
from workbench.errors import UserError, nearest
from workbench.parameters.sets import lacks
from workbench.records.channels import FORCE, TORQUE
from workbench.records.importing.channels import Found
from workbench.records.importing.proposal import Ask, Line, Question
from workbench.records.importing.units import ANGLES
from workbench.records.sampling.sight import SLOW
from workbench.toml.units import QuantityError, factor

SENSORS = ("position", "pressure_1", "pressure_2")
"""What nearly every rig would measure if it had it: a plant that shows more than the log is believed less."""

FREELY = ("time", "velocity", "acceleration", "supply_pressure", "motor_current")
"""Channels that a log may have beside those of the plant."""

NOT_SHOWN = 0.5
"""What a sensor counts that a plant has and a log has not."""


OIL = "bulk_modulus"
"""The parameter by which a plant is known to be full of oil."""

AIR = 1.2e6
"""Pa up to which pressures are those of compressed air: its networks have 10 bar above the surroundings."""

UNLIKELY = 0.25
"""What it counts that pressures are those of air, and the plant is full of oil, or the other way round."""


class Fit(NamedTuple):
    """How well a plant fits, the larger the better, and the channels that it uses."""

    score: float
    plant: Plant
    used: frozenset[str]


def plant_for(
    found: Mapping[str, Found],
    model: str | None,
    values: Mapping[str, float] | None = None,
    sample_time: float = 0.0,
    ask: Ask | None = None,
) -> tuple[Plant, Line]:
    """The plant, and its line of the file: as asked for, or what fits best; with what else would, for a user to choose.

    Where a parameter set's `values` (SI) are known, it is one that they serve, if any is. Of a log whose `sample_time`
    (s) is slow it is rather one that is known by how fast it goes than by a force, which does not show there.

    Raises:
        UserError: there is no such plant, or none fits.
    """
    known = PLANTS.working()
    if model is not None:
        if model not in known:
            raise UserError(f'--plant "{model}": unknown plant; {nearest(model, known)}')
        return known[model], Line("model", {"": model}, "as asked for")
    slow = sample_time > SLOW
    served = set(known) if values is None else {name for name, plant in known.items() if lacks(plant, values) is None}
    fits = sorted(
        filter(None, (_fit(plant, found) for name, plant in known.items() if name in served or not served)),
        key=lambda fit: (-fit.score, bool(fit.plant.friction) == slow, len(fields(fit.plant.Parameters))),
    )
    names = ", ".join(name for name in found if name != "time") or "none but the time"
    if not fits:
        raise UserError(f"no plant fits these channels: {names}; name one with --plant, and its command by hand")
    best, others = fits[0], [fit.plant.name for fit in fits[1:] if fit.score >= fits[0].score - NOT_SHOWN]
    another = "" if ask is not None else " (another one needs other values: import again with --plant)"
    asked = Question(f"which plant is it? What fits as well: {', '.join(others[:4])}{another}")
    reason = f"its command and sensors are those of the log: {names}"
    if slow and not best.plant.friction:
        reason += f"; at {1.0 / sample_time:.3g} Hz no force shows"
    line = Line("model", {"": best.plant.name}, reason, (asked,) if others else ()).asked(ask)
    chosen = str(line.values[""])
    if chosen not in known:
        raise UserError(f'plant "{chosen}": unknown; {nearest(chosen, known)}')
    return known[chosen], line


def _fit(plant: Plant, found: Mapping[str, Found]) -> Fit | None:
    """How a plant fits; None where its axis is another one or nothing gives its command."""
    position = found.get("position")
    turns = (position is not None and position.unit in ANGLES) or TORQUE in found
    if (plant.axis == "rad") != turns or (plant.rotary_command is not None and "rotation_speed" not in found):
        return None
    command = given(plant, found)
    if not command:
        return None
    inputs = {item.name for item in fields(plant.Inputs)}
    shown = [name for name in plant.channels if name in SENSORS or plant.rotary_command is not None]
    used = {name for name in found if name in inputs or name in shown} | {command}
    lost = [name for name in found if name not in used and name not in FREELY]
    lacking = [name for name in SENSORS if name in plant.channels and name not in found]
    direct = NOT_SHOWN * (command == plant.command)
    score = len(used) + direct - len(lost) - NOT_SHOWN * len(lacking) - UNLIKELY * _is_unlikely(plant, found)
    return Fit(score, plant, frozenset(used))


def _is_unlikely(plant: Plant, found: Mapping[str, Found]) -> bool:
    """Whether a plant has oil where the pressures, if their scale is known, are those of air, or air where not."""
    known = [one for name, one in found.items() if name in SENSORS and name != "position"]
    asked = any(question.key == "scale" for one in known for question in one.questions)
    if not known or asked or not any(name in plant.channels for name in SENSORS if name != "position"):
        return False
    highest = max(factor(one.unit, "Pa") * abs(one.scale) * one.column.size for one in known)
    return (OIL in [item.name for item in fields(plant.Parameters)]) == (highest <= AIR)


def given(plant: Plant, found: Collection[str] | Mapping[str, Found]) -> str:
    """The channel that gives a plant's command; "" where none does."""
    if plant.command in found:
        return plant.command
    drives = next((name for name in (FORCE, TORQUE) if name in found), "")
    if drives and plant.command.endswith((FORCE, TORQUE)):
        return drives
    if "command" in found and (not isinstance(found, Mapping) or _measures(found["command"].unit, plant.command_unit)):
        return "command"
    if "motor_current" in found and plant.command_unit == "A":
        return "motor_current"
    return ""


def _measures(unit: str, other: str) -> bool:
    try:
        factor(unit, other)
    except QuantityError:
        return False
    return True
