"""The compiled loop: sample, control, saturate, log, integrate to the next sample.

Compiled once for the C signatures of `workbench.simulation.compilation`; plants and controllers plug
in as function pointers.
"""

from collections.abc import Callable
from typing import Any, TypeAlias

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
    WRITTEN_OUT,
    controlled,
    dormand_prince,
    fixed_step,
    its_own,
)

COMPLETED, DIVERGED, STEP_TOO_SMALL, STOPPED, MACHINE_FAILED = 0, 1, 2, 3, 4
"""How a loop ended."""

FIRST_OF_DRIVE = Measurement._fields.index("rotation_speed")
"""From this channel on the motor's drive measures itself, speed and current, and at once; the rest may be delayed."""

KEPT = 2
"""Samples of the command that are kept beyond a delay of whole ones: this one, and one that ends within this one."""

Ended: TypeAlias = tuple[int, int, int]
"""How a loop ended, the number of samples logged, the number of integration steps."""

register_jitable(forceinline=True, **INNER)(systematic_error)

_vector = types.float64[::1]
_table = types.float64[:, ::1]
_number = types.float64
_integer = types.int64

_SIGNATURE = types.Tuple((_integer, _integer, _integer))(
    types.UniTuple(_integer, 2),  # addresses of the plant's derivatives, or `ADVANCE`, and of its measure
    types.UniTuple(_integer, 4),  # of step and commit of the controller, and of the rotary one
    types.Tuple((_vector, _vector, _vector, _vector)),  # y, inputs, parameters, scales
    types.Tuple((_vector, _vector, _vector, _vector)),  # controller state, gains; the same, rotary
    types.Tuple((_integer, _number, _integer, _number)),  # command's input, its limit; the same of the rotary command
    types.Tuple((_table, _table, _table, _vector)),  # references; if any, rotary ones and exogenous; linear hold
    types.Tuple((_table, _vector, _vector, _table)),  # noise, if any; resolution, filter cutoffs, systematic errors
    types.Tuple((_integer, _number)),  # delay: whole samples, and the rest in s
    _table,  # of each input that is the command of a time ago: its place, that time in whole samples, and the rest in s
    types.Tuple((_number, _integer, _number)),  # sample time, steps a sample, tolerance
    _number,  # times its typical magnitude and its initial value at which a state has diverged
    types.Tuple((_integer, _integer, _number, _vector)),  # the method: `workbench.simulation.steppers.scheme`
    types.Tuple((_table, _table, _table, _table)),  # logs: states, inputs, measurements, the controller's state
    _vector,  # scratch, of `scratch_size`
    _integer,  # address of the flag that stops it: `workbench.stopping`
)


def _scalar_loops(function: Callable[..., Ended]) -> Callable[..., Ended]:
    """Compile for `_SIGNATURE` without vectorised loops: over a handful of states they cost more than they give."""
    vectorize = numba.config.LOOP_VECTORIZE
    numba.config.LOOP_VECTORIZE = 0
    try:
        return njit(_SIGNATURE, cache=True, nogil=True, error_model="numpy")(function)
    finally:
        numba.config.LOOP_VECTORIZE = vectorize


def scratch_size(states: int, inputs: int, channels: int, delay_samples: int, slopes: int, past: int) -> int:
    """Numbers that the loop works on beside its arguments: with `states` those of the filters are counted.

    `slopes` is how many the method takes in a step; beside them stand the states of a stage, and bounds. `past` is the
    longest delay of a command in whole samples.

    They come from the caller, who keeps them: the loop has pointers alone, and an array of its own would be freed after
    its last mention, before the last use of its memory.
    """
    return (slopes + 2) * states + 3 * inputs + (4 + delay_samples) * channels + 2 * (past + KEPT)


@register_jitable
def _clip(value: float, limit: float) -> float:
    return min(max(value, -limit), limit)


@register_jitable
def _read(system: Any, y: Any, out: Any) -> None:
    """The sensors' analogue outputs into `out`: of the filter where there is one, else of the plant."""
    _, measure, parameters, cutoffs, _, sizes, _ = system
    total, plant_states, _, channels = sizes
    call_measure(measure, y, parameters, out)
    if total > plant_states:
        for j in range(channels):
            if cutoffs[j] > 0.0:
                out[j] = y[plant_states + j]


@register_jitable
def _arrive(lined: Any, inputs: Any, k: int, h: float, time: float) -> None:
    """Set the inputs that are the command of a time ago, from `time` (s) in sample k on: values and slopes.

    `lined` is (number of them, the command's value and slope in the last samples, how many, place, whole samples and
    rest (s) of each); values are those at the start of the sample, as the slopes would have them.
    """
    count, past, depth, lines = lined
    now, initial, slopes = inputs
    for i in range(count):
        place, samples, rest = int(lines[3 * i]), int(lines[3 * i + 1]), lines[3 * i + 2]
        early = 1 if time < k * h + rest else 0
        sent = (k - samples - early) % depth
        slopes[place] = past[2 * sent + 1]
        initial[place] = past[2 * sent] + slopes[place] * (early * h - rest)
        now[place] = initial[place] + slopes[place] * (time - k * h)


@_scalar_loops
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
    scratch: Any,
    flag: Any,
) -> Ended:
    """Run the loop from t = 0 over all samples of the logs; the arguments are those of `_SIGNATURE`.

    At sample k: the sensors deliver y(k h - delay), those of the motor's drive y(k h), with systematic error, noise and
    quantisation; the controllers step; the sum of each command and its exogenous input is saturated and committed; the
    plant is integrated to (k + 1) h. An exogenous input is held over the sample, or a ramp to its next value where its
    hold is linear. An input that is the command of a time ago changes exactly that time behind it, also within a
    sample; before t = 0 it was what the inputs say.

    Returns:
        how it ended, the number of samples logged, the number of integration steps.
    """
    derivatives, measure = plant
    step, commit, rotary_step, rotary_commit = control
    y, base, parameters, scales = vectors
    state, gains, rotary_state, rotary_gains = memory
    command_input, command_limit, rotary_input, rotary_limit = channels
    references, rotary_references, exogenous, linear = signals
    noise, resolution, cutoffs, errors = sensors
    delay_samples, delay_rest = delay
    h, steps_a_sample, tolerance = clock
    kind, slope_count, order, numbers = method
    log_states, log_inputs, log_measurements, log_control = logs

    plant_states = log_states.shape[1]
    n, m, channel_count, memory_count = y.size, base.size, cutoffs.size, state.size
    samples = log_states.shape[0]
    slots = delay_samples + 1
    slot = 0
    guess = h
    total_steps = 0

    # From here on pointers: an array handed to a function costs a reference count, at every sample.
    p_y, p_base, p_scales, p_linear = address(y), address(base), address(scales), address(linear)
    p_work = address(scratch)
    p_bounds = shift(p_work, (slope_count + 1) * n)
    p_now = shift(p_bounds, n)
    p_initial, p_slopes = shift(p_now, m), shift(p_now, 2 * m)
    p_readings = shift(p_now, 3 * m)
    p_measured, p_prompt = shift(p_readings, channel_count), shift(p_readings, 2 * channel_count)
    p_delayed = shift(p_readings, 3 * channel_count)
    p_past, p_lines = shift(p_delayed, slots * channel_count), address(lines)
    p_state, p_gains = address(state), address(gains)
    p_rotary_state, p_rotary_gains = address(rotary_state), address(rotary_gains)
    p_references, p_rotary_references = address(references), address(rotary_references)
    p_exogenous, p_noise, p_resolution = address(exogenous), address(noise), address(resolution)
    p_errors = address(errors)
    p_log_states, p_log_inputs = address(log_states), address(log_inputs)
    p_log_read, p_log_control = address(log_measurements), address(log_control)
    sizes = (n, plant_states, m, channel_count)
    system = (derivatives, measure, address(parameters), address(cutoffs), p_readings, sizes, flag)
    inputs, tableau = (p_now, p_initial, p_slopes), (slope_count, order, address(numbers))
    ramped = erring = False
    noisy, fed = noise.size > 0, exogenous.size > 0
    for j in range(m):
        ramped = ramped or p_linear[j] > 0.0
    for j in range(errors.size):
        erring = erring or p_errors[j] != 0.0
    for i in range(scratch.size):
        p_work[i] = 0.0
    for j in range(n):
        p_bounds[j] = farthest * (p_scales[j] + abs(p_y[j]))
    for j in range(m):
        p_now[j] = p_base[j]
        p_initial[j] = p_base[j]
    for i in range(slots):
        _read(system, p_y, shift(p_delayed, i * channel_count))
    line_count, depth = lines.shape[0], KEPT
    for i in range(line_count):
        depth = max(depth, int(lines[i, 1]) + KEPT)
    for i in range(depth if line_count > 0 else 0):
        p_past[2 * i] = p_base[int(lines[0, 0])]
    lined = (line_count, p_past, depth, p_lines)

    for k in range(samples):
        if flagged(flag):
            return STOPPED, k, total_steps
        if delay_rest == 0.0:
            _read(system, p_y, shift(p_delayed, slot * channel_count))
        slot = slot + 1 if slot + 1 < slots else 0
        oldest = shift(p_delayed, slot * channel_count)
        late = delay_samples > 0 or delay_rest > 0.0
        if late:
            _read(system, p_y, p_prompt)
        for j in range(channel_count):
            value = p_prompt[j] if late and j >= FIRST_OF_DRIVE else oldest[j]
            if erring:
                value += systematic_error(value, shift(p_errors, j * ERROR_NUMBERS))
            if noisy:
                value += p_noise[k * channel_count + j]
            if p_resolution[j] > 0.0:
                value = p_resolution[j] * np.rint(value / p_resolution[j])
            p_measured[j] = value
            p_log_read[k * channel_count + j] = value
        for j in range(m):
            p_initial[j] = p_base[j] + p_exogenous[k * m + j] if fed else p_base[j]
            if ramped and p_linear[j] > 0.0:
                p_slopes[j] = (p_exogenous[(k + 1) * m + j] - p_exogenous[k * m + j]) / h
        command = call_step(step, shift(p_references, 3 * k), p_measured, p_state, p_gains, h)
        feed = p_initial[command_input]
        p_initial[command_input] = _clip(command + feed, command_limit)
        if p_slopes[command_input] != 0.0:
            following = _clip(command + feed + h * p_slopes[command_input], command_limit)
            p_slopes[command_input] = (following - p_initial[command_input]) / h
        call_commit(commit, p_initial[command_input] - feed, p_state, p_gains, h)
        if rotary_input >= 0:
            rotary = call_step(
                rotary_step, shift(p_rotary_references, 3 * k), p_measured, p_rotary_state, p_rotary_gains, h
            )
            rotary_feed = p_initial[rotary_input]
            p_initial[rotary_input] = _clip(rotary + rotary_feed, rotary_limit)
            call_commit(rotary_commit, p_initial[rotary_input] - rotary_feed, p_rotary_state, p_rotary_gains, h)
        if line_count > 0:
            p_past[2 * (k % depth)] = p_initial[command_input]
            p_past[2 * (k % depth) + 1] = p_slopes[command_input]
            _arrive(lined, inputs, k, h, k * h)
        for j in range(memory_count):
            p_log_control[k * memory_count + j] = p_state[j]
        for j in range(plant_states):
            p_log_states[k * plant_states + j] = p_y[j]
        for j in range(m):
            p_log_inputs[k * m + j] = p_initial[j]
            p_now[j] = p_initial[j]
        if k + 1 == samples:
            break

        at, end, middle = k * h, (k + 1) * h, (k + 1) * h - delay_rest
        reading = delay_rest > 0.0
        first = stop = at  # of a stretch between two stops
        while at < end:
            until, steps_here = middle if reading else end, steps_a_sample
            for i in range(line_count):
                turn = k * h + p_lines[3 * i + 2]
                until = turn if at < turn < until else until
            if line_count > 0:
                _arrive(lined, inputs, k, h, at)
                steps_here = max(int(np.ceil(steps_a_sample * (until - at) / h - 1e-9)), 1)
            if kind != FIXED_STEP and steps_a_sample > 1:
                if at >= stop:
                    first, stop = at, until
                part = np.floor((at - first) / (stop - first) * steps_a_sample + 1e-6) + 1.0
                if part < steps_a_sample:
                    until = min(until, first + part / steps_a_sample * (stop - first))
            interval, driven = (at, until), (*inputs, k * h, ramped)
            if kind == WRITTEN_OUT:
                ended, guess, tried = dormand_prince(system, interval, guess, tolerance, p_scales, p_y, driven, p_work)
            elif kind == ITS_OWN:
                ended, tried = its_own(system, interval, p_y, driven, p_work), 1
            elif kind == FIXED_STEP:
                ended, tried = fixed_step(system, interval, tableau, steps_here, p_y, driven, p_work), steps_here
            else:
                control = (guess, tolerance, p_scales)
                ended, guess, tried = controlled(system, interval, tableau, control, p_y, driven, p_work)
            total_steps += tried
            if ended == INTERRUPTED:
                return STOPPED, k + 1, total_steps
            if ended == FAILED:
                return MACHINE_FAILED, k + 1, total_steps
            if ended != OK:
                return (STEP_TOO_SMALL if ended == STEP_LIMIT else DIVERGED), k + 1, total_steps
            if reading and until == middle:
                _read(system, p_y, shift(p_delayed, slot * channel_count))
                reading = False
            at = until
        for j in range(n):
            if not abs(p_y[j]) <= p_bounds[j]:
                return DIVERGED, k + 1, total_steps
    return COMPLETED, samples, total_steps
