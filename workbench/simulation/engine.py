"""The compiled loop: sample, control, saturate, log, integrate to the next sample.

Compiled once for the C signatures of `workbench.simulation.compilation`; plants and controllers plug
in as function pointers. Several plants alike go side by side, each a lane of the loop.
"""

from collections.abc import Callable
from typing import Any

import numba
import numpy as np
from numba import types
from numba.extending import register_jitable

from plants.compiled import INNER, address, flagged, njit, shift
from plants.interface import Measurement
from workbench.simulation.compilation import call_commit, call_measure, call_step
from workbench.simulation.sensors import ERROR_NUMBERS, systematic_error
from workbench.simulation.steppers import (
    FAILED,
    FIXED_STEP,
    INTERRUPTED,
    ITS_OWN,
    OK,
    STEP_LIMIT,
    controlled_steps,
    fixed_steps,
    its_own,
)
from workbench.simulation.whole_step import CLOCK, RAMPED

COMPLETED, DIVERGED, STEP_TOO_SMALL, STOPPED, MACHINE_FAILED, TOO_MANY_STEPS = 0, 1, 2, 3, 4, 5
"""How a loop ended."""

ENDED, COUNT, STEPS = 0, 1, 2
"""Of a lane's results: how it ended, the number of samples logged, the number of integration steps."""

FIRST_OF_DRIVE = Measurement._fields.index("rotation_speed")
"""From this channel on the motor's drive measures itself, speed and current, and at once; the rest may be delayed."""

KEPT = 2
"""Samples of the command that are kept beyond a delay of whole ones: this one, and one that ends within this one."""

WORK = 11
"""Numbers that the loop keeps of each lane: spans, what `controlled_steps` works on, and where it is in a sample."""

register_jitable(forceinline=True, **INNER)(systematic_error)

_vector = types.float64[::1]
_table = types.float64[:, ::1]
_number = types.float64
_integer = types.int64

_ARGUMENTS = (
    types.UniTuple(_integer, 3),  # addresses of a whole step, of the plant's rates, or `ADVANCE`, and of its measure
    types.UniTuple(_integer, 4),  # of step and commit of the controller, and of the rotary one
    types.Tuple((_table, _table, _table, _table)),  # of each lane y, inputs, parameters, scales
    types.Tuple((_table, _table, _table, _table)),  # of each lane controller state, gains; the same, rotary
    types.Tuple((_integer, _integer, _table)),  # command's and rotary command's input; of each lane the limits of both
    types.Tuple((_table, _table, _table, _vector)),  # references; if any, rotary ones and exogenous; linear hold
    types.Tuple((_table, _vector, _vector, _table)),  # noise, if any; resolution, filter cutoffs, systematic errors
    types.Tuple((_integer, _number)),  # delay: whole samples, and the rest in s
    _table,  # of each input that is the command of a time ago: its place, that time in whole samples, and the rest in s
    types.Tuple((_number, _integer, _number, _number)),  # sample time, steps a sample, tolerance, most steps
    _number,  # times its typical magnitude and its initial value at which a state has diverged
    types.Tuple((_integer, _number, _integer, _integer)),  # the method: how it steps, order, slopes, what it works on
    types.Tuple((_table, _table, _table, _table)),  # logs: states, inputs, measurements, the controller's state
    _table,  # of each lane, out: how it ended, the number of samples logged, the number of integration steps
    _vector,  # scratch, of `scratch_size`
    _integer,  # address of the flag that stops it: `workbench.stopping`
)
"""What there is of every sample of every lane, or of every line of every lane, stands lane by lane."""


def _compiled(*arguments: Any) -> Callable[[Callable[..., int]], Callable[..., int]]:
    """Compile for these without vectorised loops: over a handful of states they cost more than they give."""

    def compiled(function: Callable[..., int]) -> Callable[..., int]:
        vectorize = numba.config.LOOP_VECTORIZE
        numba.config.LOOP_VECTORIZE = 0
        try:
            return njit(_integer(*arguments), cache=True, nogil=True, error_model="numpy")(function)
        finally:
            numba.config.LOOP_VECTORIZE = vectorize

    return compiled


def scratch_size(lanes: int, sizes: tuple[int, int, int, int], step: int, delay_samples: int, past: int) -> int:
    """Numbers that the loop works on beside its arguments: `sizes` are those of states with the filters', inputs,
    parameters and channels; `step` is what a step works on, `past` the longest delay of a command in whole samples.

    They come from the caller, who keeps them: the loop has pointers alone, and an array of its own would be freed after
    its last mention, before the last use of its memory.
    """
    states, inputs, parameters, channels = sizes
    of_step = CLOCK + states + 2 * inputs + parameters + channels + 2 * (1 + states) + step
    own = WORK + states + channels * (1 + delay_samples) + 2 * (past + KEPT)
    return lanes * (of_step + own) + states + inputs + 4 * channels


@register_jitable
def _clip(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


@register_jitable
def _read(lanes: int, lane: int, system: Any, y: Any, out: Any) -> None:
    """The sensors' analogue outputs into `out`: of the filter where there is one, else of the plant."""
    measure, parameters, cutoffs, alone, sizes = system
    total, plant_states, _, channels = sizes
    own = y if lanes == 1 else alone
    for j in range(total if lanes > 1 else 0):
        own[j] = y[j * lanes + lane]
    call_measure(measure, own, parameters, out)
    if total > plant_states:
        for j in range(channels):
            if cutoffs[j] > 0.0:
                out[j] = own[plant_states + j]


@register_jitable
def _arrive(lanes: int, lane: int, lined: Any, inputs: Any, k: int, h: float, time: float) -> None:
    """Set the inputs that are the command of a time ago, from `time` (s) in sample k on: values and slopes.

    `lined` is (number of them, the command's value and slope in the last samples, how many, place, whole samples and
    rest (s) of each); values are those at the start of the sample, as the slopes would have them.
    """
    count, past, depth, lines = lined
    initial, slopes = inputs
    for i in range(count):
        place, samples, rest = int(lines[3 * i]), int(lines[3 * i + 1]), lines[3 * i + 2]
        early = 1 if time < k * h + rest else 0
        sent = (k - samples - early) % depth
        at = place * lanes + lane
        slopes[at] = past[2 * sent + 1]
        initial[at] = past[2 * sent] + slopes[at] * (early * h - rest)


@register_jitable
def _sensed(lane: int, k: int, lanes: int, reading: Any, sensing: Any, out: Any) -> None:
    """What the sensors of a lane deliver at sample k, into `out`.

    `reading` is what `_read` takes, states and where readings are kept until they are as old as the delay; `sensing`
    what disturbs a reading, and which of them is the oldest, and the newest.
    """
    own, y, kept, prompt = reading
    errors, noise, resolution, erring, noisy, late, read_now, newest, oldest = sensing
    channels = own[4][3]
    if read_now:
        _read(lanes, lane, own, y, shift(kept, newest * channels))
    if late:
        _read(lanes, lane, own, y, prompt)
    for j in range(channels):
        value = prompt[j] if late and j >= FIRST_OF_DRIVE else kept[oldest * channels + j]
        if erring:
            value += systematic_error(value, shift(errors, j * ERROR_NUMBERS))
        if noisy:
            value += noise[k * channels + j]
        if resolution[j] > 0.0:
            value = resolution[j] * np.rint(value / resolution[j])
        out[j] = value


@register_jitable
def _commanded(loop: Any, reference: Any, measured: Any, driven: int, limit: float, inputs: Any, h: float) -> None:
    """A controller's step: its command is added to what is fed to the input that it drives, in the place `driven` of
    all lanes' inputs, saturated, and committed.

    `loop` is (addresses of step and commit, state, gains).
    """
    step, commit, state, gains = loop
    initial, slopes = inputs
    feed = initial[driven]
    command = call_step(step, reference, measured, state, gains, h)
    initial[driven] = _clip(command + feed, limit)
    if slopes[driven] != 0.0:
        following = _clip(command + feed + h * slopes[driven], limit)
        slopes[driven] = (following - initial[driven]) / h
    call_commit(commit, initial[driven] - feed, state, gains, h)


@register_jitable
def _stop_behind(at: float, within: Any, turns: Any, parts: Any) -> float:
    """Where a stretch of time ends that begins at `at` (s), within a sample: at the sample's end, where a reading is
    taken, or where an input changes; or one of as many parts of what is between two such stops.

    `within` is (start, end of the sample, where a reading is taken, if it is), `turns` (number of inputs that are the
    command of a time ago, the numbers of each), `parts` (how many, and where the first began, and the last ends).
    """
    start, end, middle, reading = within
    count, lines = turns
    steps, first, stop = parts
    until = middle if reading and at < middle else end
    for i in range(count):
        turn = start + lines[3 * i + 2]
        until = turn if at < turn < until else until
    if steps > 1:
        if at >= stop[0]:
            first[0], stop[0] = at, until
        part = np.floor((at - first[0]) / (stop[0] - first[0]) * steps + 1e-6) + 1.0
        if part < steps:
            until = min(until, first[0] + part / steps * (stop[0] - first[0]))
    return until


@register_jitable(forceinline=True, **INNER)
def _loops(lanes: int, given: Any) -> int:
    """Run the loops of `lanes` plants alike from t = 0 over all samples of the logs; `given` are `_ARGUMENTS`.

    At sample k: the sensors deliver y(k h - delay), those of the motor's drive y(k h), with systematic error, noise and
    quantisation; the controllers step; the sum of each command and its exogenous input is saturated and committed; the
    plant is integrated to (k + 1) h. An exogenous input is held over the sample, or a ramp to its next value where its
    hold is linear. An input that is the command of a time ago changes exactly that time behind it, also within a
    sample; before t = 0 it was what the inputs say. A lane that ends early waits for the others.

    Returns:
        whether it was `STOPPED`, else `COMPLETED`.
    """
    plant, control, vectors, memory, channels, signals, sensors, delay = given[:8]
    lines, clock, farthest, method, logs, results, scratch, flag = given[8:]
    code, rates, measure = plant
    step, commit, rotary_step, rotary_commit = control
    y, base, parameters, scales = vectors
    state, gains, rotary_state, rotary_gains = memory
    command_input, rotary_input, limits = channels
    references, rotary_references, exogenous, linear = signals
    noise, resolution, cutoffs, errors = sensors
    delay_samples, delay_rest = delay
    h, steps_a_sample, tolerance, most_steps = clock
    kind, order, slope_count, step_work = method
    log_states, log_inputs, log_measurements, log_control = logs

    plant_states = log_states.shape[1]
    n, m, parameter_count, channel_count = y.shape[1], base.shape[1], parameters.shape[1], cutoffs.size
    memory_count, gain_count = state.shape[1], gains.shape[1]
    rotary_count, rotary_gain_count = rotary_state.shape[1], rotary_gains.shape[1]
    samples = log_states.shape[0] // lanes
    slots = delay_samples + 1
    slot = 0

    # From here on pointers: an array handed to a function costs a reference count, at every sample.
    p_base, p_parameters, p_linear = address(base), address(parameters), address(linear)
    p_filters = address(cutoffs)
    p_scratch = address(scratch)
    for i in range(scratch.size):
        p_scratch[i] = 0.0
    p_clock = p_scratch
    p_y = shift(p_clock, CLOCK * lanes)
    p_initial, p_slopes = shift(p_y, n * lanes), shift(p_y, (n + m) * lanes)
    p_numbers = shift(p_slopes, m * lanes)
    p_control = shift(p_numbers, (parameter_count + channel_count) * lanes)
    p_given = shift(p_control, (1 + n) * lanes)
    p_step_work = shift(p_given, (1 + n) * lanes)
    p_starts = shift(p_step_work, step_work * lanes)
    p_ends, p_guesses, p_tried = shift(p_starts, lanes), shift(p_starts, 2 * lanes), shift(p_starts, 3 * lanes)
    p_ended, p_times, p_jumps = shift(p_starts, 4 * lanes), shift(p_starts, 5 * lanes), shift(p_starts, 6 * lanes)
    p_at, p_first = shift(p_starts, 7 * lanes), shift(p_starts, 8 * lanes)
    p_stop, p_steps = shift(p_starts, 9 * lanes), shift(p_starts, 10 * lanes)
    p_bounds = shift(p_starts, WORK * lanes)
    p_delayed = shift(p_bounds, n * lanes)
    line_count, depth = lines.shape[0] // lanes, KEPT
    p_lines = address(lines)
    for i in range(lines.shape[0]):
        depth = max(depth, int(p_lines[3 * i + 1]) + KEPT)
    p_past = shift(p_delayed, slots * channel_count * lanes)
    p_own = shift(p_past, 2 * depth * lanes)  # what one lane works on at a time
    p_measured = shift(p_own, n)
    p_prompt, p_inner = shift(p_measured, channel_count), shift(p_measured, 2 * channel_count)
    p_references, p_rotary_references = address(references), address(rotary_references)
    p_exogenous, p_noise, p_resolution = address(exogenous), address(noise), address(resolution)
    p_errors, p_limits = address(errors), address(limits)
    p_state, p_gains = address(state), address(gains)
    p_rotary_state, p_rotary_gains = address(rotary_state), address(rotary_gains)
    p_log_states, p_log_inputs = address(log_states), address(log_inputs)
    p_log_read, p_log_control = address(log_measurements), address(log_control)
    p_results = address(results)

    sizes = (n, plant_states, m, channel_count)
    inputs, spans = (p_initial, p_slopes), (p_starts, p_ends)
    system = (
        code,
        n,
        slope_count,
        (rates, p_clock, p_y, p_initial, p_slopes, p_numbers, p_control, p_step_work, p_given),
    )
    work = (p_guesses, p_tried, p_ended, p_times, p_jumps)
    ramped = erring = False
    noisy, fed, late = noise.size > 0, exogenous.size > 0, delay_samples > 0 or delay_rest > 0.0
    for j in range(m):
        ramped = ramped or p_linear[j] > 0.0
    p_clock[RAMPED * lanes] = 1.0 if ramped else 0.0
    for j in range(errors.size):
        erring = erring or p_errors[j] != 0.0
    for lane in range(lanes):
        p_control[lane] = tolerance
        p_guesses[lane] = h
        for j in range(n):
            p_y[j * lanes + lane] = y[lane, j]
            p_control[(1 + j) * lanes + lane] = scales[lane, j]
            p_bounds[j * lanes + lane] = farthest * (scales[lane, j] + abs(y[lane, j]))
        for j in range(m):
            p_initial[j * lanes + lane] = base[lane, j]
        for j in range(parameter_count):
            p_numbers[j * lanes + lane] = parameters[lane, j]
        for j in range(channel_count):
            p_numbers[(parameter_count + j) * lanes + lane] = cutoffs[j]
        own = (measure, shift(p_parameters, lane * parameter_count), p_filters, p_own, sizes)
        for i in range(slots):
            _read(lanes, lane, own, p_y, shift(p_delayed, (lane * slots + i) * channel_count))
        for i in range(depth if line_count > 0 else 0):
            p_past[2 * (lane * depth + i)] = p_base[lane * m + int(p_lines[3 * lane * line_count])]

    for k in range(samples):
        if flagged(flag):
            return STOPPED
        before, slot = slot, slot + 1 if slot + 1 < slots else 0
        going = False
        for lane in range(lanes):
            if p_results[3 * lane + ENDED] != COMPLETED:
                continue
            going = True
            row = lane * samples + k
            own = (measure, shift(p_parameters, lane * parameter_count), p_filters, p_own, sizes)
            reading = (own, p_y, shift(p_delayed, lane * slots * channel_count), p_prompt)
            sensing = (p_errors, p_noise, p_resolution, erring, noisy, late, delay_rest == 0.0, before, slot)
            _sensed(lane, k, lanes, reading, sensing, p_measured)
            for j in range(channel_count):
                p_log_read[row * channel_count + j] = p_measured[j]
            fed_row = (lane * (samples + 1) + k) * m
            for j in range(m):
                at = j * lanes + lane
                p_initial[at] = p_base[lane * m + j] + p_exogenous[fed_row + j] if fed else p_base[lane * m + j]
                if ramped and p_linear[j] > 0.0:
                    p_slopes[at] = (p_exogenous[fed_row + m + j] - p_exogenous[fed_row + j]) / h
            remembered, driven = shift(p_state, lane * memory_count), command_input * lanes + lane
            loop = (step, commit, remembered, shift(p_gains, lane * gain_count))
            _commanded(loop, shift(p_references, 3 * k), p_measured, driven, p_limits[2 * lane], inputs, h)
            if rotary_input >= 0:
                turned, limit = rotary_input * lanes + lane, p_limits[2 * lane + 1]
                rotary_memory = shift(p_rotary_state, lane * rotary_count)
                turning = (rotary_step, rotary_commit, rotary_memory, shift(p_rotary_gains, lane * rotary_gain_count))
                _commanded(turning, shift(p_rotary_references, 3 * k), p_measured, turned, limit, inputs, h)
            if line_count > 0:
                sent = shift(p_past, 2 * (lane * depth + k % depth))
                sent[0], sent[1] = p_initial[driven], p_slopes[driven]
                lined = (line_count, shift(p_past, 2 * lane * depth), depth, shift(p_lines, 3 * lane * line_count))
                _arrive(lanes, lane, lined, inputs, k, h, k * h)
            for j in range(memory_count):
                p_log_control[row * memory_count + j] = remembered[j]
            for j in range(plant_states):
                p_log_states[row * plant_states + j] = p_y[j * lanes + lane]
            for j in range(m):
                p_log_inputs[row * m + j] = p_initial[j * lanes + lane]
            p_results[3 * lane + COUNT] = k + 1
        if k + 1 == samples or not going:
            break

        start, end, middle = k * h, (k + 1) * h, (k + 1) * h - delay_rest
        for lane in range(lanes):
            p_clock[2 * lanes + lane] = start
            p_at[lane] = start if p_results[3 * lane + ENDED] == COMPLETED else end
            p_first[lane] = p_stop[lane] = start  # of a stretch between two stops
        while True:
            going = False
            for lane in range(lanes):
                at = p_at[lane]
                p_starts[lane] = p_ends[lane] = at
                p_steps[lane] = p_ended[lane] = 0.0
                if at >= end:
                    continue
                going = True
                own_lines, steps_here = shift(p_lines, 3 * lane * line_count), steps_a_sample
                parts = steps_a_sample if kind != FIXED_STEP else 1
                within, divided = (
                    (start, end, middle, delay_rest > 0.0),
                    (parts, shift(p_first, lane), shift(p_stop, lane)),
                )
                until = _stop_behind(at, within, (line_count, own_lines), divided)
                if line_count > 0:
                    _arrive(
                        lanes, lane, (line_count, shift(p_past, 2 * lane * depth), depth, own_lines), inputs, k, h, at
                    )
                    steps_here = max(int(np.ceil(steps_a_sample * (until - at) / h - 1e-9)), 1)
                p_ends[lane], p_steps[lane] = until, float(steps_here)
            if not going:
                break
            if kind == FIXED_STEP:
                how = fixed_steps(lanes, p_steps, spans, system, flag)
                for lane in range(lanes):
                    p_tried[lane] += p_steps[lane]
            elif kind == ITS_OWN:
                machine = (rates, measure, p_numbers, p_filters, sizes)
                how = its_own(machine, (p_starts[0], p_ends[0]), p_y, (p_initial, p_slopes, start), p_inner, flag)
                p_tried[0] += 1.0
            else:
                how = controlled_steps(lanes, order, spans, system, work, flag)
            if how == INTERRUPTED:
                return STOPPED
            for lane in range(lanes):
                until = p_ends[lane]
                if until == p_starts[lane]:
                    continue
                ended = FAILED if how == FAILED else int(p_ended[lane])
                if ended != OK:
                    early = MACHINE_FAILED if ended == FAILED else STEP_TOO_SMALL if ended == STEP_LIMIT else DIVERGED
                    p_results[3 * lane + ENDED] = early
                    until = end
                elif delay_rest > 0.0 and until == middle:
                    own = (measure, shift(p_parameters, lane * parameter_count), p_filters, p_own, sizes)
                    _read(lanes, lane, own, p_y, shift(p_delayed, (lane * slots + slot) * channel_count))
                p_at[lane] = until
        for lane in range(lanes):
            gone = False
            for j in range(n):
                gone = gone or not abs(p_y[j * lanes + lane]) <= p_bounds[j * lanes + lane]
            if (gone or p_tried[lane] > most_steps) and p_results[3 * lane + ENDED] == COMPLETED:
                p_results[3 * lane + ENDED] = DIVERGED if gone else TOO_MANY_STEPS
    for lane in range(lanes):
        p_results[3 * lane + STEPS] = p_tried[lane]
    return COMPLETED


@_compiled(*_ARGUMENTS)
def run_loop(
    plant: Any,
    control: Any,
    vectors: Any,
    memory: Any,
    channels: Any,
    signals: Any,
    sensors: Any,
    delay: Any,
    lines: Any,
    clock: Any,
    farthest: Any,
    method: Any,
    logs: Any,
    results: Any,
    scratch: Any,
    flag: Any,
) -> int:
    """`_loops` of one plant, compiled for that: a loop over one lane costs nothing."""
    first = (plant, control, vectors, memory, channels, signals, sensors, delay)
    return _loops(1, (*first, lines, clock, farthest, method, logs, results, scratch, flag))


@_compiled(_integer, types.Tuple(_ARGUMENTS))
def run_loops(lanes: Any, given: Any) -> int:
    """`_loops` of several plants."""
    return _loops(lanes, given)
