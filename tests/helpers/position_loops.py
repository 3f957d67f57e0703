"""Controllers of the position loop as tests run them: by hand over samples, and on the simulated plant."""

from dataclasses import replace
from typing import Any

import numpy as np
from support import registered

from controllers.interface import Controller, Reference
from plants.interface import Measurement
from workbench.metrics.limit_cycle import LimitCycle, judge
from workbench.simulation.references import ReferenceSignal, Sine, Steps
from workbench.simulation.simulate import Loop, Setup, simulate

H = 1e-3
LAG = 12e-3
KEEP = np.exp(-0.5)
"""Of the velocity filter: T_v 2 ms, 1 kHz."""

NO_LOAD_GAIN = 5.9e-4 * 6e-5 * np.sqrt(2.94e6 / 2.0) / 6.33e-4
"""K_q of the simulation set: 0.0678 m/s per V."""

BELIEF = registered("rotating_helical", duration=1.0).parameters


def play(
    controller: Controller, settings: Any, samples: list[tuple[float, float]], limit: float = np.inf
) -> tuple[list[float], Any]:
    """Commands over samples of reference and position (mm), and the last state; nothing but position is measured."""
    gains = controller.design(settings, BELIEF, H)
    state = controller.start(Measurement(samples[0][1] * 1e-3, np.nan, np.nan, np.nan), gains)
    commands = []
    for wanted, position in samples:
        measured = Measurement(position * 1e-3, np.nan, np.nan, np.nan)
        command, state = controller.step(Reference(wanted * 1e-3, 0.0, 0.0), measured, state, gains, H)
        state = controller.commit(min(max(command, -limit), limit), state, gains, H)
        commands.append(float(command))
    return commands, state


def loop(controller: Controller, settings: Any, reference: ReferenceSignal, duration: float, **changes: float) -> Setup:
    """A run of the simulation plant, believed as it is but for `changes` of its hydraulics."""
    setup = registered("non_rotating", duration=duration, reference=reference)
    gains = controller.design(settings, setup.parameters, H)
    parameters = setup.parameters._replace(hydraulics=setup.parameters.hydraulics._replace(**changes))
    return replace(setup, parameters=parameters, loop=Loop(controller, gains))


def tracking_error(controller: Controller, settings: Any, amplitude: float, frequency: float) -> float:
    """rms of the error (mm) over the second and third period of a sine."""
    run = simulate(loop(controller, settings, Sine(amplitude, frequency), 3.0 / frequency))
    return float(1e3 * np.sqrt(np.mean(run.signals["error"][run.time >= 1.0 / frequency] ** 2)))


def hunting(controller: Controller, settings: Any) -> tuple[LimitCycle, float]:
    """Verdict for a step of 10 mm of the hose-fed plant (bulk modulus 30 MPa), and the largest late error (mm)."""
    run = simulate(loop(controller, settings, Steps((10e-3,), 30.0), 30.0, bulk_modulus=30e6))
    error = run.signals["error"]
    verdict = judge(run.time, error, run.state("velocity"), 0.0)
    return verdict, float(1e3 * np.max(np.abs(error[run.time > 20.0])))


def replayed(
    loop: Loop, first: Measurement, record: np.ndarray, references: np.ndarray, realised: np.ndarray
) -> np.ndarray:
    """The commands of a controller that is given the record of the sensors and what was realised, and nothing else."""
    gains = loop.gains
    state = loop.controller.start(first, gains)
    commands = np.empty(len(record))
    for k, reading in enumerate(record):
        command, state = loop.controller.step(Reference(*references[k]), Measurement(*reading), state, gains, H)
        state = loop.controller.commit(realised[k], state, gains, H)
        commands[k] = command
    return commands
