"""Measured friction-velocity curves: read from a file of static parameters, which they were drawn from."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from pydantic import Field

from plants.bristles import AnisotropicParameters
from plants.friction import LuGre, steady_friction
from workbench.parameters.sets import build
from workbench.records.friction import SLIDING
from workbench.toml import reading as files

FASTEST, POINTS = 11.4e-3, 200
"""m/s. What the thesis's quasi-static runs reach, from `SLIDING` on; points of a curve."""

DIRECTIONS = {"forward": 1.0, "backward": -1.0}

LARGEST_STRIBECK_VELOCITY = 0.1
"""m/s. A larger one is in another unit: lubricated contacts have some mm/s."""


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
    rpm: list[float] = Field(min_length=1)
    forward: DirectionTable
    backward: DirectionTable


@dataclass(frozen=True, eq=False)
class Curve:
    """Friction (N, positive) over speed (m/s) along, at a speed of rotation; `static` is its a0 + a1 (N)."""

    rpm: float
    direction: str
    speed: np.ndarray
    friction: np.ndarray
    static: float

    def at(self, speed: float) -> float:
        """Friction (N) at a speed (m/s)."""
        return float(np.interp(speed, self.speed, self.friction))


def speeds() -> np.ndarray:
    """Speeds (m/s) at which curves are known."""
    return np.linspace(SLIDING, FASTEST, POINTS)


def read_curves(path: Path) -> list[Curve]:
    """The measured curves of a file, a0 + a1 exp(-(v/v_s)^2) + a2 v (thesis 4.7).

    Raises:
        UserError: the file is not one of measured static parameters.
    """
    data, text = files.read_toml(path)
    content = files.validate(CurveFile, data, path, text)
    found = []
    _check_rpm(content, path, text)
    for direction in DIRECTIONS:
        table: DirectionTable = getattr(content, direction)
        _check_direction(table, direction, content.rpm, path, text)
        for i, rpm in enumerate(content.rpm):
            stribeck = table.static[i] - table.coulomb[i]
            law = LuGre(table.coulomb[i], stribeck, table.viscous[i], table.stribeck_velocity[i], 0.0, 0.0)
            found.append(_curve(rpm, direction, law))
    return found


def _check_rpm(content: CurveFile, path: Path, text: str) -> None:
    """Raise UserError unless the speeds of rotation are above 0 and ascend."""
    for before, rpm in zip([0.0, *content.rpm], content.rpm, strict=False):
        if rpm <= before:
            told = f"got {rpm:g} behind {before:g}" if before else f"got {rpm:g}, what is measured without rotation is"
            hint = "expected each once, ascending" if before else "in the parameter set: expected more than 0"
            raise files.at(path, text, ("rpm",), f"{told}{':' if before else ''} {hint}")


def _check_direction(table: DirectionTable, direction: str, rpm: Sequence[float], path: Path, text: str) -> None:
    """Raise UserError for the first entry that a contact cannot have."""
    for name in DirectionTable.model_fields:
        values, key = getattr(table, name), (direction, name)
        if len(values) != len(rpm):
            message = f"holds {len(values)} values, expected one for each of the {len(rpm)} rpm"
            raise files.at(path, text, key, message)
        for speed, value in zip(rpm, values, strict=True):
            got = f"got {value:g} at {speed:g} rpm, expected"
            if value < 0.0:
                raise files.at(path, text, key, f"{got} a value that is not negative")
            if name == "stribeck_velocity" and not 0.0 < value <= LARGEST_STRIBECK_VELOCITY:
                fix = f" ({value:g} mm/s is {1e-3 * value:g})" if value else ""
                raise files.at(path, text, key, f"{got} m/s, above 0 and at most {LARGEST_STRIBECK_VELOCITY:g}{fix}")
    for speed, static, coulomb in zip(rpm, table.static, table.coulomb, strict=True):
        if static < coulomb:
            message = f"got {static:g} N at {speed:g} rpm, below coulomb of {coulomb:g} N: expected at least that"
            raise files.at(path, text, (direction, "static"), message)


def _curve(rpm: float, direction: str, law: LuGre) -> Curve:
    friction = np.asarray(steady_friction(speeds(), law))
    return Curve(rpm, direction, speeds(), friction, law.coulomb + law.stribeck)


def without_rotation(values: Mapping[str, float]) -> list[Curve]:
    """The curves of the axial set itself, at rpm 0."""
    friction = build(AnisotropicParameters, values).friction
    laws = {"forward": friction.positive, "backward": friction.negative}
    return [_curve(0.0, name, law) for name, law in laws.items()]
