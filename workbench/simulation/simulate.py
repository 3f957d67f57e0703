"""One run: a plant, its controllers, a reference, sensors, and how exactly to integrate.

run = simulate(setup)            # Run: time, states, inputs, measurements, outcome
run.signals["axial_friction"]    # any signal of the plant, over time
solver_error(setup, run)         # how far the positions are off (m)

Importing this module loads the compiled engine; what only sets up imports `setup`, what only reads `run`.
"""

from dataclasses import replace

import numpy as np

from plants.equation import fields, from_array, to_array
from plants.hydraulics import Hydraulic
from plants.interface import Measurement
from plants.motor import Motor
from workbench.fmu.machine import FmuMachine
from workbench.simulation import engine
from workbench.simulation.compilation import controller_addresses, plant_addresses
from workbench.simulation.integrators.registry import INTEGRATORS
from workbench.simulation.motor_limits import at_a_limit
from workbench.simulation.references import Signal
from workbench.simulation.run import COMPLETED, HARDLY_MOVES, MACHINE_FAILED, STUCK_SPEED, TORQUE_LIMITED, Run
from workbench.simulation.sensors import systematic_error
from workbench.simulation.setup import DELAY_SLACK, NO_LOOP, Feed, Integrator, Loop, Setup
from workbench.simulation.steppers import SELF_SOLVING, scheme
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
    "solver_error",
]

LIMITED_SHARE = 0.05
"""Of the run. A rod that comes to speed from standstill takes some tens of milliseconds at the limit, and so does a
step's reversal; beyond a twentieth of the run it is the motor that says how the rod turns, not the command."""

VACUUM = -101325.0
"""Pa over the ambient pressure, of which pressures of oil are counted."""


def ready(setup: Setup) -> None:
    """Have the compiled code of a run at hand, so that processes made later need not compile it, each for itself."""
    if setup.machine is None:
        plant_addresses(setup.plant)
    for loop in (setup.loop, setup.rotary or NO_LOOP):
        controller_addresses(loop.controller)


EARLY = {engine.DIVERGED: "diverged", engine.STEP_TOO_SMALL: "step too small"}
"""The outcomes of runs that end before their time, by how the loop ended."""


def simulate(setup: Setup) -> Run:
    """Simulate `setup` over its duration. A run that diverges is a result: it stops early and says so.

    Raises:
        KeyboardInterrupt: it was stopped, as `workbench.stopping` says.
        UserError: its machine may not be run, or not here.
    """
    run, limit = _integrated(setup)
    return replace(run, outcome=run.outcome or _outcome(run, limit))


def _integrated(setup: Setup, known: Signal | None = None) -> tuple[Run, float]:
    """The run of a setup, whose outcome is "" unless it ended early, and the limit of its command.

    `known`: its reference at all samples, where another run of the same has it.
    """
    if setup.machine is not None:
        return _solved_by(setup.machine, setup)
    method = INTEGRATORS.working()[setup.integrator.method]
    return _solved(setup, plant_addresses(setup.plant), scheme(method), known)


def _solved_by(machine: FmuMachine, setup: Setup) -> tuple[Run, float]:
    """The same of a machine that solves itself. One that fails is a result too, whose outcome tells what it says."""
    from workbench.fmu.running import running  # a plant of ours does without what loads foreign code

    with running(machine, to_array(setup.inputs).tolist()) as fmu:
        start = fmu.begin(setup.integrator.tolerance)
        begun = replace(setup, state=from_array(setup.plant.State, start.tolist()))
        run, limit = _solved(replace(begun, duration=0.0) if fmu.failure else begun, fmu.addresses, SELF_SOLVING)
    if fmu.stopped is not None:
        raise fmu.stopped
    return (replace(run, outcome=f"{MACHINE_FAILED}: {fmu.failure}") if fmu.failure else run), limit


def _solved(
    setup: Setup,
    addresses: tuple[int, int],
    how: tuple[int, int, float, np.ndarray],
    known: Signal | None = None,
) -> tuple[Run, float]:
    """The same of what stands at these addresses, solved as `scheme` says."""
    plant, h = setup.plant, setup.sample_time
    samples = round(setup.duration / h) + 1
    time = h * np.arange(samples)
    state = to_array(setup.state)
    parameters = to_array(setup.parameters)
    inputs = to_array(setup.inputs)
    scales = np.array([item.scale for item in fields(plant.State)])
    reading = plant.measure(setup.state, setup.parameters)
    cutoffs = np.where(np.isnan(to_array(reading)), 0.0, setup.sensors.cutoffs())  # no sensor, no filter
    if cutoffs.any():
        analogue = np.where(cutoffs > 0.0, to_array(reading), 0.0)
        state = np.concatenate([state, analogue])
        typical = np.where(cutoffs > 0.0, np.maximum(np.abs(analogue), 1e-3), 1.0)
        scales = np.concatenate([scales, typical])

    errors = setup.sensors.errors()
    shown = _shown(reading, errors)
    profile = setup.reference(time) if known is None and setup.reference is not None else known
    references = np.zeros((samples, 3)) if profile is None else np.column_stack(profile)
    rotary_references = np.zeros((samples if setup.rotary else 0, 3))
    rotary_references[:, 0] = setup.rotation_speed
    exogenous, linear, lines = _sampled_feeds(setup, samples, inputs)
    rotary = setup.rotary or NO_LOOP
    memory = _memory(setup.loop, shown)
    widths = (len(fields(plant.State)), inputs.size, len(Measurement._fields), memory[0].size)
    log = tuple(np.empty((samples, width)) for width in widths)
    delay_samples, delay_rest = _in_samples(setup.sensors.delay, h)
    past = int(np.max(lines[:, 1], initial=0))
    integrator = setup.integrator
    method = INTEGRATORS.working()[integrator.method]
    driven = setup.loop.drives or plant.command
    limit = float(plant.command_limit(setup.parameters)) if driven == plant.command else np.inf
    ended, count, steps = engine.run_loop(
        addresses,
        controller_addresses(setup.loop.controller) + controller_addresses(rotary.controller),
        (state, inputs, parameters, scales),
        (*memory, *_memory(rotary, shown)),
        (
            plant.input_index(driven),
            limit,
            plant.input_index(plant.rotary_command) if setup.rotary and plant.rotary_command else -1,
            float(plant.rotary_limit(setup.parameters)),
        ),
        (references, rotary_references, exogenous, linear),
        (setup.sensors.noise(samples, setup.seed), setup.sensors.resolution(), cutoffs, errors),
        (delay_samples, delay_rest),
        lines,
        (h, integrator.fewest if method.errors else int(np.ceil(h / integrator.step - 1e-9)), integrator.tolerance),
        setup.farthest,
        how,
        log,
        np.empty(engine.scratch_size(state.size, inputs.size, cutoffs.size, delay_samples, method.count, past)),
        ADDRESS,
    )
    if ended == engine.STOPPED:
        raise KeyboardInterrupt
    states, realised, measurements, remembered = (table[:count] for table in log)
    run = Run(
        plant,
        setup.loop,
        setup.parameters,
        time[:count],
        states,
        realised,
        measurements,
        remembered,
        None if profile is None else (profile[0][:count], profile[1][:count], profile[2][:count]),
        EARLY.get(ended, ""),
        steps,
    )
    return run, limit


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


def _outcome(run: Run, limit: float) -> str:
    """What happened in a run to its end, in words; the first that applies."""
    position = run.state("position")
    if max(-position.min(), position.max()) > 0.5 * run.plant.travel(run.parameters):
        return "end stop"
    if abs(run.command[0]) >= limit and np.all(np.abs(run.command) >= limit):
        return "saturated throughout"
    if run.reference is not None:
        asked, velocity = run.reference[0], run.state("velocity")
        if max(-velocity.min(), velocity.max()) < STUCK_SPEED and _range(asked) > 0.0:
            return "stuck"
        if _hardly_moves(asked, position):
            return "hardly moves"
    if _cavitates(run):
        return "cavitates"
    return TORQUE_LIMITED if _torque_limited(run) else COMPLETED


def _cavitates(run: Run) -> bool:
    """Whether the oil of a chamber is pulled below vacuum: no oil is, and no plant here knows of its vapour."""
    states = {item.name for item in fields(run.plant.State)}
    if "pressure_1" not in states and not run.plant.effects:
        return False  # both are between tank and supply by its equations
    if not isinstance(run.parameters, Hydraulic):
        return False
    pressures = [run.state(name) if name in states else run.signals[name] for name in ("pressure_1", "pressure_2")]
    return any(np.min(pressure) < VACUUM for pressure in pressures)


def _torque_limited(run: Run) -> bool:
    """Whether a motor turns the rod and is at its limit in more than `LIMITED_SHARE` of the run."""
    motor, command = getattr(run.parameters, "motor", None), run.plant.rotary_command
    driven = "motor_current" in [item.name for item in fields(run.plant.State)]
    if command is None or not driven or not isinstance(motor, Motor):
        return False
    voltage = run.inputs[:, run.plant.input_index(command)]
    return bool(np.mean(at_a_limit(run.state("motor_current"), voltage, motor)) > LIMITED_SHARE)


def _hardly_moves(asked: np.ndarray, position: np.ndarray) -> bool:
    """Whether the position covers less than `HARDLY_MOVES` of what it is asked for (m), from its start or lately.

    The second half of the run tells of a rod that goes to where a sine begins and does not follow it.
    """
    late = asked.size // 2
    low, high, start = asked.min(), asked.max(), position[0]
    wanted = max(high - low, high - start, start - low)
    return bool(
        _range(position) < HARDLY_MOVES * wanted or _range(position[late:]) < HARDLY_MOVES * _range(asked[late:])
    )


def _range(values: np.ndarray) -> float:
    return float(values.max() - values.min())


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
