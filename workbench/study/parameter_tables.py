"""[plant] and [belief]: from their sets, files and changes to the plant's parameters, true and believed."""

import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from plants import motor
from plants.equation import NEGATIVE
from plants.interface import Plant
from plants.laws.registry import LAWS
from workbench.errors import UserError, nearest
from workbench.parameters.sets import (
    build,
    drawn,
    nearby,
    parameter_path,
    parameter_value,
    plain_name,
    read_deviations,
    read_parameters,
)
from workbench.study.registered import registered
from workbench.study.schema import CaseTables
from workbench.study.study import Case
from workbench.toml.reading import SchemaError
from workbench.toml.units import QuantityError

LACKING = ("stribeck", "bristle_damping")
"""What a friction law may be without, and a compensator then takes for 0. Its bristle stays as stiff as it is declared:
an observer needs one."""


@dataclass(frozen=True)
class ParameterValues:
    """What the sets or files of a case and its `set` tables say of parameters (SI, by canonical name): true values,
    their standard deviations, and what controllers believe them to be, which is of the set `source`.
    """

    true: Mapping[str, float]
    deviations: Mapping[str, float]
    believed: Mapping[str, float]
    source: str


def read_values(tables: CaseTables, case: Case, axis: str) -> ParameterValues:
    """The values of [plant], whose axis is given, and of [belief], else of what [plant] declares; never of a scenario.

    Controllers believe 0 where the friction law that they believe in has no place for a value.

    Raises:
        SchemaError: an unknown set, parameter or friction law, an impossible value.
    """
    table, belief, declared = tables.plant, tables.belief, case.declared
    true = _values(table.parameters, table.set, case.folder, "plant", axis)
    source = belief.parameters or declared.get("parameters", table.parameters)
    overrides = {**({} if belief.parameters else declared.get("set", {})), **belief.set}
    believed = _values(source, overrides, case.folder, "belief", axis)
    law = registered(LAWS, belief.friction, ("belief", "friction"))
    believed |= {name: 0.0 for name in believed if plain_name(name) in LACKING and plain_name(name) not in law.uses}
    return ParameterValues(true, read_deviations(parameter_path(table.parameters, case.folder), axis), believed, source)


class ParameterReader:
    """`read_values`, once for all cases that say the same of parameters: a file is as it was when it was first read."""

    def __init__(self) -> None:
        self._known: dict[str, ParameterValues] = {}

    def __call__(self, tables: CaseTables, case: Case, axis: str) -> ParameterValues:
        """See `read_values`."""
        said, declared = tables.plant, case.declared
        own = said.parameters, said.set, declared.get("parameters"), declared.get("set")
        key = repr((own, case.tables.get("belief"), axis))
        if key not in self._known:
            self._known[key] = read_values(tables, case, axis)
        return self._known[key]


def _values(parameters: str, overrides: Mapping[str, object], folder: Path, table: str, axis: str) -> dict[str, float]:
    """Values of a set or file with `set` overrides, by canonical name; a plain name sets both directions."""
    try:
        values = dict(read_parameters(parameter_path(parameters, folder), axis))
    except UserError as error:
        raise SchemaError((table, "parameters"), str(error)) from None
    for name, value in overrides.items():
        try:
            number = parameter_value(name, value, axis)
        except (UserError, QuantityError) as error:
            raise SchemaError((table, "set", name), str(error)) from None
        own = f"{name}_{NEGATIVE}"
        values |= dict.fromkeys([name, *([own] if own in values and own not in overrides else [])], number)
    return values


def _rotated(plant: Plant, values: Mapping[str, float], table: Mapping[str, object]) -> Mapping[str, float]:
    """Values with what a study says of rotation in [plant]: `turned`, `inertia`, `motor` and `motor_limits`.

    Where the cylinder turns (thesis 6.2), the rod at rest in it, the friction is the same and the inertia another:
    `cylinder_inertia`. Inertia "mass" is the thesis's M R^2 (section 3.3.1.2). A "consistent" motor has the back-EMF
    constant of its torque constant, so that what enters at the terminals is shaft power, winding loss and what winding
    and rotor store: torque and current are what the thesis measured friction with (4.2), the printed back EMF only
    moves the voltage.
    """
    if not plant.rotary_command:
        return values
    values = dict(values)
    if table.get("turned") == "cylinder":
        if "cylinder_inertia" not in values:
            raise UserError('turned = "cylinder" needs cylinder_inertia, that of all that turns with the cylinder')
        values["rotary_inertia"] = values["cylinder_inertia"]
    elif table.get("inertia") == "mass" and {"mass", "piston_radius"} <= values.keys():
        values["rotary_inertia"] = values["mass"] * values["piston_radius"] ** 2
    if table.get("motor") == "consistent" and "torque_constant" in values:
        values["back_emf_constant"] = values["torque_constant"]
    if not table.get("motor_limits", True):
        values |= dict.fromkeys(motor.LIMITS, math.inf)
    return values


def build_truth(plant: Plant, tables: CaseTables, read: ParameterValues) -> NamedTuple:
    """The plant's parameters: the values of [plant], with its `spread` and `scale` over them, in that order.

    Raises:
        SchemaError: unknown parameters, or values that do not serve the plant.
    """
    table, values = tables.plant, dict(read.true)
    _spread(values, tables, read.deviations)
    for name, ratio in table.scale.items():
        if name not in values:
            raise SchemaError(("plant", "scale", name), f"unknown parameter; {nearby(name, values)}")
        if not ratio >= 0.0:
            raise SchemaError(("plant", "scale", name), f"got {ratio}, expected a factor that is not negative")
        for scaled in (name, f"{name}_negative"):
            if scaled in values:
                values[scaled] *= ratio
    try:
        return build(plant.Parameters, _rotated(plant, values, dict(table)), table.flow)
    except UserError as error:
        raise SchemaError(
            ("plant", "parameters"), f'"{table.parameters}" does not serve {plant.name}: {error}'
        ) from None


def _spread(values: dict[str, float], tables: CaseTables, deviations: Mapping[str, float]) -> None:
    """Draw the parameters of [plant.spread] about their values, each direction apart where the file has both."""
    table = tables.plant
    for name, times in table.spread.items():
        if name not in deviations:
            hint = nearest(name, deviations)
            raise SchemaError(("plant", "spread", name), f'"{table.parameters}" gives no std for it; {hint}')
        if not times >= 0.0:
            raise SchemaError(("plant", "spread", name), f"got {times}, expected a factor that is not negative")
        for each in (name, f"{name}_negative"):
            if each in deviations:
                values[each] = drawn(each, values[each], times * deviations[each], tables.simulation.seed)


def build_belief(plant: Plant, tables: CaseTables, declared: Mapping[str, object], read: ParameterValues) -> NamedTuple:
    """What controllers believe the parameters to be, of a plant table as `declared`.

    Whether the motor has limits is on its nameplate: there belief follows the truth.

    Raises:
        SchemaError: values that do not serve the plant.
    """
    try:
        values = _rotated(plant, read.believed, {**declared, "motor_limits": tables.plant.motor_limits})
        return build(plant.Parameters, values, tables.belief.flow or str(declared.get("flow", "derived")))
    except UserError as error:
        raise SchemaError(("belief", "parameters"), f'"{read.source}" does not serve {plant.name}: {error}') from None
