"""Which derivatives should a fit by simulation use: CasADi's, or differences of the compiled simulator?

The Jacobian of position and load pressure over six friction parameters, on the extending quasi-static run of the
thesis's rig (35 s, valve voltage in straight lines over 1 ms). Prints the time of one Jacobian each way, and how far
they differ. Run: python benchmarks/identification_derivatives.py
"""

import time
from dataclasses import replace

import casadi
import numpy as np

from plants.equation import fields, to_array
from plants.registry import THESIS
from workbench.linear.linearise import symbolic
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.references import Sine
from workbench.simulation.setup import Feed, Integrator, Setup
from workbench.simulation.simulate import simulate

FREE = ("coulomb", "stribeck", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping")
DURATION, SAMPLE, START = 35.0, 1e-3, -0.07
VOLTAGE = Sine(1.0, 0.005, 1.0, -np.pi / 2)
OUTPUTS = (0, 2)
SUBSTEPS = 5
"""Runge-Kutta steps a sample in CasADi; the fastest rate of this run is 2300 1/s."""

VALUES = dict(read_parameters(named_sets()["owen2001_experiment"]))
NAMES = [item.name for item in fields(THESIS.Parameters)]


def outputs(changes: dict[str, float], integrator: Integrator) -> np.ndarray:
    parameters = build(THESIS.Parameters, {**VALUES, **changes})
    state = THESIS.equilibrium(parameters, 0.0)[0]._replace(position=START)
    setup = Setup(THESIS, parameters, state, THESIS.Inputs(0.0, 0.0), DURATION, feeds=(Feed("valve_voltage", VOLTAGE),))
    return simulate(replace(setup, integrator=integrator)).states[:, OUTPUTS]


def differences(step: float, integrator: Integrator) -> np.ndarray:
    """Central differences by log(p), shape (samples, outputs, parameters)."""
    columns = []
    for name in FREE:
        ends = [outputs({name: VALUES[name] * np.exp(side * step)}, integrator) for side in (1.0, -1.0)]
        columns.append((ends[0] - ends[1]) / (2.0 * step))
    return np.stack(columns, axis=-1)


def sensitivities() -> np.ndarray:
    """Exact sensitivities of a Runge-Kutta solution: CasADi's derivatives of the equations, folded over the samples."""
    function = symbolic(THESIS)
    count = len(fields(THESIS.State))
    x, voltage, p = casadi.SX.sym("x", count), casadi.SX.sym("u", 2), casadi.SX.sym("p", len(NAMES))
    seeds = casadi.SX.sym("s", count, len(FREE))
    places = [NAMES.index(name) for name in FREE]

    def step(state: casadi.SX) -> casadi.SX:
        h = SAMPLE / SUBSTEPS
        for k in range(SUBSTEPS):

            def rate(y: casadi.SX, share: float, k: int = k) -> casadi.SX:
                u = voltage[0] + (k + share) / SUBSTEPS * (voltage[1] - voltage[0])
                return function(y, casadi.vertcat(u, 0.0), p)[0]

            k1 = rate(state, 0.0)
            k2 = rate(state + h / 2 * k1, 0.5)
            k3 = rate(state + h / 2 * k2, 0.5)
            state = state + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(state + h * k3, 1.0))
        return state

    # One Runge-Kutta sample as a function, its derivative by state and log(p), and the chain rule over the samples.
    following = step(x)
    by_parameters = casadi.jacobian(following, p)[:, places] @ casadi.diag(p[places])
    advanced = casadi.jacobian(following, x) @ seeds
    both = casadi.horzcat(following, advanced + by_parameters)
    sample = casadi.Function("sample", [casadi.horzcat(x, seeds), casadi.vertcat(voltage, p)], [both])
    samples = round(DURATION / SAMPLE)
    parameters = build(THESIS.Parameters, VALUES)
    state = THESIS.equilibrium(parameters, 0.0)[0]._replace(position=START)
    start = np.column_stack([to_array(state), np.zeros((count, len(FREE)))])
    volts = VOLTAGE(SAMPLE * np.arange(samples + 1))[0]
    inputs = np.vstack([volts[:-1], volts[1:], np.tile(to_array(parameters)[:, None], samples)])
    began = time.perf_counter()
    folded = sample.mapaccum(samples)(start, inputs).full()
    print(f"CasADi, sensitivities with the equations' exact derivatives: {time.perf_counter() - began:.2f} s")
    table = folded.reshape(count, samples, 1 + len(FREE))
    found = np.zeros((samples + 1, len(OUTPUTS), len(FREE)))
    found[1:] = table[list(OUTPUTS)].transpose(1, 0, 2)[:, :, 1:]
    return found


def main() -> None:
    outputs({}, Integrator())
    prepared = time.perf_counter()
    exact = sensitivities()
    print(f"CasADi, with making the function: {time.perf_counter() - prepared:.2f} s")
    for integrator, label in ((Integrator(), "error-controlled, 1e-6"), (Integrator("rk4", 1e-4), "rk4, 0.1 ms")):
        for step in (1e-2, 1e-3, 1e-4):
            began = time.perf_counter()
            found = differences(step, integrator)
            took = time.perf_counter() - began
            error = np.sqrt(np.mean((found - exact) ** 2, axis=0) / np.mean(exact**2, axis=0))
            print(f"differences, {label}, step {step:g}: {took:.2f} s, off by (rms, position, load pressure)")
            for name, row in zip(FREE, error.T, strict=True):
                print(f"    {name:20s} {row[0]:.1e} {row[1]:.1e}")


if __name__ == "__main__":
    main()
