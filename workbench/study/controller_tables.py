"""[controllers] and [references] of a case: the type that it names, its settings in SI, what it follows or feeds."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from controllers.interface import Controller
from controllers.open_loop import OPEN_LOOP
from controllers.registry import CONTROLLERS
from controllers.settings import ANY, Setting, settings_of, usable
from plants.equation import fields
from plants.interface import Plant
from workbench.errors import UserError, nearest, spelled
from workbench.simulation.references import ReferenceSignal
from workbench.study.reference_tables import REFERENCES
from workbench.study.registered import registered
from workbench.study.schema import CaseTables
from workbench.toml import reading as files
from workbench.toml.reading import SchemaError
from workbench.toml.units import QuantityError, si


@dataclass(frozen=True)
class ControllerCase:
    """The controller of a case as its tables say it: its name, that of its type, and its settings (SI).

    `signal` is its reference, or, where it drives the plant in open loop, what is fed to the input `fed` (else "").
    """

    name: str
    type: str
    controller: Controller
    settings: Any
    signal: ReferenceSignal | None
    fed: str


def parse_controller(tables: CaseTables, plant: Plant, folder: Path) -> ControllerCase:
    """The controller of a case on a plant; `folder` is where recorded references are looked for.

    Raises:
        SchemaError: none or several without an axis that chooses, an unknown type, setting or kind, a value of the
            wrong unit or out of its range.
    """
    name = _chosen("controller", tables.controller, tables.controllers)
    if name is None:
        raise SchemaError(("controllers",), "is missing: expected a table such as [controllers.p]")
    controller, settings = _controller(name, tables, plant)
    unit, fed = plant.axis, ""
    if controller is OPEN_LOOP:
        fed = settings.input or plant.command
        units = {item.name: item.unit for item in fields(plant.Inputs)}
        if fed not in units:
            key = ("controllers", name, "input")
            raise SchemaError(key, f'plant {plant.name} has no input "{fed}"; {nearest(fed, units)}')
        unit = units[fed]
    reference = _chosen("reference", tables.reference, tables.references)
    signal = None if reference is None else _reference(reference, tables.references[reference], unit, folder)
    return ControllerCase(name, str(tables.controllers[name]["type"]), controller, settings, signal, fed)


def _chosen(kind: str, name: str | None, available: Mapping[str, object]) -> str | None:
    """The name that an axis gives, or that of the only one there is."""
    if name is None and len(available) > 1:
        *others, last = available
        message = f'there is "{others[0]}" too: expected an axis {kind} that says which'
        raise SchemaError((f"{kind}s", last), message)
    return name or next(iter(available), None)


def _controller(name: str, tables: CaseTables, plant: Plant) -> tuple[Controller, Any]:
    key = ("controllers", name)
    table = dict(tables.controllers[name])
    if "type" not in table:
        hint = nearest("", CONTROLLERS.working())
        raise SchemaError((*key, "type"), f"is missing; this key is needed here; {hint}")
    controller = registered(CONTROLLERS, str(table.pop("type")), (*key, "type"))
    declared, offered = settings_of(controller.Settings), usable(controller)
    mistakes = [
        SchemaError((*key, item), f"unknown key; {nearest(item, [*offered, 'type'])}")
        for item in table
        if item not in declared
    ]
    mistakes += [
        SchemaError((*key, item.name), "is missing; this key is needed here")
        for item in declared.values()
        if item.name not in table and item.default is None
    ]
    if mistakes:
        raise files.together(mistakes)
    values: dict[str, Any] = {}
    for item, value in table.items():
        try:
            values[item] = _setting_value(declared[item], value, plant)
        except QuantityError as error:
            raise SchemaError((*key, item), str(error)) from None
    settings: Any = controller.Settings
    return controller, settings(**values)


def _setting_value(item: Setting, value: object, plant: Plant) -> float | str:
    """A setting's value in SI, or its choice.

    Raises:
        QuantityError: the wrong unit, out of its range, or no such choice.
    """
    if item.unit:
        number = si(value, plant.unit_for(item.unit))
        if not item.about.admits(number):
            raise QuantityError(f"got {json.dumps(value)}, expected {item.about.expected}")
        return number
    if not isinstance(value, str) or (item.choices != (ANY,) and value not in item.choices):
        expected = "a name" if item.choices == (ANY,) else f"one of {', '.join(item.choices)}"
        raise QuantityError(f"got {spelled(value)}, expected {expected}")
    return value


def _reference(name: str, table: Mapping[str, object], unit: str, folder: Path) -> ReferenceSignal:
    key = ("references", name)
    kind = table.get("kind")
    if kind is None:
        hint = nearest(str(kind), REFERENCES.working())
        raise SchemaError((*key, "kind"), f"is missing; this key is needed here; {hint}")
    declared = registered(REFERENCES, str(kind), (*key, "kind"))
    try:
        return files.conform(declared.table, table).build(unit, folder)
    except SchemaError as error:
        raise files.together(
            [SchemaError((*key, *each.key), each.message) for each in (error, *error.others)]
        ) from None
    except UserError as error:
        raise SchemaError(key, str(error)) from None
