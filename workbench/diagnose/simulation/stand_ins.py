"""Whether what was found stands in for something that no effect is: one curve in its place.

A push that follows a recorded signal (`lacking`) is judged to first order beside the fit with the effects, whose
numbers go to where they do nothing. A curve over what the plant itself does (`plants.effects.curves`) may take over
from an effect, however strong, with nothing else changed along the way: there first order leads to where it is fitted.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from plants.effects.curves import NODES
from plants.effects.interface import Effect
from plants.equation import NEGATIVE
from workbench.diagnose.residuals.fit import QUICK, Fit, fit
from workbench.diagnose.residuals.motion import signals_of
from workbench.diagnose.selection.likelihood import asked, gained, left_by
from workbench.diagnose.selection.search import LEVEL
from workbench.diagnose.selection.selection import Effects
from workbench.diagnose.selection.sets import Asked, away_of, declared_again
from workbench.diagnose.simulation.fits import settle
from workbench.diagnose.simulation.lacking import CERTAIN, Lacking
from workbench.diagnose.simulation.own_curves import OwnCurve, curves_of, flat_curve, simulated_motion
from workbench.diagnose.simulation.shooting import Shooting
from workbench.fitting.least_squares import bounded_minimum
from workbench.fitting.threads import side_by_side

NEARLY, FITTED = 0.1, 2
"""Share of what effects gain that a curve may lose in their place, to first order, and be fitted there; and how many
are, at most."""

HIGHEST = 3.0
"""Times the largest value of a curve to which first order leads, beyond which none of its values goes: a search in far
too steep ones takes minutes."""

SMALL = 50.0
"""Gain of effects up to which first order tells what a curve loses in their place: it is then within ten standard
deviations of noise."""

UNSEEN = 1e-3
"""Of what that number of a curve changes that shows most, below which another stays where it is: a record that is
nearly never there says nothing of it."""

PROMISED = 0.5
"""Share of what a curve has to gain that a push gains beside the effects where it is worth looking for one: beside them
a curve gains no less than in their place."""


def standing_in(how: Shooting, place: "Place", pushes: Sequence[Lacking], price: float | None) -> list[Lacking]:
    """Curves each of which does in the place of all effects that were found, from the best.

    A curve loses likelihood there. It has to be likelier than the effects, with what is asked of it and with their
    `price`, by odds that data can tell; if `price` is None it has to lose nothing: where something is left beside the
    effects what they cost decides nothing.
    """

    def told(curve: Lacking, lost: float) -> Lacking:
        more = 0.0 if price is None else curve.asked - price + LEVEL
        return replace(curve, gain=place.worth - lost, asked=place.worth + more)

    curves = [told(push, place.without(place.found.weighing(push.columns))[0]) for push in pushes]
    curves += [told(*pair) for pair in _fitted(how, place, pushes, np.inf if price is None else price)]
    return sorted((one for one in curves if one.is_certain), key=lambda one: one.asked - one.gain)


def _fitted(how: Shooting, place: "Place", pushes: Sequence[Lacking], price: float) -> list[tuple[Lacking, float]]:
    """Curves of the plant's own that come near the effects, fitted in their place, each with what it loses there."""
    found, plant = place.found, how.along.plant
    offers = curves_of(plant)
    certain = CERTAIN * asked(NODES, 2 * max(len(offers), 1))
    if PROMISED * (certain - price) > max((push.gain for push in pushes), default=0.0):
        return []
    along = [signals_of(simulated_motion(how, motion, found)) for motion in found.balance.motions]

    def flat(offer: tuple[str, Effect]) -> OwnCurve:
        return flat_curve(how, found, *offer, along)

    curves = side_by_side(flat, [offer for offer in offers if all(offer[0] in signals for signals in along)])
    ordered = sorted(
        ((*place.without(found.weighing(curve.changed)), curve) for curve in curves), key=lambda one: one[0]
    )
    whole = place.without(np.zeros((found.residual.size, 0)))[0]
    near = [one for one in ordered[:FITTED] if one[0] < NEARLY * whole]

    def lost(by_first_order: float, x: np.ndarray, curve: OwnCurve) -> float:
        if place.worth < SMALL:
            return by_first_order
        return -gained(found.balance, left_by(place.taken_by(curve, x)), left_by(found))

    told = [Lacking(curve.balance, curve.signal, 0.0, certain, curve.changed) for _, _, curve in near]
    return list(zip(told, side_by_side(lambda one: lost(*one), near), strict=True))


@dataclass(frozen=True, eq=False)
class Place:
    """The place of effects beside a fit, whose names are in `taken` and which are `worth` so much in the logarithm of
    the likelihood: which of its unknowns are the plant's own, what they change, what is known of them before any
    record and how that pulls them, and what is left without the effects (weighed).
    """

    found: Fit
    taken: frozenset[str]
    worth: float
    ask: Asked
    own: Sequence[int]
    changes: np.ndarray
    known: np.ndarray
    pull: np.ndarray
    left: np.ndarray

    @classmethod
    def of(cls, found: Fit, taken: Effects, worth: float, ask: Asked) -> "Place":
        """The place of these effects."""
        names = frozenset(name for numbers in taken.values() for name in numbers)
        jacobian, places = found.jacobian * found.free, {u.name: i for i, u in enumerate(found.unknowns)}
        away: dict[int, float] = {}
        for numbers in taken.values():
            away |= away_of(found, numbers, ask)
        left = found.weighed + jacobian[:, list(away)] @ np.array(list(away.values()))
        for name in names & set(places):  # what has a value of its own in this direction has that of the other again
            plain = name.removesuffix(f"_{NEGATIVE}")
            if plain != name and plain in places:
                jacobian[:, places[plain]] += jacobian[:, places[name]]
        own = [i for name, i in places.items() if name not in names]
        return cls(found, names, worth, ask, own, jacobian[:, own], found.known[own], found.pull[own], left)

    def without(self, columns: np.ndarray) -> tuple[float, np.ndarray]:
        """Likelihood (its logarithm) that is lost with columns (weighed) in the effects' place, to first order, and how
        far the plant's own unknowns and the columns' numbers then go.
        """
        stack, count = np.column_stack([self.changes, columns]), len(self.own)
        curvature = stack.T @ stack
        curvature[:count, :count] += np.diag(self.known)
        nodes = np.arange(count, stack.shape[1])
        curvature[nodes, nodes] += UNSEEN**2 * float(np.max(curvature[nodes, nodes], initial=0.0))
        wide = np.full(stack.shape[1], np.inf)
        slope = stack.T @ self.left
        slope[:count] += self.pull
        x = bounded_minimum(curvature, slope, -wide, wide)
        rest, moved = self.left + stack @ x, x[:count]
        vaguer = float(self.pull @ moved + 0.5 * self.known @ moved**2)
        return 0.5 * float(rest @ rest - self.found.weighed @ self.found.weighed) + vaguer, x

    def taken_by(self, curve: OwnCurve, x: np.ndarray) -> Fit:
        """The plant with a curve in the effects' place, from where first order leads: `x` as from `without`."""
        found, ask, count = self.found, self.ask, len(self.own)
        moved = found.places.copy()
        moved[self.own] += x[:count]
        low, high = (np.array([getattr(u, end) for u in found.unknowns]) for end in ("low", "high"))
        values = declared_again(found.at(np.clip(moved, low, high)), self.taken, ask.declared)
        own = {name: value for name, value in curve.flat.items() if name not in found.values}
        own |= dict(zip(curve.nodes, (curve.size * x[count:]).tolist(), strict=True))
        names = [*(found.unknowns[i].name for i in self.own), *curve.nodes]
        highest = HIGHEST * max(abs(own[name]) for name in curve.nodes)
        bounds = {**ask.bounds, **dict.fromkeys(curve.nodes, (-highest, highest))}
        balance = curve.how.balance(found.balance.motions, names)
        fitted = fit(balance, {**values, **own}, names, bounds, QUICK, found.weighing)
        return settle(curve.how, balance.motions, fitted, bounds)
