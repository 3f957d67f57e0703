"""The share of repeated records in which likelihood tells a hypothesis from its rival, to hold beside a prediction."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np

from workbench.design.power import drawn_from
from workbench.design.refit import refitted, shown_along, started
from workbench.design.result import Design
from workbench.design.search import ODDS

REPETITIONS = 50
THREADS = 2

SEED = 977
"""Another one than the design's own."""


def share_found(design: Design) -> float:
    """Of records of one machine that is drawn, each with noise of its own, to which both plants are fitted anew."""
    rig, (true, rival), draw = design.rig, design.hypotheses, np.random.default_rng(SEED)
    away = drawn_from(true) @ draw.standard_normal(len(true.unknowns))
    machine = true.moved(away)
    by_name = {unknown.name: float(x) for unknown, x in zip(true.unknowns, away, strict=True)}
    starts = [started(one, true, by_name) for one in (true, rival)]
    runs = [rig.driven(machine, leg.reference, leg.condition) for leg in design.legs]
    clean = np.concatenate([rig.seen(run) for run in runs])
    own, other = (shown_along(rig, one, design.legs, runs) for one in (true, rival))
    asked = -ODDS if true.is_part_of(rival) else ODDS

    def is_told(seed: int) -> bool:
        record = clean + np.random.default_rng([SEED, seed]).standard_normal(clean.size)
        plants = zip((true, rival), (own, other), starts, strict=True)
        left = [refitted(rig, one, record, shown, design.legs, runs, start).squares for one, shown, start in plants]
        return left[1] - left[0] > asked

    with ThreadPoolExecutor(THREADS) as pool:
        return float(np.mean(list(pool.map(is_told, range(REPETITIONS)))))
