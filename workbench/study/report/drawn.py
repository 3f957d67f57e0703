"""The machines that a study has drawn, and what differs between them."""

from pathlib import Path

import numpy as np
import pandas as pd

from plants.axis import unit_along
from plants.equation import fields, named
from workbench.publish.folders import write_whole
from workbench.publish.tables import with_unit
from workbench.study.plan import Plan
from workbench.study.sensor_tables import CHANNEL_UNITS
from workbench.study.store import DRAWS
from workbench.study.study import DRAW

MOST = 10_000
"""Draws that are written, the first: each machine is built for it."""


def drawn_machines(planned: Plan) -> pd.DataFrame:
    """What differs between the machines that a study draws, as its first case has them: draw | seed | parameter (unit)
    ... | noise of a sensor (unit) ...
    """
    draws = planned.cases.draws
    if draws is None:
        return pd.DataFrame()
    units = {item.name: item.unit for item in fields(planned.resolved[0].setup.plant.Parameters)}
    lines = []
    for turn, number in enumerate(draws.numbers[:MOST]):
        sample = draws.sample(number)
        parameters = named(planned.resolved[turn].setup.parameters)
        noise = {
            with_unit(f"noise of {name}", unit_along(CHANNEL_UNITS[name], planned.axis)): value
            for name, value in sample.noise.items()
        }
        shown = {with_unit(name, units[name]): value for name, value in parameters.items()}
        lines.append({DRAW: number, "seed": sample.seed, **shown, **noise})
    frame = pd.DataFrame(lines)
    kept = [name for name in frame if name in (DRAW, "seed") or not _alike(frame[name].to_numpy())]
    return frame[kept]


def _alike(values: np.ndarray) -> bool:
    return bool(np.all(values == values[0]) or np.all(values != values))


def write_draws(planned: Plan, folder: Path) -> None:
    """Write the machines that were drawn to `draws.csv`; nothing where none were."""
    frame = drawn_machines(planned)
    if len(frame):
        write_whole(
            folder / DRAWS, lambda path: frame.to_csv(path, index=False, lineterminator="\n", float_format="%.10g")
        )
