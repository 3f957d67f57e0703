"""What a record leaves of the balances of the plant at hand, of flow and of force: of the right one noise."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from plants.equation import fields, to_array
from plants.interface import Plant
from workbench.diagnose.residuals.balances import Diagnosed, allowed, residuals_of
from workbench.diagnose.residuals.motion import Motion, motion_of
from workbench.records.reading import Record
from workbench.simulation.setup import Setup

KEPT = 8
"""Records that stay smoothed, and plants that stay prepared, for the next run beside them."""


@dataclass(frozen=True, eq=False)
class Left:
    """The residuals of a balance over time (s), one for each of its rates, in `unit`; NaN where nothing is known."""

    time: np.ndarray
    residuals: list[np.ndarray]
    unit: str


def balances_left(record: Record, flow: str, setup: Setup) -> Mapping[str, Left]:
    """The balances that a record's channels allow, for a plant with its parameters; `flow` is its law of flow."""
    motion = _motion(record)
    names = [item.name for item in fields(setup.plant.Parameters)]
    values = dict(zip(names, to_array(setup.parameters).tolist(), strict=True))
    thin = motion.thinned
    known = thin.valid & ~thin.blurred
    return {
        item.name: Left(
            thin.time,
            [np.where(known, residual, np.nan) for residual in residuals_of(item, motion, values)],
            item.along.plant.balances[item.name].unit,
        )
        for item in _allowed(setup.plant, flow, tuple(motion.channels))
    }


@lru_cache(maxsize=KEPT)
def _motion(record: Record) -> Motion:
    return motion_of(record)


@lru_cache(maxsize=KEPT)
def _allowed(plant: Plant, flow: str, channels: tuple[str, ...]) -> list[Diagnosed]:
    return allowed(plant, flow, channels)
