"""What is asked of a design, in SI: the table [design] of an experiment, with what a command line says instead."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from plants.axis import unit_along
from plants.interface import SENSORS
from workbench.design.pieces import Condition
from workbench.design.rig import Limits
from workbench.design.schema import DesignTable
from workbench.errors import UserError, nearest
from workbench.parameters.sets import parameter_value
from workbench.records.channels import quantity
from workbench.records.experiment import Experiment, parameter_names
from workbench.records.schema import CHANNELS
from workbench.toml import reading as files
from workbench.toml.units import QuantityError

SHORTEST, LONGEST = 4.0, 600.0
"""s of a motion."""

MOST_HYPOTHESES, MOST_CONDITIONS = 6, 12
"""That one motion is for: each costs its simulations."""


@dataclass(frozen=True)
class Asked:
    """What a motion is for, how long (s) it may last, how the rig is driven, and what it allows; see `DesignTable`."""

    between: Sequence[str]
    identify: Sequence[str]
    sizes: Mapping[str, float]
    duration: float
    closed: bool
    controller: Mapping[str, Any] | None
    conditions: Sequence[Condition]
    limits: Mapping[str, float]
    noise: Mapping[str, float]
    sample_time: float | None

    @property
    def rotates(self) -> bool:
        """Whether a rod has to turn."""
        return any(condition.rotation > 0.0 for condition in self.conditions)


def asked_of(
    experiment: Experiment,
    between: Sequence[str] = (),
    identify: Sequence[str] = (),
    duration: float | None = None,
) -> Asked:
    """The table [design] of an experiment in SI, with what is given here in its place.

    Raises:
        UserError: the first mistake, with its place.
    """
    text = files.read_text(experiment.path)
    try:
        table = files.conform(DesignTable, experiment.design)
        found = _asked(table, experiment, between, identify, duration)
    except files.SchemaError as mistake:
        raise files.lines_of(
            (mistake, *mistake.others),
            lambda each: files.at(experiment.path, text, ("design", *each.key), each.message),
        ) from None
    for what, count, most in (
        ("hypotheses", len(found.between), MOST_HYPOTHESES),
        ("speeds of rotation and loads", len(found.conditions), MOST_CONDITIONS),
    ):
        if count > most:
            raise UserError(f"{experiment.path}: {count} {what} are held against each other, expected {most} at most")
    for what, names in (("hypothesis", found.between), ("parameter", found.identify)):
        for name in names:
            if names.count(name) > 1:
                raise UserError(f"{experiment.path}: {what} {name} is asked for more than once")
    for name in found.identify:
        if name not in (known := parameter_names(experiment.plant)):
            said = f'"{name}": unknown parameter; {nearest(name, known)}'
            if identify:
                raise UserError(f"--identify {said}")
            raise files.at(experiment.path, text, ("design", "identify"), said)
    if not SHORTEST <= found.duration <= LONGEST:
        raise UserError(f"duration: got {found.duration:g} s, expected {SHORTEST:g} s to {LONGEST:g} s")
    return found


def _asked(
    table: DesignTable, experiment: Experiment, between: Sequence[str], identify: Sequence[str], duration: float | None
) -> Asked:
    axis, plant = experiment.plant.axis, experiment.plant
    position, force = axis, unit_along("N", axis)
    if any(rpm > 0.0 for rpm in table.rpm) and plant.rotary_command is None:
        raise files.SchemaError(
            ("rpm",), f'plant {plant.name} does not turn; declare it with turned = "rod", or leave it out'
        )
    units = {
        "low": position,
        "high": position,
        "speed": f"{position}/s",
        "least_pressure": "Pa",
        "most_pressure": "Pa",
        "command": plant.command_unit,
    }
    limits = {name: quantity(value, units[name], ("limits", name)) for name, value in table.limits if value is not None}
    _check_limits(limits)
    for name in ("least_pressure", "most_pressure"):
        if name in limits and "pressure_1" not in plant.channels:
            raise files.SchemaError(("limits", name), f"plant {plant.name} has no pressures; leave it out")
    loads = [quantity(load, force, ("loads", i)) for i, load in enumerate(table.loads)]
    for key, values in (("rpm", table.rpm), ("loads", loads)):
        if len({*values}) < len(values):
            raise files.SchemaError((key,), "a value stands there more than once")
    if table.controller is not None and table.loop == "open":
        raise files.SchemaError(("controller",), 'belongs to loop = "closed"')
    return Asked(
        between=tuple(between) or tuple(table.between),
        identify=tuple(identify) or tuple(table.identify),
        sizes=_sizes(table, axis),
        duration=table.duration if duration is None else duration,
        closed=table.loop == "closed",
        controller=table.controller,
        conditions=[Condition(rotation, load) for rotation in table.rpm for load in loads],
        limits=limits,
        noise=_noise(table, axis),
        sample_time=table.sample_time,
    )


def _check_limits(limits: Mapping[str, float]) -> None:
    for name in ("speed", "command"):
        if limits.get(name, 1.0) <= 0.0:
            raise files.SchemaError(("limits", name), f"got {limits[name]:g}, expected a value above 0")
    for least, most in (("low", "high"), ("least_pressure", "most_pressure")):
        default = Limits._field_defaults
        lower, upper = limits.get(least, default[least]), limits.get(most, default[most])
        if lower >= upper:
            raise files.SchemaError(
                ("limits", least if least in limits else most),
                f"got {lower:g} for {least} and {upper:g} for {most}, expected {least} below {most}",
            )


def _sizes(table: DesignTable, axis: str) -> dict[str, float]:
    found = {}
    for name, value in table.sizes.items():
        try:
            found[name] = parameter_value(name, value, axis)
        except (UserError, QuantityError) as error:
            raise files.SchemaError(("sizes", name), str(error)) from None
    return found


def _noise(table: DesignTable, axis: str) -> dict[str, float]:
    found = {}
    for name, value in table.noise.items():
        if name not in SENSORS:
            raise files.SchemaError(("noise", name), f"no channel with a sensor; {nearest(name, SENSORS)}")
        found[name] = quantity(value, unit_along(CHANNELS[name], axis), ("noise", name))
        if found[name] <= 0.0:
            raise files.SchemaError(("noise", name), f"got {found[name]:g}, expected a standard deviation above 0")
    return found


def limits_of(asked: Asked, low: float, high: float, speed: float) -> Limits:
    """The rig's limits, those of a record or of its plant where none is said.

    Raises:
        UserError: they leave no room within what the plant can do.
    """
    given = asked.limits
    found = Limits(
        low=max(given.get("low", low), low),
        high=min(given.get("high", high), high),
        speed=given.get("speed", speed),
        least_pressure=given.get("least_pressure", -float("inf")),
        most_pressure=given.get("most_pressure", float("inf")),
        command=given.get("command", float("inf")),
    )
    if found.low >= found.high:
        raise UserError(
            f"[design.limits]: between {found.low:g} and {found.high:g} there is no room; the plant has {low:g} to "
            f"{high:g}"
        )
    return found
