"""Simulation error: what a plant that is driven by the measured input alone shows, beside the record.

Nothing is smoothed here, so that nothing is blurred, and where the plant lacks nothing the sensors' noise is all that
is left. One simulation from end to end tells most. What runs away before the end starts anew from the record every few
seconds (multiple shooting).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from typing import Any

import numpy as np

from plants.axis import name_along
from plants.effects.interface import Scales
from plants.equation import fields, from_array, replaced, to_array
from plants.interface import Measurement, Plant
from plants.observed import observed
from workbench.diagnose.residuals.along import Along
from workbench.diagnose.residuals.balance import SIMULATION, Balance
from workbench.diagnose.residuals.motion import Motion, with_slack
from workbench.diagnose.residuals.shown import deviation, shown, state_along
from workbench.diagnose.residuals.unknowns import Priors, Values
from workbench.diagnose.residuals.weighing import Changes
from workbench.diagnose.simulation.beside import Followed, arriving
from workbench.diagnose.simulation.counting import HARMONICS, is_coarse, over_steps
from workbench.diagnose.simulation.first_samples import sensed_at_first
from workbench.diagnose.simulation.leading import led, quickest
from workbench.diagnose.simulation.stiffness import method_for
from workbench.diagnose.simulation.to_first_order import errors_near
from workbench.diagnose.simulation.together import Asked, Push, errors_of
from workbench.fitting.replay import BRISTLES, Sampled, breakaway_bend
from workbench.records.reading import Record
from workbench.simulation.simulate import Feed, Run, Setup, simulate_together

SOLVER = 1e-6
"""Share of a channel's largest value that counts as its noise at least: no simulation is nearer than its solver."""

NUDGED = 1e-2
"""Of the typical magnitude of a state that no sensor shows, by which it is moved at a start."""

ASIDE = 0.3
"""Standard deviations along a record by which a state may start beside what was measured, at most."""

BENT = 3.0
"""Times the deflection at which a contact breaks away that one may begin beside what the balance of forces asks of it.
"""

MOST_PIECES = 30
"""Pieces of a record that are simulated, at most: each has its cost, and as many tell a place to begin."""

HOPELESS = 30.0
"""Times the steps of a simulation near its record up to which others beside it go: what needs more shakes faster than
any sensor shows, and a search that strays there would take longer for it than for all else.
"""

LONG = 20_000
"""Samples of a record from which a plant is simulated with those effects alone that act: of shorter ones it costs more
to compile such plants than they save."""

REMEMBERED = 8
"""Sets of values for which it is remembered where the simulations of a record start."""

BY_ANGLE = ("cosine_force", "sine_force")
"""Parameters of a force over the rod's angle; the simulated plant gets it as a disturbance that is known."""

FOLLOWS = "spool_position"
"""The state that follows the command, which is known: it starts where the command set it, unless that is off."""

VALVES = ("valve_voltage", "arriving_voltage")
"""The command of an actuator with a valve."""


@dataclass(frozen=True, eq=False)
class Shooting:
    """How a plant is simulated along records: its setup for each, what it is compared by, which `effects` it may lack,
    on a machine of which `scales`, whether it `is_beside` its records, which show with noise what drives it, and how
    often (s) it starts anew, in `most` pieces of a record at most. `priors` are what is declared of parameters that are
    known to a deviation; `crossover` is that (rad/s) of a loop that leads the plant along its records, if one does.

    The command is `held` from sample to sample or a straight line, as any other input. The plant starts with
    what is measured, smoothed, and with a contact that carries what the balance of forces leaves to it; `begins` is
    what is added to that, for some records an array (starts, states).
    """

    along: Along
    setups: Mapping[Record, Setup]
    channels: tuple[str, ...]
    held: bool
    scales: Scales
    effects: tuple[str, ...]
    is_beside: bool
    length: float = np.inf
    most: int = MOST_PIECES
    begins: Mapping[Record, np.ndarray] = field(default_factory=dict)
    push: Push | None = None
    priors: Priors = field(default_factory=dict)
    crossover: float | None = None

    @property
    def is_kept(self) -> bool:
        """Whether a filter or a loop keeps the plant beside its records, which makes of noise what no free run has."""
        return self.is_beside or self.crossover is not None

    @property
    def has_valve(self) -> bool:
        """Whether the command is that of a valve."""
        return self.along.plant.command in VALVES

    @property
    def takes_a_force(self) -> bool:
        """Whether a force can act on the plant's mass."""
        return self.along.plant.disturbance in (item.name for item in fields(self.along.plant.Inputs))

    def push_scale(self, on_command: bool) -> float:
        """A typical force, or command, of the machine."""
        return self.scales.voltage if on_command else self.scales.force

    def balance(self, motions: Sequence[Motion], free: Sequence[str]) -> Balance:
        """The simulation error of records as a balance to which parameters are fitted; its floor is the sensors'
        noise.
        """
        return Balance(
            SIMULATION,
            motions,
            self.errors,
            1.0,
            "1",
            tuple(free),
            self.scales,
            self.effects,
            parts=len(self.channels),
            simulated=True,
            axis=self.along.plant.axis,
            beside=lambda values: self.undecided(motions, values),
            together=lambda asked: errors_of([Asked(self, *each) for each in asked]),
            near=lambda values, asked: errors_near(self, values, [Asked(self, *each) for each in asked]),
            priors=self.priors,
        )

    def undecided(self, motions: Sequence[Motion], values: Values, known: Changes | None = None) -> Changes:
        """What no parameter decides: where a simulation starts (`starting`, if that is not `known`), and what a coarse
        converter leaves of what rests.
        """
        starting, groups = self.starting(motions, values) if known is None else known
        coarse = [self._coarse(motion) for motion in motions]
        names = [name for name in self.channels if any(name in own for own in coarse)]
        if not names:
            return starting, groups
        counted = [self._counted(motion, values, names, own) for motion, own in zip(motions, coarse, strict=True)]
        return np.column_stack([starting, np.concatenate(counted)]), groups

    def _coarse(self, motion: Motion) -> list[str]:
        """The channels of a record whose converters are coarse: none of pieces, which are too short to tell it."""
        return [name for name in self.channels if np.isinf(self.length) and is_coarse(motion, name)]

    def _counted(self, motion: Motion, values: Values, names: Sequence[str], coarse: Sequence[str]) -> np.ndarray:
        """What a converter's steps change of a record's rows, of each channel of these `names` in columns of its own: 0
        where it is none of those that are `coarse` here.
        """
        seen, rows = self.simulated(motion, values) if coarse else {}, motion.thinned.time.size
        out = np.zeros((len(self.channels), rows, len(names), 2 * HARMONICS))
        for name in coarse:
            waves = np.nan_to_num(over_steps(motion, name, seen[name]))
            place = self.channels.index(name), slice(None), names.index(name)
            out[place] = self._in_noise(motion, name, waves, self.tells(motion))
        return out.reshape(len(self.channels) * rows, -1)

    def _in_noise(self, motion: Motion, name: str, errors: np.ndarray, tells: np.ndarray) -> np.ndarray:
        """Errors of a channel, shape (samples, ...), as rows of a stack: means over the times between a fit's instants,
        in standard deviations of the noise of such a mean; 0 where nothing is told: where it is not, as `tells` says.
        """
        followed = self._followed(motion)
        if followed is not None:
            errors = errors / followed.spread.reshape(-1, *(1,) * (errors.ndim - 1))
        told = np.where(tells.reshape(-1, *(1,) * (errors.ndim - 1)), errors, 0.0)
        return self.of_sums(motion, name, np.add.reduceat(told, motion.instants))

    def of_sums(self, motion: Motion, name: str, sums: np.ndarray) -> np.ndarray:
        """The same of sums of errors of a channel over these times, shape (instants, ...)."""
        sizes = np.diff(np.append(motion.instants, motion.record.time.size))
        noise = max(motion.sensed[name], SOLVER * float(np.max(np.abs(motion.measured[name]))), 1e-30)
        return np.asarray(sums / np.sqrt(sizes).reshape(-1, *(1,) * (sums.ndim - 1)) / noise)

    def starting(self, motions: Sequence[Motion], values: Values) -> Changes:
        """What a change of each state at a start would change of the stack (rows, states), and the rows behind each
        start.
        """
        changed = list[np.ndarray]()
        for motion in motions:
            moves = [np.zeros(len(self.along.names)), *self.moves(motion, values)]
            asked = [Asked(self, motion, values, moved) for moved in moves]
            base, *others = (np.concatenate(errors) for errors in errors_of(asked))
            changed.append(np.nan_to_num(np.column_stack(others) - base[:, None], posinf=0.0, neginf=0.0))
        return np.concatenate(changed), self.groups(motions)

    def groups(self, motions: Sequence[Motion]) -> list[np.ndarray]:
        """The rows of the stack behind each start."""
        groups, before = list[np.ndarray](), 0
        for motion in motions:
            size, per = motion.thinned.time.size, self.samples(motion)
            for start in self.starts(motion):
                place = np.arange(-(-start // motion.thinning), min(-(-(start + per) // motion.thinning), size))
                groups.append(np.concatenate([before + kind * size + place for kind in range(len(self.channels))]))
            before += size * len(self.channels)
        return groups

    @property
    def own(self) -> list[str]:
        """The states that the plant has without any effect."""
        plant = self.along.plant
        bare = {item.name for item in fields((plant.bare or plant).State)}
        return [item.name for item in fields(plant.State) if item.name in bare]

    @property
    def follows(self) -> np.ndarray:
        """Which of these states a command sets, shape (states,)."""
        return np.array([name == FOLLOWS for name in self.own])

    def moves(self, motion: Motion, values: Values) -> list[np.ndarray]:
        """A change of each of the plant's own states at a start: by its sensor's noise, or a little."""
        own, moves, nudges = self.own, list[np.ndarray](), NUDGED * self.along.magnitudes(motion, values)
        for place, name in enumerate(self.along.names):
            if name in own:
                moves.append(np.zeros(len(self.along.names)))
                moves[-1][place] = deviation(name, motion, values) if shown(motion.channels, name) else nudges[place]
        return moves

    def reach(self, motion: Motion, values: Values) -> np.ndarray:
        """How far each state may start from what was measured, shape (starts, states): by how much it varies where a
        sensor shows it, since smoothing is off by no more; a bristle by what it can carry. Before a record's first
        sample smoothing knows nothing: there it may be off by as much as the first samples or rest are beside it.
        """

        def farthest(name: str) -> float:
            if shown(motion.channels, name):
                return ASIDE * float(np.std(state_along(name, motion, values)))
            return BENT * breakaway_bend(values) if name == BRISTLES else np.inf

        reach = np.tile([farthest(name) for name in self.along.names], (len(self.starts(motion)), 1))
        reach[0] += np.maximum(np.abs(self._sensed(motion)), np.abs(self._rested(motion, values)))
        return reach

    def _sensed(self, motion: Motion) -> np.ndarray:
        """The state that a record's first samples show, beside what smoothing makes of them."""
        beside, places = np.zeros(len(self.along.names)), [self.along.names.index(n) for n in ("position", "velocity")]
        beside[places] = np.subtract(sensed_at_first(motion), (motion.position[0], motion.velocity[0]))
        return beside

    def _rested(self, motion: Motion, values: Values) -> np.ndarray:
        """The state of rest where the rod was measured to be first, beside what smoothing makes of that."""
        (measured,) = _starting(self.along, motion, tuple(values.items()), range(1))
        beside = to_array(self.along.at_rest(motion, values)[0]) - to_array(measured)
        beside[self.along.names.index("position")] = 0.0
        return beside

    def as_sensed(self, motions: Sequence[Motion]) -> "Shooting":
        """The same from end to end of each record from its first samples, which no smoothing has bent."""
        return replace(self, begins={motion.record: self._sensed(motion)[None, :] for motion in motions})

    def rested(self, motions: Sequence[Motion], values: Values) -> "Shooting":
        """The same from end to end of each record from rest, where the rod was measured to be."""
        return replace(self, begins={motion.record: self._rested(motion, values)[None, :] for motion in motions})

    def quickest(self, motion: Motion, values: Values) -> float:
        """rad/s: the quickest loop that leads a plant with `values` along a record."""
        return quickest(self.along, motion, values)

    def led(self, motions: Sequence[Motion], values: Values, crossover: float) -> "Shooting":
        """The same from end to end with a loop (rad/s) that leads a plant with `values` along the records."""
        setups = {
            motion.record: led(self.setups[motion.record], self.along, motion, values, crossover) for motion in motions
        }
        return replace(self, setups=setups, crossover=crossover)

    def errors(self, motion: Motion, values: Values, moved: np.ndarray | None = None) -> list[np.ndarray]:
        """Measured less simulated, a row a channel, in standard deviations of the sensor's noise: means over the times
        between a fit's instants; NaN where it diverges, 0 where none is simulated. The states at each start may be
        `moved`.
        """
        return errors_of([Asked(self, motion, values, moved)])[0]

    def off_by(self, motion: Motion, runs: Iterable[tuple[int, Run]]) -> list[np.ndarray]:
        """The same of runs, each with the sample at which it starts."""
        seen, tells = self._seen(motion, runs), self.tells(motion)
        return [self._in_noise(motion, name, motion.measured[name] - seen[name], tells) for name in self.channels]

    def with_tolerance(self, tolerance: float) -> "Shooting":
        """The same with another tolerance of the solver."""
        setups = {
            record: replace(setup, integrator=replace(setup.integrator, tolerance=tolerance))
            for record, setup in self.setups.items()
        }
        return replace(self, setups=setups)

    def bounded(self, motions: Sequence[Motion], values: Values) -> "Shooting":
        """The same with simulations that end early which take far more steps than those with these values."""
        setups = dict(self.setups)
        for motion in motions:
            if np.isinf(setups[motion.record].most_steps):
                taken = max(sum(run.steps for _, run in self.runs(motion, values)), motion.record.time.size)
                setups[motion.record] = replace(setups[motion.record], most_steps=HOPELESS * taken)
        return replace(self, setups=setups)

    @property
    def tolerance(self) -> float:
        """Of the solver, as `Integrator` has it."""
        return max(setup.integrator.tolerance for setup in self.setups.values())

    def samples(self, motion: Motion) -> int:
        """Samples from start to start."""
        record = motion.record
        return record.time.size if np.isinf(self.length) else max(round(self.length / record.sample_time), 1)

    def starts(self, motion: Motion) -> range:
        """Samples at which a simulation starts."""
        every = range(0, motion.record.time.size, self.samples(motion))
        return every[:: -(-len(every) // self.most)]

    def simulated(self, motion: Motion, values: Values) -> dict[str, np.ndarray]:
        """What the sensors would have shown, at every sample; NaN where the plant diverges."""
        return self._seen(motion, self.runs(motion, values))

    def _seen(self, motion: Motion, runs: Iterable[tuple[int, Run]]) -> dict[str, np.ndarray]:
        samples = motion.record.time.size
        seen = {name: np.full(samples, np.nan) for name in self.channels}
        for k, run in runs:
            if run.diverged:
                continue
            for name in self.channels:
                seen[name][k : k + run.time.size] = run.measurements[:, Measurement._fields.index(name)]
        return seen

    def tells(self, motion: Motion) -> np.ndarray:
        """At which samples it tells something: where it is simulated."""
        covered = np.zeros(motion.record.time.size, dtype=bool)
        for start in self.starts(motion):
            covered[start : start + self.samples(motion)] = True
        return covered

    def is_led(self, motion: Motion) -> bool:
        """Whether a loop that sees its sensors leads the plant along a record, or a filter keeps it beside."""
        return self.setups[motion.record].reference is not None

    def _followed(self, motion: Motion) -> Followed | None:
        """The position that a filter sees which keeps the plant beside the record; None without one."""
        reference = self.setups[motion.record].reference
        return reference if isinstance(reference, Followed) else None

    def with_backlash_of(self, motion: Motion, values: Values) -> Motion:
        """The motion with the side of the backlash on which the simulated rod is; as it is without a backlash."""
        width, names = values.get("backlash_width", 0.0), self.along.names
        if width == 0.0 or "sensor_gap" not in names:
            return motion
        gap = np.zeros(motion.record.time.size)
        for k, run in self.runs(motion, values):
            place = [item.name for item in fields(run.plant.State)].index("sensor_gap")
            gap[k : k + run.time.size] = run.states[:, place]
        return with_slack(motion, -np.clip(gap / width, -0.5, 0.5))

    def _pushed(self, feeds: Sequence[Feed], record: Record, push: Push) -> list[Feed]:
        """Feeds with a push: on the mass as a disturbance, which acts against it, else on the command."""
        series = push.series[record]
        if not push.on_command:
            return [*feeds, Feed(self.along.plant.disturbance, Sampled(record.time, -series))]
        return [
            replace(feed, signal=Sampled(feed.signal.times, feed.signal.values + series))
            if feed.input == self.along.plant.command and isinstance(feed.signal, Sampled)
            else feed
            for feed in feeds
        ]

    def runs(self, motion: Motion, values: Values) -> list[tuple[int, Run]]:
        """The simulations along a record, each with the sample at which it starts."""
        plant = self.along.having(self.along.acts(values), alone=motion.record.time.size > LONG)
        places, setups = zip(*self.pieces(motion, values, plant), strict=True)
        return list(zip(places, simulate_together(setups), strict=True))

    def pieces(
        self, motion: Motion, values: Values, plant: Plant, moved: np.ndarray | None = None
    ) -> Iterator[tuple[int, Setup]]:
        """The setups of the simulations along a record of a plant that has what acts, each with the sample at which it
        starts; the states there may be `moved`.
        """
        record, along = motion.record, self.along
        cosine, sine = (name_along(name, along.plant.axis) for name in BY_ANGLE)
        setup = self.setups[record]
        method = method_for(along, motion, values, setup.integrator.tolerance)
        integrator = replace(setup.integrator, method=method)
        followed = self._followed(motion)
        without = {name: value for name, value in values.items() if name not in (cosine, sine)}
        feeds = arriving(setup.feeds, along, values)
        if values.get(cosine) or values.get(sine):
            angle = motion.measured["rotation_angle"]
            swing = values.get(cosine, 0.0) * np.cos(angle) + values.get(sine, 0.0) * np.sin(angle)
            feeds.append(Feed(along.plant.disturbance, Sampled(record.time, swing)))
        if self.push is not None:
            feeds = self._pushed(feeds, record, self.push)
        inputs = along.at_rest(motion, without)[1]
        inputs = replaced(inputs, {feed.input: 0.0 for feed in feeds})
        if followed is not None:
            plant, feeds = observed(plant), [*feeds, *followed.feeds]
            inputs = plant.Inputs(*inputs)
        size, per, starts = record.time.size, self.samples(motion), self.starts(motion)
        sent = next(feed.signal for feed in feeds if feed.input == along.plant.command)(record.time[list(starts)])[0]
        begins = self.begins.get(record, np.zeros((len(starts), len(along.names))))
        if moved is not None:
            begins = begins + moved
        for k, command, state, begin in zip(
            starts, sent.tolist(), _starting(along, motion, tuple(values.items()), starts), begins, strict=True
        ):
            if np.any(begin) or plant.State is not along.plant.State:
                begun = dict(zip(along.names, (to_array(state) + begin).tolist(), strict=True))
                state = from_array(plant.State, [begun[item.name] for item in fields(plant.State)])
            yield (
                k,
                replace(
                    setup,
                    plant=plant,
                    parameters=along.parameters_of(plant, without),
                    state=state,
                    inputs=inputs._replace(**dict.fromkeys(along.plant.delayed, command)),
                    duration=record.sample_time * (min(per, size - k) - 1),
                    feeds=tuple(_from(feed, k * record.sample_time) for feed in feeds),
                    reference=setup.reference if followed is None else followed.since(k * record.sample_time),
                    integrator=integrator,
                ),
            )


@lru_cache(REMEMBERED)
def _starting(along: Along, motion: Motion, values: tuple[tuple[str, float], ...], starts: range) -> Sequence[Any]:
    """Where simulations start by what was measured: the same for all that begin beside it."""
    return along.starting_states(motion, dict(values), starts)


def _from(feed: Feed, time: float) -> Feed:
    """A feed from a time (s) on."""
    if time == 0.0 or not isinstance(feed.signal, Sampled):
        return feed
    return replace(feed, signal=Sampled(feed.signal.times - time, feed.signal.values))
