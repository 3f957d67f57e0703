"""Least squares of a balance's residual over parameters of the plant, and how well it holds on blocks left out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench.diagnose.residuals.balance import SIMULATION, Balance
from workbench.diagnose.residuals.motion import fluctuation
from workbench.diagnose.residuals.unknowns import Bounds, Unknown, Values, declared_with, unknown, values_at
from workbench.diagnose.residuals.weighing import (
    Changes,
    Directions,
    Slices,
    Weighing,
    beside_known,
    by_scatter,
    less,
    plain,
    weighing_of,
    without,
)
from workbench.fitting.covariance import inverse, long_run_length, sandwich
from workbench.fitting.least_squares import Search, differences, jacobian_of, least_squares
from workbench.fitting.threads import side_by_side

BOUNDED = 1e-9
"""Distance (of an unknown as the search sees it) to an end of its range at which a parameter has stopped there: a fine
sensor shows what is a millionth of the largest that is plausible."""

NEAR_NOISE = 3.0
"""Floors up to which what is left may be noise of a colour that the floor does not know."""

THOROUGH = Search()
"""When the fit ends whose parameters count."""

QUICK = Search(flat=1e-3, most_steps=15, learns=True)
"""When a fit ends from which another goes on, or by which alone the size of what it leaves is asked."""

AS_IT_IS = Search(most_steps=1)
"""No search, but what parameters change where they are."""

FINAL = Search(flat=1e-5, most_steps=6)
"""When a fit ends that goes on from another one's end."""

SIZES, WITHIN = 10.0, 0.1
"""Of an effect, and share of its range, by which a difference quotient may move it: one that is hardly seen is felt
by no less."""

COLOURED = 2.0
"""Times the white noise of its samples by which, and by the root of their number, noise of means may be larger."""

LOST = 1e6
"""Floors in the place of a residual that is no number, since the plant diverges: to and fro, as nothing is that no
parameter decides, and which is not weighed.
"""


@dataclass(frozen=True, eq=False)
class Fit:
    """A balance at its best over some free parameters.

    `residual` is over the floor, `weighed` what it weighs against its noise with the `vague` knowledge of parameters
    before any record; `jacobian` that of the weighed residual by the `unknowns`, without that knowledge, of which
    `free` are at no bound; `bounded` are parameters that stopped at the end of their range.
    """

    balance: Balance
    names: tuple[str, ...]
    values: dict[str, float]
    residual: np.ndarray
    weighed: np.ndarray
    vague: np.ndarray
    jacobian: np.ndarray
    unknowns: Sequence[Unknown]
    free: np.ndarray
    bounded: frozenset[str]
    weighing: Weighing

    @property
    def moved(self) -> Values:
        """The values that it was free to move."""
        return {name: self.values[name] for name in self.names}

    @property
    def rms(self) -> float:
        """Of the residual, in floors."""
        return float(np.sqrt(np.mean(self.residual**2)))

    @cached_property
    def excess(self) -> float:
        """The same over the noise in it, which is the floor where noise is white, and what its third differences show,
        within what colour can make of means, where it is not.
        """
        squares, count = 0.0, 0
        for motion, slices in zip(self.balance.motions, self.balance.series, strict=True):
            for place in slices:
                part = self.residual[place]
                fast = min(fluctuation(part), COLOURED * float(np.sqrt(motion.thinning)))
                squares += float(part @ part) / max(fast, 1.0) ** 2
                count += part.size
        return float(np.sqrt(squares / max(count, 1)))

    @property
    def squares(self) -> float:
        """Of what it weighs: twice the logarithm of a likelihood, but for a constant."""
        return float(self.weighed @ self.weighed + self.vague @ self.vague)

    @cached_property
    def places(self) -> np.ndarray:
        """Where the parameters are, as a search sees them."""
        return np.array([u.place(self.values[u.name]) for u in self.unknowns])

    @cached_property
    def known(self) -> np.ndarray:
        """What is known of the unknowns before any record: 1 over the variance of each."""
        return _precisions(self.unknowns) ** 2

    @cached_property
    def curvature(self) -> np.ndarray:
        """J' J of the unknowns, with what is known before any record."""
        return np.asarray(self.jacobian.T @ self.jacobian + np.diag(self.known))

    @cached_property
    def pull(self) -> np.ndarray:
        """By how much half the squares of what is known before any record rise with each unknown."""
        return self.known * (self.places - np.array([u.centre for u in self.unknowns]))

    @cached_property
    def changes(self) -> np.ndarray:
        """What a unit of each unknown changes of the residual (rows, unknowns), for noise of any colour to weigh."""
        x, high = self.places, np.array([u.high for u in self.unknowns])
        steps = differences(x, high, THOROUGH.step, self.jacobian, self.squares, _longest(self.unknowns))
        return jacobian_of(lambda places: stacks(self.balance, list(map(self.at, places))), x, self.residual, steps)

    @cached_property
    def beside(self) -> Changes:
        """What no parameter decides, at its values."""
        return self.balance.beside(self.values)

    @cached_property
    def undecided(self) -> Directions:
        """What that spans of the residual."""
        return beside_known(self.residual != 0.0, *self.beside)

    def at(self, places: np.ndarray) -> dict[str, float]:
        """The values where the unknowns are elsewhere, as a search sees them."""
        return values_at(self.values, self.unknowns, places)

    @cached_property
    def covariance(self) -> np.ndarray:
        """Of the unknowns, with what noise still has of memory; 0 for one that is held at a bound."""
        series = [place for slices in self.balance.series for place in slices]
        length = long_run_length([self.weighed[place] for place in series])
        held = self.jacobian * self.free
        return sandwich(held, self.weighed, series, length, self.known * self.free)

    @cached_property
    def deviations(self) -> dict[str, float]:
        """Standard deviations of the parameters."""
        if not self.unknowns:
            return {}
        stds = np.sqrt(np.maximum(np.diag(self.covariance), 0.0)) * self.free
        return {
            u.name: abs(u.slope(float(place))) * float(std)
            for u, place, std in zip(self.unknowns, self.places, stds, strict=True)
        }

    @cached_property
    def left_out(self) -> np.ndarray:
        """The weighed residual of each block at the parameters that the others give, by one Gauss-Newton step."""
        if not self.unknowns:
            return self.weighed
        out = self.weighed.copy()
        for block in self.balance.blocks:
            own = self.jacobian[block] * self.free
            moved = inverse(self.curvature - own.T @ own) @ (own.T @ self.weighed[block])
            out[block] += own @ moved
        return out

    def seen_by(self, weighing: Weighing) -> float:
        """Its squares if noise were that of another weighing."""
        weighed = weighing(self.residual)
        return float(weighed @ weighed + self.vague @ self.vague)

    def seen_at(self, values: Values) -> float:
        """The squares of other values, in the same noise."""
        return self.seen_at_each([values])[0]

    def seen_at_each(self, several: Sequence[Values]) -> list[float]:
        """The same of several."""
        weighed = map(self.weighing, stacks(self.balance, several))
        places = (np.array([u.place(values[u.name]) for u in self.unknowns]) for values in several)
        vague = (_vague(self.unknowns, place) for place in places)
        return [float(one @ one + own @ own) for one, own in zip(weighed, vague, strict=True)]


def fit(
    balance: Balance,
    values: Values,
    names: Sequence[str],
    bounds: Bounds | None = None,
    search: Search = THOROUGH,
    weighing: Weighing | None = None,
) -> Fit:
    """The best values of the parameters `names`, all others as in `values`: every row counts alike, or as weighed."""
    unknowns = unknowns_of(balance, names, values, bounds or {})

    def lefts(places: Sequence[np.ndarray]) -> list[np.ndarray]:
        return stacks(balance, [values_at(values, unknowns, x) for x in places])

    low, high = np.array([u.low for u in unknowns]), np.array([u.high for u in unknowns])
    start = np.clip([u.first for u in unknowns], low, high)
    weigh = plain(balance.series, balance.rows) if weighing is None else weighing

    left = dict[bytes, np.ndarray]()

    def residuals(places: Sequence[np.ndarray]) -> list[np.ndarray]:
        found = lefts(places)
        left[places[0].tobytes()] = found[0]  # a search ends at one that it asked for first
        weighed = side_by_side(weigh, found)
        return [np.concatenate([one, _vague(unknowns, x)]) for one, x in zip(weighed, places, strict=True)]

    solution = least_squares(residuals, start, low, high, search, _longest(unknowns))
    size, places = solution.residual.size - len(unknowns), list(zip(unknowns, solution.x, strict=True))
    return Fit(
        balance=balance,
        names=tuple(names),
        values=values_at(values, unknowns, solution.x),
        residual=left[solution.x.tobytes()],
        weighed=solution.residual[:size],
        vague=solution.residual[size:],
        jacobian=solution.jacobian[:size],
        unknowns=unknowns,
        free=solution.free.astype(float),
        bounded=frozenset(u.name for u, place in places if min(place - u.low, u.high - place) < BOUNDED),
        weighing=weigh,
    )


def unknowns_of(balance: Balance, names: Sequence[str], values: Values, bounds: Bounds) -> list[Unknown]:
    """Parameters of a balance as a search sees them that starts at these values."""
    unknowns = [unknown(name, values, bounds, balance.scales) for name in names]
    return [declared_with(u, *balance.priors[u.name]) if u.name in balance.priors else u for u in unknowns]


def _precisions(unknowns: Sequence[Unknown]) -> np.ndarray:
    return np.array([1.0 / u.deviation for u in unknowns])


def _vague(unknowns: Sequence[Unknown], places: np.ndarray) -> np.ndarray:
    """How far unknowns are from where they are before any record, in the standard deviations of that."""
    return _precisions(unknowns) * (places - np.array([u.centre for u in unknowns]))


def _longest(unknowns: Sequence[Unknown]) -> np.ndarray:
    """Steps up to which difference quotients may go: of what has a size, and acts in proportion to it, sizes; of what
    is positive, and bends, no farther than a search goes by itself.
    """
    return np.array([0.0 if u.logarithmic else min(SIZES, WITHIN * (u.high - u.low)) for u in unknowns])


def stacked(balance: Balance, values: Values) -> np.ndarray:
    """The residuals of a balance over its floor, `LOST` where the plant diverges."""
    return stacks(balance, [values])[0]


def stacks(balance: Balance, several: Sequence[Values]) -> list[np.ndarray]:
    """The same of several values."""
    return list(map(without_lost, balance.stacks(several)))


def stacks_near(balance: Balance, values: Values, several: Sequence[Values]) -> list[np.ndarray]:
    """The same of several near some values, to first order where that is known."""
    return list(map(without_lost, balance.stacks_near(values, several)))


def without_lost(stack: np.ndarray) -> np.ndarray:
    """A stack with `LOST` where the plant diverges."""
    finite = np.isfinite(stack)
    return stack if np.all(finite) else np.where(finite, stack, np.resize((LOST, -LOST), stack.size))


def over(fitted: Fit, balance: Balance) -> Fit:
    """The same fit of the same balance over another floor."""
    share = fitted.balance.floor / balance.floor
    return replace(
        fitted, balance=balance, residual=share * fitted.residual, weighing=fitted.weighing.times(1.0 / share)
    )


def noise_like(balance: Balance) -> Callable[[Slices, np.ndarray], Weighing]:
    """How residuals of a balance weigh if they are noise: of a simulation by their spectrum, since sensors alone decide
    it, and nobody knows how slow their noise is; of others by their scatter, since smoothing, contacts and what is
    missing decide it.
    """
    return weighing_of if balance.name == SIMULATION else by_scatter


def weighed_without(fitted: Fit, residual: np.ndarray) -> Weighing:
    """How the residuals of a fit weigh if this is what noise leaves of them, known where they are."""
    balance, left = fitted.balance, less(residual, fitted.undecided)
    return noise_like(balance)(balance.series, left).without(*fitted.beside)


def weighing_at(fitted: Fit) -> Weighing:
    """How residuals weigh if what a fit leaves is noise."""
    return weighed_by(noise_like(fitted.balance), fitted)


def weighed_by(
    weigh: Callable[[Slices, np.ndarray], Weighing],
    fitted: Fit,
    beside: Changes | None = None,
) -> Weighing:
    """What a fit leaves as noise, without what no parameter decides, if that is not known already."""
    columns, groups = fitted.beside if beside is None else beside
    return weigh(fitted.balance.series, without(fitted.residual, columns, groups)).without(columns, groups)


def weighed_fit(
    balance: Balance,
    values: Values,
    names: Sequence[str],
    bounds: Bounds | None = None,
    search: Search = THOROUGH,
    first: Fit | None = None,
) -> Fit:
    """The best values by the likelihood of noise like that which the fit leaves; `first` is a fit to begin with."""
    best = fit(balance, values, names, bounds, search) if first is None else first
    return again(best, weighing_at(best), bounds, search)


def again(fitted: Fit, weighing: Weighing, bounds: Bounds | None = None, search: Search = THOROUGH) -> Fit:
    """A fit once more from where it is, with another weighing."""
    return fit(fitted.balance, fitted.values, fitted.names, bounds, search, weighing)
