"""The same closed loop by this program, by general tools and by hand-written C: time and position error of each.

    python benchmarks/closed_loop.py [--rounds N]

The work: 3 s of the thesis's non-rotating actuator (chapter 3 parameters, derived flow) under P control of
500 V/m, sampled at 1 kHz with zero-order hold, following 25 mm at 0.9 Hz; states at every sample. The same with the
parameters of the rig, whose bristles are damped more strongly (stiff). See README.md.
"""

import argparse
import ctypes
import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import casadi
import control
import numpy as np
from scipy.integrate import solve_ivp

from controllers.pid import PID, Settings
from plants.equation import fields, from_array, to_array
from plants.registry import THESIS as PLANT
from workbench.linear.linearise import nonlinear_system, symbolic
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.compilation import compile_derivatives
from workbench.simulation.references import Sine
from workbench.simulation.setup import Integrator, Loop, Setup
from workbench.simulation.simulate import simulate

GAIN = 500.0
SAMPLE = 1e-3
DURATION = 3.0
LOOSE = 1e-4
"""Of our error control: the loosest power of ten with which either actuator stays within `NEAR`."""
NEAR = 1e-8
"""m. By what positions of a contestant may be off."""
SLOW_STRETCH = 0.2
"""s. What takes seconds runs this long and is counted in proportion."""
SLOW_TURNS = 2
TURN = 0.02
"""s. In its turn a contestant runs again and again for this long, so that all but the first run find warm caches."""

REFERENCE = Sine(0.025, 0.9)
SCALES = np.array([item.scale for item in fields(PLANT.State)])


def setup_of(values: str) -> Setup:
    """The closed loop of the actuator with a named set of parameters."""
    parameters = build(PLANT.Parameters, read_parameters(named_sets()[values]))
    loop = Loop(PID, PID.design(Settings(kp=GAIN), parameters, SAMPLE))
    return Setup(PLANT, parameters, *PLANT.equilibrium(parameters, 0.0), DURATION, loop, REFERENCE, sample_time=SAMPLE)


SETUP, MEASURED = setup_of("owen2001_simulation"), setup_of("owen2001_experiment")
PARAMETERS, REST, HOLDING = SETUP.parameters, SETUP.state, SETUP.inputs
LIMIT = PARAMETERS.hydraulics.voltage_limit


@dataclass(frozen=True)
class Contestant:
    """`run(samples)` gives the positions (m) at that many samples after the start, the start included."""

    name: str
    run: Callable[[int], np.ndarray]
    slow: bool = False

    @property
    def samples(self) -> int:
        return round((SLOW_STRETCH if self.slow else DURATION) / SAMPLE)


def ours(integrator: Integrator, setup: Setup = SETUP) -> Callable[[int], np.ndarray]:
    """This program, from the call of `simulate` to its return."""
    setup = replace(setup, integrator=integrator)
    return lambda samples: simulate(replace(setup, duration=samples * SAMPLE)).state("position")


def sampled(advance: Callable[[np.ndarray, float, float], np.ndarray]) -> Callable[[int], np.ndarray]:
    """The loop in Python around `advance(state, voltage, start)`, which integrates one sample."""

    def run(samples: int) -> np.ndarray:
        state, positions = to_array(REST), np.empty(samples + 1)
        reference = REFERENCE(SAMPLE * np.arange(samples + 1))[0]
        for k in range(samples):
            positions[k] = state[0]
            voltage = min(max(GAIN * (reference[k] - state[0]), -LIMIT), LIMIT)
            state = advance(state, voltage, k * SAMPLE)
        positions[samples] = state[0]
        return positions

    return run


def scipy_restarted(rates: Callable[[float, np.ndarray, float], np.ndarray]) -> Callable[[int], np.ndarray]:
    """`solve_ivp` from sample to sample."""

    def advance(state: np.ndarray, voltage: float, start: float) -> np.ndarray:
        span = (start, start + SAMPLE)
        return solve_ivp(rates, span, state, args=(voltage,), rtol=1e-3, atol=1e-3 * SCALES).y[:, -1]

    return sampled(advance)


def rates_in_python(time: float, state: np.ndarray, voltage: float) -> np.ndarray:
    """The plant's equations as Python runs them."""
    inputs = HOLDING._replace(valve_voltage=voltage)
    return to_array(PLANT.derivatives(time, from_array(PLANT.State, state), inputs, PARAMETERS))


def rates_compiled() -> Callable[[float, np.ndarray, float], np.ndarray]:
    """The plant's equations as our simulation runs them, called from Python."""
    function, parameters = compile_derivatives(PLANT).ctypes, to_array(PARAMETERS)

    def rates(time: float, state: np.ndarray, voltage: float) -> np.ndarray:
        out, inputs = np.empty_like(state), np.array([voltage, 0.0])
        function(time, *(_pointer(array) for array in (state, inputs, parameters, out)))
        return out

    return rates


def control_restarted() -> Callable[[int], np.ndarray]:
    """python-control's `input_output_response` from sample to sample: how a sampled loop is closed with it."""
    system = nonlinear_system(PLANT, PARAMETERS)
    options = {"rtol": 1e-3, "atol": 1e-3 * SCALES}

    def advance(state: np.ndarray, voltage: float, start: float) -> np.ndarray:
        span, inputs = [start, start + SAMPLE], [[voltage, voltage], [0.0, 0.0]]
        return control.input_output_response(system, span, inputs, state, solve_ivp_kwargs=options).states[:, -1]

    return sampled(advance)


def control_in_one_go(voltages: np.ndarray) -> Callable[[int], np.ndarray]:
    """python-control in one call, the loop left open: it is given our run's voltages, held over each sample.

    Inputs are interpolated between points of time, so each step is a pair of points 1e-9 of a sample apart.
    """
    system = nonlinear_system(PLANT, PARAMETERS)
    options = {"method": "LSODA", "rtol": 1e-7, "atol": 1e-7 * SCALES, "max_step": SAMPLE}

    def run(samples: int) -> np.ndarray:
        instants = SAMPLE * np.arange(samples + 1)
        times = np.column_stack([instants[:-1], instants[1:] - 1e-9 * SAMPLE]).ravel()
        times = np.append(times, instants[-1])
        held = np.append(np.repeat(voltages[:samples], 2), voltages[samples])
        response = control.input_output_response(
            system,
            times,
            [held, np.zeros_like(held)],
            to_array(REST),
            evaluation_times=instants,
            solve_ivp_kwargs=options,
        )
        return response.states[0]

    return run


def casadi_cvodes(setup: Setup = SETUP) -> Callable[[int], np.ndarray]:
    """CasADi with CVODES on scaled states, one integrator call a sample, the whole loop inside CasADi."""
    scaled = casadi.SX.sym("state", SCALES.size)
    voltage = casadi.SX.sym("voltage")
    inputs = casadi.vertcat(voltage, 0.0)
    rates, _ = symbolic(PLANT)(scaled * SCALES, inputs, to_array(setup.parameters))
    problem = {"x": scaled, "u": voltage, "ode": rates / SCALES}
    options = {"abstol": 1e-7, "reltol": 1e-7}
    integrate = casadi.integrator("sample", "cvodes", problem, 0.0, SAMPLE, options)
    state, reference = casadi.MX.sym("state", SCALES.size), casadi.MX.sym("reference")
    limit = setup.parameters.hydraulics.voltage_limit
    command = casadi.fmin(casadi.fmax(GAIN * (reference - state[0] * SCALES[0]), -limit), limit)
    step = casadi.Function("step", [state, reference], [integrate(x0=state, u=command)["xf"]])

    def run(samples: int) -> np.ndarray:
        wanted = REFERENCE(SAMPLE * np.arange(samples))[0]
        states = step.mapaccum(samples)(to_array(setup.state) / SCALES, wanted[np.newaxis])
        return np.append(setup.state.position, states.full()[0] * SCALES[0])

    return run


@contextmanager
def written_in_c(setup: Setup = SETUP) -> Iterator[list[Contestant]]:
    """loop.c at two levels of optimisation, or nothing where there is no gcc."""
    if shutil.which("gcc") is None:
        print("gcc not found: hand-written C is skipped\n")
        yield []
        return
    with tempfile.TemporaryDirectory() as folder:
        yield [_built(level, folder, setup) for level in ("-O2", "-O3")]


def _built(level: str, folder: str, setup: Setup) -> Contestant:
    library = Path(folder) / f"loop{level}.so"
    source = Path(__file__).with_name("loop.c")
    subprocess.run(["gcc", level, "-shared", "-fPIC", "-o", library, source, "-lm"], check=True)
    loop = ctypes.CDLL(str(library)).run
    loop.restype = ctypes.c_long
    parameters = to_array(setup.parameters)

    def run(samples: int) -> np.ndarray:
        reference = np.ascontiguousarray(REFERENCE(SAMPLE * np.arange(samples + 1))[0])
        log = np.empty((samples + 1, SCALES.size))
        loop(
            _pointer(parameters),
            ctypes.c_double(GAIN),
            _pointer(reference),
            ctypes.c_long(samples + 1),
            ctypes.c_double(SAMPLE),
            ctypes.c_double(LOOSE),
            _pointer(SCALES),
            _pointer(log),
        )
        return log[:, 0]

    return Contestant(f"the same scheme in C, gcc {level}, tolerance {LOOSE:g}", run)


def _pointer(array: np.ndarray) -> Any:
    return array.ctypes.data_as(ctypes.POINTER(ctypes.c_double))


def best_times(contestants: list[Contestant], rounds: int) -> list[float]:
    """Best processor time (s) of each for the whole work; they take turns, so that a busy machine hits all alike."""
    best = [np.inf] * len(contestants)
    for turn in range(rounds):
        for i, contestant in enumerate(contestants):
            if contestant.slow and turn >= SLOW_TURNS:
                continue
            share = contestant.samples * SAMPLE / DURATION
            turn_ends = time.perf_counter() + TURN
            while time.perf_counter() < turn_ends:
                begin = time.thread_time()
                contestant.run(contestant.samples)
                best[i] = min(best[i], (time.thread_time() - begin) / share)
    return best


def race(title: str, setup: Setup, contestants: list[Contestant], rounds: int) -> None:
    """Print the times of all, the first of which is ours.

    Raises:
        RuntimeError: the positions of one are off by more than `NEAR`, and its time says nothing.
    """
    exact = simulate(replace(setup, integrator=Integrator(tolerance=1e-12))).state("position")
    errors = [np.max(np.abs(c.run(c.samples) - exact[: c.samples + 1])) for c in contestants]
    for contestant, error in zip(contestants, errors, strict=True):
        if not error <= NEAR:
            raise RuntimeError(f"{contestant.name}: off by {error:.1e} m, expected at most {NEAR:g} m")
    times = best_times(contestants, rounds)
    print(f"{title:50}{'ms':>10}{'error, m':>10}{'over ours':>11}")
    for contestant, error, seconds in zip(contestants, errors, times, strict=True):
        mark = "*" if contestant.slow else " "
        print(f"{contestant.name:50}{1e3 * seconds:9.2f}{mark}{error:10.1e}{seconds / times[0]:11.2f}")
    print()


def main() -> None:
    """Print the tables."""
    parser = argparse.ArgumentParser(description="Time of a closed loop against other tools and C.")
    parser.add_argument("--rounds", type=int, default=20, help="turns of each, of which the best run counts")
    rounds = parser.parse_args().rounds

    loose, default = Integrator(tolerance=LOOSE), Integrator()
    voltages = simulate(replace(SETUP, integrator=Integrator(tolerance=1e-12))).command
    with written_in_c() as in_c:
        contestants = [
            Contestant(f"ours, tolerance {LOOSE:g}", ours(loose)),
            Contestant(f"ours, tolerance {default.tolerance:g} (default)", ours(default)),
            Contestant("ours, compiled RK4, step 0.5 ms", ours(Integrator("rk4", 5e-4))),
            *in_c,
            Contestant("CasADi with CVODES, sample by sample", casadi_cvodes()),
            Contestant("scipy solve_ivp, restarted each sample", scipy_restarted(rates_in_python), slow=True),
            Contestant("the same, our compiled equations", scipy_restarted(rates_compiled()), slow=True),
            Contestant("python-control, restarted each sample", control_restarted(), slow=True),
            Contestant("python-control, our voltages replayed, one call", control_in_one_go(voltages), slow=True),
        ]
        race("3 s of closed loop at 1 kHz", SETUP, contestants, rounds)
    with written_in_c(MEASURED) as in_c:
        contestants = [
            Contestant(f"ours, tolerance {LOOSE:g}", ours(loose, MEASURED)),
            Contestant(f"ours, tolerance {default.tolerance:g} (default)", ours(default, MEASURED)),
            *in_c,
            Contestant("CasADi with CVODES, sample by sample", casadi_cvodes(MEASURED)),
        ]
        race("the same, friction as measured (stiff)", MEASURED, contestants, rounds)
    print(f"* measured over {SLOW_STRETCH} s and scaled to {DURATION:g} s; its error is that of the stretch")


if __name__ == "__main__":
    main()
