"""Effects compete for what the simulated plant leaves of the records; idle ones are dropped."""

from collections.abc import Mapping, Sequence

from plants.equation import NEGATIVE
from workbench.diagnose.residuals.fit import Fit, fit
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.selection.selection import (
    ANEW,
    AT_FLOOR,
    LEAST_GAIN,
    MOST,
    SURE,
    Candidate,
    Step,
    beside,
    gain,
    round_of,
)
from workbench.diagnose.simulation.fits import polished
from workbench.diagnose.simulation.promising import EXPLAINS, QUICK, explained, promising
from workbench.parameters.sets import NEUTRAL
from workbench.progress import Progress

PLAINLY = 1.0
"""Times the mean square by which it has to rise without an effect, to first order, that no fit has to be made without
it: that fit would be long, since nothing fits."""

TOLERATED = 0.02
"""Share by which the size of a declared effect may be off: nobody declares it more exactly."""

Effects = Mapping[str, tuple[str, ...]]
"""Effects by name, with their parameters."""


def add_effects(
    start: Fit,
    effects: Effects,
    declared: Values,
    free: Sequence[str],
    bounds: Mapping[str, tuple[float, float]],
    progress: Progress,
) -> tuple[Fit, Effects, list[Step]]:
    """Add effects one by one until none passes, from the plant as it is `declared`, with its own parameters `free`."""
    own = {name: declared[name] for name in free}
    current, named, steps, anew = start, dict(effects), list[Step](), 0
    while current.rms > AT_FLOOR and len(named) < MOST:
        progress(f"what the simulated plant lacks, round {len(steps) + 1}", 0.85 - 0.35 * 0.5 ** len(steps))
        candidates = promising(current, named, bounds)
        passing = [one for one in candidates if _passes(current, one, named) and _is_sized_anew(one, declared)]
        if passing and anew < ANEW and (better := beside(current, passing[0].fit, bounds, QUICK)) is not current:
            current, anew = better, anew + 1
            continue
        anew = 0
        steps.append(round_of(current, candidates, passing))
        added = steps[-1].added
        if added is None:
            break
        named[added.effect] = tuple(dict.fromkeys([*named.get(added.effect, ()), *added.variant]))
        progress(f"the plant with {added.effect}, simulated", 0.85 - 0.25 * 0.5 ** len(steps))
        current = polished(added.fit, own, bounds)
    return current, named, steps


def without_idle(
    current: Fit, effects: Effects, declared: Values, bounds: Mapping[str, tuple[float, float]], progress: Progress
) -> tuple[Fit, Effects, list[str]]:
    """Drop effects without which the rest does as well, the last first; returns which."""
    known = {**NEUTRAL, **declared}
    dropped = []
    for effect in list(reversed(list(effects))) if len(effects) > 1 else []:
        own = effects[effect]
        neutral = {name: _neutral(name, current.values, known) for name in own}
        if current.rise_without(neutral) > PLAINLY * current.rms**2:
            continue
        progress(f"the plant without {effect}", 0.85)
        names = [name for name in current.names if name not in own]
        values = {name: value for name, value in current.values.items() if name not in own}
        values |= {name: known[name] for name in own if name in known}
        fitted = fit(current.balance, values, names, bounds, QUICK)
        if gain(fitted, current)[0] < LEAST_GAIN:
            current, effects = fitted, {name: numbers for name, numbers in effects.items() if name != effect}
            dropped.append(effect)
    return current, effects, dropped


def _passes(before: Fit, candidate: Candidate, named: Effects) -> bool:
    """Whether an effect explains enough; a further parameter of one that is there has to be worth its price alone."""
    share, sure = gain(before, candidate.fit)
    enough = candidate.effect in named or explained(before, candidate.fit) > EXPLAINS
    estimated = not candidate.fit.bounded - set(before.balance.free)
    return share > LEAST_GAIN and sure > SURE and enough and estimated


def _is_sized_anew(candidate: Candidate, declared: Values) -> bool:
    """Whether the plant is declared without an effect, or with another size of it."""
    sizes = {name: declared.get(name, 0.0) for name in candidate.variant}
    return any(
        size in (0.0, NEUTRAL.get(name, 0.0)) or abs(candidate.fit.values[name] / size - 1.0) > TOLERATED
        for name, size in sizes.items()
    )


def _neutral(name: str, values: Values, known: Values) -> float:
    """The value at which an effect's parameter does nothing: of one direction that of the other."""
    plain = name.removesuffix(f"_{NEGATIVE}")
    return values[plain] if plain != name else known.get(name, 0.0)
