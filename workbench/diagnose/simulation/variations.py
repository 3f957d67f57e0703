"""What small changes make of a simulation: the variational equation along it.

Beside a simulation whose states at the samples are x_k a changed one goes to first order by

    dx_{k+1} = F_k dx_k + B_k r_k,    F = dx_{k+1}/dx_k,    B = dx_{k+1}/dr

where r_k are the rates that a change adds, on average over the sample, and a sensor shows C_k dx_k. F and B cost as
much as some dozens of simulations. What is compared are sums over the samples from one instant to the next; of each
such block is kept what its rates make of these sums, and of the state at its end:

    E_j = F_{K-1} ... F_{j+1},    A_j = C_{j+1} + C_{j+2} F_{j+1} + ...    (within the block),    W_j = (E_j; A_j) B_j

Then a change costs next to nothing, and has no error of a solver in it.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from plants.compiled import address, copy, njit, shift
from plants.equation import fields, from_array, to_array
from plants.interface import Plant
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.residuals.walk import rates_along
from workbench.diagnose.simulation.beside import NUDGED, held_inputs
from workbench.diagnose.simulation.kalman import Sampling, fastest, over_sample
from workbench.diagnose.simulation.together import Asked, Push, errors_of
from workbench.fitting.threads import side_by_side
from workbench.simulation.compilation import call_derivatives, plant_addresses
from workbench.simulation.run import Run

if TYPE_CHECKING:
    from workbench.diagnose.simulation.shooting import Shooting

STEP, MOST_STEPS, MOST = 1.0, 8, 512
"""Step within a sample over one over the plant's fastest rate there; steps at most on average, since more cost more
than they save, and within any sample.
"""

FELT, RIGHT = 10.0, 0.25
"""Standard deviations of noise that a push makes by which it is seen whether first order is right, and the share of
that by which it may be off.
"""

ALONG, NODES = ("position", "velocity"), 8
"""Signals over which pushes go up and down by which that is seen, and how often."""

APART = 0.01
"""Share of the range of a signal by which places are apart between which a push goes up or down."""

STILL = 1e-3
"""Of the fastest motion, below which a contact rests."""


@njit(cache=True, nogil=True)
def _in_blocks(
    plant: Sampling,
    time: np.ndarray,
    states: np.ndarray,
    inputs: np.ndarray,
    shown: np.ndarray,
    still: np.ndarray,
    carried: np.ndarray,
    steps: np.ndarray,
    size: int,
) -> tuple[np.ndarray, np.ndarray]:
    """What states before blocks of so many samples make of the states behind them and of the sums of what is shown in
    them, (blocks, states + channels, states), and what rates make of these, (samples, states, states + channels).

    Args:
        plant: as it goes over a sample.
        time: s, shape (samples,).
        states: along the simulation, shape (samples, states).
        inputs: held over each sample, shape (samples, inputs).
        shown: what each state adds to what sensors show, C, shape (samples, channels, states).
        still: where the contact rests, and slips differently to either side, shape (samples,).
        carried: which states a flank carries from there on: what they were is forgotten, shape (samples, states).
        steps: within each sample, shape (samples,).
        size: of a block.
    """
    channels, count = shown.shape[1:]
    derivatives, parameters, places, nudges, command, push, span, _ = plant
    blocks = -(-time.size // size)
    first = np.zeros((blocks, count + channels, count))
    rated = np.zeros((time.size, count, count + channels), np.float32)
    both = np.zeros((count + channels, count))
    for block in range(blocks):
        begin, end = block * size, min((block + 1) * size, time.size)
        both.fill(0.0)
        for i in range(count):
            both[i, i] = 1.0
        for k in range(end - 1, begin - 1, -1):
            if k < time.size - 1:
                sampling = (derivatives, parameters, places, nudges, command, push, span, steps[k])
                moved, held = over_sample(sampling, time[k], states[k], inputs[k], still[k])
                for i in range(count):
                    if carried[k + 1, i]:
                        moved[i].fill(0.0)
                        held[i].fill(0.0)
                added = both @ held
                for i in range(count + channels):
                    for j in range(count):
                        rated[k, j, i] = added[i, j]
                both = both @ moved
            for i in range(channels):
                for j in range(count):
                    both[count + i, j] += shown[k, i, j]
        copy(both.ravel(), first[block].ravel())
    return first, rated


@njit(cache=True, nogil=True)
def _over_blocks(first: np.ndarray, added: np.ndarray, start: np.ndarray, count: int) -> np.ndarray:
    """Sums over blocks of what is shown (blocks, channels, changes) of changes whose rates add to states and sums
    `added`, (blocks, states + channels, changes), and that start at (states, changes).
    """
    sums, state = np.zeros((first.shape[0], first.shape[1] - count, start.shape[1])), start.copy()
    for block in range(first.shape[0]):
        both = first[block] @ state + added[block]
        for change in range(start.shape[1]):
            for i in range(count):
                state[i, change] = both[i, change]
            for i in range(sums.shape[1]):
                sums[block, i, change] = both[count + i, change]
    return sums


@njit(cache=True, nogil=True)
def _rates_of(
    derivatives: int,
    time: np.ndarray,
    states: np.ndarray,
    inputs: np.ndarray,
    parameters: np.ndarray,
    whole: np.ndarray,
    places: np.ndarray,
) -> np.ndarray:
    """Rates (samples, states) of states at `places` of a plant whose others are as in a `whole` state."""
    state, made, rates = whole.copy(), whole.copy(), np.empty_like(states)
    for k in range(time.size):
        for j in range(places.size):
            state[places[j]] = states[k, j]
        held = shift(address(inputs), k * inputs.shape[1])
        call_derivatives(derivatives, time[k], address(state), held, address(parameters), address(made))
        for j in range(places.size):
            rates[k, j] = made[places[j]]
    return rates


@njit(cache=True, nogil=True)
def _in_sums(rated: np.ndarray, rates: np.ndarray, instants: np.ndarray) -> np.ndarray:
    """What rates (samples, states) add to states and sums, as `_over_blocks` has it, of one change."""
    added = np.zeros((instants.size, rated.shape[2]))
    for block in range(instants.size):
        end = instants[block + 1] if block + 1 < instants.size else rates.shape[0]
        for k in range(instants[block], end):
            for j in range(rates.shape[1]):
                for i in range(rated.shape[2]):
                    added[block, i] += rated[k, j, i] * rates[k, j]
    return added


@dataclass(frozen=True, eq=False)
class Varied:
    """A simulation along a record from end to end, and how it answers: inputs as they act over each sample (samples,
    inputs), and what `_in_blocks` gives.
    """

    asked: Asked
    run: Run
    inputs: np.ndarray
    first: np.ndarray
    rated: np.ndarray

    @classmethod
    def of(cls, asked: Asked) -> "Varied | None":
        """None of one that starts more than once, diverges, is stiff, led by a loop that sees what it does, or of which
        first order tells too little.
        """
        how, motion, values = asked.how, asked.motion, asked.values
        if how.is_led(motion) or not np.isinf(how.length):
            return None
        ((_, run),) = how.runs(motion, values)
        names = [item.name for item in fields(run.plant.State)]
        if run.diverged:
            return None
        ((_, setup),) = how.pieces(motion, values, run.plant)
        inputs = np.ascontiguousarray(held_inputs(setup, run.time))
        sizes = how.along.magnitudes(motion, values)[[how.along.names.index(name) for name in names]]
        nudges, places, span = NUDGED * sizes, np.arange(len(names)), motion.record.sample_time
        states = np.ascontiguousarray(run.states)
        sampling = plant_addresses(run.plant)[0], to_array(run.parameters), places, nudges, 0, 1.0, span, 1
        carried = _carried(states) & ~np.isin(names, how.own)
        rates = fastest(_moving(sampling, ~np.any(carried, axis=0)), run.time, states, inputs)
        steps = np.clip(np.ceil(span * rates / STEP), 1, MOST).astype(np.int64)
        if np.mean(steps) > MOST_STEPS:
            return None
        shown = _shown(asked, run, nudges)
        still = np.abs(states[:, names.index("velocity")]) < STILL * motion.top_speed
        first, rated = _in_blocks(sampling, run.time, states, inputs, shown, still, carried, steps, motion.thinning)
        varied = cls(asked, run, inputs, first, rated)
        with np.errstate(over="ignore", invalid="ignore"):  # what runs away to first order is not right
            return varied if np.all(np.isfinite(first)) and varied._is_right() else None

    def _is_right(self) -> bool:
        """Whether pushes that are well felt change simulations as they should to first order: constant, and up and down
        over position and velocity; on the mass and on the command, if a valve has one.
        """
        how, record = self.asked.how, self.asked.motion.record
        names = [item.name for item in fields(self.run.plant.State)]
        series = [np.ones(record.time.size), *(_zigzag(self.run.states[:, names.index(name)]) for name in ALONG)]
        for on_command in [False] * how.takes_a_force + [True] * (how.has_valve or not how.takes_a_force):
            told = [np.array(one) for one in self.pushed(series, on_command)]
            sizes = [FELT / max(float(np.linalg.norm(one)), 1e-30) for one in told]
            pushes = [Push(on_command, {record: size * one}) for size, one in zip(sizes, series, strict=True)]
            pushed = [replace(self.asked, how=replace(how, push=push)) for push in pushes]
            base, *there = errors_of([self.asked, *pushed])
            off = [np.subtract(one, base) - size * own for one, size, own in zip(there, sizes, told, strict=True)]
            if not all(np.linalg.norm(one) < RIGHT * FELT for one in off):
                return False
        return True

    def pushed(self, several: Sequence[np.ndarray], on_command: bool) -> list[list[np.ndarray]]:
        """What pushes (samples,) on the mass, or on the command, add to what the simulation is off by, as
        `Shooting.errors` has it.
        """
        how, motion, plant = self.asked.how, self.asked.motion, self.run.plant
        series, place = np.column_stack(several), plant.input_index(plant.command if on_command else plant.disturbance)
        if on_command:
            late = how.along.late(self.asked.values)
            series = np.column_stack([np.interp(motion.time - late, motion.time, one) for one in series.T])
        else:
            series = -series
        feeds = how.setups[motion.record].feeds
        held = on_command and any(not feed.linear for feed in feeds if feed.input == plant.command)
        return self._in_noise(self._added(self._adds(place), series, held))

    def having(self, how: "Shooting", several: Sequence[Values], than: Values) -> list[list[np.ndarray]]:
        """The same of other values `than` these, with which the plant remembers as much: by the rates that they make in
        the states of the simulation, where it starts, and what sensors show of it.
        """
        base, instants = self._with(how, than), self.asked.motion.instants

        def changes(values: Values) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
            there = self._with(how, values)
            added = _in_sums(self.rated, there.rates - base.rates, instants)
            return added, there.start - base.start, np.add.reduceat(there.shown - base.shown, instants)

        added, starts, shown = zip(*side_by_side(changes, several), strict=True)
        sums = _over_blocks(self.first, np.stack(added, -1), np.column_stack(starts), base.start.size)
        return self._in_noise(sums + np.stack(shown, -1))

    def _with(self, how: "Shooting", values: Values) -> "_Acting":
        """What these values make in the states of the simulation."""
        motion, run = self.asked.motion, self.run
        plant = how.along.plant
        ((_, setup),) = how.pieces(motion, values, plant)
        start, names = to_array(setup.state), [item.name for item in fields(plant.State)]
        places = np.array([names.index(item.name) for item in fields(run.plant.State)])
        (time, states), inputs = self.half_way, np.ascontiguousarray(held_inputs(setup, run.time))
        derivatives, parameters = plant_addresses(plant)[0], to_array(setup.parameters)
        rates = _rates_of(derivatives, time, states, inputs, parameters, start, places)
        columns = start.tolist()
        for place, column in zip(places, run.states.T, strict=True):
            columns[place] = column
        return _Acting(rates, start[places], _seen(how, plant, columns, setup.parameters))

    @cached_property
    def half_way(self) -> tuple[np.ndarray, np.ndarray]:
        """Times and states (samples, states) in the middle of each sample."""
        time, states = self.run.time, self.run.states
        following = np.append(time[1:], time[-1:]), np.append(states[1:], states[-1:], axis=0)
        return 0.5 * (time + following[0]), 0.5 * (states + following[1])

    def _adds(self, place: int) -> np.ndarray:
        """What a unit of an input adds to the rates at each sample, (samples, states)."""
        plant = self.run.plant
        size = NUDGED * self.asked.how.push_scale(place == plant.input_index(plant.command))
        derivatives, parameters = plant_addresses(plant)[0], to_array(self.run.parameters)
        states, pushed = np.ascontiguousarray(self.run.states), self.inputs.copy()
        pushed[:, place] += size
        before, after = (
            rates_along(derivatives, self.run.time, states, inputs, parameters) for inputs in (self.inputs, pushed)
        )
        return np.asarray((after - before) / size)

    def _added(self, adds: np.ndarray, series: np.ndarray, held: bool) -> np.ndarray:
        """What `series` (samples, changes) of rates `adds` (samples, states), straight lines between samples or `held`,
        add to the sums of what is shown, (blocks, channels, changes).
        """
        series = series if held else 0.5 * (series + np.append(series[1:], series[-1:], axis=0))
        made, count = np.einsum("kji,kj->ki", self.rated, adds), adds.shape[1]
        added = np.stack(
            [np.add.reduceat(made * one[:, None], self.asked.motion.instants, axis=0) for one in series.T], axis=-1
        )
        return np.asarray(_over_blocks(self.first, added, np.zeros((count, series.shape[1])), count))

    def _in_noise(self, sums: np.ndarray) -> list[list[np.ndarray]]:
        """Sums of what is shown as each change adds them to what the simulation is off by."""
        how, motion = self.asked.how, self.asked.motion
        off = [how.of_sums(motion, name, -sums[:, place]) for place, name in enumerate(how.channels)]
        return [[one[:, change] for one in off] for change in range(sums.shape[-1])]


def _carried(states: np.ndarray) -> np.ndarray:
    """Which states (samples, states) stay what they are over the sample that follows, to the last bit."""
    stays = np.zeros(states.shape, dtype=bool)
    stays[:-1] = states[:-1] == states[1:]
    return stays


def _moving(sampling: Sampling, which: np.ndarray) -> Sampling:
    """The same of these states alone, shape (states,)."""
    derivatives, parameters, places, nudges, *rest = sampling
    return derivatives, parameters, places[which], nudges[which], *rest


def _zigzag(values: np.ndarray) -> np.ndarray:
    """Up and down over a signal, between -1 and 1 at even shares of its values; not among those where it rests."""
    nodes = np.unique(np.quantile(values, np.linspace(0.0, 1.0, NODES)))
    nodes = nodes[np.append(True, np.diff(nodes) > APART * np.ptp(values))]
    return np.asarray(np.interp(values, nodes, (-1.0) ** np.arange(nodes.size)))


@dataclass(frozen=True, eq=False)
class _Acting:
    """What values make in the states of a simulation: rates (samples, states) on average over each sample, where it
    starts, (states,), and what sensors show, (samples, channels).
    """

    rates: np.ndarray
    start: np.ndarray
    shown: np.ndarray


def _seen(how: "Shooting", plant: Plant, states: Sequence[Any], parameters: Any) -> np.ndarray:
    """What each channel's sensor shows of states, (states,) of (samples,) each: (samples, channels)."""
    shown = plant.measure(from_array(plant.State, states), parameters)
    return np.column_stack(np.broadcast_arrays(*(getattr(shown, name) for name in how.channels)))


def _shown(asked: Asked, run: Run, nudges: np.ndarray) -> np.ndarray:
    """What a unit of each state adds to what each channel's sensor shows, C, (samples, channels, states)."""
    base = _seen(asked.how, run.plant, list(run.states.T), run.parameters)
    moved = [
        (_seen(asked.how, run.plant, list((run.states + move).T), run.parameters) - base) / nudge
        for move, nudge in zip(np.diag(nudges), nudges, strict=True)
    ]
    return np.stack(moved, axis=-1)
