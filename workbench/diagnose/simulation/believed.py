"""What of that which a search found is believed: effects that stand in for something else are not named."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.diagnose.residuals.fit import NEAR_NOISE, Fit
from workbench.diagnose.selection.likelihood import gained, left_by
from workbench.diagnose.selection.search import LEVEL, Found
from workbench.diagnose.selection.sets import Asked, fitted_without
from workbench.diagnose.selection.unexplained import Dependence
from workbench.diagnose.simulation.fits import NOISE
from workbench.diagnose.simulation.lacking import Lacking, dependence_of, lacking
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.stand_ins import Place, standing_in

STRONG = 10.0
"""Times that effects gain more than what is left beside them says, and take away more than they leave, from which they
are named beside it."""

MANY = 3
"""Effects that together are less likely than one that nobody knows, if something is left beside them."""


def believed(how: Shooting, found: Found, without: Fit, ask: Asked) -> tuple[Found, Dependence | None]:
    """What was found, and on what depends that which no effect explains. Nothing is found where something is left
    beside many effects, or more than one of them gains, but for strong ones; or where one curve in their place loses
    nothing; nor where one curve beside the plant without them is likelier than they are, whatever is left. `without` is
    the fit without.
    """
    pushes = lacking(how, found.fit)
    lacks = dependence_of(pushes)
    if not found.effects:
        return found, lacks
    cost = sum(ask.of(effect, names, found.fit.balance) for effect, names in found.effects.items())
    place = Place.of(found.fit, found.effects, 0.5 * (without.squares - found.fit.squares), ask)
    instead = standing_in(how, place, pushes, cost if lacks is None else None)
    if instead or (lacks is not None and _is_more(lacks, found)):
        strong = None if instead or lacks is None else strong_of(found, lacks, without, ask)
        if strong is not None:
            return strong, dependence_of(lacking(how, strong.fit))
        return _nothing(found, without), dependence_of(instead or lacking(how, without)) or lacks
    if without.excess < NEAR_NOISE:  # farther off first order is no guide
        plain = ask.settled(without)
        alone, beside = lacking(how, plain), _net(pushes) if lacks is not None else 0.0
        gain = gained(found.fit.balance, left_by(found.fit), left_by(plain))
        if _net(alone) > gain - cost + beside + LEVEL:
            return _nothing(found, plain), dependence_of(alone)
    return found, lacks


def _is_more(lacks: Dependence, found: Found) -> bool:
    """Whether what is left says more than what was found does, which then stands in for it."""
    least = min(found.gains[effect] for effect in found.effects)
    return len(found.effects) >= MANY or (lacks.gain is not None and lacks.gain > least)


def strong_of(found: Found, lacks: Dependence, without: Fit, ask: Asked) -> Found | None:
    """What was found with the fewest effects, of those that gain far more than what is left says, that bring the plant
    from far off to noise by themselves; None if none do, or all are needed.
    """
    assert lacks.gain is not None  # a simulated plant's
    gains = {effect: gain for effect, gain in found.gains.items() if gain > STRONG * lacks.gain}
    ordered = sorted(gains, key=lambda effect: -gains[effect])
    for count in range(1, min(len(ordered), len(found.effects) - 1) + 1):
        weak = tuple(effect for effect in found.effects if effect not in ordered[:count])
        alone = ask.settled(fitted_without(found.fit, found.effects, weak, ask))
        if alone.excess < NOISE and without.excess > STRONG * alone.excess:
            kept = {effect: own for effect, own in found.effects.items() if effect not in weak}
            return replace(
                found,
                fit=alone,
                effects=kept,
                gains={effect: gains[effect] for effect in kept},
                alternatives={effect: found.alternatives[effect] for effect in kept},
            )
    return None


def _net(curves: Sequence[Lacking]) -> float:
    """What the best of some curves gains beyond what is asked of it."""
    return max((curve.gain - curve.asked for curve in curves), default=-np.inf)


def _nothing(found: Found, without: Fit) -> Found:
    """A search that found nothing, whose fit is that `without` effects."""
    return replace(found, fit=without, effects={}, gains={}, alternatives={})
