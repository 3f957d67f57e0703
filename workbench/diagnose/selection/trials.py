"""What an effect would change of a residual, to first order: a column for each number that sizes it."""

import math
from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field
from weakref import WeakKeyDictionary

import numpy as np

from plants.effects.interface import Effect, Number
from plants.effects.registry import effects
from plants.equation import NEGATIVE
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.fit import Fit, stacks_near
from workbench.diagnose.residuals.unknowns import Bounds, Unknown, Values, unknown
from workbench.diagnose.selection.hum import humming_at, without_hum
from workbench.diagnose.selection.lines import band_of, matched, references, swinging
from workbench.fitting.threads import side_by_side
from workbench.parameters.sets import NEUTRAL

FELT = 10.0
"""Standard deviations of noise by which a change is to move a residual where its worth is looked at: what sticks, or
has play, does not act in proportion, and is looked at where it is about as large as is sought."""

MUCH, LITTLE, LOOKS = 3.0, 0.3, 5
"""Times that, beyond which another change is looked at, and how many are, at most."""

STEEPEST = 3.0
"""Power of a change with which it is taken to be felt, at most, and at least one over it."""

UNSEEN = 0.5
"""Standard deviations of noise that an effect of the largest plausible size makes, and cannot be seen."""

CHANGE = 0.02
"""Relative change of a parameter that has a value already, at which its worth is first looked at."""


Shape = tuple[tuple[str, float], ...]
"""Values of numbers that shape an effect, by name."""

Shapes = Mapping[str, Sequence[Shape]]
"""For effects by name the shapes that are tried."""


@dataclass(frozen=True)
class Trial:
    """An effect with the numbers that would be free: those that size it, and the others with values that shape it."""

    effect: str
    sized: tuple[str, ...]
    shapes: Shape = ()

    @property
    def names(self) -> tuple[str, ...]:
        """All numbers that a fit would move."""
        return (*self.sized, *(name for name, _ in self.shapes))


Kind = tuple[str, Shape]
"""A number that sizes an effect, with the values that shape the effect."""


@dataclass(frozen=True, eq=False)
class Column:
    """What a `step` of a number, as a search sees it, changes of a residual (rows); where the number starts, and
    whether records could show it at any plausible size.
    """

    unknown: Unknown
    start: float
    step: float
    changed: np.ndarray
    shows: bool

    @property
    def change(self) -> np.ndarray:
        """What a unit of it changes."""
        return self.changed / self.step


@dataclass(frozen=True, eq=False)
class Seen:
    """The columns that were found of a fit."""

    fitted: Fit
    columns: Mapping[Kind, Column]


@dataclass(frozen=True, eq=False)
class Columns:
    """What a trial's numbers change of the residual of a fit: a column (rows) of each, the steps as a search sees them,
    where the numbers start, and between which bounds they may move from there.
    """

    trial: Trial
    fitted: Fit
    own: Sequence[Column]
    unknowns: Sequence[Unknown]
    starts: np.ndarray
    low: np.ndarray
    high: np.ndarray

    @property
    def change(self) -> np.ndarray:
        """The columns (rows, numbers) as they are, less what a hum takes of what repeats over time: those of all trials
        would take much memory, and are made when asked for.
        """
        columns, balance = np.column_stack([column.change for column in self.own]), self.fitted.balance
        frequency = humming_at(balance, self.trial.effect, dict(self.trial.shapes))
        return columns if frequency is None else without_hum(balance, columns, [frequency])

    @property
    def block(self) -> np.ndarray:
        """The columns weighed (rows, numbers)."""
        return self.fitted.weighing(self.change)

    def values(self, x: np.ndarray) -> dict[str, float]:
        """The numbers where a linear search got to."""
        reached = np.clip(self.starts + x, [u.low for u in self.unknowns], [u.high for u in self.unknowns])
        sized = {u.name: u.value(float(place)) for u, place in zip(self.unknowns, reached, strict=True)}
        return {**sized, **dict(self.trial.shapes)}


def trials_of(fitted: Fit, taken: Sequence[str], shapes: Shapes) -> list[Trial]:
    """Every set of an effect's numbers that a balance may show and that is not free yet; of those that shape an effect
    the values that it has in `shapes`, else all of their grids.
    """

    def of(name: str) -> list[Trial]:
        effect, found = effects(fitted.balance.axis)[name], list[Trial]()
        if name in taken and not set(effect.numbers) - set(fitted.names):
            return found
        for variant in effect.variants:
            free = [number for number in variant if number not in fitted.names]
            if free and (name not in taken or set(fitted.names) & set(effect.numbers) < set(variant)):
                found += _trials(effect, free, fitted, shapes)
        return found

    return [trial for trials in side_by_side(of, fitted.balance.effects) for trial in trials]


def _trials(effect: Effect, free: Sequence[str], fitted: Fit, shapes: Shapes) -> list[Trial]:
    """A variant of an effect with each combination of values that shape it."""
    shaping = [name for name in free if effect.numbers[name].shapes]
    sized = tuple(name for name in free if name not in shaping)
    if not sized:
        return []
    known = [shape for shape in shapes.get(effect.name, ()) if {name for name, _ in shape} == set(shaping)]
    if known or not shaping:
        return [Trial(effect.name, sized, shape) for shape in known or [()]]
    return [Trial(effect.name, sized, shape) for shape in _shapes(fitted, effect, shaping)]


def _shapes(fitted: Fit, effect: Effect, shaping: Sequence[str]) -> list[Shape]:
    """Values from which a search of numbers that shape an effect begins; of one that is damped for each damping."""
    shapes: list[Shape] = [()]
    for name in sorted(shaping, key=lambda one: bool(effect.numbers[one].damped_by)):
        shapes = [(*shape, (name, value)) for shape in shapes for value in _grid(fitted, effect, name, shape)]
    return shapes


def _grid(fitted: Fit, effect: Effect, name: str, shape: Shape) -> list[float]:
    """Values (SI) from which the search of a number that shapes an effect begins: of a period over a signal those that
    stand out of what is left, as the plant would show them.
    """
    number = effect.numbers[name]
    signal = number.period_of or number.frequency_of
    grid = [number.scale(fitted.balance.scales) * value for value in number.grid]
    if not signal:
        return grid
    band = band_of(fitted.balance, number)
    if number.damped_by:
        damping = _value({**fitted.values, **dict(shape)}, number.damped_by)
        return [*grid, *(swinging(fitted, signal, band, damping) if band.high > band.low else [])]
    chosen = _lines(fitted, effect, name) if band.high > band.low else ()
    return [1.0 / frequency for frequency in chosen] if number.period_of else list(chosen)


_lines_of: WeakKeyDictionary[Fit, dict[tuple[str, str], tuple[float, ...]]] = WeakKeyDictionary()


def _lines(fitted: Fit, effect: Effect, name: str) -> tuple[float, ...]:
    """The frequencies at which an effect that repeats along a signal may show, by its number `name`: remembered as long
    as the fit is there.
    """
    known = _lines_of.setdefault(fitted, {})
    if (effect.name, name) not in known:
        known[effect.name, name] = _sought(fitted, effect, name)
    return known[effect.name, name]


def _sought(fitted: Fit, effect: Effect, name: str) -> tuple[float, ...]:
    number, (cosine, sine) = effect.numbers[name], [*effect.numbers][:2]
    signal, band = number.period_of or number.frequency_of, band_of(fitted.balance, number)
    shapes = [((name, 1.0 / one if number.period_of else one),) for one in references(band)]
    (first,) = _columns(fitted, [(cosine, shapes[0])], {}, {})
    kinds = [(wave, shape) for shape in shapes for wave in (cosine, sine)]
    known = dict.fromkeys((cosine, sine), first.step)
    waves = _columns(fitted, kinds, {}, known)
    changes = [fitted.weighing(column.change) for column in waves]
    made = [real + 1j * imaginary for real, imaginary in zip(changes[::2], changes[1::2], strict=True)]
    return tuple(matched(fitted, signal, band, made))


def looks(balance: Balance, effect: str, names: Collection[str]) -> int:
    """Among how many shapes of an effect the best is sought: of a period, or of the bands of what swings, those that
    records of this length tell apart (Davies 1987).
    """
    numbers = {name: number for name, number in effects(balance.axis)[effect].numbers.items() if name in names}
    damping = {number.damped_by for number in numbers.values()}
    shaping = [number for name, number in numbers.items() if number.shapes and name not in damping]
    return math.prod(_told_apart(balance, number, numbers) for number in shaping)


def _told_apart(balance: Balance, number: Number, free: Mapping[str, Number]) -> int:
    """How many values of a number that shapes an effect are looked at beside the others that are `free`."""
    if not (number.period_of or number.frequency_of):
        return len(number.grid)
    band = band_of(balance, number)
    if not number.damped_by:
        return max(round(band.lines), 1)
    ratios = free[number.damped_by].grid if number.damped_by in free else (NEUTRAL[number.damped_by],)
    return max(
        round(sum(min(0.5 * math.log(max(band.high / band.low, 1.0)) / ratio, band.lines) for ratio in ratios)), 1
    )


def sizing(balance: Balance, effect: str, names: Collection[str]) -> int:
    """How many of these numbers size an effect."""
    numbers = effects(balance.axis)[effect].numbers
    return sum(not numbers[name].shapes for name in names)


def columns_of(fitted: Fit, trials: Sequence[Trial], bounds: Bounds) -> dict[Trial, Columns]:
    """The columns of each trial that these records could show."""
    return together(seen_of(fitted, trials, bounds), trials)


def together(seen: Seen, trials: Sequence[Trial]) -> dict[Trial, Columns]:
    """The same, of columns that were found."""
    made = {}
    for trial in trials:
        own = [seen.columns[name, trial.shapes] for name in trial.sized]
        if all(column.shows for column in own):
            made[trial] = _together(seen.fitted, trial, own)
    return made


def seen_of(fitted: Fit, trials: Sequence[Trial], bounds: Bounds, before: Seen | None = None) -> Seen:
    """The column of each number of these trials with each of its shapes. Those that were seen `before` of the same fit
    are known; of another one, or with the first of its shapes, it is known how far to move a number.
    """
    known = before.columns if before is not None and before.fitted is fitted else dict[Kind, Column]()
    kinds = list(dict.fromkeys((name, trial.shapes) for trial in trials for name in trial.sized))
    wanted = [kind for kind in kinds if kind not in known]
    found, last = dict(known), before.columns if before is not None else known
    steps = {name: column.step for (name, _), column in reversed(list(last.items()))}
    first = {name: (name, shapes) for name, shapes in reversed(wanted) if name not in steps}

    found |= zip(first.values(), _columns(fitted, list(first.values()), bounds, steps), strict=True)
    steps |= {name: found[kind].step for name, kind in first.items()}
    rest = [kind for kind in wanted if kind not in found]
    found |= zip(rest, _columns(fitted, rest, bounds, steps), strict=True)
    return Seen(fitted, found)


def _together(fitted: Fit, trial: Trial, own: Sequence[Column]) -> Columns:
    unknowns, starts = [column.unknown for column in own], np.array([column.start for column in own])
    low = np.array([u.low for u in unknowns]) - starts
    high = np.array([u.high for u in unknowns]) - starts
    return Columns(trial, fitted, own, unknowns, starts, np.minimum(low, 0.0), np.maximum(high, 0.0))


def _value(values: Values, name: str) -> float:
    """Of a number that is not declared: where it does nothing, or that of the other direction."""
    return values.get(name, NEUTRAL.get(name, values.get(name.removesuffix(f"_{NEGATIVE}"), 0.0)))


def _columns(fitted: Fit, kinds: Sequence[Kind], bounds: Bounds, steps: Mapping[str, float]) -> list[Column]:
    """What a change of each number does to the residual, to first order where that is known, of a size that is felt: at
    the step that is known of it.
    """
    looked = [_Look.at_first(fitted, kind, bounds, steps.get(kind[0])) for kind in kinds]
    going = list(looked)
    for last in range(LOOKS, -1, -1):
        several = stacks_near(fitted.balance, fitted.values, [look.values for look in going])
        for look, there in zip(going, several, strict=True):
            look.sees(there - fitted.residual, float(np.linalg.norm(fitted.weighing(there - fitted.residual))))
        going = [look for look in going if last and look.moves_on()]
        if not going:
            break
    return [look.column for look in looked]


@dataclass(eq=False)
class _Look:
    """A number that is moved from `place` by a step, with its values otherwise; what the last step changed, how much of
    it is felt, the step before with what was felt of that, and the power with which a change is felt.
    """

    searched: Unknown
    others: Values
    place: float
    room: float
    step: float
    change: np.ndarray = field(default_factory=lambda: np.zeros(0))
    felt: float = 0.0
    before: tuple[float, float] | None = None
    power: float = 1.0

    @classmethod
    def at_first(cls, fitted: Fit, kind: Kind, bounds: Bounds, first: float | None) -> "_Look":
        """At the `first` step, if that is known."""
        name, shapes = kind
        values = {**fitted.values, **dict(shapes)}
        searched = unknown(name, values, bounds, fitted.balance.scales)
        start = _value(values, name)
        place = searched.place(start) if not searched.logarithmic or start > 0.0 else 0.0
        room = searched.high - place if searched.high - place > place - searched.low else searched.low - place
        look = cls(searched, values, place, room, 0.0)
        look.step = look.within(first if first is not None else CHANGE if searched.logarithmic else 1.0)
        return look

    def within(self, size: float) -> float:
        """A step of a size, where there is room for it."""
        return math.copysign(min(abs(size), 0.5 * abs(self.room)), 1.0 if self.room > 0.0 else -1.0)

    @property
    def values(self) -> dict[str, float]:
        """Where the step leads."""
        return {**self.others, self.searched.name: self.searched.value(self.place + self.step)}

    def sees(self, change: np.ndarray, felt: float) -> None:
        """What the step changes."""
        self.change, self.felt = change, felt
        if self.before is not None and felt > 0.0 < self.before[1]:
            power = math.log(felt / self.before[1]) / math.log(self.step / self.before[0])
            self.power = min(max(power, 1.0 / STEEPEST), STEEPEST)

    def moves_on(self) -> bool:
        """Take a step that is felt as it should be, if the last one is not and there is room for another."""
        if LITTLE * FELT < self.felt < MUCH * FELT:
            return False
        more = max(FELT / max(self.felt, 1e-12), 1e-12) ** (1.0 / self.power)
        wanted = self.within(self.step * min(max(more, 1e-6), 1e3))
        if abs(wanted / self.step - 1.0) < 0.1:
            return False
        self.before, self.step = (self.step, self.felt), wanted
        return True

    @property
    def column(self) -> Column:
        """What was seen last."""
        shows = bool(np.isfinite(self.felt)) and self.felt * abs(self.room / self.step) >= UNSEEN
        return Column(self.searched, self.place, self.step, self.change, shows)
