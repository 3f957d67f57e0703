"""Plants with effects, for tests: numbers of the thesis's rig, sizes that are felt, and what effects remember."""

import ctypes
import itertools
from collections.abc import Callable
from typing import Any

import numpy as np
from thesis_actuator import OF_OTHERS, along

from plants.effects.attach import meant
from plants.effects.curves import CURVES
from plants.effects.maps import FORCE_MAP
from plants.equation import fields, replaced, to_array
from plants.interface import Plant
from plants.registry import plants
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.compilation import compile_derivatives

POINTER = ctypes.POINTER(ctypes.c_double)

TRUTH = {
    **read_parameters(named_sets()["owen2001_experiment"]),
    "pump_displacement": 2.5e-7,
    **OF_OTHERS,
    "force_gain": 30.0,
    "spring_stiffness": 0.0,
}
SIZES = {
    "friction_gradient": 0.3,
    "friction_curvature": 0.8,
    "friction_per_pressure": 1e-4,
    "static_rise": 1.0,
    "memory_time": 0.02,
    "drag_coefficient": 2e4,
    "viscous_drift": 0.05,
    "spring_stiffness": 5e3,
    "cosine_force": 30.0,
    "sine_force": 30.0,
    "droop_resistance": 3e9,
    "air_fraction": 0.01,
    "area_ratio": 0.8,
    "command_delay": 0.01,
    "backlash_width": 5e-5,
    "pressure_1_offset": 5e4,
    "valve_natural_frequency": 60.0,
    "valve_hysteresis": 0.1,
    "spool_stiction": 0.1,
    "valve_gain_curvature": 0.5,
    "valve_gain_ratio": 0.8,
    "ripple_cosine": 1e5,
    "ripple_sine": 1e5,
    "volume_share": 1.0,
    "area_gradient": 0.1,
    "position_ripple_cosine": 1e-5,
    "position_ripple_sine": 1e-5,
    "position_sensor_lag": 5e-3,
    "cogging_cosine": 20.0,
    "cogging_sine": 20.0,
    "cushion_stiffness": 1e5,
    "cushion_start": 0.0,
    "dahl_exponent": 1.5,
    "slip_level": 50.0,
    "warming_share": -0.5,
    "compliant_share": 0.3,
}
"""A size of each parameter that is felt on this rig."""

RANGES = {
    "position": (-0.03, 0.03),
    "velocity": (-0.1, 0.1),
    "time": (0.0, 1.0),
    "load_pressure": (-2e6, 2e6),
    "pressure_1": (0.0, 3e6),
    "pressure_2": (0.0, 3e6),
    "valve_voltage": (-1.0, 1.0),
}
"""Of each signal over which there are curves."""

NODES = np.array([1.0, 0.4, -0.3, -0.3, 0.2, 1.1, 0.9, 1.4, 2.0, -1.0, 0.5, 0.7])
"""Of a curve that rises, falls, rests and turns."""


CURVE_SIZES = {"force": 30.0, "flow": 1e-6, "air_flow": 1e-5}
"""N, m^3/s and kg/s, of curves."""


def curve_of(kind: str, signal: str, share: float = 1.0) -> dict[str, float]:
    """The parameters of a curve of up to twice its size over the range of a signal."""
    values = [share, *RANGES[signal], *(CURVE_SIZES[kind] * NODES).tolist()]
    return dict(zip(CURVES[kind, signal].own_names, values, strict=True))


for chosen in CURVES:
    SIZES |= curve_of(*chosen)

MAP = np.sin(1.7 * np.arange(36.0)).reshape(6, 6)
"""Of a map."""


def map_of(share: float = 1.0) -> dict[str, float]:
    """The parameters of a map of up to 30 N over the ranges of position and velocity."""
    ranges = (*RANGES["position"], *RANGES["velocity"])
    return dict(zip(FORCE_MAP.own_names, [share, *ranges, *(30.0 * MAP).ravel().tolist()], strict=True))


SIZES |= map_of()

FREE_MASS = {
    **dict.fromkeys(("coulomb", "stribeck", "viscous", "bristle_stiffness", "bristle_damping"), 0.0),
    "stribeck_velocity": 0.01,
    "mass": 20.0,
    "end_stop_stiffness": 0.0,
    "end_stop_damping": 0.0,
    "load_force": 0.0,
    "spring_stiffness": 0.0,
}
"""Of a drive that nothing brakes."""


def having(name: str, values: dict[str, float], truth: dict[str, float] = TRUTH) -> tuple[Plant, Any]:
    """A registered plant with the effects whose parameters are given, and its parameters."""
    bare = plants()[name]
    plant = bare.with_effects(*meant(bare, list(values)))
    return plant, build(plant.Parameters, along(plant, {**truth, **values}))


def at_rest(plant: Plant, parameters: Any, **states: float) -> tuple[Any, Any]:
    """State and inputs of a plant at rest, with some states elsewhere."""
    state, inputs = plant.equilibrium(parameters, 0.0)
    return replaced(state, states), inputs


def remembered(
    plant: Plant,
    parameters: Any,
    motion: Callable[[float], tuple[float, float]],
    command: Callable[[float], float],
    times: np.ndarray,
) -> np.ndarray:
    """What effects remember (times, numbers) along an imposed position and velocity, by the classical Runge-Kutta
    method between these times, with the derivatives that the program compiles.
    """
    rest, inputs = plant.equilibrium(parameters, 0.0)
    derivatives = compile_derivatives(plant).ctypes
    state, driven, constant = to_array(rest), to_array(inputs), to_array(parameters)
    rates = np.empty_like(state)
    pointers = [numbers.ctypes.data_as(POINTER) for numbers in (state, driven, constant, rates)]
    names = [item.name for item in fields(plant.State)]
    place, speed, commanded = names.index("position"), names.index("velocity"), plant.input_index(plant.command)
    first = np.flatnonzero(np.isnan(to_array(rest._replace(effects=_unknown(rest.effects)))))
    memories = slice(first[0], first[-1] + 1)

    def rate(time: float, memory: np.ndarray) -> np.ndarray:
        state[place], state[speed] = motion(time)
        state[memories] = memory
        driven[commanded] = command(time)
        derivatives(time, *pointers)
        return rates[memories].copy()

    kept = [state[memories].copy()]
    for start, end in itertools.pairwise(times.tolist()):
        memory, step = kept[-1], end - start
        one = rate(start, memory)
        two = rate(start + 0.5 * step, memory + 0.5 * step * one)
        three = rate(start + 0.5 * step, memory + 0.5 * step * two)
        four = rate(end, memory + step * three)
        kept.append(memory + step / 6.0 * (one + 2.0 * two + 2.0 * three + four))
    return np.array(kept)


def _unknown(memories: Any) -> Any:
    """NaN in the place of each number that effects remember."""
    return type(memories)._make(type(memory)._make(np.nan for _ in memory) for memory in memories)
