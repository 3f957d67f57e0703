"""model.h: sizes, start values and the solver's numbers of one machine; all other C is the same for all."""

from collections.abc import Iterable, Sequence

from plants.equation import fields
from workbench.export.fmi.equations import DECLARED, INPUTS, PARAMETERS, STATES, Equations
from workbench.export.fmi.variables import start_values
from workbench.simulation.integrators.dormand_prince import DORMAND_PRINCE
from workbench.simulation.setup import Setup

NAME_LENGTH = 64
"""Characters of an instance's name that are kept for messages."""


def model_header(setup: Setup, equations: Equations, token: str) -> str:
    """The text of model.h."""
    plant, pair = setup.plant, DORMAND_PRINCE
    states, inputs, parameters = (fields(cls) for cls in (plant.State, plant.Inputs, plant.Parameters))
    square = [[*row, *[0.0] * (pair.count - len(row))] for row in ((), *pair.stages)]
    defined = {
        "TOKEN": f'"{token}"',
        "NAME_LENGTH": NAME_LENGTH,
        "STATES": len(states),
        "INPUTS": len(inputs),
        "PARAMETERS": len(parameters),
        "VALUES": "(STATES + INPUTS + PARAMETERS)",
        "OUTPUTS": len(equations.named),
        "STAGES": pair.count,
        "ORDER": float(pair.order),
        "TOLERANCE": repr(setup.integrator.tolerance),
        "FIRST_STEP": repr(setup.sample_time),
    }
    vectors = zip((STATES, INPUTS, PARAMETERS), (states, inputs, parameters), strict=True)
    names = [f"{vector}[{i}]: {item.name}, {item.unit}" for vector, of in vectors for i, item in enumerate(of)]
    lines = [
        f"/* {plant.name}: its sizes, its start values, and a Runge-Kutta pair ({pair.source}). Generated. */",
        "#ifndef MODEL_H",
        "#define MODEL_H",
        "",
        "#include <math.h>",
        "",
        *(f"#define {name} {value}" for name, value in defined.items()),
        "",
        *(f"{function};" for function in DECLARED.values()),
        "",
        "/* States, inputs, parameters, in SI. */",
        "static const double start_values[VALUES] = {",
        *(f"    {_numbers([value])}, /* {name} */" for name, value in zip(names, start_values(setup), strict=True)),
        "};",
        "",
        "/* Typical magnitudes of the states. */",
        *_array("magnitudes[STATES]", [item.scale for item in states]),
        "",
        *_array("nodes[STAGES]", (0.0, *pair.nodes)),
        *_table("stages[STAGES][STAGES]", square),
        *_array("errors[STAGES]", pair.errors),
        "",
        "#endif",
    ]
    return "\n".join(lines) + "\n"


def _numbers(values: Iterable[float]) -> str:
    return ", ".join(repr(float(value)).replace("inf", "INFINITY") for value in values)


def _array(declared: str, values: Sequence[float]) -> list[str]:
    rows = [_numbers(values[i : i + 4]) for i in range(0, len(values), 4)]
    return [f"static const double {declared} = {{", *(f"    {row}," for row in rows), "};"]


def _table(declared: str, rows: Sequence[Sequence[float]]) -> list[str]:
    return [f"static const double {declared} = {{", *(f"    {{{_numbers(row)}}}," for row in rows), "};"]
