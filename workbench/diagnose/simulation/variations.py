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
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from plants.compiled import njit
from plants.effects.attach import possible
from plants.effects.interface import Change, Effect
from plants.effects.moment import moment_of
from plants.equation import fields, from_array, members, to_array
from plants.laws.interface import Nothing
from workbench.diagnose.residuals.fit import Fit
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.residuals.walk import rates_along
from workbench.diagnose.simulation.beside import NUDGED, held_inputs
from workbench.diagnose.simulation.kalman import Sampling, fastest, over_sample
from workbench.diagnose.simulation.together import Asked, Push, errors_of
from workbench.fitting.threads import side_by_side
from workbench.simulation.compilation import plant_addresses
from workbench.simulation.run import Run

if TYPE_CHECKING:
    from workbench.diagnose.simulation.shooting import Shooting

STEP, MOST_STEPS = 1.0, 8
"""Step within a sample over one over the plant's fastest rate, and steps at most: more cost more than they save."""

FELT, RIGHT = 10.0, 0.25
"""Standard deviations of noise that a push makes by which it is seen whether first order is right, and the share of
that by which it may be off.
"""

ALONG, NODES = ("position", "velocity"), 8
"""Signals over which pushes go up and down by which that is seen, and how often."""

LOOKED = 500
"""States along a simulation among which its fastest rate is looked for."""

WORTH = 16
"""Changes from which it pays to find how a simulation answers."""

REMEMBERED = 4
"""Simulations of which it is remembered how they answer: one of each record of a fit."""


@njit(cache=True, nogil=True)
def _in_blocks(
    plant: Sampling, time: np.ndarray, states: np.ndarray, inputs: np.ndarray, shown: np.ndarray, size: int
) -> tuple[np.ndarray, np.ndarray]:
    """What states before blocks of so many samples make of the sums of what is shown in them and of the states behind
    them, (blocks, states + channels, states), and what rates make of these, (samples, states + channels, states).

    Args:
        plant: as it goes over a sample.
        time: s, shape (samples,).
        states: along the simulation, shape (samples, states).
        inputs: held over each sample, shape (samples, inputs).
        shown: what each state adds to what sensors show, C, shape (samples, channels, states).
        size: of a block.
    """
    channels, count = shown.shape[1:]
    blocks = -(-time.size // size)
    first = np.zeros((blocks, count + channels, count))
    rated = np.zeros((time.size, count + channels, count), np.float32)
    both = np.zeros((count + channels, count))
    for block in range(blocks):
        begin, end = block * size, min((block + 1) * size, time.size)
        both[:] = 0.0
        for i in range(count):
            both[i, i] = 1.0
        for k in range(end - 1, begin - 1, -1):
            if k < time.size - 1:
                moved, held, _ = over_sample(plant, time[k], states[k], inputs[k])
                rated[k] = both @ held
                both = both @ moved
            both[count:] += shown[k]
        first[block] = both
    return first, rated


@njit(cache=True, nogil=True)
def _over_blocks(first: np.ndarray, added: np.ndarray, start: np.ndarray, count: int) -> np.ndarray:
    """Sums over blocks of what is shown (blocks, channels, changes) of changes whose rates add to states and sums
    `added`, (blocks, states + channels, changes), and that start at (states, changes).
    """
    sums, state = np.zeros((first.shape[0], first.shape[1] - count, start.shape[1])), start.copy()
    for block in range(first.shape[0]):
        both = first[block] @ state + added[block]
        state, sums[block] = both[:count].copy(), both[count:]
    return sums


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
        """None of one that starts more than once, diverges, is stiff, led by a loop that sees what it does, has effects
        that remember, or of which first order tells too little.
        """
        how, motion, values = asked.how, asked.motion, asked.values
        if how.is_led(motion) or not np.isinf(how.length):
            return None
        ((_, run),) = how.runs(motion, values)
        names = [item.name for item in fields(run.plant.State)]
        if run.diverged or not {*names} <= {*how.own}:
            return None
        inputs = held_inputs(how.setups[motion.record], how.along, motion, values)
        sizes = how.along.magnitudes(motion, values)[[how.along.names.index(name) for name in names]]
        nudges, places, span = NUDGED * sizes, np.arange(len(names)), motion.record.sample_time
        derivatives, parameters = plant_addresses(run.plant)[0], to_array(run.parameters)
        states, rows = np.ascontiguousarray(run.states), slice(None, None, -(-run.time.size // LOOKED))
        time, under = np.ascontiguousarray(run.time[rows]), np.ascontiguousarray(inputs[rows])

        def rates(states: np.ndarray) -> np.ndarray:
            return np.asarray(rates_along(derivatives, time, np.ascontiguousarray(states), under, parameters))

        steps = max(int(np.ceil(span * fastest(rates, states[rows], places, nudges) / STEP)), 1)
        if steps > MOST_STEPS:
            return None
        sampling = derivatives, parameters, places, nudges, 0, 1.0, span, steps
        shown = _shown(asked, run, nudges)
        first, rated = _in_blocks(sampling, run.time, states, inputs, shown, motion.thinning)
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

    def having(
        self, how: "Shooting", effect: Effect, several: Sequence[Values], than: Values
    ) -> list[list[np.ndarray]]:
        """The same of an effect that `pushes` with other numbers `than` these, on a plant that can have it."""
        plant, p, size = self.run.plant, self.run.parameters, self.run.time.size
        state, inputs = from_array(plant.State, self.run.states.T), from_array(plant.Inputs, self.inputs.T)
        moment = moment_of(plant.bare or plant)(self.run.time, state, inputs, p)
        owns = [
            effect.Own(*(values.get(item.name, item.default) for item in fields(effect.Own)))
            for values in (than, *several)
        ]

        def more(change: Change) -> np.ndarray:
            first, *values = (change(np.zeros(size), moment, Nothing(), p, own) for own in owns)
            return np.column_stack([value - first for value in values])

        first, *starts = (self._start(how, values) for values in (than, *several))
        found = [self._begun(np.column_stack(starts) - first[:, None])]
        for name, change in effect.inputs.items():
            found.append(self._added(self._adds(members(plant.Inputs).index(name)), more(change)))
        for place, item in enumerate(fields(plant.State)):
            if item.name in effect.rates:
                adds = np.zeros_like(self.run.states)
                adds[:, place] = 1.0
                found.append(self._added(adds, more(effect.rates[item.name])))
        return self._in_noise(np.sum(found, axis=0))

    def _start(self, how: "Shooting", values: Values) -> np.ndarray:
        """Where a simulation with other values starts."""
        ((_, setup),) = how.pieces(self.asked.motion, values, self.run.plant)
        return to_array(setup.state)

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

    def _begun(self, starts: np.ndarray) -> np.ndarray:
        """What changes of the start (states, changes) add to the sums of what is shown (blocks, channels, changes)."""
        none = np.zeros((*self.first.shape[:2], starts.shape[1]))
        return np.asarray(_over_blocks(self.first, none, np.ascontiguousarray(starts), starts.shape[0]))

    def _added(self, adds: np.ndarray, series: np.ndarray, held: bool = False) -> np.ndarray:
        """The same of `series` (samples, changes) of rates `adds` (samples, states), straight lines between samples, or
        `held`.
        """
        series = series if held else 0.5 * (series + np.append(series[1:], series[-1:], axis=0))
        made, count = np.einsum("kij,kj->ki", self.rated, adds), adds.shape[1]
        added = np.stack(
            [np.add.reduceat(made * one[:, None], self.asked.motion.instants, axis=0) for one in series.T], axis=-1
        )
        return np.asarray(_over_blocks(self.first, added, np.zeros((count, series.shape[1])), count))

    def _in_noise(self, sums: np.ndarray) -> list[list[np.ndarray]]:
        """Sums of what is shown as each change adds them to what the simulation is off by."""
        how, motion = self.asked.how, self.asked.motion
        off = [how.of_sums(motion, name, -sums[:, place]) for place, name in enumerate(how.channels)]
        return [[one[:, change] for one in off] for change in range(sums.shape[-1])]


def _zigzag(values: np.ndarray) -> np.ndarray:
    """Up and down over a signal, between -1 and 1 at even shares of its values."""
    nodes = np.unique(np.quantile(values, np.linspace(0.0, 1.0, NODES)))
    return np.asarray(np.interp(values, nodes, (-1.0) ** np.arange(nodes.size)))


def _shown(asked: Asked, run: Run, nudges: np.ndarray) -> np.ndarray:
    """What a unit of each state adds to what each channel's sensor shows, C, (samples, channels, states)."""
    plant, channels = run.plant, asked.how.channels

    def seen(states: np.ndarray) -> np.ndarray:
        shown = plant.measure(from_array(plant.State, states.T), run.parameters)
        return np.column_stack([np.broadcast_to(getattr(shown, name), run.time.shape) for name in channels])

    base = seen(run.states)
    moved = [(seen(run.states + move) - base) / nudge for move, nudge in zip(np.diag(nudges), nudges, strict=True)]
    return np.stack(moved, axis=-1)


def errors_near(base: Values, asked: Sequence[Asked]) -> list[list[np.ndarray]]:
    """What each of these is off by, as `errors_of` has it: to first order where no more than what pushes differs from a
    simulation with `base` values that answers.
    """
    kinds: dict[tuple[Motion, Effect], list[Asked]] = {}
    for one in asked:
        effect = _pushing(base, one)
        if effect is not None:
            kinds.setdefault((one.motion, effect), []).append(one)
    found = dict[Asked, list[np.ndarray]]()
    for (_, effect), several in kinds.items():
        varied = _varied(replace(several[0], values=base)) if len(several) >= WORTH else None
        if varied is not None:
            (off,) = errors_of([varied.asked])
            changes = varied.having(several[0].how, effect, [one.values for one in several], base)
            found |= {one: list(map(np.add, off, own)) for one, own in zip(several, changes, strict=True)}
    rest = [one for one in asked if one not in found]
    found |= zip(rest, errors_of(rest), strict=True)
    return [found[one] for one in asked]


def _pushing(base: Values, one: Asked) -> Effect | None:
    """The effect whose numbers alone are other than in `base`, if it pushes."""
    names = {name for name, value in one.values.items() if base.get(name) != value}
    able = possible(one.how.along.plant)
    return next((effect for effect in able if effect.pushes and names <= {*effect.own_names}), None) if names else None


@lru_cache(REMEMBERED)
def _varied(asked: Asked) -> Varied | None:
    """`Varied.of`, remembered."""
    return Varied.of(asked)


def variations_of(how: "Shooting", fitted: Fit) -> list[Varied]:
    """How the simulations of a fit answer along each of its records; none where one of them does not."""
    asked = [Asked(how, motion, fitted.values) for motion in fitted.balance.motions]
    found = [one for one in side_by_side(_varied, asked) if one is not None]
    return found if len(found) == len(asked) else []
