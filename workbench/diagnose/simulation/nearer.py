"""Ways by which a fit that is far from noise gets nearer: loops that lead the plant, steps over hollows, and pieces.

What a plant is off by adds up, and a run that went astray shows nothing. A loop that leads it along its record takes
most of that away, and with parameters that are nearer a weaker one does.

A contact that breaks away at another time puts hollows into the error of a long run, and a chamber that rings more.
Wide steps do not see them. A short piece has few of them, since it starts from what was measured.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import numpy as np

from workbench.diagnose.residuals.fit import NEAR_NOISE, QUICK, THOROUGH, Fit, fit, stacks, unknowns_of
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values, values_at
from workbench.diagnose.simulation.evolution import evolved
from workbench.diagnose.simulation.fits import ASTRAY, AT_NOISE, BETTER, NOISE, PIECES, Fitting, Simulated
from workbench.diagnose.simulation.setup import follows
from workbench.diagnose.simulation.shooting import Shooting
from workbench.fitting.wide_steps import descend
from workbench.parameters.sets import EITHER_SIGN

BUILDS_UP = 2.0
"""Times what shorter pieces leave that longer ones leave where something is missing, which adds up over time."""

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

DEVIATIONS, GENERATIONS = 2.0, 120
"""Deviations of a fit beside a loop by which the first free runs that are tried lie away from it, and how many
generations of them are, at most."""

ALIKE = 0.01
"""Part by which what a loop leaves differs from what the one before did, up to which it no longer decides."""


def fit_as_sensed(first: Simulated, fitting: Fitting, start: Values) -> Simulated:
    """The same by way of loops along which every run begins as the first samples show, if that leads nearer to noise:
    starts that are found with the parameters may make up for these from loop to loop.
    """
    whole, left, values = replace(first.how, length=np.inf, begins={}), list[float](), None
    for led in _along_loops(fitting, whole, start):
        left.append(led.excess)
        if _is_lost(left) or led.rms > first.fit.rms:
            return first
        values = led.values
    if values is None:
        return first
    free = fitting.begun(whole, _freed(fitting, whole, values).values)
    return fitting.final(fitting.bettered(free)) if free.fit.rms < first.fit.rms else first


def fit_led(first: Simulated, fitting: Fitting, start: Values) -> Simulated:
    """The same by way of loops that lead the plant along its records, each weaker than the one before, from `start` on,
    if that leads nearer to noise. Where a led run starts is found with its parameters: a weak loop hardly corrects it,
    and parameters would. Where no loop leads to a free run that is near noise, the weakest beside which the plant is
    says where one is to be looked for.
    """
    whole, motions, best = replace(first.how, length=np.inf, begins={}), fitting.motions, first
    led: Simulated | None = None
    near: Simulated | None = None
    left = list[float]()
    for crossover in crossovers(whole, motions, start):
        values, begins = (start, {}) if led is None else (led.fit.values, led.how.begins)
        led = fitting.found(replace(whole.led(motions, values, crossover), begins=begins), values)
        left.append(led.fit.excess)
        if _is_lost(left) or led.fit.rms > first.fit.rms:
            break
        near = led if led.fit.excess < NEAR_NOISE else near
        free = fitting.begun(replace(whole, begins=led.how.begins), led.fit.values)
        if free.fit.rms < best.fit.rms:
            best = free
        if free.fit.rms < AT_NOISE * led.fit.rms and (free.fit.excess < NEAR_NOISE or _are_alike(left)):
            break
    best = best if best is first else fitting.final(fitting.bettered(best))
    return best if near is None else fit_evolved(best, fitting, fitting.final(near).fit)


def fit_evolved(first: Simulated, fitting: Fitting, led: Fit) -> Simulated:
    """The same, if it is not near noise, from that free run which leaves least of those that the deviations of a fit
    beside a loop leave open, if that leads nearer: where a contact sticks and slips with a loop that makes a force of
    noise, weaker ones may lead astray what follows its record without any.
    """
    if first.fit.excess < NEAR_NOISE:
        return first
    whole = replace(first.how, length=np.inf, begins={})
    free = whole.as_sensed(fitting.motions).balance(fitting.motions, fitting.names)
    lower = fitting.begun(whole, evolved(free, led, DEVIATIONS, GENERATIONS, NEAR_NOISE))
    return fitting.final(fitting.bettered(lower)) if lower.fit.rms < first.fit.rms else first


def fit_over_hollows(first: Simulated, fitting: Fitting) -> Simulated:
    """The same by steps over hollows, if that leads nearer to noise."""
    over = fitting.found(first.how, _over_hollows(first, fitting))
    return fitting.final(over) if over.fit.rms < first.fit.rms else first


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


def freely(fitting: Fitting, whole: Shooting, values: Values) -> Fit:
    """The parameters that leave least of a run from end to end that begins as its first samples show, by way of
    weaker and weaker loops from these values on: of a plant far from noise, whose start would make up for what it
    lacks. Of its hollows that one counts into which parameters lead that hold beside the record.
    """
    for led in _along_loops(fitting, whole, values):
        values = led.values
    return _freed(fitting, whole, values)


def _freed(fitting: Fitting, whole: Shooting, values: Values) -> Fit:
    """The parameters that leave least of a run without a loop that begins as its first samples show."""
    free = whole.as_sensed(fitting.motions).balance(fitting.motions, fitting.names)
    return fit(free, values, fitting.names, fitting.bounds, THOROUGH)


def _along_loops(fitting: Fitting, whole: Shooting, values: Values) -> Iterator[Fit]:
    """Fits beside loops, each weaker than the one before and from where that one ended, of runs that begin as their
    first samples show; until what is left is no longer the loop's.
    """
    sensed, left = whole.as_sensed(fitting.motions), list[float]()
    for crossover in crossovers(whole, fitting.motions, values):
        led = sensed.led(fitting.motions, values, crossover).balance(fitting.motions, fitting.names)
        found = fit(led, values, fitting.names, fitting.bounds, QUICK)
        values = found.values
        left.append(found.rms)
        yield found
        if _are_alike(left):
            break


def _is_lost(left: Sequence[float]) -> bool:
    """Whether loops leave more and more: something is missing that no parameters make up for."""
    return min(left[-PATIENCE:]) > max(min(left), ASTRAY)


def crossovers(whole: Shooting, motions: Sequence[Motion], values: Values) -> Iterator[float]:
    """Those (rad/s) of loops that lead a plant along its records, from the quickest on; none of a plant that is kept
    beside its records, on which no force acts, or which delays its command.
    """
    if whole.is_beside or not whole.takes_a_force or whole.along.plant.delayed:
        return
    yield from weaker(min(whole.quickest(motion, values) for motion in motions), motions)


def weaker(crossover: float, motions: Sequence[Motion]) -> Iterator[float]:
    """This crossover (rad/s) of a loop, and those of weaker and weaker ones."""
    while crossover > WEAKEST / max(float(motion.record.time[-1]) for motion in motions):
        yield crossover
        crossover /= WEAKER


def _are_alike(left: Sequence[float]) -> bool:
    """Whether the last two loops left the same."""
    return len(left) > 1 and abs(left[-1] / left[-2] - 1.0) < ALIKE


def _over_hollows(of: Simulated, fitting: Fitting) -> Values:
    """Values of the parameters that leave less, however rugged the way there is."""
    balance, values = of.how.balance(fitting.motions, ()), of.fit.values
    unknowns = unknowns_of(balance, fitting.names, values, fitting.bounds)
    first, low, high = (np.array([getattr(u, end) for u in unknowns]) for end in ("first", "low", "high"))

    def residuals(places: Sequence[np.ndarray]) -> list[np.ndarray]:
        return stacks(balance, [values_at(values, unknowns, x) for x in places])

    return values_at(values, unknowns, descend(residuals, first, low, high))


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

        for name in fitting.names:
            if name not in (*EITHER_SIGN, *balance.priors) and values[name] > 0.0:
                tried = [{**values, name: factor * values[name]} for factor in FACTORS]
                left = [float(np.mean(np.log1p((one / width) ** 2))) for one in stacks(balance, tried)]
                values = tried[int(np.argmin(left))]
        again = fitting.found(best.how, values)
        if again.fit.rms > BETTER * best.fit.rms:
            break
        best = again
    return best
