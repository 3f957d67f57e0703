"""Plants with all effects that they can have, each of a size that is felt: NumPy, compiled code and CasADi agree."""

import ctypes

import casadi
import numpy as np
import pytest
from effect_machines import SIZES, TRUTH
from thesis_actuator import along

from plants.effects.attach import possible
from plants.equation import fields, from_array, leaves, to_array
from plants.interface import Plant
from plants.registry import plants
from workbench.linear.linearise import numpy_functions_of_symbols
from workbench.parameters.sets import build
from workbench.simulation.compilation import compile_derivatives

TIME = 0.37
"""s. Some effects do nothing as a record begins."""

POINTER = ctypes.POINTER(ctypes.c_double)
LEAKS = {
    "external_leakage_1": 1e-13,
    "external_leakage_2": 2e-13,
    "valve_overlap": 1e-6,
    "valve_overlap_negative": 3e-6,
}


def of_symbols(plant: Plant) -> casadi.Function:
    """Rates of a plant's states from vectors of states, inputs and parameters."""
    classes = (plant.State, plant.Inputs, plant.Parameters)
    vectors = [casadi.SX.sym(cls.__name__, len(fields(cls))) for cls in classes]
    arguments = [from_array(cls, casadi.vertsplit(one)) for cls, one in zip(classes, vectors, strict=True)]
    with numpy_functions_of_symbols():
        rates = casadi.vertcat(*leaves(plant.derivatives(TIME, *arguments)))
    return casadi.Function("rates", vectors, [rates])


@pytest.mark.parametrize(
    "name",
    [
        *("non_rotating", "rotating_isotropic", "cylinder", "two_chamber"),
        *("pneumatic_cylinder", "drive_force", "rotary_torque", "valve_axis"),
    ],
)
def test_derivatives_with_effects_are_the_same_in_numpy_compiled_code_and_casadi(name: str) -> None:
    bare = plants()[name]
    plant = bare.with_effects(*possible(bare))
    parameters = build(plant.Parameters, {**along(plant, TRUTH), **along(plant, {**SIZES, **LEAKS})})
    draw, rest = np.random.default_rng(5), plant.equilibrium(parameters, 0.0)
    scales = np.array([item.scale for item in fields(plant.State)])
    states = to_array(rest[0]) + 0.3 * scales * draw.standard_normal((50, scales.size))
    inputs = to_array(rest[1]) + 0.5 * draw.standard_normal((50, len(fields(plant.Inputs))))
    constants, out = to_array(parameters), np.empty(scales.size)
    compiled = compile_derivatives(plant).ctypes

    def native(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        compiled(TIME, *(array.ctypes.data_as(POINTER) for array in (x, u, constants, out)))
        return out.copy()

    def plain(x: np.ndarray, u: np.ndarray) -> np.ndarray:
        return to_array(plant.derivatives(TIME, from_array(plant.State, x), from_array(plant.Inputs, u), parameters))

    expected = np.array([plain(x, u) for x, u in zip(states, inputs, strict=True)])
    arrays = np.column_stack(
        np.broadcast_arrays(
            *leaves(
                plant.derivatives(
                    TIME, from_array(plant.State, states.T), from_array(plant.Inputs, inputs.T), parameters
                )
            )
        )
    )
    others = [
        arrays,
        np.array([native(x, u) for x, u in zip(states, inputs, strict=True)]),
        of_symbols(plant)(states.T, inputs.T, constants).full().T,
    ]
    size = np.maximum(np.max(np.abs(expected), axis=0), 1e-300)
    assert np.all(np.isfinite(expected))
    for other in others:
        assert np.max(np.abs(other - expected) / size) < 1e-11
