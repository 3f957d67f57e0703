"""One run: a plant, its controllers, a reference, sensors, and how exactly to integrate.

run = simulate(setup)            # Run: time, states, inputs, measurements, outcome
run.signals["axial_friction"]    # any signal of the plant, over time
solver_error(setup, run)         # how far the positions are off (m)
"""

import functools
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from controllers.interface import Controller
from controllers.open_loop import OPEN_LOOP
from controllers.open_loop import Gains as OpenLoopGains
from plants.equation import fields, from_array, to_array
from plants.interface import SENSORS, Measurement, Plant
from plants.motor import Motor
from workbench.simulation import engine, steppers
from workbench.simulation.compilation import controller_addresses, plant_addresses
from workbench.simulation.motor_limits import at_a_limit
from workbench.simulation.references import ReferenceSignal
from workbench.simulation.sensors import Sensors, systematic_error

Method = Literal["euler", "heun", "rk4", "dormand_prince"]
"""What an integration may be called."""

FIXED_STEP: Mapping[str, int] = {"euler": steppers.EULER, "heun": steppers.HEUN, "rk4": steppers.RK4}
"""Fixed-step methods, of order 1, 2 and 4."""

METHODS: Mapping[str, int] = {**FIXED_STEP, "dormand_prince": steppers.DORMAND_PRINCE}

DEFAULT_TOLERANCE = 1e-6
TIGHTER = 100.0
"""The solver's error is found against a run with a tolerance this many times smaller (or half the step)."""

COMPLETED = "completed"
"""The outcome of a run with which nothing is wrong."""

TORQUE_LIMITED = "torque-limited"
"""The outcome of a run whose motor cannot give what holding the speed of rotation takes."""

LIMITED_SHARE = 0.05
"""Of the run. A rod that comes to speed from standstill takes some tens of milliseconds at the limit, and so does a
step's reversal; beyond a twentieth of the run it is the motor that says how the rod turns, not the command."""

STUCK_SPEED = 1e-4
"""m/s. Slower than this counts as not moving."""

FRICTION_ERROR = "friction_estimate_error"
"""The signal of a friction estimate less the friction along the rod, where a run has both."""

ESTIMATE, TRUE = "controller_friction", "axial_friction"
"""The signals of both."""

HARDLY_MOVES = 0.05
"""A rod that moves by less than this share of what it is asked for hardly moves; no phase lag is meant then."""

MEASURED = "measured_"
"""What stands before the name of a sensor's channel in the signals of a run."""

DELAY_SLACK = 1e-9
"""A delay this close (in samples) to a whole number of samples is one."""


@dataclass(frozen=True)
class Integrator:
    """How to integrate: an error-controlled method with its `tolerance`, or a fixed-step one with its `step` (s).

    A fixed step is shortened so that a whole number of steps makes one sample.
    """

    method: str = "dormand_prince"
    step: float = 1e-4
    tolerance: float = DEFAULT_TOLERANCE

    def finer(self) -> "Integrator":
        """The integrator against which this one's error is taken."""
        return replace(self, step=self.step / 2.0, tolerance=self.tolerance / TIGHTER)


@dataclass(frozen=True)
class Loop:
    """A sampled controller with its gains."""

    controller: Controller
    gains: Any


@dataclass(frozen=True)
class Feed:
    """An input of the plant that follows a signal: open-loop commands, disturbances, moving spring ends.

    `linear`: a ramp from sample to sample; otherwise each sample's value is held.
    """

    input: str
    signal: ReferenceSignal
    linear: bool = True


NO_LOOP = Loop(OPEN_LOOP, OpenLoopGains(0.0))
"""No feedback: the command is what a feed gives."""


@dataclass(frozen=True)
class Setup:
    """Everything that a run depends on.

    `state` and `inputs` are where the plant starts and what its inputs are before any command is added.
    `rotary` drives the plant's rotary input from `rotation_speed` (rad/s), a constant wanted speed.
    """

    plant: Plant
    parameters: Any
    state: Any
    inputs: Any
    duration: float
    loop: Loop = NO_LOOP
    reference: ReferenceSignal | None = None
    rotary: Loop | None = None
    rotation_speed: float = 0.0
    feeds: tuple[Feed, ...] = ()
    sensors: Sensors = field(default_factory=Sensors)
    integrator: Integrator = field(default_factory=Integrator)
    sample_time: float = 1e-3
    seed: int = 0


def memory_names(controller: Controller) -> list[str]:
    """Names of the signals that a controller's state gives: `controller_theta`, `controller_friction`, ..."""
    return [f"controller_{item.name}" for item in fields(controller.State)]


@dataclass(frozen=True)
class Run:
    """What happened. Arrays over the sample instants; `outcome` in words.

    `memory` holds the controller's state after each sample: its estimates, its integral.
    """

    plant: Plant
    loop: Loop
    parameters: Any
    time: np.ndarray
    states: np.ndarray
    inputs: np.ndarray
    measurements: np.ndarray
    memory: np.ndarray
    reference: tuple[np.ndarray, np.ndarray, np.ndarray] | None
    outcome: str
    steps: int

    @functools.cached_property
    def signals(self) -> Mapping[str, np.ndarray]:
        """All signals, by name, over time: the plant's, its inputs, the controller's state, reference and error."""
        with np.errstate(all="ignore"):  # a diverged run holds numbers beyond all bounds
            state = from_array(self.plant.State, self.states.T)
            inputs = from_array(self.plant.Inputs, self.inputs.T)
            values = self.plant.signals(self.time, state, inputs, self.parameters)
        names = [item.name for item in fields(self.plant.Signals)]
        named = dict(zip(names, values, strict=True))
        for i, item in enumerate(fields(self.plant.Inputs)):
            named.setdefault(item.name, self.inputs[:, i])
        for i, name in enumerate(SENSORS):
            named[f"{MEASURED}{name}"] = self.measurements[:, i]
        for i, name in enumerate(memory_names(self.loop.controller)):
            named[name] = self.memory[:, i]
        if ESTIMATE in named and TRUE in named:
            named[FRICTION_ERROR] = named[ESTIMATE] - named[TRUE]
        if self.reference is not None:
            named["reference_position"] = self.reference[0]
            named["reference_velocity"] = self.reference[1]
            named["error"] = self.reference[0] - named["position"]
        return {name: np.broadcast_to(value, self.time.shape) for name, value in named.items()}

    def state(self, name: str) -> np.ndarray:
        """One state of the plant over time."""
        names = [item.name for item in fields(self.plant.State)]
        return self.states[:, names.index(name)]

    @property
    def command(self) -> np.ndarray:
        """The realised command of the position loop."""
        return self.inputs[:, self.plant.input_index(self.plant.command)]

    @property
    def diverged(self) -> bool:
        """Whether it ended before its time."""
        return self.outcome in ("diverged", "step too small")


def simulate(setup: Setup) -> Run:
    """Simulate `setup` over its duration. A run that diverges is a result: it stops early and says so."""
    plant, h = setup.plant, setup.sample_time
    samples = round(setup.duration / h) + 1
    time = h * np.arange(samples)
    state = to_array(setup.state)
    parameters = to_array(setup.parameters)
    inputs = to_array(setup.inputs)
    scales = np.array([item.scale for item in fields(plant.State)])
    reading = plant.measure(setup.state, setup.parameters)
    cutoffs = np.where(np.isnan(to_array(reading)), 0.0, setup.sensors.cutoffs())  # no sensor, no filter
    if np.any(cutoffs > 0.0):
        analogue = np.where(cutoffs > 0.0, to_array(reading), 0.0)
        state = np.concatenate([state, analogue])
        typical = np.where(cutoffs > 0.0, np.maximum(np.abs(analogue), 1e-3), 1.0)
        scales = np.concatenate([scales, typical])

    errors = setup.sensors.errors()
    shown = Measurement(*(value + systematic_error(value, row) for value, row in zip(reading, errors, strict=True)))

    references, profile = _sampled_reference(setup.reference, time)
    rotary_references = np.zeros((samples, 3))
    rotary_references[:, 0] = setup.rotation_speed
    exogenous, linear = _sampled_feeds(setup, samples)
    rotary = setup.rotary or NO_LOOP
    memory = _memory(setup.loop, shown)
    widths = (len(fields(plant.State)), inputs.size, len(Measurement._fields), memory[0].size)
    log = tuple(np.empty((samples, width)) for width in widths)
    delay_samples = int(np.floor(setup.sensors.delay / h + DELAY_SLACK))
    delay_rest = setup.sensors.delay - delay_samples * h
    integrator = setup.integrator
    limit = float(plant.command_limit(setup.parameters))
    ended, count, steps = engine.run_loop(
        plant_addresses(plant),
        controller_addresses(setup.loop.controller) + controller_addresses(rotary.controller),
        (state, inputs, parameters, scales),
        (*memory, *_memory(rotary, shown)),
        (
            plant.input_index(plant.command),
            limit,
            plant.input_index(plant.rotary_command) if setup.rotary and plant.rotary_command else -1,
            float(plant.rotary_limit(setup.parameters)),
        ),
        (references, rotary_references, exogenous, linear),
        (setup.sensors.noise(samples, setup.seed), setup.sensors.resolution(), cutoffs, errors),
        (delay_samples, delay_rest if delay_rest > DELAY_SLACK * h else 0.0),
        (h, METHODS[integrator.method], int(np.ceil(h / integrator.step - 1e-9)), integrator.tolerance),
        log,
        np.empty(engine.scratch_size(state.size, inputs.size, cutoffs.size, delay_samples)),
    )
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
        "",
        steps,
    )
    return replace(run, outcome=_outcome(run, ended, limit))


def _memory(loop: Loop, reading: Measurement) -> tuple[np.ndarray, np.ndarray]:
    return to_array(loop.controller.start(reading, loop.gains)), to_array(loop.gains)


def _sampled_reference(
    reference: ReferenceSignal | None, time: np.ndarray
) -> tuple[np.ndarray, tuple[np.ndarray, np.ndarray, np.ndarray] | None]:
    if reference is None:
        return np.zeros((time.size, 3)), None
    profile = reference(time)
    return np.column_stack(profile), profile


def _sampled_feeds(setup: Setup, samples: int) -> tuple[np.ndarray, np.ndarray]:
    """Values of the fed inputs at each sample and one beyond, and which of them are ramps between samples."""
    count = len(fields(setup.plant.Inputs))
    values, linear = np.zeros((samples + 1, count)), np.zeros(count)
    time = setup.sample_time * np.arange(samples + 1)
    for feed in setup.feeds:
        index = setup.plant.input_index(feed.input)
        values[:, index] += feed.signal(time)[0]
        linear[index] = 1.0 if feed.linear else 0.0
    return values, linear


def _outcome(run: Run, ended: int, limit: float) -> str:
    """What happened, in words; the first that applies."""
    if ended == engine.DIVERGED:
        return "diverged"
    if ended == engine.STEP_TOO_SMALL:
        return "step too small"
    if np.max(np.abs(run.state("position"))) > 0.5 * run.plant.travel(run.parameters):
        return "end stop"
    if np.all(np.abs(run.command) >= limit):
        return "saturated throughout"
    asked_to_move = run.reference is not None and np.ptp(run.reference[0]) > 0.0
    if asked_to_move and np.max(np.abs(run.state("velocity"))) < STUCK_SPEED:
        return "stuck"
    if run.reference is not None and _hardly_moves(run.reference[0], run.state("position")):
        return "hardly moves"
    return TORQUE_LIMITED if _torque_limited(run) else COMPLETED


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
    covered = np.ptp(position), np.ptp(position[late:])
    wanted = max(np.ptp(asked), np.max(np.abs(asked - position[0]))), np.ptp(asked[late:])
    return any(got < HARDLY_MOVES * far for got, far in zip(covered, wanted, strict=True))


def solver_error(setup: Setup, run: Run) -> float | None:
    """Largest distance (m) of the run's positions from those of a finer integration, or None if it diverged."""
    return largest_distance(run, finer(setup))


def finer(setup: Setup) -> Run:
    """The run of `setup` with a finer integration: half the step, or a tolerance `TIGHTER` times smaller."""
    return simulate(replace(setup, integrator=setup.integrator.finer()))


def largest_distance(run: Run, other: Run) -> float | None:
    """Largest distance (m) of the positions of two runs of the same setup, or None if one of them diverged."""
    if run.diverged or other.diverged:
        return None
    return float(np.max(np.abs(run.state("position") - other.state("position"))))
