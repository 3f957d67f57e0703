"""One run: a plant, its controllers, a reference, sensors, and how exactly to integrate.

run = simulate(setup)            # Run: time, states, inputs, measurements, outcome
run.signals["axial_friction"]    # any signal of the plant, over time
solver_error(setup, run)         # how far the positions are off (m)

Importing this module loads the compiled engine; what only sets up imports `setup`, what only reads `run`.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import TypeAlias

import numpy as np

from plants.equation import fields, from_array, to_array
from plants.interface import Measurement
from workbench.fmu.machine import FmuMachine
from workbench.simulation import engine
from workbench.simulation.compilation import controller_addresses, step_addresses
from workbench.simulation.integrators.registry import INTEGRATORS
from workbench.simulation.outcomes import outcome_of
from workbench.simulation.references import Signal
from workbench.simulation.run import COMPLETED, EARLY, MACHINE_FAILED, TORQUE_LIMITED, Run
from workbench.simulation.sensors import systematic_error
from workbench.simulation.setup import DELAY_SLACK, NO_LOOP, Feed, Integrator, Loop, Setup
from workbench.simulation.steppers import CONTROLLED, FIXED_STEP, ITS_OWN
from workbench.simulation.whole_step import sizes_of, work_size
from workbench.stopping import ADDRESS

__all__ = [
    "COMPLETED",
    "NO_LOOP",
    "TORQUE_LIMITED",
    "Feed",
    "Integrator",
    "Loop",
    "Run",
    "Setup",
    "finer",
    "largest_distance",
    "ready",
    "simulate",
    "simulate_together",
    "solver_error",
]

LANES = 4
"""Setups that are solved at once: as many numbers as the vectors of common processors hold."""

Code: TypeAlias = tuple[tuple[int, int, int], tuple[int, float, int, int]]
"""Addresses of a whole step, of a plant's rates, or of `ADVANCE`, and of its readings; and the method: how it steps,
the order of its error, its number of slopes, and how many numbers of a lane it works on."""


def ready(setup: Setup) -> None:
    """Have the compiled code of a run at hand, so that processes made later need not compile it, each for itself."""
    if setup.machine is None:
        _code_of(setup, 1)
    for loop in (setup.loop, setup.rotary or NO_LOOP):
        controller_addresses(loop.controller)


ENDED = dict(zip((engine.DIVERGED, engine.STEP_TOO_SMALL, engine.TOO_MANY_STEPS), EARLY, strict=True))
"""The outcomes of runs that end before their time, by how the loop ended."""


def simulate(setup: Setup) -> Run:
    """Simulate `setup` over its duration. A run that diverges is a result: it stops early and says so.

    Raises:
        KeyboardInterrupt: it was stopped, as `workbench.stopping` says.
        UserError: its machine may not be run, or not here.
    """
    run, limit = _integrated(setup)
    return replace(run, outcome=run.outcome or outcome_of(run, limit))


def simulate_together(setups: Sequence[Setup]) -> list[Run]:
    """The runs of some setups, to the same bits as one by one: those that are alike several at once, in a fraction of
    the time. Alike are setups of one plant, without a machine of its own, that differ in parameters, state, inputs,
    what feeds show, and gains alone.

    Raises:
        KeyboardInterrupt: it was stopped, as `workbench.stopping` says.
        UserError: a machine may not be run, or not here.
    """
    groups = list[tuple[object, list[int]]]()
    for place, setup in enumerate(setups):
        alike = _alike(setup)
        own = next((places for other, places in groups if other == alike and setup.machine is None), None)
        if own is None:
            groups.append((alike, [place]))
        else:
            own.append(place)
    found = dict[int, tuple[Run, float]]()
    for _, places in groups:
        for at in range(0, len(places), LANES):
            some = places[at : at + LANES]
            if len(some) == 1:
                found[some[0]] = _integrated(setups[some[0]])
            else:
                several = [setups[place] for place in (*some, *[some[-1]] * (LANES - len(some)))]
                found |= zip(some, _solved(several, _code_of(several[0], LANES)), strict=False)
    return [
        replace(run, outcome=run.outcome or outcome_of(run, limit))
        for run, limit in map(found.__getitem__, range(len(setups)))
    ]


def _alike(setup: Setup) -> tuple[object, ...]:
    """What setups that go side by side have in common."""
    loops = [None if loop is None else (loop.controller, loop.drives) for loop in (setup.loop, setup.rotary)]
    linear = [(feed.input, feed.linear, _changes_within_samples(feed, setup)) for feed in setup.feeds]
    numbers = setup.duration, setup.sample_time, setup.seed, setup.rotation_speed, setup.farthest, setup.most_steps
    return setup.plant, setup.reference, *loops, linear, setup.sensors, setup.integrator, *numbers


def _integrated(setup: Setup, known: Signal | None = None) -> tuple[Run, float]:
    """The run of a setup, whose outcome is "" unless it ended early, and the limit of its command.

    `known`: its reference at all samples, where another run of the same has it.
    """
    if setup.machine is not None:
        return _solved_by(setup.machine, setup)
    return _solved([setup], _code_of(setup, 1), known)[0]


def _code_of(setup: Setup, lanes: int) -> Code:
    """The compiled code of the plant of a setup, for so many lanes."""
    method, filtered = INTEGRATORS.working()[setup.integrator.method], bool(_cutoffs(setup).any())
    states, inputs, _ = sizes_of(setup.plant, filtered)
    kind = CONTROLLED if method.errors else FIXED_STEP
    how = kind, float(max(method.order, 1)), method.count, work_size(method, states, inputs)
    return step_addresses(setup.plant, method, filtered, lanes), how


def _cutoffs(setup: Setup) -> np.ndarray:
    """Of the filters of the sensors (rad/s), 0 for none: where no sensor is, there is no filter."""
    cutoffs = setup.sensors.cutoffs()
    if not cutoffs.any():
        return cutoffs
    reading = to_array(setup.plant.measure(setup.state, setup.parameters))
    return np.where(np.isnan(reading), 0.0, cutoffs)


def _solved_by(machine: FmuMachine, setup: Setup) -> tuple[Run, float]:
    """The same of a machine that solves itself. One that fails is a result too, whose outcome tells what it says."""
    from workbench.fmu.running import running  # a plant of ours does without what loads foreign code

    with running(machine, to_array(setup.inputs).tolist()) as fmu:
        start = fmu.begin(setup.integrator.tolerance)
        begun = replace(setup, state=from_array(setup.plant.State, start.tolist()))
        if fmu.failure:
            begun = replace(begun, duration=0.0)
        ((run, limit),) = _solved([begun], ((0, *fmu.addresses), (ITS_OWN, 1.0, 1, 0)))
    if fmu.stopped is not None:
        raise fmu.stopped
    return (replace(run, outcome=f"{MACHINE_FAILED}: {fmu.failure}") if fmu.failure else run), limit


def _solved(setups: Sequence[Setup], code: Code, known: Signal | None = None) -> list[tuple[Run, float]]:
    """The same of some setups alike, by the code of their plant."""
    setup = setups[0]
    plant, h, sensors = setup.plant, setup.sample_time, setup.sensors
    addresses, how = code
    fixed = how[0] == FIXED_STEP
    samples = round(setup.duration / h) + 1
    time, cutoffs, errors = h * np.arange(samples), _cutoffs(setup), setup.sensors.errors()
    profile = setup.reference(time) if known is None and setup.reference is not None else known
    references = np.zeros((samples, 3)) if profile is None else np.column_stack(profile)
    rotary_references = np.zeros((samples if setup.rotary else 0, 3))
    rotary_references[:, 0] = setup.rotation_speed
    arrays, linear = _side_by_side([_lane(each, samples, cutoffs, errors) for each in setups])
    state, inputs, parameters, scales, memory, gains, rotary_memory, rotary_gains, limits, exogenous, lines = arrays
    rotary, lanes = setup.rotary or NO_LOOP, len(setups)
    widths = (len(fields(plant.State)), inputs.shape[1], len(Measurement._fields), memory.shape[1])
    log = tuple(np.empty((lanes * samples, width)) for width in widths)
    delay_samples, delay_rest = _in_samples(sensors.delay, h)
    past = int(np.max(lines[..., 1], initial=0))
    integrator = setup.integrator
    results = np.zeros((lanes, 3))
    sizes = (state.shape[1], inputs.shape[1], parameters.shape[1], cutoffs.size)
    given = (
        addresses,
        controller_addresses(setup.loop.controller) + controller_addresses(rotary.controller),
        (state, inputs, parameters, scales),
        (memory, gains, rotary_memory, rotary_gains),
        (
            plant.input_index(_driven(setup)),
            plant.input_index(plant.rotary_command) if setup.rotary and plant.rotary_command else -1,
            limits,
        ),
        (references, rotary_references, exogenous.reshape(-1, exogenous.shape[-1]), linear),
        (sensors.noise(samples, setup.seed), sensors.resolution(), cutoffs, errors),
        (delay_samples, delay_rest),
        lines.reshape(-1, lines.shape[-1]),
        (
            h,
            int(np.ceil(h / integrator.step - 1e-9)) if fixed else integrator.fewest,
            integrator.tolerance,
            setup.most_steps,
        ),
        setup.farthest,
        how,
        log,
        results,
        np.empty(engine.scratch_size(lanes, sizes, how[-1], delay_samples, past)),
        ADDRESS,
    )
    stopped = engine.run_loop(*given) if lanes == 1 else engine.run_loops(lanes, given)
    if stopped == engine.STOPPED:
        raise KeyboardInterrupt
    found = list[tuple[Run, float]]()
    for lane, (each, (ended, count, steps)) in enumerate(zip(setups, results.astype(int).tolist(), strict=True)):
        states, realised, measurements, remembered = (table[lane * samples : lane * samples + count] for table in log)
        run = Run(
            plant,
            each.loop,
            each.parameters,
            time[:count],
            states,
            realised,
            measurements,
            remembered,
            None if profile is None else (profile[0][:count], profile[1][:count], profile[2][:count]),
            ENDED.get(ended, ""),
            steps,
        )
        found.append((run, float(limits[lane, 0])))
    return found


@dataclass(frozen=True, eq=False)
class _Lane:
    """One setup as the engine takes it: arrays in its order, and which of the inputs are ramps within a sample."""

    arrays: tuple[np.ndarray, ...]
    linear: np.ndarray


def _side_by_side(lanes: Sequence[_Lane]) -> tuple[list[np.ndarray], np.ndarray]:
    """The arrays of some lanes, each kind stacked, and which of their inputs are ramps."""
    return [np.stack(each) for each in zip(*(lane.arrays for lane in lanes), strict=True)], lanes[0].linear


def _lane(setup: Setup, samples: int, cutoffs: np.ndarray, errors: np.ndarray) -> _Lane:
    plant, state, inputs = setup.plant, to_array(setup.state), to_array(setup.inputs)
    scales = np.array([item.scale for item in fields(plant.State)])
    reading = plant.measure(setup.state, setup.parameters)
    if cutoffs.any():
        analogue = np.where(cutoffs > 0.0, to_array(reading), 0.0)
        state = np.concatenate([state, analogue])
        typical = np.where(cutoffs > 0.0, np.maximum(np.abs(analogue), 1e-3), 1.0)
        scales = np.concatenate([scales, typical])
    shown = _shown(reading, errors)
    exogenous, linear, lines = _sampled_feeds(setup, samples, inputs)
    limit = float(plant.command_limit(setup.parameters)) if _driven(setup) == plant.command else np.inf
    limits = np.array([limit, float(plant.rotary_limit(setup.parameters))])
    loops = (*_memory(setup.loop, shown), *_memory(setup.rotary or NO_LOOP, shown))
    return _Lane((state, inputs, to_array(setup.parameters), scales, *loops, limits, exogenous, lines), linear)


def _driven(setup: Setup) -> str:
    """The input that the controller drives."""
    return setup.loop.drives or setup.plant.command


def first_reading(setup: Setup) -> Measurement:
    """What the sensors show at the start, without noise: what the controllers start from."""
    return _shown(setup.plant.measure(setup.state, setup.parameters), setup.sensors.errors())


def _shown(reading: Measurement, errors: np.ndarray) -> Measurement:
    return Measurement(*(value + systematic_error(value, row) for value, row in zip(reading, errors, strict=True)))


def _in_samples(delay: float, sample_time: float) -> tuple[int, float]:
    """A delay (s) as whole samples and the rest (s)."""
    samples = int(np.floor(delay / sample_time + DELAY_SLACK))
    rest = delay - samples * sample_time
    return samples, rest if rest > DELAY_SLACK * sample_time else 0.0


def _memory(loop: Loop, reading: Measurement) -> tuple[np.ndarray, np.ndarray]:
    return to_array(loop.controller.start(reading, loop.gains)), to_array(loop.gains)


def _sampled_feeds(setup: Setup, samples: int, inputs: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Values of the fed inputs at each sample and one beyond (no rows without feeds), which are ramps between, and the
    inputs that are the command of a time ago: place, whole samples and rest (s).

    Of a command that comes late within a sample, what it was before t = 0 goes to `inputs`, as the engine asks for it.
    """
    plant, h = setup.plant, setup.sample_time
    late = [(plant.input_index(name), float(delay(setup.parameters))) for name, delay in plant.delayed.items()]
    lines = [(place, *_in_samples(delay, h)) for place, delay in late]
    count = len(fields(plant.Inputs))
    values, linear = np.zeros((samples + 1 if setup.feeds else 0, count)), np.zeros(count)
    time = h * np.arange(samples + 1)
    for feed in setup.feeds:
        index, delay = plant.input_index(feed.input), feed.delay
        if _changes_within_samples(feed, setup):
            whole, rest = _in_samples(feed.delay, h)
            delay = whole * h
            lines.append((index, 0, rest))
            before = float(feed.signal(np.array([-h - delay]))[0][0])
            inputs[index] += before
            values[:, index] -= before
        values[:, index] += feed.signal(time - delay)[0]
        linear[index] = 1.0 if feed.linear else 0.0
    return values, linear, np.array(lines, dtype=float).reshape(-1, 3)


def _changes_within_samples(feed: Feed, setup: Setup) -> bool:
    """Whether it is a held command, of no loop and of a plant that does not delay it itself, that comes late by more
    than whole samples.
    """
    plain = not feed.linear and feed.input == setup.plant.command and setup.loop is NO_LOOP
    return plain and not setup.plant.delayed and _in_samples(feed.delay, setup.sample_time)[1] > 0.0


def solver_error(setup: Setup, run: Run) -> float | None:
    """Largest distance (m) of the run's positions from those of a finer integration, or None if it diverged."""
    return largest_distance(run, finer(setup, run))


def finer(setup: Setup, run: Run) -> Run:
    """The run of `setup` with a finer integration, which tells the error of its own `run`; an outcome only if it ends
    early.

    Raises:
        KeyboardInterrupt: it was stopped, as `workbench.stopping` says.
    """
    known = None if run.diverged else run.reference
    return _integrated(replace(setup, integrator=setup.integrator.companion()), known)[0]


def largest_distance(run: Run, other: Run) -> float | None:
    """Largest distance (m) of the positions of two runs of the same setup, or None if one of them diverged."""
    if run.diverged or other.diverged:
        return None
    return float(np.max(np.abs(run.state("position") - other.state("position"))))
