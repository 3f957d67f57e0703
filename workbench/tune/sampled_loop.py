"""The sampled closed loop with its adjoint as CasADi functions, from the equations that the simulation compiles.

With s = (plant's state, controller's state), constants q = (gains, parameters, inputs, sample time, command limit) and
what is wanted r_k, one sample is s_(k+1) = F(s_k, r_k, q). For a sum of costs c_k(s_k) the adjoint runs backwards,

    lambda_k = (dF/ds)_k' lambda_(k+1) + dc_k/ds,     dJ/dgains = sum over k of (dF/dgains)_k' lambda_(k+1)

and needs only the states at the samples: a run of 20 s at 1 kHz keeps some 3 MB, where differentiation through every
step of the integration would keep each of their intermediate results.
"""

import functools
from dataclasses import dataclass
from typing import Any

import casadi
import numpy as np

from controllers.interface import Controller, Reference
from plants.equation import fields, from_array, leaves
from plants.interface import Plant
from workbench.linear import numpy_functions_of_symbols

BLOCK = 250
"""Samples that one call of a CasADi function runs over: few enough to be built at once and kept for any duration."""

WANTED = 4
"""Numbers of a sample from outside: position (m), velocity, acceleration of the reference, time (s)."""

SMALLEST_ROOT = 1e-60
"""Arguments of square roots are kept above it. At 0 the infinite slope of a root meets the slope 0 of the |v| or
max(p, 0) within it, and 0 times infinity is no number; so it is 0. No result of any size is changed."""

NOT_SYMBOLIC = (TypeError, ValueError, AttributeError, RuntimeError)
"""What equations raise that cannot take symbols: an `if`, a `float()`, a function that is not NumPy's."""


class NotSymbolicError(Exception):
    """Equations that do not take CasADi symbols: whose, and what they said."""


@dataclass(frozen=True, eq=False)
class SampledLoop:
    """CasADi functions of a plant, a controller and a number of Runge-Kutta steps a sample, over `BLOCK` samples.

    start(plant state, q) -> s                                  both as they start
    forward(s, r, q) -> s after each sample                     r (4, BLOCK), result (states, BLOCK)
    backward(lambda, s, r, q, dc/dposition) -> lambda, terms    samples in reverse order; of lambda and of the terms
                                                                of dJ/dgains a column a sample
    start_backward(lambda, plant state, q) -> term              what the gains do through the controller's start
    """

    start: casadi.Function
    forward: casadi.Function
    backward: casadi.Function
    start_backward: casadi.Function


@functools.lru_cache(maxsize=64)
def sampled_loop(plant: Plant, controller: Controller, substeps: int) -> SampledLoop:
    """The loop of `plant` and `controller` with `substeps` steps of Runge and Kutta's method of order 4 a sample.

    Order of events as in `workbench.simulation.engine`: measure, step, saturate, commit, hold.

    Raises:
        NotSymbolicError: equations that do not take symbols.
    """
    classes = {"gains": controller.Gains, "parameters": plant.Parameters, "inputs": plant.Inputs}
    vectors = {name: casadi.SX.sym(name, len(fields(cls))) for name, cls in classes.items()}
    gains, parameters, inputs = (from_array(cls, casadi.vertsplit(vectors[name])) for name, cls in classes.items())
    sample_time, limit = casadi.SX.sym("sample_time"), casadi.SX.sym("limit")
    constants = casadi.vertcat(*vectors.values(), sample_time, limit)
    x = casadi.SX.sym("x", len(fields(plant.State)))
    memory = casadi.SX.sym("memory", len(fields(controller.State)))
    wanted = casadi.SX.sym("wanted", WANTED)
    *profile, time = casadi.vertsplit(wanted)
    reference = from_array(Reference, profile)
    try:
        with numpy_functions_of_symbols():
            reading = plant.measure(from_array(plant.State, casadi.vertsplit(x)), parameters)
            begun = casadi.vertcat(x, *leaves(controller.start(reading, gains)))
            state = from_array(controller.State, casadi.vertsplit(memory))
            command, state = controller.step(reference, reading, state, gains, sample_time)
            feed = inputs[plant.input_index(plant.command)]
            total = casadi.fmin(casadi.fmax(command + feed, -limit), limit)
            state = controller.commit(total - feed, state, gains, sample_time)
            held = inputs._replace(**{plant.command: total})
            moved = _runge_kutta(plant, time, x, held, parameters, sample_time, substeps)
        after = casadi.vertcat(moved, *leaves(state))
        loop_state = casadi.vertcat(x, memory)
        start = _rooted(casadi.Function("start", [x, constants], [begun]))
        sample = _rooted(casadi.Function("sample", [loop_state, wanted, constants], [after]))
    except NOT_SYMBOLIC as error:
        raise NotSymbolicError(f"the equations of {controller.name} on {plant.name} take no symbols: {error}") from None
    place = [item.name for item in fields(plant.State)].index("position")
    return SampledLoop(
        start,
        sample.mapaccum(BLOCK),
        _adjoint(sample, vectors["gains"].numel(), place).mapaccum(BLOCK),
        _start_adjoint(start, vectors["gains"].numel()),
    )


def _runge_kutta(
    plant: Plant, time: Any, x: Any, inputs: Any, parameters: Any, sample_time: Any, substeps: int
) -> casadi.SX:
    """The plant's state one sample on, its inputs held."""
    step = sample_time / substeps

    def rates(t: Any, y: Any) -> casadi.SX:
        state = from_array(plant.State, casadi.vertsplit(y))
        return casadi.vertcat(*leaves(plant.derivatives(t, state, inputs, parameters)))

    for i in range(substeps):
        t = time + i * step
        k1 = rates(t, x)
        k2 = rates(t + 0.5 * step, x + 0.5 * step * k1)
        k3 = rates(t + 0.5 * step, x + 0.5 * step * k2)
        k4 = rates(t + step, x + step * k3)
        x = x + step / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4)
    return x


def _adjoint(sample: casadi.Function, gain_count: int, place: int) -> casadi.Function:
    """(lambda, s, r, q, dc/dposition) -> lambda one sample earlier, term of dJ/dgains."""
    loop_state, wanted, constants = sample.sx_in()
    adjoint, slope = casadi.SX.sym("adjoint", loop_state.numel()), casadi.SX.sym("slope")
    over = casadi.vertcat(loop_state, constants[:gain_count])
    back = casadi.densify(casadi.jtimes(sample(loop_state, wanted, constants), over, adjoint, True))
    earlier, term = back[: loop_state.numel()], back[loop_state.numel() :]
    earlier[place] += slope
    arguments = [adjoint, loop_state, wanted, constants, slope]
    return casadi.Function("adjoint", arguments, [earlier, term], {"cse": True})


def _start_adjoint(start: casadi.Function, gain_count: int) -> casadi.Function:
    x, constants = start.sx_in()
    begun = start(x, constants)
    adjoint = casadi.SX.sym("adjoint", begun.numel())
    term = casadi.densify(casadi.jtimes(begun, constants, adjoint, True))[:gain_count]
    return casadi.Function("start_adjoint", [adjoint, x, constants], [term])


def _rooted(function: casadi.Function) -> casadi.Function:
    """The same function of one output with the arguments of its square roots above `SMALLEST_ROOT`."""
    arguments = function.sx_in()
    registers = [casadi.SX(0.0)] * function.sz_w()
    result = casadi.SX(function.sparsity_out(0))
    for k in range(function.n_instructions()):
        operation, into = function.instruction_id(k), function.instruction_output(k)
        if operation == casadi.OP_CONST:
            constant = function.instruction_constant(k)
            if np.isnan(constant):  # what float() of a symbol gives
                raise ValueError("a symbol became a plain number")
            registers[into[0]] = casadi.SX(constant)
            continue
        taken = function.instruction_input(k)
        if operation == casadi.OP_INPUT:
            registers[into[0]] = arguments[taken[0]].nz[taken[1]]
        elif operation == casadi.OP_OUTPUT:
            result.nz[into[1]] = registers[taken[0]]
        elif operation == casadi.OP_SQRT:
            registers[into[0]] = casadi.sqrt(casadi.fmax(registers[taken[0]], SMALLEST_ROOT))
        elif len(taken) == 1:
            registers[into[0]] = casadi.SX.unary(operation, registers[taken[0]])
        else:
            registers[into[0]] = casadi.SX.binary(operation, registers[taken[0]], registers[taken[1]])
    return casadi.Function(function.name(), arguments, [casadi.densify(result)], {"cse": True})
