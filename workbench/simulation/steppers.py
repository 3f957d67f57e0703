"""Explicit Runge-Kutta integration of a plant over one interval in which its inputs are constant or ramps.

Any method goes by its tableau; the default, Dormand's and Prince's, has its sums written out, which is faster. Compiled
into the engine; every vector is a pointer to doubles. Beside the plant's states a vector `y` carries the states of the
sensors' anti-alias filters, so that these are integrated as exactly as the plant.
"""

import functools
from typing import Any

import numpy as np
from numba.extending import register_jitable

from plants.compiled import flagged, shift
from workbench.simulation.compilation import call_advance, call_derivatives, call_measure
from workbench.simulation.integrators.dormand_prince import DORMAND_PRINCE
from workbench.simulation.integrators.interface import IntegrationMethod

OK, STEP_LIMIT, NOT_FINITE, INTERRUPTED, FAILED = 0, 1, 2, 3, 4
"""What an interval ended with."""

SMALLEST_STEP, MOST_JUMPS = 1e-9, 100
"""s. An error control that asks for less has met a rate that jumps, which such a step crosses with next to no error, or
a slope without end: in an interval it takes so many of them, and gives up.
"""

LONGEST, SHORTEST = 5.0, 0.1
"""By what a step is at most and at least longer than the one before."""

FIXED_STEP, CONTROLLED, WRITTEN_OUT, ITS_OWN = 0, 1, 2, 3
"""How a method takes its steps: of one length, or controlled by their error; the latter without a tableau; or not at
all, since the machine solves itself."""

SELF_SOLVING = (ITS_OWN, 1, 1.0, np.zeros(0))
"""What `scheme` is of a method, of a machine that solves itself."""

_A = DORMAND_PRINCE.stages
(_A21,), (_A31, _A32), (_A41, _A42, _A43), (_A51, _A52, _A53, _A54) = _A[0], _A[1], _A[2], _A[3]
_A61, _A62, _A63, _A64, _A65 = _A[4]
_B1, _, _B3, _B4, _B5, _B6, _ = DORMAND_PRINCE.weights
_E1, _, _E3, _E4, _E5, _E6, _E7 = DORMAND_PRINCE.errors
_C2, _C3, _C4, _C5, _, _ = DORMAND_PRINCE.nodes


@functools.cache
def scheme(method: IntegrationMethod) -> tuple[int, int, float, np.ndarray]:
    """A method as the engine takes it: how it steps, its number of slopes, the order of its error, and its numbers.

    The numbers are a_ij as a square, c_i, b_i and e_i, one behind another.
    """
    square = np.zeros((method.count, method.count))
    for i, row in enumerate(method.stages, start=1):
        square[i, :i] = row
    kind = WRITTEN_OUT if method is DORMAND_PRINCE else CONTROLLED if method.errors else FIXED_STEP
    errors = method.errors or (0.0,) * method.count
    numbers = np.concatenate([square.ravel(), (0.0, *method.nodes), method.weights, errors])
    return kind, method.count, float(max(method.order, 1)), numbers


@register_jitable
def rates(system: Any, time: float, y: Any, inputs: Any, out: Any) -> None:
    """Rates of plant and filters at `time` into `out`.

    `system` is (addresses of derivatives and measure, parameters, filter cutoffs in rad/s, readings (scratch), sizes,
    address of the flag that stops) with sizes (all states, plant states, inputs, channels); `inputs` is (values now,
    values at the interval's start, slopes, that start, whether any slope is not 0).
    """
    derivatives, measure, parameters, cutoffs, readings, sizes, _ = system
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
def _combined(weights: Any, count: int, slopes: Any, n: int, j: int) -> float:
    """The sum of w_i k_i in place `j`, of the first `count` slopes: vectors of `n` numbers one behind another."""
    total = weights[0] * slopes[j]
    for i in range(1, count):
        total += weights[i] * slopes[i * n + j]
    return total


@register_jitable
def _further_slopes(system: Any, tableau: Any, time: float, h: float, y: Any, inputs: Any, slopes: Any) -> None:
    """The slopes of a step (s) behind the first, which is there; behind them the states of the last stage.

    `tableau` is (number of slopes, order of the error, numbers) of `scheme`.
    """
    count, _, numbers = tableau
    n = system[5][0]
    trial = shift(slopes, count * n)
    for i in range(1, count):
        row, first = shift(numbers, i * count), 0
        while row[first] == 0.0:  # most rows of classic methods have one number
            first += 1
        used, among = shift(row, first), shift(slopes, first * n)
        if first == i - 1:
            for j in range(n):
                trial[j] = y[j] + h * used[0] * among[j]
        else:
            for j in range(n):
                trial[j] = y[j] + h * _combined(used, i - first, among, n, j)
        rates(system, time + numbers[count * count + i] * h, trial, inputs, shift(slopes, i * n))


@register_jitable
def fixed_step(system: Any, interval: Any, tableau: Any, steps: int, y: Any, inputs: Any, work: Any) -> int:
    """`steps` equal steps of a fixed-step method over `interval` (s); `y` is advanced in place."""
    start, end = interval
    count, _, numbers = tableau
    h = (end - start) / steps
    n = system[5][0]
    weights = shift(numbers, (count + 1) * count)
    for i in range(steps):
        if flagged(system[6]):
            return INTERRUPTED
        time = start + i * h
        rates(system, time, y, inputs, work)
        _further_slopes(system, tableau, time, h, y, inputs, work)
        for j in range(n):
            y[j] += h * _combined(weights, count, work, n, j)
    return OK


@register_jitable
def _step_factor(worst: float, order: float) -> float:
    """By what the next step is longer where the error of this one was `worst` times what is allowed."""
    return LONGEST if worst < 1e-4 else min(LONGEST, max(SHORTEST, 0.9 * worst ** (-1.0 / order)))


@register_jitable
def _next_step(step: float, h: float, last: bool, worst: float, order: float) -> float:
    """The step to go on with behind one of `h` (s) that was accepted: the last of an interval shortens none."""
    if last and step >= LONGEST * h:
        return step
    return max(step, h * _step_factor(worst, order)) if last else h * _step_factor(worst, order)


@register_jitable
def controlled(
    system: Any, interval: Any, tableau: Any, control: Any, y: Any, inputs: Any, work: Any
) -> tuple[int, float, int]:
    """Error-controlled steps over `interval` (s) by any method; `y` is advanced in place.

    `control` is (step to begin with, tolerance, scales). Each step's estimated error stays below `tolerance` times
    (scale + |y|) in every state.

    Returns:
        how it ended, the step to begin the next interval with, and the number of steps tried.
    """
    time, end = interval
    guess, tolerance, scales = control
    count, order, numbers = tableau
    n = system[5][0]
    errors = shift(numbers, (count + 2) * count)
    last_slope, trial = shift(work, (count - 1) * n), shift(work, count * n)
    step, tried, jumps = guess, 0, 0
    rates(system, time, y, inputs, work)
    while time < end:
        left = end - time
        last = step >= left * (1.0 - 1e-9)
        h = left if last else min(step, 0.5 * left)
        if flagged(system[6]):
            return INTERRUPTED, guess, tried
        tried += 1
        _further_slopes(system, tableau, time, h, y, inputs, work)
        worst = 0.0
        for j in range(n):
            error = h * _combined(errors, count, work, n, j)
            ratio = abs(error) / (tolerance * (scales[j] + max(abs(y[j]), abs(trial[j]))))
            worst = max(worst, ratio) if np.isfinite(ratio) else np.inf
        crosses = worst > 1.0 and h <= SMALLEST_STEP
        jumps += crosses
        if crosses and (jumps > MOST_JUMPS or not np.isfinite(worst)):
            return (STEP_LIMIT if np.isfinite(worst) else NOT_FINITE), guess, tried
        if worst <= 1.0 or crosses:
            step = h if crosses else _next_step(step, h, last, worst, order)
            time = end if last else time + h
            for j in range(n):
                y[j] = trial[j]
                work[j] = last_slope[j]
        else:
            step = max(h * _step_factor(worst, order), SMALLEST_STEP)
    return OK, step, tried


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
    """What `controlled` does, by Dormand's and Prince's method, written out."""
    time, end = interval
    n = system[5][0]
    k1, k2, k3, k4 = work, shift(work, n), shift(work, 2 * n), shift(work, 3 * n)
    k5, k6, k7, trial = shift(work, 4 * n), shift(work, 5 * n), shift(work, 6 * n), shift(work, 7 * n)
    step = guess
    tried = jumps = 0
    rates(system, time, y, inputs, k1)
    while time < end:
        left = end - time
        last = step >= left * (1.0 - 1e-9)
        h = left if last else min(step, 0.5 * left)
        if flagged(system[6]):
            return INTERRUPTED, guess, tried
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
        crosses = worst > 1.0 and h <= SMALLEST_STEP
        jumps += crosses
        if crosses and (jumps > MOST_JUMPS or not finite):
            return (STEP_LIMIT if finite else NOT_FINITE), guess, tried
        if worst <= 1.0 or crosses:
            step = h if crosses else _next_step(step, h, last, worst, 5.0)
            time = end if last else time + h
            for j in range(n):
                y[j] = trial[j]
                k1[j] = k7[j]
        else:
            step = max(h * _step_factor(worst, 5.0), SMALLEST_STEP)
    return OK, step, tried


@register_jitable
def its_own(system: Any, interval: Any, y: Any, inputs: Any, work: Any) -> int:
    """A step of a machine that solves itself over `interval` (s), its inputs held at their mean; `y` is its new state.

    In `system` the address of `ADVANCE` is in the place of that of the derivatives. What filters see is a line from the
    readings before to those behind: dy/dt = c (r_0 + s t - y) is solved exactly.
    """
    advance, measure, parameters, cutoffs, readings, sizes, flag = system
    total, plant_states, input_count, channels = sizes
    now, initial, slopes, sample, ramped = inputs
    start, end = interval
    if flagged(flag):
        return INTERRUPTED
    if ramped:
        for j in range(input_count):
            now[j] = initial[j] + slopes[j] * (0.5 * (start + end) - sample)
    filtered = total > plant_states
    if filtered:
        call_measure(measure, y, parameters, work)
    if call_advance(advance, start, end, now, y) != 0.0:
        return FAILED
    if filtered:
        call_measure(measure, y, parameters, readings)
        for j in range(channels):
            if cutoffs[j] > 0.0:
                lag = (readings[j] - work[j]) / (end - start) / cutoffs[j]
                k = plant_states + j
                y[k] = readings[j] - lag + (y[k] - work[j] + lag) * np.exp(-cutoffs[j] * (end - start))
    return OK
