"""Named parameter sets and parameter files: physical values with units and sources, checked, for any plant."""

import functools
import json
from collections.abc import Iterable, Mapping
from importlib.resources import files
from pathlib import Path
from types import MappingProxyType

import numpy as np
from pydantic import ConfigDict, Field

import workbench.toml.reading as toml
from plants.axis import AXES, KINDS, LINEAR, along, name_along
from plants.axis import ROTARY as TURNING
from plants.coupling import PLACES
from plants.effects.registry import EFFECTS, effects
from plants.equation import NEGATIVE, ROTARY, NumbersT, fields, from_array
from plants.hydraulics import FLOW_LAWS
from plants.interface import Plant
from plants.laws.registry import LAWS
from plants.motor import LIMITS, TurningCylinder
from plants.rated_flow import RatedFlow, flow_gain
from plants.registry import PLANTS, plants
from workbench.errors import UserError, few_of, nearest, spelled
from workbench.toml.units import QuantityError, si

FLOW_SHARE = "flow_pressure_share"
"""Not in parameter sets: the flow law of a study gives it."""

_EFFECTS = [effect for axis in AXES for effect in effects(axis).values()]

SIGNED = ("drift_velocity", *(f"edge_overlap_{edge}" for edge in ("pa", "at", "pb", "bt")))

EITHER_SIGN = frozenset((*SIGNED, *(name for effect in _EFFECTS for name in effect.signed)))
"""Parameters that may be negative: a drift, edges that are open at rest, those of effects that act either way."""

NEUTRAL = MappingProxyType({name: value for effect in _EFFECTS for name, value in effect.neutral.items()})
"""Values of the parameters that effects bring at which they do nothing."""

WORDS: Mapping[str, Mapping[str, float]] = MappingProxyType({"measured_at": PLACES})
"""Parameters that are said in words, and the number that stands for each."""

UNBOUNDED = {
    "stroke",
    "force_limit",
    "torque_limit",
    "voltage_limit",
    "current_limit",
    "pump_speed_limit",
    "motor_nominal_torque",
    *LIMITS,
}
MAY_BE_ZERO = {
    "hose_volume",
    "tank_pressure",
    "coulomb",
    "stribeck",
    "viscous",
    "bristle_stiffness",
    "bristle_damping",
    "end_stop_stiffness",
    "end_stop_damping",
    "valve_overlap",
    "leakage_coefficient",
    "leakage_conductance",
    "external_leakage_1",
    "external_leakage_2",
    "bearing_viscous",
    "dead_volume_1",
    "dead_volume_2",
    "edge_gain_pa",
    "edge_gain_at",
    "edge_gain_pb",
    "edge_gain_bt",
    "guide_coulomb",
    "guide_stribeck",
    "elastic_share",
    "dead_band",
    "motor_viscous",
    "coupling_damping",
    *WORDS,
    *(name for name, value in NEUTRAL.items() if value == 0.0),
}
UNEQUAL = frozenset({"dead_volume_1", "pump_displacement"})
"""Parameters by which one knows a plant whose piston areas may differ."""

BELOW_ONE = {"elastic_share"}

NEAR = 6
"""Parameters that a set may lack of a plant, at most, to be told of which."""

LEAST_SHARE = 0.1
"""A drawn parameter is at least this share of its value: friction of the wrong sign, or next to none, is redrawn."""


class Entry(toml.Strict):
    """One parameter of a file; `value` and `std` are checked with the parameter's own unit."""

    model_config = ConfigDict(allow_inf_nan=True)

    value: float | str
    """A quantity, or a number in SI."""
    source: str
    """Where it comes from."""
    std: float | str | None = None
    """Its standard deviation."""
    correction: str | None = None
    """What was mended in the source, and why."""
    note: str | None = None
    """Anything else."""


class ParameterFile(toml.Strict):
    """A parameter set as it stands in a file."""

    title: str
    """Of the set."""
    source: str
    """Of the set as a whole."""
    parameters: dict[str, Entry] = Field(min_length=1)
    """By name."""


@functools.cache
def known_units(axis: str = LINEAR) -> dict[str, str]:
    """The unit of every parameter that some plant of that axis, friction law or effect has, by its canonical name."""
    known: dict[str, str] = {}
    for plant in plants().values():
        for item in fields(plant.Parameters) if plant.axis == axis else ():
            known.setdefault(item.name, item.unit)
    known |= {item.name: item.unit for cls in (TurningCylinder, RatedFlow) for item in fields(cls)}
    for law in LAWS.working().values():
        known |= {item.name: item.unit for item in fields(along(law.Extra, axis))}
    for effect in effects(axis).values():
        known |= {item.name: item.unit for item in fields(effect.Own)}
    return known


def axis_of(names: Iterable[str]) -> str:
    """The axis whose plants have parameters of these names: one that goes straight, unless only a turning one has them.

    A set for a turning axis has an `inertia`.
    """
    straight, turning = known_units(LINEAR), known_units(TURNING)
    return TURNING if any(name in turning and name not in straight for name in names) else LINEAR


def _unknown(name: str, axis: str) -> UserError:
    """What is said of a name that is no parameter's: what it is called on such an axis, or the nearest one."""
    units = {known: unit for known, unit in known_units(axis).items() if known != FLOW_SHARE}
    for own, unit in units.items():
        if own != name and name_along(own, TURNING) == name_along(name, TURNING):
            return UserError(f'unknown parameter "{name}"; {KINDS[axis]} has {own} ({unit})')
    return UserError(f'unknown parameter "{name}"; {nearby(name, units)}')


def nearby(name: str, valid: Iterable[str]) -> str:
    """A hint for the unknown name of a parameter, which a plug-in may have that cannot be used."""
    broken = [failure for registry in (PLANTS, LAWS, EFFECTS) for failure in registry.broken().values()]
    return nearest(name, valid, broken)


@functools.cache
def named_sets() -> Mapping[str, Path]:
    """The parameter sets that come with the program, by name."""
    folder = Path(str(files("plants"))) / "parameters"
    return {path.stem: path for path in sorted(folder.glob("*.toml"))}


def parameter_path(name: str, folder: Path) -> Path:
    """The file of a named set, or of a path relative to `folder`.

    Raises:
        UserError: neither a known set nor a TOML file's name.
    """
    sets = named_sets()
    if name in sets:
        return sets[name]
    if name.endswith(".toml"):
        return folder / name
    raise UserError(f'unknown parameter set "{name}"; {nearest(name, sets)} (a file needs the ending .toml)')


def read_parameters(path: Path, axis: str | None = None) -> Mapping[str, float]:
    """Values (SI) of a parameter file by canonical name, for plants of that axis (None: of that which it is for).

    Raises:
        UserError: unknown name, wrong unit, impossible value.
    """
    return _parsed(path, toml.read_text(path), axis)[0]


def read_deviations(path: Path, axis: str | None = None) -> Mapping[str, float]:
    """Standard deviations (SI) by canonical name, of those parameters of a file that have one.

    Raises:
        UserError: as `read_parameters`.
    """
    return _parsed(path, toml.read_text(path), axis)[1]


@functools.cache
def _parsed(path: Path, text: str, axis: str | None) -> tuple[Mapping[str, float], Mapping[str, float]]:
    """Values and standard deviations."""
    data = toml.parse_toml(path, text)
    content = toml.validate(ParameterFile, data, path, text)
    axis = axis or axis_of(content.parameters)
    values, deviations = {}, {}
    for name, entry in content.parameters.items():
        key = "value"
        try:
            values[name] = parameter_value(name, entry.value, axis)
            key = "std"
            if entry.std is not None:
                deviations[name] = _deviation(entry.std, known_units(axis)[name])
        except (QuantityError, UserError) as error:
            raise toml.at(path, text, ("parameters", name, key), str(error)) from None
    if {*RatedFlow._fields} & values.keys():
        values = _with_flow_gain(values, path, text)
    return MappingProxyType(values), MappingProxyType(deviations)


def _with_flow_gain(values: dict[str, float], path: Path, text: str) -> dict[str, float]:
    """Values with the valve's flow gain in the place of a data sheet's rated flow at a rated pressure drop."""
    needed = [*RatedFlow._fields, "spool_limit"]
    if "valve_flow_gain" in values or not {*needed} <= values.keys():
        raise toml.at(
            path, text, ("parameters",), f"expected {', '.join(needed)} together, and no valve_flow_gain beside them"
        )
    gain = flow_gain(RatedFlow(*(values.pop(name) for name in RatedFlow._fields)), values["spool_limit"])
    return {**values, "valve_flow_gain": gain}


def _deviation(value: object, unit: str) -> float:
    number = si(value, unit)
    if number < 0.0:
        raise UserError(f"got {spelled(value)}, expected a value that is not negative")
    return number


@functools.lru_cache(4096)  # the machine of a draw is the same for every controller, speed and motion
def drawn(name: str, value: float, deviation: float, seed: int) -> float:
    """One parameter's value (SI) drawn from the normal distribution with mean `value` and that standard `deviation`.

    Each parameter has a stream of its own, so that what else is drawn does not matter. A draw below `LEAST_SHARE` of
    the value is non-physical and drawn again, but for parameters that may have either sign. With the thesis's spreads
    (at most 0.31 of the value: 2.9 deviations to that bound) this moves no mean by more than 0.2 %.
    """
    generator = np.random.default_rng([seed, *name.encode()])
    least = -np.inf if name in EITHER_SIGN else LEAST_SHARE * value
    while (number := value + deviation * generator.standard_normal()) < least:
        pass
    return float(number)


def parameter_value(name: str, value: object, axis: str = LINEAR) -> float:
    """One parameter's value (SI) from text or number, in the unit that it has on that axis.

    Raises:
        UserError: unknown name or impossible value.
        QuantityError: wrong unit.
    """
    units = known_units(axis)
    if name not in units or name == FLOW_SHARE:
        raise _unknown(name, axis)
    if name in WORDS:
        if value not in WORDS[name]:
            raise UserError(f"got {spelled(value)}, expected {' or '.join(json.dumps(word) for word in WORDS[name])}")
        return WORDS[name][str(value)]
    number = si(value, units[name], infinite=name in UNBOUNDED)
    check_range(name, number, axis)
    return number


@functools.cache
def plain_name(name: str) -> str:
    """A parameter's name without what says for which direction, or around the rod, it holds."""
    return name.removesuffix(f"_{NEGATIVE}").removesuffix(f"_{ROTARY}")


def check_range(name: str, number: float, axis: str = LINEAR) -> None:
    """Raise UserError where `number` (SI) is impossible for the parameter."""
    plain = plain_name(name)
    if plain in EITHER_SIGN:
        return
    if number < 0.0:
        raise UserError(f"got {number:g} {known_units(axis)[name]}, expected a value that is not negative")
    if plain in BELOW_ONE and number >= 1.0:
        raise UserError(f"got {number:g}, expected a share below 1")
    if number == 0.0 and plain not in MAY_BE_ZERO:
        raise UserError(f"got 0 {known_units(axis)[name]}, expected a value above 0")


def build(cls: type[NumbersT], values: Mapping[str, float], flow: str = "derived") -> NumbersT:
    """The parameters of a plant class from values by canonical name; values that it does not know are left out.

    A `_negative` value that is not given is that of the positive direction, and so is a `_rotary` one.

    Raises:
        UserError: parameters are missing, or the values do not fit together.
    """
    available = {**values, FLOW_SHARE: FLOW_LAWS[flow]}
    numbers = _numbers(cls, available)
    known = [number for number in numbers.values() if number is not None]
    if len(known) < len(numbers):
        raise UserError(f"the parameter set lacks {few_of(_missing(numbers))}")
    _check_together(available, list(numbers))
    return from_array(cls, known)


def _numbers(cls: type[NumbersT], available: Mapping[str, float]) -> dict[str, float | None]:
    """Each parameter of a plant class; None where nothing gives it."""
    numbers = dict[str, float | None]()
    for item in fields(cls):
        number = available.get(item.name)
        numbers[item.name] = available.get(plain_name(item.name), item.default) if number is None else number
    return numbers


def _missing(numbers: Mapping[str, float | None]) -> list[str]:
    """The parameters that nothing gives, each once for both directions."""
    return list(dict.fromkeys(plain_name(name) for name, number in numbers.items() if number is None))


def serves(values: Mapping[str, float]) -> list[str]:
    """In words, which plants along their axis can be built from these values, and what is missing for those that are
    near to it.
    """
    axis, far = axis_of(values), list[str]()
    found: dict[str | None, list[str]] = {None: []}
    for plant in plants().values():
        if plant.axis == axis:
            missing = _missing(_numbers(plant.Parameters, {**values, FLOW_SHARE: 0.0}))
            own = far if len(missing) > NEAR else found.setdefault(lacks(plant, values), [])
            own.append(plant.name)
    able = ", ".join(found.pop(None)) or "no plant"
    lines = [f"serves {able}", *(f"does not serve {', '.join(names)}: {why}" for why, names in found.items())]
    return [*lines, *([f"lacks more than {NEAR} parameters of {', '.join(far)}"] if far else [])]


def lacks(plant: Plant, values: Mapping[str, float]) -> str | None:
    """Why a plant cannot be built from these values, in words; None where it can."""
    try:
        build(plant.Parameters, values)
    except UserError as error:
        return str(error)
    return None


def _check_together(values: Mapping[str, float], names: Iterable[str]) -> None:
    if "piston_area_2" in names and not UNEQUAL & {*names} and values["piston_area_1"] != values["piston_area_2"]:
        raise UserError(
            f"piston areas {values['piston_area_1']:g} and {values['piston_area_2']:g} m^2 differ: the load-pressure "
            'form holds for equal areas only; expected model = "cylinder", or equal areas'
        )
    for suffix in ("", f"_{NEGATIVE}", f"_{ROTARY}"):
        level = [values.get(f"{name}{suffix}", values.get(name)) for name in ("coulomb", "stribeck")]
        stiffness = values.get(f"bristle_stiffness{suffix}", values.get("bristle_stiffness"))
        if level == [0.0, 0.0] and stiffness:
            raise UserError(
                f"coulomb{suffix} and stribeck{suffix} are both 0: a contact without any friction level needs "
                "bristle_stiffness = 0 too"
            )
