"""Runs whose position is given, and the figures of them."""

from collections.abc import Callable

import numpy as np
from support import OSCILLATOR, Parameters

from plants.hydraulics import Mass
from plants.interface import Measurement
from workbench.metrics.evaluate import evaluate
from workbench.simulation.references import ReferenceSignal
from workbench.simulation.simulate import NO_LOOP, Run

STEP = 1e-3


def made_up(position: np.ndarray, reference: ReferenceSignal | None, outcome: str = "completed") -> Run:
    """A run whose position (m, each ms) is given; the plant of `support` has neither friction nor power."""
    time = STEP * np.arange(position.size)
    parameters = Parameters(Mass(1.0, 0.0, 0.0, 0.0), 0.0, 0.0)
    velocity = np.gradient(position, time) if time.size > 1 else np.zeros(1)
    states = np.column_stack([position, velocity])
    inputs = np.zeros((time.size, 2))
    profile = None if reference is None else reference(time)
    measured, memory = np.zeros((time.size, len(Measurement._fields))), np.zeros((time.size, 1))
    return Run(
        OSCILLATOR,
        NO_LOOP,
        parameters,
        time,
        states,
        inputs,
        measured,
        memory,
        profile,
        outcome,
        time.size,
    )


def figures_of(
    position: Callable[[np.ndarray], np.ndarray], reference: ReferenceSignal, duration: float, transient: float
) -> dict[str, float | str | None]:
    time = STEP * np.arange(round(duration / STEP) + 1)
    return evaluate(made_up(position(time), reference), reference, transient)
