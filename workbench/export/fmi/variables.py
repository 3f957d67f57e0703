"""The variables of an FMU: what it shows of a plant, each with its reference, unit and start value."""

from dataclasses import dataclass
from typing import Literal

from plants.equation import fields, to_array
from workbench.export.fmi.equations import Equations
from workbench.simulation.setup import Setup

Causality = Literal["independent", "input", "output", "parameter", "local"]


@dataclass(frozen=True)
class Variable:
    """One number. `reference` is its place in `machine.h`; `derivative_of` the reference of a rate's state.

    `depends` are references of the states and inputs from which it follows; None where it follows from none.
    """

    name: str
    reference: int
    causality: Causality
    unit: str
    description: str
    start: float | None = None
    nominal: float | None = None
    derivative_of: int | None = None
    depends: tuple[int, ...] | None = None


def variables_of(setup: Setup, equations: Equations) -> list[Variable]:
    """All variables, in the order of their references: time, states, inputs, parameters, rates, outputs."""
    plant = setup.plant
    states, inputs, parameters = (fields(cls) for cls in (plant.State, plant.Inputs, plant.Parameters))
    first_input = 1 + len(states)
    first_parameter = first_input + len(inputs)
    first_rate = first_parameter + len(parameters)
    first_output = first_rate + len(states)
    starts = start_values(setup)
    found = [Variable("time", 0, "independent", "s", "time")]
    for place, item in enumerate(states, start=1):
        magnitude = item.scale if item.scale != 1.0 else None
        words = f"state: {_words(item.name)}"
        found.append(
            Variable(item.name, place, "output", item.unit, words, starts[place - 1], magnitude, None, (place,))
        )
    for place, item in enumerate(inputs, start=first_input):
        words = f"input: {_words(item.name)}{_limit(setup, item.name)}"
        found.append(Variable(item.name, place, "input", item.unit, words, starts[place - 1]))
    for place, item in enumerate(parameters, start=first_parameter):
        words = f"parameter: {_words(item.name)}"
        found.append(Variable(item.name, place, "parameter", item.unit, words, starts[place - 1]))

    def references(depends: tuple[list[int], list[int]]) -> tuple[int, ...]:
        on_states, on_inputs = depends
        return (*(1 + place for place in on_states), *(first_input + place for place in on_inputs))

    for i, (item, depends) in enumerate(zip(states, equations.depends(equations.rates), strict=True)):
        unit, words = _per_second(item.unit), f"rate of the state {_words(item.name)}"
        found.append(
            Variable(
                f"der({item.name})",
                first_rate + i,
                "local",
                unit,
                words,
                derivative_of=1 + i,
                depends=references(depends),
            )
        )
    for i, (output, depends) in enumerate(zip(equations.named, equations.depends(equations.outputs), strict=True)):
        words = f"output: {_words(output.name)}"
        found.append(Variable(output.name, first_output + i, "output", output.unit, words, depends=references(depends)))
    return found


def start_values(setup: Setup) -> list[float]:
    """Of states, inputs and parameters: where the study starts, and what holds the rod's rotation there."""
    inputs, turned = setup.inputs, setup.plant.rotary_command
    if setup.rotary is not None and turned:
        speed = getattr(setup.state, "surface_speed", 0.0)
        _, holding = setup.plant.equilibrium(setup.parameters, speed)
        inputs = inputs._replace(**{turned: getattr(holding, turned)})
    return [number for part in (setup.state, inputs, setup.parameters) for number in to_array(part).tolist()]


def _words(name: str) -> str:
    return name.replace("_", " ")


def _per_second(unit: str) -> str:
    """The unit of a rate."""
    known = {"m/s": "m/s^2", "rad/s": "rad/s^2"}
    return known.get(unit, f"({unit})/s" if "/" in unit or " " in unit else f"{unit}/s")


def _limit(setup: Setup, name: str) -> str:
    """What limits an input before it comes to the plant, in words."""
    plant = setup.plant
    if name in plant.delayed:
        return f", the command of {float(plant.delayed[name](setup.parameters)):g} s ago"
    limits = {plant.command: plant.command_limit, plant.rotary_command: plant.rotary_limit}
    limit = float(limits[name](setup.parameters)) if name in limits else float("inf")
    return "" if limit == float("inf") else f", which the amplifier limits to +-{limit:g}, not the FMU"
