"""What simulations that change a little are off by: to first order, where that is right and pays, else by simulations
of their own.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import lru_cache
from typing import TYPE_CHECKING

import numpy as np

from plants.effects.attach import possible
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.simulation.together import Asked, Push, errors_of
from workbench.diagnose.simulation.variations import Varied
from workbench.fitting.threads import side_by_side

if TYPE_CHECKING:
    from workbench.diagnose.simulation.shooting import Shooting

WORTH = 16
"""Changes from which it pays to find how a simulation answers."""

REMEMBERED = 4
"""Simulations of which it is remembered how they answer: one of each record of a fit. Of more records none is asked: it
would be found anew each time.
"""


def errors_near(
    how: "Shooting", values: Values, asked: Sequence[Asked], than: Values | None = None, least: int = WORTH
) -> list[list[np.ndarray]]:
    """What each of these is off by, as `errors_of` has it: to first order beside simulations with `values` that answer,
    along records of which at `least` so many are asked for, where the plant remembers as much, and no command comes
    later, which would change within samples. These may be of a plant that is more, and that does as much with the
    values `than`.
    """
    kinds: dict[Motion, list[Asked]] = {}
    remembered = _remembered(how, values)
    for one in asked:
        if _remembered(one.how, one.values) == remembered and how.along.late(one.values) == how.along.late(values):
            kinds.setdefault(one.motion, []).append(one)
    many = {motion: several for motion, several in kinds.items() if len(several) >= least}
    found = dict[Asked, list[np.ndarray]]()
    for varied in _answering(how, list(many), values):
        several = many[varied.asked.motion]
        (off,) = errors_of([varied.asked])
        changes = varied.having(several[0].how, [one.values for one in several], values if than is None else than)
        found |= {one: list(map(np.add, off, own)) for one, own in zip(several, changes, strict=True)}
    rest = [one for one in asked if one not in found]
    found |= zip(rest, errors_of(rest), strict=True)
    return [found[one] for one in asked]


def errors_pushed(
    how: "Shooting", motions: Sequence[Motion], values: Values, pushes: Sequence[Push]
) -> list[list[list[np.ndarray]]]:
    """The same of simulations with each of these pushes, all on the mass or all on the command, along each record."""
    found = dict[tuple[Motion, Push], list[np.ndarray]]()
    for varied in _answering(how, motions, values):
        motion, (off,) = varied.asked.motion, errors_of([varied.asked])
        changes = varied.pushed([push.series[motion.record] for push in pushes], pushes[0].on_command)
        found |= {(motion, push): list(map(np.add, off, own)) for push, own in zip(pushes, changes, strict=True)}
    rest = [(motion, push) for push in pushes for motion in motions if (motion, push) not in found]
    asked = [Asked(replace(how, push=push), motion, values) for motion, push in rest]
    found |= zip(rest, errors_of(asked), strict=True)
    return [[found[motion, push] for motion in motions] for push in pushes]


def _answering(how: "Shooting", motions: Sequence[Motion], values: Values) -> list[Varied]:
    """The simulations along these motions that answer."""
    if len(motions) > REMEMBERED:
        return []
    found = side_by_side(_varied, [Asked(how, motion, values) for motion in motions])
    return [one for one in found if one is not None]


def _remembered(how: "Shooting", values: Values) -> dict[str, float]:
    """The numbers of those effects that remember what was: what stays between two flanks depends on where these are."""
    acting, able = how.along.acts(values), possible(how.along.plant)
    own = [effect.own_names for effect in able if effect.remember is not None and effect.name in acting]
    return {name: values[name] for names in own for name in names if name in values}


@lru_cache(REMEMBERED)
def _varied(asked: Asked) -> Varied | None:
    """`Varied.of`, remembered."""
    return Varied.of(asked)
