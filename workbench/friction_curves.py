"""Measured friction-velocity curves of a rotating rod against what the bristle laws predict of them.

The laws are given the axial set without rotation and the set of pure rotation, and nothing that was measured while the
rod turned and slid. Effects that a law may lack are fitted on some speeds of rotation and checked on the others.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from pydantic import Field
from scipy.optimize import least_squares

from plants import bristles
from plants.anisotropic import Film, Guide
from plants.bristles import BristleLaw
from plants.friction import LuGre, steady_friction
from workbench import files
from workbench.parameters import build

SLOWEST, FASTEST, POINTS = 0.6e-3, 11.4e-3, 200
"""m/s. Range of the measured curves: below it the thesis takes the contact for one at rest (4.9)."""

DIRECTIONS = {"forward": 1.0, "backward": -1.0}


class DirectionTable(files.Strict):
    """Means of the static parameters in one direction of motion, in SI, an entry for each speed of rotation."""

    coulomb: list[float]
    static: list[float]
    viscous: list[float]
    viscous_std: list[float]
    stribeck_velocity: list[float]


class CurveFile(files.Strict):
    """A file of measured static parameters: see studies/measured/owen2001_friction.toml."""

    title: str
    source: str
    rpm: list[float] = Field(min_length=2)
    forward: DirectionTable
    backward: DirectionTable


@dataclass(frozen=True)
class Curve:
    """Friction (N, positive) over speed (m/s) along, measured at a speed of rotation."""

    rpm: float
    direction: str
    speed: np.ndarray
    friction: np.ndarray


def read_curves(path: Path) -> list[Curve]:
    """The measured curves of a file, a0 + a1 exp(-(v/v_s)^2) + a2 v (thesis 4.7).

    Raises:
        UserError: the file is not one of measured static parameters.
    """
    text = files.read_text(path)
    content = files.validate(CurveFile, files.parse_toml(path, text), path, text)
    speed = np.linspace(SLOWEST, FASTEST, POINTS)
    found = []
    for direction in DIRECTIONS:
        table: DirectionTable = getattr(content, direction)
        for i, rpm in enumerate(content.rpm):
            law = LuGre(
                table.coulomb[i],
                table.static[i] - table.coulomb[i],
                table.viscous[i],
                table.stribeck_velocity[i],
                0.0,
                0.0,
            )
            found.append(Curve(rpm, direction, speed, np.asarray(steady_friction(speed, law))))
    return found


def without_rotation(values: Mapping[str, float]) -> list[Curve]:
    """The curves of the axial set itself, at rpm 0."""
    friction = build(bristles.ANISOTROPIC.Parameters, values).friction
    speed = np.linspace(SLOWEST, FASTEST, POINTS)
    laws = {"forward": friction.positive, "backward": friction.negative}
    return [Curve(0.0, name, speed, np.asarray(steady_friction(speed, law))) for name, law in laws.items()]


@dataclass(frozen=True)
class Prediction:
    """A law with its parameters, under the name by which it is told."""

    name: str
    law: BristleLaw
    parameters: Any

    def friction(self, rpm: float, direction: str, speed: np.ndarray) -> np.ndarray:
        """Steady axial friction (N, positive) at a speed of rotation (rpm) over axial speed (m/s)."""
        surface = rpm * 2.0 * np.pi / 60.0 * self.parameters.motor.piston_radius
        sign = DIRECTIONS[direction]
        return np.asarray(sign * self.law.steady(sign * speed, surface, self.parameters)[0])

    def residual(self, curve: Curve) -> np.ndarray:
        """Measured less predicted friction (N)."""
        return curve.friction - self.friction(curve.rpm, curve.direction, curve.speed)


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
    """What the anisotropic law may lack: how its numbers enter the parameters, where they start and may lie (SI)."""

    name: str
    numbers: tuple[str, ...]
    start: tuple[float, ...]
    least: tuple[float, ...]
    most: tuple[float, ...]
    apply: Callable[[Any, Sequence[float]], Any]


FILM = Effect(
    "film",
    ("film_share", "film_speed"),
    (0.8, 0.05),
    (0.05, 0.012),
    (1.5, 1.0),
    lambda p, x: p._replace(film=Film(x[0], x[1])),
)
GUIDE = Effect(
    "guide",
    ("guide_coulomb", "guide_stribeck", "guide_stribeck_velocity"),
    (10.0, 30.0, 0.003),
    (0.0, 0.0, 0.0005),
    (200.0, 200.0, 0.02),
    lambda p, x: p._replace(guide=Guide(x[0], x[1], x[2])),
)
FILM_AND_GUIDE = Effect(
    "film and guide",
    FILM.numbers + GUIDE.numbers,
    FILM.start + GUIDE.start,
    FILM.least + GUIDE.least,
    FILM.most + GUIDE.most,
    lambda p, x: GUIDE.apply(FILM.apply(p, x[:2]), x[2:]),
)
EFFECTS = (FILM, GUIDE, FILM_AND_GUIDE)


@dataclass(frozen=True)
class Fitted:
    """The law with an effect in it; each number (SI) with the standard deviation that the curves give it."""

    prediction: Prediction
    numbers: dict[str, tuple[float, float]]


def fit(base: Prediction, effect: Effect, curves: Sequence[Curve]) -> Fitted:
    """Least squares of an effect's numbers on measured curves.

    The points of a curve are not independent, since each was drawn from four parameters: in the standard deviations it
    counts as four points.
    """

    def residuals(numbers: np.ndarray) -> np.ndarray:
        changed = Prediction(effect.name, base.law, effect.apply(base.parameters, numbers.tolist()))
        return np.concatenate([changed.residual(curve) for curve in curves])

    bounds = (effect.least, effect.most)
    solution = least_squares(residuals, effect.start, bounds=bounds, x_scale=np.abs(effect.start))
    weight = 4.0 * len(curves) / solution.fun.size
    freedom = max(4 * len(curves) - len(effect.start), 1)
    variance = weight * float(solution.fun @ solution.fun) / freedom
    covariance = np.linalg.pinv(weight * solution.jac.T @ solution.jac) * variance
    deviations = np.sqrt(np.diag(covariance))
    named = {
        name: (float(value), float(std))
        for name, value, std in zip(effect.numbers, solution.x, deviations, strict=True)
    }
    label = f"{base.name}, {effect.name}"
    return Fitted(Prediction(label, base.law, effect.apply(base.parameters, solution.x.tolist())), named)
