"""A plant's equations as C: CasADi's symbols go through the functions that the simulation compiles."""

from dataclasses import dataclass

import casadi

from plants.equation import fields, from_array, leaves
from plants.interface import Measurement, Plant
from workbench.linear.linearise import numpy_functions_of_symbols

RATES, OUTPUTS = "plant_rates", "plant_outputs"
"""The C functions (time, states, inputs, parameters) -> vector."""

MEASURED = "measured_"
"""What stands before the name of what a rig measures, as in the signals of a run."""


@dataclass(frozen=True)
class Output:
    """A number that follows from states, inputs and parameters."""

    name: str
    unit: str


@dataclass(frozen=True)
class Equations:
    """The rates of the states, and outputs behind them, as functions of (time, states, inputs, parameters)."""

    rates: casadi.Function
    outputs: casadi.Function
    named: tuple[Output, ...]

    def depends(self, function: casadi.Function) -> list[tuple[list[int], list[int]]]:
        """Of each number of a function: places of the states, and of the inputs, on which it depends."""
        over_states, over_inputs = (function.jac_sparsity(0, place) for place in (1, 2))
        return [(_columns(over_states, row), _columns(over_inputs, row)) for row in range(function.numel_out(0))]

    @property
    def code(self) -> str:
        """Both functions as C."""
        generator = casadi.CodeGenerator("plant.c", {"with_header": False})
        generator.add(self.rates)
        generator.add(self.outputs)
        return str(generator.dump())


def equations_of(plant: Plant) -> Equations:
    """The equations of a plant; its outputs are its signals that are no states or inputs, and what a rig measures."""
    classes = {"state": plant.State, "inputs": plant.Inputs, "parameters": plant.Parameters}
    time = casadi.SX.sym("time")
    vectors = {name: casadi.SX.sym(name, len(fields(cls))) for name, cls in classes.items()}
    state, inputs, parameters = (from_array(cls, casadi.vertsplit(vectors[name])) for name, cls in classes.items())
    with numpy_functions_of_symbols():
        rates = [*leaves(plant.derivatives(time, state, inputs, parameters))]
        signals = [*leaves(plant.signals(time, state, inputs, parameters))]
        readings = plant.measure(state, parameters)._asdict()
    known = {item.name for cls in (plant.State, plant.Inputs) for item in fields(cls)}
    found = {
        Output(item.name, item.unit): value
        for item, value in zip(fields(plant.Signals), signals, strict=True)
        if item.name not in known
    }
    units = {item.name: plant.unit_for(item.unit) for item in fields(Measurement)}
    found |= {Output(f"{MEASURED}{name}", units[name]): readings[name] for name in plant.channels}
    arguments = [time, *vectors.values()]

    def function(name: str, values: list[casadi.SX]) -> casadi.Function:
        return casadi.Function(name, arguments, [casadi.densify(casadi.vertcat(*values))])

    return Equations(function(RATES, rates), function(OUTPUTS, [*found.values()]), tuple(found))


def _columns(sparsity: casadi.Sparsity, row: int) -> list[int]:
    rows, columns = sparsity.get_triplet()
    return sorted(column for at, column in zip(rows, columns, strict=True) if at == row)
