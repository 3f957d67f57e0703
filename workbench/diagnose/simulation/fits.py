"""Fits of a plant to simulation error, from end to end or in pieces: parameters, and where each simulation starts.

Where a simulation starts is no part of the plant, and is found with its parameters.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench.diagnose.residuals.fit import (
    AS_IT_IS,
    FINAL,
    NEAR_NOISE,
    QUICK,
    Fit,
    fit,
    noise_like,
    weighed_by,
)
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Bounds, Values
from workbench.diagnose.residuals.weighing import Changes, Weighing, by_scatter, weighing_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.starts import FIRST, restarted, squares_of
from workbench.fitting.threads import side_by_side

NOISE = 1.5
"""Standard deviations of noise up to which nothing has to be explained further."""

AT_NOISE = 1.1
"""Standard deviations of noise up to which a start leaves nothing that another one could."""

TRUSTED = 3.0
"""Standard deviations of noise up to which the parameters of a simulated plant are believed before those that the
balances give: beyond it what the model lacks decides them, and what adds up over time most of all."""

PIECES = (20, 80, 320, 1280)
"""Grains of a record in a piece, from the shortest."""

RUGGED = replace(QUICK, rugged=True)
"""When a fit ends that is not near noise, though it weighs as if it were."""

ROUNDS = 20
"""Times that parameters, and then states at the starts, are found, at most."""

STEPS = 8
"""Further steps of a start, at most."""

HALVES, CLIMBS = 0.6, 0.95
"""Share of the rms that a step of a start, or a round, has to leave at most for another: of a long run that is astray,
and of what else is not near noise."""

SETTLES = 2.0
"""Squares over noise by which it has to leave less where it is: twice the logarithm of a likelihood."""

ASTRAY = 30.0
"""Standard deviations of noise from which a long run is no place to begin a fit."""

FINER, FINEST, HIDDEN, EDGE = 0.1, 1e-10, 1.0, 2.0
"""Factor of the solver's tolerance until it changes squares of what is left over noise by less than `HIDDEN`; the least
tolerance that is changed; and times the least change from which on a finer one makes up for it. What no tolerance makes
smaller is not the solver's: a motion is at an edge, where it sticks or not, and any error turns it.
"""

FARTHEST = 5.0
"""Times the rms of the median piece from which a piece went astray."""

BETTER = 0.98
"""Rms over that of another fit from which it is better."""


@dataclass(frozen=True, eq=False)
class Simulated:
    """A plant with its parameters fitted to simulation error: how it is simulated, the fit, and what the states at
    the starts would change (`Shooting.starting`), if that was found.
    """

    how: Shooting
    fit: Fit
    starting: Changes | None = None

    @cached_property
    def left(self) -> float:
        """Of a typical piece: sqrt(1 + q^2), as a geometric mean over pieces with an rms of q each."""
        return left_of_pieces(self.fit, self.groups)

    @cached_property
    def groups(self) -> Sequence[np.ndarray]:
        """The rows of each piece."""
        return self.how.groups(self.fit.balance.motions) if self.starting is None else self.starting[1]

    @property
    def is_astray(self) -> bool:
        """Whether it goes from end to end of its records and is off by far more than noise."""
        return bool(np.isinf(self.how.length)) and self.fit.excess >= ASTRAY

    @property
    def is_near(self) -> bool:
        """Whether it follows its records from end to end, and so near to noise, which may be slow, that what it leaves
        tells what it lacks.
        """
        return bool(np.isinf(self.how.length)) and self.fit.excess < ASTRAY


@dataclass(frozen=True)
class Fitting:
    """What is fitted: the parameters `names` on some motions, within bounds."""

    motions: Sequence[Motion]
    names: Sequence[str]
    bounds: Bounds

    def found(self, how: Shooting, values: Values) -> Simulated:
        """The parameters and the states at the starts that leave least of the records, from these values on."""
        return self.bettered(self.begun(how, values))

    def bettered(self, best: Simulated, enough: float = 0.0) -> Simulated:
        """The same from a plant as it is begun, as long as a round leaves clearly less, and more than is `enough`."""
        for _ in range(ROUNDS):
            if best.is_near and best.fit.excess < enough:
                break
            before, again = best, self._once(best)
            best = min(before, again, key=lambda one: one.left)
            if not _fell(before.fit, again.fit, again.how, (before.left, again.left)):
                break
        return best

    def begun(self, how: Shooting, values: Values) -> Simulated:
        """The plant with these values, from the starts that suit them best: near those that suited others, or near what
        was measured, since a long run may not find back from the one to the other; or from rest, where that alone
        follows within noise.

        Far from noise a long run is begun by what comes soon after: else its start makes up for what its parameters
        are off by, and does not find back.
        """
        if not np.isinf(how.length):
            return self.stepped(how, values)
        near = self.stepped(how, values) if how.begins else None
        if near is not None and near.fit.excess < AT_NOISE:
            return near
        soon = self._begun_soon(how, values)
        fresh = fit(soon.balance(self.motions, ()), values, ())
        if fresh.excess < ASTRAY:
            measured = self.stepped(soon, values)
        else:
            measured = Simulated(soon, fresh, soon.starting(self.motions, values))
        others = [near] if near is not None and near.fit.excess < ASTRAY else []
        if not how.begins and measured.fit.excess > NEAR_NOISE:
            rested = self.stepped(how.rested(self.motions, values), values)
            others += [rested] if rested.fit.excess < NEAR_NOISE else []
        return min([*others, measured], key=lambda one: one.fit.rms)

    def _begun_soon(self, how: Shooting, values: Values) -> Shooting:
        """The same from starts that suit the first instants of each record."""
        instant = self.motions[0].grain * self.motions[0].record.sample_time
        soon = replace(how, begins={}, most=1)
        for count in PIECES:
            soon = self.stepped(replace(soon, length=count * instant), values).how
        return replace(how, begins=soon.begins)

    def stepped(self, how: Shooting, values: Values) -> Simulated:
        """The same by damped Gauss-Newton steps of the starts, as long as these leave clearly less: to none from which
        a simulation is hopeless.
        """
        best, damping, bounded = None, np.array([FIRST]), how.bounded(self.motions, values)
        for _ in range(STEPS):
            starting = bounded.starting(self.motions, values)
            before = best or fit(bounded.balance(self.motions, ()), values, ())  # which has gone beside those
            bounded, damping = restarted(bounded, before, starting, damping)
            best = fit(bounded.balance(self.motions, ()), values, ())
            left = left_of_pieces(before, starting[1]), left_of_pieces(best, starting[1])
            if not _fell(before, best, bounded, left):
                break
        assert best is not None
        return Simulated(replace(bounded, setups=how.setups), best, starting)

    def _once(self, of: Simulated) -> Simulated:
        """The parameters with starts that follow them to first order, and then these starts."""
        balance = of.how.balance(self.motions, self.names)
        weigh, search = (by_scatter, RUGGED) if of.fit.excess > NEAR_NOISE else (weighing_of, QUICK)
        weighing = _without_astray(weighed_by(weigh, of.fit, of.starting), of)
        fitted = fit(balance, of.fit.values, self.names, self.bounds, search, weighing)
        return self.begun(of.how, fitted.values)

    def final(self, of: Simulated) -> Simulated:
        """The fit whose parameters count, by the likelihood of noise like that which is left."""
        how = of.how.bounded(self.motions, of.fit.values) if of.is_near else of.how
        balance = how.balance(self.motions, self.names)
        weigh, search = noise_like(balance), FINAL
        if of.fit.excess > ASTRAY:  # nobody's noise: the values stay, and are as uncertain as it is
            weigh, search = by_scatter, AS_IT_IS
        beside = None if of.starting is None else of.how.undecided(self.motions, of.fit.values, of.starting)
        weighing = weighed_by(weigh, of.fit, beside)
        return Simulated(how, fit(balance, of.fit.values, self.names, self.bounds, search, weighing))


def fit_simulation(whole: Shooting, fitting: Fitting, starts: Sequence[Values]) -> Simulated:
    """The plant fitted to its records from end to end, from the best of some starts. Near noise the solver is made
    fine enough before the search goes on: it would end where the error of a coarse one is least.
    """
    best = min(side_by_side(lambda start: fitting.begun(whole, start), starts), key=lambda one: one.fit.rms)
    best = fitting.bettered(best, enough=NEAR_NOISE)
    return fitting.final(fitting.bettered(finer(best, fitting)) if best.fit.excess < NEAR_NOISE else best)


def exactly(of: Simulated, fitting: Fitting) -> Simulated:
    """A fit once more with a solver whose error does not matter beside the noise: a fine sensor shows it, and effects
    would explain it. Far from noise it does not count.
    """
    exact = finer(of, fitting)
    return of if exact is of else fitting.final(fitting.bettered(exact))


def finer(of: Simulated, fitting: Fitting) -> Simulated:
    """The same plant by such a solver, from the starts that suit its values; itself if it is, or is far from noise."""
    if not of.is_near:
        return of
    values, hows, changes = of.fit.values, [of.how], list[float]()
    left = of.fit.weighing(of.how.balance(fitting.motions, ()).stacked(values))
    while hows[-1].tolerance > FINEST and min(changes, default=np.inf) > HIDDEN:
        hows.append(hows[-1].with_tolerance(hows[-1].tolerance * FINER))
        before, left = left, of.fit.weighing(hows[-1].balance(fitting.motions, ()).stacked(values))
        changes.append(float(np.nan_to_num(np.sum((left - before) ** 2), nan=np.inf)))
    least = max(HIDDEN, EDGE * min(changes, default=np.inf))
    fine = next((how for how, changed in zip(hows, changes, strict=False) if changed <= least), of.how)
    return of if fine is of.how else fitting.stepped(fine, values)


def afresh(of: Simulated, fitting: Fitting) -> Simulated:
    """A fit once more from starts that know nothing of those before, if these leave less: a start has hollows, too."""
    fresh = fitting.begun(replace(of.how, begins={}), of.fit.values)
    return fitting.final(fitting.bettered(fresh)) if _fell(of.fit, fresh.fit, of.how, (of.left, fresh.left)) else of


def begun(how: Shooting, motions: Sequence[Motion], values: Values) -> Shooting:
    """A plant with these values from end to end, from the starts that suit them best; as its first samples show, where
    it is far from noise.
    """
    fitting = Fitting(motions, (), {})
    first = fitting.begun(how, values)
    if first.is_astray:
        return how.as_sensed(motions)
    if first.fit.excess < AT_NOISE:
        return first.how
    starts = first.how, replace(how, begins={})
    return min(side_by_side(lambda start: fitting.stepped(start, values), starts), key=lambda one: one.fit.rms).how


def settle(how: Shooting, motions: Sequence[Motion], found: Fit, bounds: Bounds) -> Fit:
    """A fit from the starts that suit its values best, by the likelihood of the noise that it leaves then."""
    fitting = Fitting(motions, found.names, bounds)
    return fitting.final(fitting.begun(how, found.values)).fit


def _fell(before: Fit, after: Fit, how: Shooting, left: tuple[float, float]) -> bool:
    """Whether a step left so much less that another may be worth it: near noise a little counts, and a long run that is
    astray has to find back at once. Of pieces it is the typical one that counts, of which there is `left` so much.
    """
    astray = after.excess > ASTRAY and np.isinf(how.length)
    if after.excess < NEAR_NOISE and np.isinf(how.length):
        return bool((before.rms / after.rms) ** 2 > 1.0 + SETTLES / np.count_nonzero(after.residual))
    share = HALVES if astray else CLIMBS
    return left[1] < share * left[0] if np.isfinite(how.length) else after.rms < share * before.rms


def left_of_pieces(fitted: Fit, groups: Sequence[np.ndarray]) -> float:
    """sqrt(1 + q^2), as a geometric mean over pieces with an rms of q each: few that went astray do not decide it."""
    return float(np.exp(0.5 * np.mean(np.log1p(_mean_squares(fitted.residual, groups)))))


def _mean_squares(residual: np.ndarray, groups: Sequence[np.ndarray]) -> np.ndarray:
    return squares_of(residual, groups) / np.array([max(rows.size, 1) for rows in groups])


def _without_astray(weighing: Weighing, of: Simulated) -> Weighing:
    """The same without pieces that leave far more than the typical one: their starts went astray."""
    squares, counts = _mean_squares(of.fit.residual, of.groups), weighing.counts.copy()
    for rows, own in zip(of.groups, squares, strict=True):
        if own > FARTHEST**2 * np.median(squares):
            counts[rows] = False
    return replace(weighing, counts=counts)
