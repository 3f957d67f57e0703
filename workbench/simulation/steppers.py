"""Steps of plants over stretches of time in which their inputs are constant or ramps, of one length or controlled.

A step is one C function (`workbench.simulation.whole_step`) of several `lanes`: plants alike that go side by side, each
with numbers, inputs and steps of its own. Compiled into the engine; every vector is a pointer to doubles, and where
lanes are several their numbers stand one behind another.
"""

from typing import Any

import numpy as np
from numba.extending import register_jitable

from plants.compiled import flagged, shift
from workbench.simulation.compilation import call_advance, call_measure, call_whole_step
from workbench.simulation.whole_step import KNOWN

OK, STEP_LIMIT, NOT_FINITE, INTERRUPTED, FAILED = 0, 1, 2, 3, 4
"""What a stretch ended with."""

SMALLEST_STEP, MOST_JUMPS = 1e-9, 100
"""s. An error control that asks for less has met a rate that jumps, which such a step crosses with next to no error, or
a slope without end: in a stretch it takes so many of them, and gives up.
"""

LONGEST, SHORTEST = 5.0, 0.1
"""By what a step is at most and at least longer than the one before."""

FIXED_STEP, CONTROLLED, ITS_OWN = 0, 1, 2
"""How a machine takes its steps: of one length, or controlled by their error; or it solves itself."""


@register_jitable
def fixed_steps(lanes: int, steps: Any, spans: Any, system: Any, flag: int) -> int:
    """The steps of equal length, so many of each lane, over its span.

    `spans` are (starts, ends) in s, `system` is (address of the step, numbers of its states and of its slopes, its
    arguments): among them clock, states, which are advanced in place, and last where what it gives goes.
    """
    starts, ends = spans
    code, states, _, arguments = system
    clock, y, given = arguments[1], arguments[2], arguments[8]
    most = 0
    for lane in range(lanes):
        most = max(most, int(steps[lane]))
    for i in range(most):
        if flagged(flag):
            return INTERRUPTED
        for lane in range(lanes):
            h = (ends[lane] - starts[lane]) / steps[lane] if i < int(steps[lane]) else 0.0
            clock[lane] = starts[lane] + i * h
            clock[lanes + lane] = h
        call_whole_step(code, *arguments)
        for lane in range(lanes):
            if i < int(steps[lane]):
                for j in range(states):
                    y[j * lanes + lane] = given[j * lanes + lane]
    return OK


@register_jitable
def _step_factor(worst: float, order: float) -> float:
    """By what the next step is longer where the error of this one was `worst` times what is allowed."""
    return LONGEST if worst < 1e-4 else min(LONGEST, max(SHORTEST, 0.9 * worst ** (-1.0 / order)))


@register_jitable
def _next_step(step: float, h: float, last: bool, worst: float, order: float) -> float:
    """The step to go on with behind one of `h` (s) that was accepted: the last of a stretch shortens none."""
    if last and step >= LONGEST * h:
        return step
    return max(step, h * _step_factor(worst, order)) if last else h * _step_factor(worst, order)


@register_jitable
def controlled_steps(lanes: int, order: float, spans: Any, system: Any, work: Any, flag: int) -> int:
    """Error-controlled steps of each lane over its span; a lane whose span has no length rests.

    `spans` and `system` are those of `fixed_steps`; in `work` stand for each lane the step (s) to go on with, how many
    were tried, how it ended, the time it has come to, and how often it crossed a jump.
    """
    starts, ends = spans
    code, states, count, arguments = system
    clock, y, slopes, given = arguments[1], arguments[2], arguments[7], arguments[8]
    known, last_slopes = shift(clock, KNOWN * lanes), shift(slopes, (count - 1) * states * lanes)
    guesses, tried, ended, times, jumps = work
    for lane in range(lanes):
        times[lane] = starts[lane]
        jumps[lane] = 0.0
        ended[lane] = OK
    lengths, worsts = shift(clock, lanes), shift(given, states * lanes)
    known[0] = 0.0
    while True:
        going = False
        for lane in range(lanes):
            clock[lane] = times[lane]
            left = ends[lane] - times[lane]
            if left > 0.0 and ended[lane] == OK:
                going = True
                tried[lane] += 1.0
                step = guesses[lane]
                lengths[lane] = left if step >= left * (1.0 - 1e-9) else min(step, 0.5 * left)
            else:
                lengths[lane] = 0.0
        if not going:
            return OK
        if flagged(flag):
            return INTERRUPTED
        call_whole_step(code, *arguments)
        known[0] = 1.0  # those at the end of a step are those at the next one's start
        for lane in range(lanes):
            h = lengths[lane]
            if h == 0.0:
                continue
            step, left = guesses[lane], ends[lane] - times[lane]
            last = step >= left * (1.0 - 1e-9)
            worst = worsts[lane]
            finite = worst < np.inf
            if not finite:
                worst = np.inf
            crosses = worst > 1.0 and h <= SMALLEST_STEP
            if crosses:
                jumps[lane] += 1.0
                if jumps[lane] > MOST_JUMPS or not finite:
                    ended[lane] = STEP_LIMIT if finite else NOT_FINITE
                    continue
            if worst <= 1.0 or crosses:
                guesses[lane] = h if crosses else _next_step(step, h, last, worst, order)
                times[lane] = ends[lane] if last else times[lane] + h
                for j in range(states):
                    place = j * lanes + lane
                    y[place], slopes[place] = given[place], last_slopes[place]
            else:
                guesses[lane] = max(h * _step_factor(worst, order), SMALLEST_STEP)


@register_jitable
def its_own(system: Any, span: tuple[float, float], y: Any, inputs: Any, work: Any, flag: int) -> int:
    """A step of a machine that solves itself over `span` (s), its inputs held at their mean; `y` is its new state.

    `system` is (address of `ADVANCE`, of the readings, parameters, filter cutoffs in rad/s, sizes) with sizes (all
    states, plant states, inputs, channels); `inputs` are (values at a time, slopes, that time). What filters see is a
    line from the readings before to those behind: dy/dt = c (r_0 + s t - y) is solved exactly.
    """
    advance, measure, parameters, cutoffs, sizes = system
    total, plant_states, input_count, channels = sizes
    initial, slopes, since = inputs
    now, before, readings = work, shift(work, input_count), shift(work, input_count + channels)
    start, end = span
    if flagged(flag):
        return INTERRUPTED
    for j in range(input_count):
        now[j] = initial[j] + slopes[j] * (0.5 * (start + end) - since)
    filtered = total > plant_states
    if filtered:
        call_measure(measure, y, parameters, before)
    if call_advance(advance, start, end, now, y) != 0.0:
        return FAILED
    if filtered:
        call_measure(measure, y, parameters, readings)
        for j in range(channels):
            if cutoffs[j] > 0.0:
                lag = (readings[j] - before[j]) / (end - start) / cutoffs[j]
                k = plant_states + j
                y[k] = readings[j] - lag + (y[k] - before[j] + lag) * np.exp(-cutoffs[j] * (end - start))
    return OK
