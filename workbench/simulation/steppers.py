"""Explicit Runge-Kutta integration of a plant over one interval in which its inputs are constant or ramps.

Compiled into the engine; every vector is a pointer to doubles. Beside the plant's states a vector `y` carries the
states of the sensors' anti-alias filters, so that these are integrated as exactly as the plant.
"""

from typing import Any

import numpy as np
from numba.extending import register_jitable

from plants.compiled import shift
from workbench.simulation.compilation import call_derivatives, call_measure

OK, STEP_LIMIT, NOT_FINITE = 0, 1, 2
"""What an interval ended with."""

SMALLEST_STEP = 1e-9
"""s. An error control that asks for less has met an infinite slope."""

# Dormand and Prince 1980, order 5 with an embedded order 4.
_A21 = 1 / 5
_A31, _A32 = 3 / 40, 9 / 40
_A41, _A42, _A43 = 44 / 45, -56 / 15, 32 / 9
_A51, _A52, _A53, _A54 = 19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729
_A61, _A62, _A63, _A64, _A65 = 9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656
_B1, _B3, _B4, _B5, _B6 = 35 / 384, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84
_E1, _E3, _E4 = 71 / 57600, -71 / 16695, 71 / 1920
_E5, _E6, _E7 = -17253 / 339200, 22 / 525, -1 / 40
_C2, _C3, _C4, _C5 = 1 / 5, 3 / 10, 4 / 5, 8 / 9

# Fixed-step methods by their number in `workbench.simulation.setup`: stages, nodes c, weights b.
_STAGES = (1, 2, 4)
_NODES = np.array([[0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.5, 0.5, 1.0]])
_WEIGHTS = np.array([[1.0, 0.0, 0.0, 0.0], [0.5, 0.5, 0.0, 0.0], [1 / 6, 1 / 3, 1 / 3, 1 / 6]])
_PREVIOUS = np.array([[0.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.5, 0.5, 1.0]])
"""These methods use only the stage before: A[i, i-1]."""


@register_jitable
def rates(system: Any, time: float, y: Any, inputs: Any, out: Any) -> None:
    """Rates of plant and filters at `time` into `out`.

    `system` is (addresses of derivatives and measure, parameters, filter cutoffs in rad/s, readings (scratch), sizes)
    with sizes (all states, plant states, inputs, channels); `inputs` is (values now, values at the interval's start,
    slopes, that start, whether any slope is not 0).
    """
    derivatives, measure, parameters, cutoffs, readings, sizes = system
    total, plant_states, input_count, channels = sizes
    now, initial, slopes, start, ramped = inputs
    if ramped:
        for j in range(input_count):
            now[j] = initial[j] + slopes[j] * (time - start)
    call_derivatives(derivatives, time, y, now, parameters, out)
    if total > plant_states:
        call_measure(measure, y, parameters, readings)
        for j in range(channels):
            k = plant_states + j
            out[k] = cutoffs[j] * (readings[j] - y[k]) if cutoffs[j] > 0.0 else 0.0


@register_jitable
def fixed_step(system: Any, interval: Any, method: int, steps: int, y: Any, inputs: Any, work: Any) -> int:
    """`steps` equal steps of a fixed-step method over `interval` (s); `y` is advanced in place."""
    start, end = interval
    h = (end - start) / steps
    n = system[5][0]
    slope, trial, total = work, shift(work, n), shift(work, 2 * n)
    for i in range(steps):
        time = start + i * h
        for j in range(n):
            total[j] = 0.0
            slope[j] = 0.0
        for stage in range(_STAGES[method]):
            for j in range(n):
                trial[j] = y[j] + h * _PREVIOUS[method, stage] * slope[j]
            rates(system, time + _NODES[method, stage] * h, trial, inputs, slope)
            for j in range(n):
                total[j] += _WEIGHTS[method, stage] * slope[j]
        for j in range(n):
            y[j] += h * total[j]
    return OK


@register_jitable
def dormand_prince(
    system: Any,
    interval: Any,
    guess: float,
    tolerance: float,
    scales: Any,
    y: Any,
    inputs: Any,
    work: Any,
) -> tuple[int, float, int]:
    """Error-controlled steps over `interval` (s); `y` is advanced in place.

    Each step's estimated error stays below `tolerance` times (scale + |y|) in every state.

    Returns:
        how it ended, the step to begin the next interval with, and the number of steps tried.
    """
    time, end = interval
    n = system[5][0]
    k1, k2, k3, k4 = work, shift(work, n), shift(work, 2 * n), shift(work, 3 * n)
    k5, k6, k7, trial = shift(work, 4 * n), shift(work, 5 * n), shift(work, 6 * n), shift(work, 7 * n)
    step = guess
    tried = 0
    rates(system, time, y, inputs, k1)
    while time < end:
        left = end - time
        last = step >= left * (1.0 - 1e-9)
        h = left if last else min(step, 0.5 * left)
        tried += 1
        for j in range(n):
            trial[j] = y[j] + h * (_A21 * k1[j])
        rates(system, time + _C2 * h, trial, inputs, k2)
        for j in range(n):
            trial[j] = y[j] + h * (_A31 * k1[j] + _A32 * k2[j])
        rates(system, time + _C3 * h, trial, inputs, k3)
        for j in range(n):
            trial[j] = y[j] + h * (_A41 * k1[j] + _A42 * k2[j] + _A43 * k3[j])
        rates(system, time + _C4 * h, trial, inputs, k4)
        for j in range(n):
            trial[j] = y[j] + h * (_A51 * k1[j] + _A52 * k2[j] + _A53 * k3[j] + _A54 * k4[j])
        rates(system, time + _C5 * h, trial, inputs, k5)
        for j in range(n):
            trial[j] = y[j] + h * (_A61 * k1[j] + _A62 * k2[j] + _A63 * k3[j] + _A64 * k4[j] + _A65 * k5[j])
        rates(system, time + h, trial, inputs, k6)
        for j in range(n):
            trial[j] = y[j] + h * (_B1 * k1[j] + _B3 * k3[j] + _B4 * k4[j] + _B5 * k5[j] + _B6 * k6[j])
        rates(system, time + h, trial, inputs, k7)
        worst = 0.0
        finite = True
        for j in range(n):
            error = h * (_E1 * k1[j] + _E3 * k3[j] + _E4 * k4[j] + _E5 * k5[j] + _E6 * k6[j] + _E7 * k7[j])
            ratio = abs(error) / (tolerance * (scales[j] + max(abs(y[j]), abs(trial[j]))))
            worst = max(worst, ratio)
            finite = finite and np.isfinite(ratio)
        if not finite:
            worst = 1e10
        factor = 5.0 if worst < 1e-4 else min(5.0, max(0.1, 0.9 * worst**-0.2))
        if worst <= 1.0:
            time = end if last else time + h
            for j in range(n):
                y[j] = trial[j]
                k1[j] = k7[j]
            step = max(step, h * factor) if last else h * factor
        else:
            step = h * factor
            if step < SMALLEST_STEP:
                return (STEP_LIMIT if finite else NOT_FINITE), guess, tried
    return OK, step, tried
