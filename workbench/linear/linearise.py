"""A plant for linear analysis: exact Jacobians, state space at any operating point, python-control's systems.

All come from the plant's one set of equations: CasADi symbols go through the functions that the simulation
compiles, so there is no second copy to keep in step.

    model = linearise(plant, parameters)                    # control.StateSpace at rest
    control.poles(model), control.bode_plot(model), ...
    system = nonlinear_system(plant, parameters)            # control.NonlinearIOSystem
    function = symbolic(plant)                              # casadi.Function
"""

import functools
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from threading import Lock

import casadi
import control
import numpy as np

from plants.equation import fields, from_array, leaves, to_array
from plants.interface import Plant
from workbench.errors import UserError, nearest
from workbench.simulation.setup import Numbers

_SWITCH = Lock()

EVALUATION_TIME = 0.0
"""s. The built-in plants do not depend on time; one that does is linearised at its start."""


def jacobians(plant: Plant, parameters: Numbers, state: Numbers, inputs: Numbers) -> tuple[np.ndarray, np.ndarray]:
    """Exact partial derivatives of the plant's state equations dx/dt = f(x, u). Thesis (C.4) to (C.6).

    `state`, `inputs` and `parameters` are the plant's NamedTuples (SI). The point need not be an equilibrium.

    Returns:
        A = df/dx, shape (states, states), and B = df/du, shape (states, inputs), rows and columns in the order of
        the plant's `State` and `Inputs`; the unit of an element is that of its row per second and per its column.

    At a kink a derivative from one side is given, or 0 for |v| at v = 0: see `linearise`.
    """
    a, b, _, _ = _derivatives_at(plant, parameters, state, inputs)
    return a, b


def output_jacobians(
    plant: Plant, parameters: Numbers, state: Numbers, inputs: Numbers, outputs: Sequence[str]
) -> tuple[np.ndarray, np.ndarray]:
    """Exact partial derivatives of chosen signals y = s(x, u) of the plant at a point; arguments as `jacobians`.

    Returns:
        C = ds/dx, shape (outputs, states), and D = ds/du, shape (outputs, inputs).

    Raises:
        UserError: the plant has no such signal.
    """
    chosen = _signal_indices(plant, outputs)
    _, _, c, d = _derivatives_at(plant, parameters, state, inputs)
    return c[chosen], d[chosen]


def measurement_jacobian(plant: Plant, parameters: Numbers, state: Numbers) -> np.ndarray:
    """Exact partial derivatives dy/dx of what the rig measures, y = measure(x, parameters), at a state.

    Returns:
        shape (readings, states), rows in the order of `plants.interface.Measurement`; 0 for a sensor that the plant
        does not have (a reading of NaN).
    """
    return _symbolic_readings(plant)(to_array(state), to_array(parameters)).full() + 0.0


def linearise(
    plant: Plant,
    parameters: Numbers,
    state: Numbers | None = None,
    inputs: Numbers | None = None,
    outputs: Sequence[str] = ("position",),
) -> control.StateSpace:
    """The plant for small deviations (dx, du) from an operating point (x0, u0), states, inputs, outputs by name:

        d(dx)/dt = A dx + B du,   dy = C dx + D du

    Around a point that is no equilibrium (a moving piston) the deviations are from the motion f(x0, u0), and hold
    for as long as it stays near that point.

    Do not use it where the equations have a kink: friction at v = 0 (|v|, different directions), the flow at a
    closed spool under load (the slope over x_s depends on its sign), a voltage, spool or pressure at its limit, the
    face of an end stop. At rest |v| has the slope 0: LuGre is then a spring sigma0 with the damping sigma1 + a2,
    right for presliding motions far below g/sigma0, wrong for anything that slides.

    Args:
        state: operating point, of the plant's `State` (SI); default: its equilibrium without rotation.
        inputs: of the plant's `Inputs` (SI); default: those of that equilibrium.
        outputs: names of any of the plant's signals.

    Raises:
        UserError: the plant has no such signal.
    """
    rest, holding = plant.equilibrium(parameters, 0.0)
    state = rest if state is None else state
    inputs = holding if inputs is None else inputs
    a, b = jacobians(plant, parameters, state, inputs)
    c, d = output_jacobians(plant, parameters, state, inputs, outputs)
    return control.ss(a, b, c, d, name=plant.name, outputs=list(outputs), **_labels(plant))


def nonlinear_system(
    plant: Plant, parameters: Numbers, outputs: Sequence[str] = ("position",)
) -> control.NonlinearIOSystem:
    """The plant as python-control's dx/dt = f(t, x, u), y = s(t, x, u), with states, inputs and outputs by name.

    Do not use it for long or many simulations: the equations run in Python, a thousand times slower than
    `workbench.simulation`; nor without tight tolerances, since python-control's default (relative 1e-3, absolute
    1e-6) is coarser than any bristle deflection. No limit of the amplifier, no sampling: it is the plant alone.

    Raises:
        UserError: the plant has no such signal.
    """
    chosen = _signal_indices(plant, outputs)

    def update(time: float, state: np.ndarray, inputs: np.ndarray, _: object) -> np.ndarray:
        x, u = from_array(plant.State, state), from_array(plant.Inputs, np.atleast_1d(inputs))
        return to_array(plant.derivatives(time, x, u, parameters))

    def output(time: float, state: np.ndarray, inputs: np.ndarray, _: object) -> np.ndarray:
        x, u = from_array(plant.State, state), from_array(plant.Inputs, np.atleast_1d(inputs))
        return to_array(plant.signals(time, x, u, parameters))[chosen]

    return control.nlsys(update, output, name=plant.name, outputs=list(outputs), **_labels(plant))


def _labels(plant: Plant) -> dict[str, list[str]]:
    return {
        "states": [item.name for item in fields(plant.State)],
        "inputs": [item.name for item in fields(plant.Inputs)],
    }


def _signal_indices(plant: Plant, outputs: Sequence[str]) -> list[int]:
    known = [item.name for item in fields(plant.Signals)]
    for name in outputs:
        if name not in known:
            raise UserError(f'plant {plant.name} has no signal "{name}"; {nearest(name, known)}')
    return [known.index(name) for name in outputs]


def _derivatives_at(plant: Plant, parameters: Numbers, state: Numbers, inputs: Numbers) -> list[np.ndarray]:
    values = (to_array(state), to_array(inputs), to_array(parameters))
    return [matrix.full() + 0.0 for matrix in _symbolic_jacobians(plant)(*values)]


@functools.cache
def symbolic(plant: Plant) -> casadi.Function:
    """The plant's equations as a CasADi function (state, inputs, parameters) -> (rates, signals) of vectors (SI).

    For whatever CasADi offers: derivatives for parameters, its integrators, optimisation. The vectors are those of
    `plants.equation.to_array`; parameters may be symbols too.
    """
    classes = {"state": plant.State, "inputs": plant.Inputs, "parameters": plant.Parameters}
    vectors = {name: casadi.SX.sym(name, len(fields(cls))) for name, cls in classes.items()}
    arguments = [from_array(cls, casadi.vertsplit(vectors[name])) for name, cls in classes.items()]
    with numpy_functions_of_symbols():
        rates = casadi.vertcat(*leaves(plant.derivatives(EVALUATION_TIME, *arguments)))
        signals = casadi.vertcat(*leaves(plant.signals(EVALUATION_TIME, *arguments)))
    return casadi.Function(plant.name, [*vectors.values()], [rates, signals], [*vectors], ["rates", "signals"])


@functools.cache
def _symbolic_jacobians(plant: Plant) -> casadi.Function:
    """(state, inputs, parameters) -> A, B, and C, D for all signals."""
    function = symbolic(plant)
    symbols = function.sx_in()
    state, inputs, _ = symbols
    matrices = [casadi.jacobian(of, over) for of in function(*symbols) for over in (state, inputs)]
    return casadi.Function(f"{plant.name}_jacobians", symbols, matrices)


@functools.cache
def _symbolic_readings(plant: Plant) -> casadi.Function:
    """(state, parameters) -> derivatives of the readings for the state."""
    classes = (plant.State, plant.Parameters)
    vectors = [
        casadi.SX.sym(name, len(fields(cls))) for name, cls in zip(("state", "parameters"), classes, strict=True)
    ]
    arguments = [from_array(cls, casadi.vertsplit(vector)) for cls, vector in zip(classes, vectors, strict=True)]
    with numpy_functions_of_symbols():
        readings = casadi.vertcat(*plant.measure(*arguments))
    return casadi.Function(f"{plant.name}_readings", vectors, [casadi.jacobian(readings, vectors[0])])


@contextmanager
def numpy_functions_of_symbols() -> Iterator[None]:
    """Let NumPy's functions take CasADi symbols; a global switch of CasADi's, put back as it was.

    One thread at a time: another would find the switch put back while it still needs it.
    """
    with _SWITCH:
        before = casadi.GlobalOptions.getNumpyMode()
        casadi.GlobalOptions.setNumpyMode(1)
        try:
            yield
        finally:
            casadi.GlobalOptions.setNumpyMode(before)
