"""Fits of a plant to simulation error: from end to end, by way of loops that lead it, and in short or longer pieces.

What a plant is off by adds up, and a run that went astray shows nothing. A loop that leads it along its record takes
most of that away, and with parameters that are nearer a weaker one does.

A contact that breaks away at another time puts hollows into the error of a long run, and a chamber that rings more.
A short piece has few of them, since it starts from what was measured; where it starts is no part of the plant, and is
found with its parameters.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.fit import (
    AS_IT_IS,
    FINAL,
    NEAR_NOISE,
    QUICK,
    THOROUGH,
    Fit,
    fit,
    stacked,
    weighed_by,
    weighing_at,
)
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Bounds, Values
from workbench.diagnose.residuals.weighing import Weighing, by_scatter, weighing_of
from workbench.diagnose.simulation.setup import follows
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.starts import FIRST, restarted, squares_of
from workbench.fitting.threads import side_by_side
from workbench.parameters.sets import EITHER_SIGN

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

BUILDS_UP = 2.0
"""Times what shorter pieces leave that longer ones leave where something is missing, which adds up over time."""

ASTRAY = 30.0
"""Standard deviations of noise from which a long run is no place to begin a fit."""

FACTORS = tuple(float(np.exp(log)) for log in np.linspace(-2.5, 2.5, 21))
"""Of a parameter, at which a fit that went astray begins anew."""

SCANS = 2
"""Times that it does."""

PATIENCE = 4
"""Loops in succession that may leave more than a quicker one did: a run that is astray has hollows, and the next may
lead out of one."""

WEAKER, WEAKEST = 2.0, 0.1
"""Times that one loop that leads a plant along its records is quicker than the next, and the least crossover of one,
over one over the longest record's duration: what it corrects by then is a hundredth of what it would move anyway."""

FINER, FINEST, HIDDEN = 0.1, 1e-10, 1.0
"""Factor of the solver's tolerance until it changes squares of what is left over noise by less than `HIDDEN`, and the
least tolerance."""

ALIKE = 0.01
"""Part by which what a loop leaves differs from what the one before did, up to which it no longer decides."""

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
    starting: tuple[np.ndarray, Sequence[np.ndarray]] | None = None

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

    def bettered(self, best: Simulated) -> Simulated:
        """The same from a plant as it is begun, as long as a round leaves clearly less."""
        for _ in range(ROUNDS):
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
        """The same by damped Gauss-Newton steps of the starts, as long as these leave clearly less."""
        best = fit(how.balance(self.motions, ()), values, ())
        damping = np.array([FIRST])
        for _ in range(STEPS):
            starting = how.starting(self.motions, values)
            how, damping = restarted(how, best, starting, damping)
            before, best = best, fit(how.balance(self.motions, ()), values, ())
            if not _fell(before, best, how, (left_of_pieces(before, starting[1]), left_of_pieces(best, starting[1]))):
                break
        return Simulated(how, best, starting)

    def _once(self, of: Simulated) -> Simulated:
        """The parameters with starts that follow them to first order, and then these starts."""
        balance = of.how.balance(self.motions, self.names)
        weigh, search = (by_scatter, RUGGED) if of.fit.excess > NEAR_NOISE else (weighing_of, QUICK)
        weighing = _without_astray(weighed_by(weigh, of.fit, of.starting), of)
        fitted = fit(balance, of.fit.values, self.names, self.bounds, search, weighing)
        return self.begun(of.how, fitted.values)

    def final(self, of: Simulated) -> Simulated:
        """The fit whose parameters count, by the likelihood of noise like that which is left."""
        balance = of.how.balance(self.motions, self.names)
        weighing, search = weighing_at(of.fit), FINAL
        if of.fit.excess > ASTRAY:  # nobody's noise: the values stay, and are as uncertain as it is
            weighing, search = weighed_by(by_scatter, of.fit), AS_IT_IS
        return Simulated(of.how, fit(balance, of.fit.values, self.names, self.bounds, search, weighing))

    def freely(self, whole: Shooting, values: Values) -> Fit:
        """The parameters that leave least of a run from end to end that begins as its first samples show, by way of
        weaker and weaker loops from these values on: of a plant far from noise, whose start would make up for what it
        lacks. Of its hollows that one counts into which parameters lead that hold beside the record.
        """
        sensed, left = whole.as_sensed(self.motions), list[float]()
        for crossover in crossovers(whole, self.motions, values):
            led = sensed.led(self.motions, values, crossover).balance(self.motions, self.names)
            found = fit(led, values, self.names, self.bounds, QUICK)
            values = found.values
            left.append(found.rms)
            if _are_alike(left):
                break  # what is left is no longer the loop's
        return fit(sensed.balance(self.motions, self.names), values, self.names, self.bounds, THOROUGH)


def fit_simulation(whole: Shooting, fitting: Fitting, starts: Sequence[Values]) -> Simulated:
    """The plant fitted to its records from end to end, from the best of some starts."""
    best = min((fitting.begun(whole, start) for start in starts), key=lambda one: one.fit.rms)
    return fitting.final(fitting.bettered(best))


def exactly(of: Simulated, fitting: Fitting) -> Simulated:
    """A fit once more with a solver whose error does not matter beside the noise: a fine sensor shows it, and effects
    would explain it.
    """
    how, values = of.how, of.fit.values
    before = of.fit.weighing(how.balance(fitting.motions, ()).stacked(values))
    while how.tolerance > FINEST:
        finer = how.with_tolerance(how.tolerance * FINER)
        after = of.fit.weighing(finer.balance(fitting.motions, ()).stacked(values))
        if float(np.sum((after - before) ** 2)) < HIDDEN:
            break
        how, before = finer, after
    if how is of.how:
        return of
    return fitting.final(fitting.bettered(fitting.stepped(how, values)))


def fit_farther(first: Simulated, fitting: Fitting, start: Values) -> Simulated:
    """The same, if it is not near noise, by way of pieces, and from where its parameters leave least of most of its
    records; to pieces alone where it does not follow them from end to end.
    """
    whole, motions = replace(first.how, length=np.inf, begins={}), fitting.motions
    best, pieces, values = first, list[Simulated](), dict(start)
    for how in _ladder(whole, motions):
        if best.fit.excess < NEAR_NOISE:
            break
        starts = [values] if pieces else [values, best.fit.values]
        piece = fitting.bettered(min((fitting.begun(how, one) for one in starts), key=lambda one: one.left))
        if pieces and piece.left > BUILDS_UP * pieces[-1].left:
            break
        pieces.append(piece)
        values = piece.fit.values
        climbed = fitting.begun(whole, values)
        if climbed.fit.rms < best.fit.rms:
            best = fitting.bettered(climbed)
    best = _scanned(fitting, best) if best.is_near else best
    if best.fit.excess > NEAR_NOISE and not follows(best.how, motions, best.fit.values):
        longest = [piece for piece in pieces if follows(piece.how, motions, piece.fit.values)]
        best = (longest or pieces or [best])[-1]
    if best is first:
        return first
    best = fitting.final(best)
    return first if np.isinf(best.how.length) and best.fit.rms > BETTER * first.fit.rms else best


def fit_led(first: Simulated, fitting: Fitting, start: Values) -> Simulated:
    """The same by way of loops that lead the plant along its records, each weaker than the one before, from `start` on,
    if that leads nearer to noise. Where a led run starts is found with its parameters: a weak loop hardly corrects it,
    and parameters would.
    """
    whole, motions, best = replace(first.how, length=np.inf, begins={}), fitting.motions, first
    led: Simulated | None = None
    left = list[float]()
    for crossover in crossovers(whole, motions, start):
        values, begins = (start, {}) if led is None else (led.fit.values, led.how.begins)
        led = fitting.found(replace(whole.led(motions, values, crossover), begins=begins), values)
        left.append(led.fit.excess)
        if min(left[-PATIENCE:]) > max(min(left), ASTRAY) or led.fit.rms > first.fit.rms:
            break  # something is missing that no parameters make up for
        free = fitting.begun(replace(whole, begins=led.how.begins), led.fit.values)
        if free.fit.rms < best.fit.rms:
            best = free
        if free.fit.rms < AT_NOISE * led.fit.rms and (free.fit.excess < NEAR_NOISE or _are_alike(left)):
            break
    return first if best is first else fitting.final(fitting.bettered(best))


def _are_alike(left: Sequence[float]) -> bool:
    """Whether the last two loops left the same."""
    return len(left) > 1 and abs(left[-1] / left[-2] - 1.0) < ALIKE


def crossovers(whole: Shooting, motions: Sequence[Motion], values: Values) -> Iterator[float]:
    """Those (rad/s) of loops that lead a plant along its records, from the quickest on; none of a plant that is kept
    beside its records, on which no force acts, or which delays its command.
    """
    if whole.is_beside(motions[0]) or not whole.takes_a_force or whole.along.plant.delayed:
        return
    crossover = min(whole.quickest(motion, values) for motion in motions)
    while crossover > WEAKEST / max(float(motion.record.time[-1]) for motion in motions):
        yield crossover
        crossover /= WEAKER


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
    return min((fitting.stepped(start, values) for start in starts), key=lambda one: one.fit.rms).how


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


def _ladder(whole: Shooting, motions: Sequence[Motion]) -> list[Shooting]:
    """The plant in pieces, from the shortest, of which each record has two at least."""
    instants = max(-(-motion.time.size // motion.grain) for motion in motions)
    step = motions[0].grain * motions[0].record.sample_time
    return [replace(whole, length=count * step, begins={}) for count in PIECES if 2 * count <= instants]


def _scanned(fitting: Fitting, best: Simulated) -> Simulated:
    """The fit from where each positive parameter in turn leaves least of most of its records, if that is better."""
    for _ in range(SCANS):
        if best.fit.excess < NOISE:
            break
        balance, values = best.fit.balance, dict(best.fit.values)
        width = max(1.4826 * float(np.median(np.abs(best.fit.residual))), 1.0)

        def left(changed: Values, of: Balance = balance, width: float = width) -> float:
            return float(np.mean(np.log1p((stacked(of, changed) / width) ** 2)))

        for name in fitting.names:
            if name not in EITHER_SIGN and values[name] > 0.0:
                tried = [{**values, name: factor * values[name]} for factor in FACTORS]
                values = tried[int(np.argmin(side_by_side(left, tried)))]
        again = fitting.found(best.how, values)
        if again.fit.rms > BETTER * best.fit.rms:
            break
        best = again
    return best
