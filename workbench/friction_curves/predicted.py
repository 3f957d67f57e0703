"""Measured friction-velocity curves of a rotating rod against what the bristle laws predict of them.

The laws are given the axial set without rotation and the set of pure rotation, and nothing that was measured while the
rod turned and slid. Effects that a law may lack are fitted on some speeds of rotation and checked on the others.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from scipy.optimize import least_squares

from plants import bristles
from plants.anisotropic import Guide
from plants.bristles import BristleLaw
from plants.friction import Friction
from workbench.friction_curves.measured import DIRECTIONS, FASTEST, POINTS, Curve, speeds
from workbench.parameters.sets import build

INDEPENDENT = 4
"""Independent numbers of a curve: it was drawn from as many parameters, so its points are no measurements each."""

NEAR_REST = np.array([1e-9])
"""m/s. In the steady state as good as at rest."""

UNFELT = 1e-6
"""Share of the residual's norm below which a number that doubles is not felt."""

IDENTIFIED = 1.0
"""A fitted number with a standard deviation above this share of it is not identified."""

MOST_NUMBERS = 0.5
"""Share of the independent numbers of the curves that an effect's numbers have to stay below."""

AT_BOUND = 1e-3
"""Share of its range within which a fitted number is at the end of it."""

RESONANT = 100.0
"""rpm at which the thesis reports a resonance."""


@dataclass(frozen=True)
class Prediction:
    """A law with its parameters, under the name by which it is told.

    A resonance takes the share `dip` / (1 + ((rpm - RESONANT) / `width`)^2) off the axial friction.
    """

    name: str
    law: BristleLaw
    parameters: Any
    dip: float = 0.0
    width: float = 10.0

    def steady(self, rpm: float, direction: str, speed: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Steady axial and rotary friction (N, positive) at a speed of rotation (rpm) over axial speed (m/s)."""
        sign = DIRECTIONS[direction]
        along, around = self.law.steady(sign * speed, self.surface_speed(rpm), self.parameters)
        left = 1.0 - self.dip / (1.0 + ((rpm - RESONANT) / self.width) ** 2)
        return left * sign * np.asarray(along), np.asarray(around)

    def surface_speed(self, rpm: float) -> float:
        """Speed (m/s) of the piston's surface at `rpm`."""
        return float(rpm * 2.0 * np.pi / 60.0 * self.parameters.motor.piston_radius)

    def curve(self, rpm: float, direction: str) -> Curve:
        """What it predicts in the place of a measured curve; its static friction is that left as v goes to 0."""
        friction = self.steady(rpm, direction, speeds())[0]
        return Curve(rpm, direction, speeds(), friction, float(self.steady(rpm, direction, NEAR_REST)[0][0]))

    def residual(self, measured: Curve) -> np.ndarray:
        """Measured less predicted friction (N)."""
        return measured.friction - self.steady(measured.rpm, measured.direction, measured.speed)[0]

    def added_slope(self, rpm: float) -> tuple[float, float]:
        """What rotation adds to the slope of friction over velocity (N s/m): at v = 0, and by regression.

        With the forward set for both directions, which `blended` would mix near rest. The regression is a line, with
        its level, over 0 to `FASTEST`.
        """
        along = self.parameters.friction.positive
        forward = replace(self, parameters=self.parameters._replace(friction=Friction(along, along)))
        speed = np.linspace(NEAR_REST[0], FASTEST, POINTS)
        added = forward.steady(rpm, "forward", speed)[0] - along.viscous * speed
        return float(added[0] / speed[0]), float(np.polyfit(speed, added, 1)[0])


def laws(values: Mapping[str, float]) -> list[Prediction]:
    """Every bristle law with one set of parameters, its effects neutral."""
    known = (bristles.HELICAL, bristles.ISOTROPIC, bristles.ANISOTROPIC)
    return [Prediction(law.name, law, build(law.Parameters, values)) for law in known]


def rms(prediction: Prediction, curves: Sequence[Curve]) -> float:
    """Root mean square (N) of the residual over all curves."""
    return float(np.sqrt(np.mean([np.mean(prediction.residual(curve) ** 2) for curve in curves])))


def share(prediction: Prediction, curves: Sequence[Curve]) -> float:
    """The same as a share of the friction's own root mean square."""
    return rms(prediction, curves) / float(np.sqrt(np.mean([np.mean(curve.friction**2) for curve in curves])))


@dataclass(frozen=True)
class Effect:
    """What the law may lack: how its numbers (SI; widths in rpm) enter, where they start, and may lie."""

    name: str
    numbers: tuple[str, ...]
    start: tuple[float, ...]
    least: tuple[float, ...]
    most: tuple[float, ...]
    apply: Callable[[Prediction, Sequence[float]], Prediction]

    def __add__(self, other: "Effect") -> "Effect":
        split = len(self.numbers)
        return Effect(
            f"{self.name} and {other.name}",
            self.numbers + other.numbers,
            self.start + other.start,
            self.least + other.least,
            self.most + other.most,
            lambda law, x: other.apply(self.apply(law, x[:split]), x[split:]),
        )


FILM = Effect(  # its speed cannot be told from curves at 25 rpm and more: at such speeds the film is there
    "film",
    ("film_share",),
    (0.8,),
    (0.05,),
    (1.5,),
    lambda law, x: replace(law, parameters=law.parameters._replace(film=law.parameters.film._replace(film_share=x[0]))),
)
GUIDE = Effect(
    "guide",
    ("guide_coulomb",),
    (10.0,),
    (0.0,),
    (200.0,),
    lambda law, x: replace(law, parameters=law.parameters._replace(guide=Guide(x[0]))),
)
STRIBECK_GUIDE = Effect(
    "guide with Stribeck part",
    ("guide_coulomb", "guide_stribeck", "guide_stribeck_velocity"),
    (10.0, 30.0, 0.003),
    (0.0, 0.0, 0.0005),
    (200.0, 200.0, 0.02),
    lambda law, x: replace(law, parameters=law.parameters._replace(guide=Guide(*x))),
)
RESONANCE = Effect(
    "resonance",
    ("dip", "width"),
    (0.05, 10.0),
    (0.0, 1.0),
    (1.0, 25.0),
    lambda law, x: replace(law, dip=x[0], width=x[1]),
)
CANDIDATES = (
    FILM,
    GUIDE,
    STRIBECK_GUIDE,
    RESONANCE,
    FILM + GUIDE,
    FILM + STRIBECK_GUIDE,
    FILM + RESONANCE,
    FILM + GUIDE + RESONANCE,
)


@dataclass(frozen=True)
class Fitted:
    """The law with an effect in it; each number with the standard deviation that the curves give it, and the price.

    A number that the curves cannot tell from another, or at all, has an infinite deviation; `at_bound` names those at
    an end of what they may be. `price` is Schwarz's criterion n ln(rms^2) + k ln(n), with `INDEPENDENT` numbers a
    curve: lower is better, and each of the k fitted numbers has its price.
    """

    effect: Effect | None
    prediction: Prediction
    numbers: dict[str, tuple[float, float]]
    price: float
    at_bound: frozenset[str] = frozenset()

    def is_identified(self, name: str) -> bool:
        """Whether the curves tell the number of this name."""
        value, std = self.numbers[name]
        return name not in self.at_bound and std < IDENTIFIED * abs(value)

    @property
    def identified(self) -> bool:
        """Whether the curves tell all of them."""
        return all(map(self.is_identified, self.numbers))


def _price(prediction: Prediction, curves: Sequence[Curve], count: int) -> float:
    size = INDEPENDENT * len(curves)
    return float(size * np.log(rms(prediction, curves) ** 2) + count * np.log(size))


def unchanged(base: Prediction, curves: Sequence[Curve]) -> Fitted:
    """A law as it is, with nothing fitted."""
    return Fitted(None, base, {}, _price(base, curves, 0))


def fit(base: Prediction, effect: Effect, curves: Sequence[Curve]) -> Fitted:
    """Least squares of an effect's numbers on measured curves.

    In the standard deviations a curve counts as `INDEPENDENT` points.
    """

    def residuals(numbers: np.ndarray) -> np.ndarray:
        changed = effect.apply(base, numbers.tolist())
        return np.concatenate([changed.residual(curve) for curve in curves])

    bounds = (effect.least, effect.most)
    solution = least_squares(residuals, effect.start, bounds=bounds, x_scale=np.abs(effect.start))
    size = INDEPENDENT * len(curves)
    freedom = max(size - len(effect.start), 1)
    weight = size / solution.fun.size
    variance = weight * float(solution.fun @ solution.fun) / freedom
    deviations = np.sqrt(np.diag(np.linalg.pinv(weight * solution.jac.T @ solution.jac) * variance))
    scaled = solution.jac * np.abs(effect.start)
    felt = np.linalg.norm(scaled, axis=0) > UNFELT * np.linalg.norm(solution.fun)
    deviations[~felt | _confused(scaled)] = np.inf
    found = dict(zip(effect.numbers, zip(solution.x.tolist(), deviations.tolist(), strict=True), strict=True))
    changed = replace(effect.apply(base, solution.x.tolist()), name=f"{base.name}, {effect.name}")
    least, most = np.array(effect.least), np.array(effect.most)
    ends = np.minimum(solution.x - least, most - solution.x) < AT_BOUND * (most - least)
    at_bound = frozenset(name for name, end in zip(effect.numbers, ends, strict=True) if end)
    return Fitted(effect, changed, found, _price(changed, curves, len(effect.start)), at_bound)


def _confused(jacobian: np.ndarray) -> np.ndarray:
    """Of each column whether others can stand in for it: it has a part in a direction without effect."""
    _, sizes, directions = np.linalg.svd(jacobian, full_matrices=False)
    unseen = directions[sizes <= UNFELT * sizes[0]]
    return np.asarray(np.any(np.abs(unseen) > UNFELT**0.5, axis=0))


def affordable(one: Fitted, curves: Sequence[Curve]) -> bool:
    """Whether an effect has fewer numbers than half the independent ones of the curves that it was fitted to."""
    return len(one.numbers) < MOST_NUMBERS * INDEPENDENT * len(curves)


def supported(base: Prediction, curves: Sequence[Curve]) -> tuple[Fitted, list[Fitted]]:
    """The candidate with the lowest price on these curves, the bare law among them; and all candidates fitted.

    One with a number that is not identified, or with too many, is never chosen, however cheap.
    """
    fitted = [fit(base, effect, curves) for effect in CANDIDATES]
    choice = [one for one in fitted if one.identified and affordable(one, curves)]
    return min([unchanged(base, curves), *choice], key=lambda one: one.price), fitted
