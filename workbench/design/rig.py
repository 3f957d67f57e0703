"""The rig on which a motion is run and measured, and what a hypothesis of its plant would show there."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

import numpy as np

from controllers.interface import Controller
from plants.axis import name_along
from plants.equation import fields, from_array, named, replaced, to_array
from plants.interface import Measurement
from workbench.design.pieces import Condition, Reach
from workbench.diagnose.residuals.along import Along
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.residuals.weighing import Whitening
from workbench.fitting.replay import Sampled
from workbench.fitting.threads import in_parts
from workbench.simulation.references import Recorded
from workbench.simulation.setup import NO_LOOP, Feed, Integrator, Loop
from workbench.simulation.simulate import LANES, Run, Setup, simulate, simulate_together

TOLERANCE = 1e-8
"""Of the solver: what it is off by is to be lost in the sensors' noise, and in difference quotients."""

NUDGED = 1e-3
"""Of its typical size, by which a state is moved where a simulation starts."""

PRESSURES = ("pressure_1", "pressure_2")


class Limits(NamedTuple):
    """What a rig must not exceed (SI): positions, speed, pressures, and the command's size."""

    low: float = -np.inf
    high: float = np.inf
    speed: float = np.inf
    least_pressure: float = -np.inf
    most_pressure: float = np.inf
    command: float = np.inf


class Replay(NamedTuple):
    """Values of a plant, the run under whose command it is simulated, in which condition, and by how much the states
    are `moved` in which it starts.
    """

    values: Values
    run: Run
    condition: Condition
    moved: np.ndarray | None = None


@dataclass(frozen=True)
class Steering:
    """The controller of a closed loop with its settings (SI), and how a study file says it."""

    controller: Controller
    settings: Any
    table: Mapping[str, object]


@dataclass(frozen=True, eq=False)
class Rig:
    """How a rig is driven and measured.

    `along` is its plant with all that it may lack; `believed` the values for which its controller is designed, if its
    loop is closed (`steering`). `noise` is the standard deviation (SI) of a sample of each channel, and `whitening` of
    each how means of `grain` samples in standard deviations of such a mean become white.
    """

    along: Along
    steering: Steering | None
    believed: Values
    sample_time: float
    grain: int
    noise: Mapping[str, float]
    whitening: Mapping[str, Whitening]
    limits: Limits
    reach: Reach
    conditions: Sequence[Condition]
    held: bool = True
    tolerance: float = TOLERANCE

    @property
    def channels(self) -> list[str]:
        """What is measured and compared."""
        return list(self.noise)

    @property
    def axis(self) -> str:
        """Unit of the position, "m" or "rad"."""
        return self.along.plant.axis

    def setup(self, values: Values, condition: Condition, samples: int, *, whole: bool = False) -> Setup:
        """The plant with these values at rest in a condition, for so many samples; with all the states that it may have
        (`whole`), or those of its effects alone that act.
        """
        load = name_along("load_force", self.axis)
        loaded = {**values, load: values.get(load, 0.0) + condition.load}
        plant, parameters = (self.along.plant, self.along.parameters(loaded)) if whole else self.along.acting(loaded)
        state, inputs = plant.equilibrium(parameters, condition.rotation * values.get("piston_radius", 0.0))
        middle = self.reach.middle if self.steering is not None else 0.0
        state = state._replace(position=middle)
        return Setup(
            plant=plant,
            parameters=parameters,
            state=state,
            inputs=replaced(inputs, {plant.command: 0.0}),
            duration=self.sample_time * (samples - 1),
            sample_time=self.sample_time,
            integrator=Integrator(tolerance=self.tolerance),
        )

    def driven(self, values: Values, reference: np.ndarray, condition: Condition) -> Run:
        """What the plant does under a reference (samples,): in its closed loop, or fed with it as a command."""
        setup = self.setup(values, condition, reference.size)
        if self.steering is None:
            return simulate(replace(setup, feeds=(self._command(reference, values),)))
        steering, times = self.steering, self.sample_time * np.arange(reference.size)
        parameters = self.along.acting(self.believed)[1]
        gains = steering.controller.design(steering.settings, parameters, self.sample_time)
        loop = replace(setup, loop=Loop(steering.controller, gains), reference=Recorded(times, reference))
        return simulate(loop)

    def replayed(self, asked: Sequence[Replay]) -> list[Run]:
        """What plants do under the commands of runs, from where those start, several at once: with closed valves many
        pressures are at rest, and which of them a rig has is no question of its parameters.
        """
        return in_parts(simulate_together, [self._replaying(each) for each in asked], LANES)

    def _replaying(self, asked: Replay) -> Setup:
        run, moved = asked.run, asked.moved
        setup = self.setup(asked.values, asked.condition, run.time.size, whole=moved is not None)
        state = replaced(setup.state, named(from_array(run.plant.State, run.states[0].tolist())))
        if moved is not None:
            state = from_array(type(state), (to_array(state) + moved).tolist())
        return replace(setup, state=state, loop=NO_LOOP, feeds=(self._command(run.command, asked.values),))

    def _command(self, command: np.ndarray, values: Values) -> Feed:
        times = self.sample_time * np.arange(command.size)
        return Feed(self.along.plant.command, Sampled(times, command), not self.held, self.along.late(values))

    def moves(self) -> list[np.ndarray]:
        """A little change of each of the plant's own states at a start."""
        plant = self.along.plant
        own = {item.name for item in fields((plant.bare or plant).State)}
        moves = []
        for place, item in enumerate(fields(plant.State)):
            if item.name in own:
                moves.append(np.zeros(len(fields(plant.State))))
                moves[-1][place] = NUDGED * item.scale
        return moves

    def seen(self, run: Run) -> np.ndarray | None:
        """What the sensors show of a run as rows of a likelihood: means over a grain, in whitened standard deviations,
        one channel behind the other; None where it diverged.
        """
        if run.diverged:
            return None
        edges = np.arange(0, run.time.size, self.grain)
        sizes = np.diff(np.append(edges, run.time.size))
        rows = []
        for name in self.channels:
            values = run.measurements[:, Measurement._fields.index(name)]
            means = np.add.reduceat(values, edges) / np.sqrt(sizes) / self.noise[name]
            rows.append(self.whitening[name](means))
        return np.concatenate(rows)

    def beyond(self, run: Run) -> str:
        """Which limit a run exceeds, in words; empty where it keeps all."""
        if run.diverged:
            return "the loop or the plant runs away"
        limits, position, velocity = self.limits, run.state("position"), run.state("velocity")
        if position.min() < limits.low or position.max() > limits.high:
            return "its stroke"
        if np.max(np.abs(velocity)) > limits.speed:
            return "its speed"
        shown = [run.measurements[:, Measurement._fields.index(name)] for name in PRESSURES if name in self.channels]
        if any(each.min() < limits.least_pressure or each.max() > limits.most_pressure for each in shown):
            return "its pressures"
        return "its command" if np.max(np.abs(run.command)) > limits.command else ""
