"""[plant] fmu: an FMU in the place of the declared machine, which stays what controllers believe in.

The model and its parameters are the nameplate: what drives the machine and how far, what is measured, and in which
units. What the machine does with its inputs the FMU says.
"""

import hashlib
import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple, cast

import numpy as np

from controllers.interface import Reference
from plants.equation import Field, fields, named, named_tuple
from plants.interface import SENSORS, Measurement, Plant
from workbench.errors import UserError, few_of, nearest
from workbench.fmu.description import NUMBERS, Fmu, FmuVariable, read_fmu
from workbench.fmu.machine import ABSENT, STILL, FmuMachine, Mapped, check_runs
from workbench.fmu.units import factor_to, value_for
from workbench.simulation.setup import Loop
from workbench.study.schema import CaseTables, FmuVariableTable
from workbench.study.study import Case, Study
from workbench.toml.reading import Key, SchemaError
from workbench.toml.units import QuantityError

NEEDED = ("position", "velocity")
"""Outputs without which there is nothing to judge."""

OF_THE_MODEL = ("friction", "start", "start_position", "minimum_helical_speed")
OF_THE_SOLVER = ("method", "step")


STANDING = ("rotation_speed", "motor_current")
"""What is 0 of a machine that does not turn."""

STEPS_TRIED = 3
"""Steps of a controller within which it shows that it needs a reading."""


class Limits(NamedTuple):
    """What the declared machine says of an FMU: its amplifiers' limits, in the commands' units, and its travel."""

    command_limit: Annotated[float, "1"]
    rotary_limit: Annotated[float, "1"]
    travel: Annotated[float, "m"]


@dataclass(frozen=True)
class ForeignPlant:
    """An FMU as a plant: its states are the outputs that are mapped, without equations of their own."""

    plant: Plant
    limits: Limits
    machine: FmuMachine

    @property
    def state(self) -> NamedTuple:
        """Where it starts the FMU alone knows."""
        return self.plant.State._make([0.0] * len(self.plant.State._fields))

    def inputs(self, believed: NamedTuple) -> NamedTuple:
        """Its inputs, of those of the model."""
        known = named(believed)
        return self.plant.Inputs._make([known[name] for name in self.plant.Inputs._fields])


def foreign_plant(tables: CaseTables, case: Case, model: Plant, declared: Any, allowed: bool | None) -> ForeignPlant:
    """The FMU of a case; `model` and its `declared` parameters are the machine in whose place it stands.

    Raises:
        SchemaError: it cannot be read, the mapping does not fit, the study changes what the FMU does not take; or it is
            to be run and may not be, or cannot be here.
    """
    _check_own(tables, case)
    table = tables.plant
    try:
        fmu = read_fmu(case.folder / str(table.fmu))
        if allowed is not None:
            check_runs(fmu, allowed)
    except UserError as error:
        raise SchemaError(("plant", "fmu"), str(error)) from None
    known = {item.name: item for item in fields(model.Inputs)}
    driven = [model.command, *([model.rotary_command] if model.rotary_command else [])]
    inputs = _mapped(fmu, table.inputs, known, driven, "input", model)
    shown = _shown(model)
    outputs = _mapped(fmu, table.outputs, shown, NEEDED, "output", model)
    turns = model.rotary_command is not None
    places = [*outputs]
    channels = [
        places.index(name) if name in outputs else STILL if name in STANDING and not turns else ABSENT
        for name in Measurement._fields
    ]
    parameters = tuple(_start_value(fmu, name, value) for name, value in table.start_values.items())
    machine = FmuMachine(
        fmu, tuple(inputs.values()), tuple(outputs.values()), tuple(channels), parameters, bool(allowed)
    )
    limits = Limits(
        float(model.command_limit(declared)), float(model.rotary_limit(declared)), float(model.travel(declared))
    )
    return ForeignPlant(
        _plant(fmu, model, [*inputs], [shown[name] for name in outputs], machine.channels), limits, machine
    )


def refuse_fmu(study: Study, command: str) -> None:
    """Raise UserError where a study names an FMU and the command needs a plant's equations."""
    file = study.file
    layers = [("cases", file.cases), ("machines", file.machines), ("scenarios", file.scenarios)]
    places: dict[Key, Any] = {("plant",): file.plant}
    places |= {
        (section, name, "plant"): table.get("plant") for section, known in layers for name, table in known.items()
    }
    for place, table in places.items():
        if isinstance(table, dict) and "fmu" in table:
            message = f"{command} needs a plant's equations, and an FMU has none; use workbench run"
            raise study.error((*place, "fmu"), message)


def check_sees(foreign: ForeignPlant, loop: Loop, sample_time: float, key: Key) -> None:
    """Raise SchemaError where a controller computes with a reading that no output of the FMU gives."""
    channels = foreign.machine.channels
    missing = [name for name, place in zip(Measurement._fields, channels, strict=True) if place == ABSENT]
    needed = next((name for name in missing if name in SENSORS and not _commands(loop, name, sample_time)), None)
    if needed is not None and _commands(loop, "", sample_time):
        message = f'controller type "{loop.controller.name}" needs {needed}; expected it in [plant.outputs]'
        raise SchemaError(key, message)


def _commands(loop: Loop, missing: str, sample_time: float) -> bool:
    """Whether the controller's first commands are numbers where that reading is none."""
    seen = Measurement(*(np.float64(math.nan if name == missing else 0.0) for name in Measurement._fields))
    state, commands = loop.controller.start(seen, loop.gains), []
    with np.errstate(all="ignore"):
        for _ in range(STEPS_TRIED):
            command, state = loop.controller.step(Reference(0.0, 0.0, 0.0), seen, state, loop.gains, sample_time)
            commands.append(float(command))
    return not any(map(math.isnan, commands))


def _check_own(tables: CaseTables, case: Case) -> None:
    """Raise SchemaError for what changes a plant of ours, and would change nothing here."""
    table, declared = tables.plant, case.declared.get("set", {})
    for section, names in (("scale", table.scale), ("spread", table.spread)):
        for name in names:
            message = "an FMU has parameters of its own; expected [plant.start_values]"
            raise SchemaError(("plant", section, name), message)
    for name, value in table.set.items():
        if declared.get(name) != value:
            message = "an FMU has parameters of its own; expected [plant.start_values], or [belief.set]"
            raise SchemaError(("plant", "set", name), message)
    for part, own in (("plant", OF_THE_MODEL), ("simulation", OF_THE_SOLVER)):
        for name in own:
            if name in getattr(tables, part).model_fields_set:
                raise SchemaError((part, name), "is the FMU's own affair; leave it out")
    if tables.sensors.friction_gauge:
        raise SchemaError(("sensors", "friction_gauge"), "no FMU shows its true friction; leave it out")


def _shown(model: Plant) -> dict[str, Field]:
    """What outputs may be: the model's states, signals and measurements, with unit and typical magnitude."""
    measured = {item.name: item._replace(unit=model.unit_for(item.unit)) for item in fields(Measurement)}
    named = {name: item for name, item in measured.items() if name in SENSORS}
    for cls in (model.Signals, model.State):
        named |= {item.name: item for item in fields(cls)}
    return named


def _mapped(
    fmu: Fmu,
    table: Mapping[str, str | FmuVariableTable],
    known: Mapping[str, Field],
    needed: tuple[str, ...] | list[str],
    causality: str,
    model: Plant,
) -> dict[str, Mapped]:
    """The variables of a mapping, by the model's names, in its order.

    Raises:
        SchemaError: a name that the model, or the FMU, does not have; another causality or unit; one that is needed.
    """
    place: Key = ("plant", f"{causality}s")
    if missing := next((name for name in needed if name not in table), None):
        raise SchemaError(
            place, f'lacks {missing}; expected {missing} = "...", one of {few_of(fmu.named(causality)) or "none"}'
        )
    found = {}
    for name, item in table.items():
        if name not in known:
            raise SchemaError((*place, name), f"{model.name} has no such {causality}; {nearest(name, known)}")
        said = item if isinstance(item, FmuVariableTable) else FmuVariableTable(variable=item)
        variable = _variable(fmu, said.variable, causality, (*place, name))
        try:
            found[name] = Mapped(variable.reference, factor_to(fmu, variable, known[name].unit, said.unit))
        except QuantityError as error:
            raise SchemaError((*place, name), str(error)) from None
    return found


def _variable(fmu: Fmu, name: str, causality: str, key: Key) -> FmuVariable:
    """The FMU's variable of that name, an input to be one, or what may serve as an output."""
    variable = fmu.variables.get(name)
    if variable is None:
        raise SchemaError(key, f'{fmu.path.name} has no variable "{name}"; {nearest(name, fmu.named(causality))}')
    if variable.kind != NUMBERS[fmu.fmi]:
        raise SchemaError(key, f'"{name}" is of type {variable.kind}, expected {NUMBERS[fmu.fmi]}')
    fits = (causality,) if causality == "input" else (causality, "local")
    if variable.causality not in fits:
        raise SchemaError(key, f'"{name}" is {variable.causality} in {fmu.path.name}, expected {causality}')
    return variable


def _start_value(fmu: Fmu, name: str, value: float | str) -> tuple[int, float]:
    """The reference of a variable that is set before the FMU starts, and its value in the FMU's unit."""
    key: Key = ("plant", "start_values", name)
    settable = [item.name for item in fmu.variables.values() if item.settable and item.kind == NUMBERS[fmu.fmi]]
    if name not in settable:
        raise SchemaError(
            key, f"{fmu.path.name} has no parameter or start value of that name; {nearest(name, settable)}"
        )
    try:
        return fmu.variables[name].reference, value_for(fmu, fmu.variables[name], value)
    except QuantityError as error:
        raise SchemaError(key, str(error)) from None


def _plant(fmu: Fmu, model: Plant, inputs: list[str], outputs: list[Field], channels: tuple[int, ...]) -> Plant:
    """The plant that the engine runs through a machine: names and units alone."""
    given = {item.name: item for item in fields(model.Inputs)}
    state_class = _numbers("State", {item.name: item for item in outputs})
    inputs_class = _numbers("Inputs", {name: given[name] for name in inputs})

    def derivatives(time: Any, state: Any, inputs: Any, p: Any) -> Any:
        raise UserError(f"{fmu.path}: an FMU has no equations, which linear analysis, fits and identification need")

    def signals(time: Any, state: Any, inputs: Any, p: Any) -> Any:
        return state

    def measure(state: Any, p: Any) -> Measurement:
        return Measurement(*(math.nan if at == ABSENT else 0.0 if at == STILL else state[at] for at in channels))

    def equilibrium(p: Any, surface_speed: float) -> tuple[Any, Any]:
        return state_class._make([0.0] * len(outputs)), inputs_class._make([0.0] * len(inputs))

    return Plant(
        name=fmu.path.name,
        summary=f"{fmu.name}, an FMU in the place of {model.name}",
        State=state_class,
        Inputs=inputs_class,
        Parameters=Limits,
        Signals=state_class,
        derivatives=derivatives,
        signals=signals,
        measure=measure,
        equilibrium=equilibrium,
        command_limit=lambda p: p.command_limit,
        travel=lambda p: p.travel,
        command=model.command,
        balances={},
        rotary_command=model.rotary_command,
        rotary_limit=lambda p: p.rotary_limit,
    )


def _numbers(name: str, items: Mapping[str, Field]) -> type[NamedTuple]:
    """A NamedTuple class of such numbers, one for all that are alike."""
    told = hashlib.sha256(repr(items).encode()).hexdigest()[:16]
    members = {each: Annotated[float, item.unit, item.scale] for each, item in items.items()}
    made: type[NamedTuple] = named_tuple(f"{name}_{told}", __name__, cast(Any, members), {}, "Of an FMU.")
    return made
