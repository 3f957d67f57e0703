"""Sketches: trajectories with few points, of which a page of results can hold thousands."""

import numpy as np

from workbench.publish.page.packed import shorts
from workbench.publish.thinning import thinned
from workbench.simulation.run import TRUE, Run
from workbench.study.cases import Cases

ERROR, REFERENCE, POSITION, COMMAND = "error", "reference_position", "position", "command"

MOST_CASES = 2500
"""On a page; of a larger study the first."""

BYTES = 8_000_000
"""Of all sketches of a study, about; a page holds the scripts and pictures beside."""

BYTES_A_POINT = 16
"""Six channels of 16 bits, in base 64."""

LEAST, MOST = 80, 800
"""Points of a sketch: from where a motion can be seen to where a screen shows no more."""


def is_sketched(cases: Cases, index: int) -> bool:
    """Whether a sketch of a case is kept: of drawn machines of the first draw of each."""
    base, turn = divmod(index, cases.repeats)
    return turn == 0 and base < MOST_CASES


def sketched(cases: Cases) -> int:
    """Of how many cases of a study sketches are kept."""
    return min(cases.bases, MOST_CASES)


def points_for(count: int) -> int:
    """How many points each of so many sketches has, about."""
    return min(max(BYTES // (max(count, 1) * BYTES_A_POINT), LEAST), MOST)


def sketch_of(run: Run, points: int) -> str:
    """A run in about so many points: time, reference and error (without a reference the position), command, velocity
    and friction where there are any, in SI, as `workbench.publish.page.packed.shorts` writes them,
    with the unit of the command.

    Half of the points are extremes of error and command, over time; the others lie where much happens: each as far from
    the next, all signals in units of their range. The position is left out where the reference less the error gives it:
    both of these keep more digits than it has.
    """
    signals = {"time": run.time, COMMAND: run.signals[run.plant.command], **run.signals}
    motion = (REFERENCE, ERROR) if ERROR in signals else (POSITION,)
    chosen = [name for name in ("time", *motion, COMMAND, "velocity", TRUE) if name in signals]
    extremes = thinned(signals[motion[-1]], signals[COMMAND], buckets=max(points // 8, 1))
    spaced = _evenly(np.stack([signals[name] for name in chosen]), points // 2)
    kept = np.union1d(extremes, spaced)
    return shorts({name: signals[name][kept] for name in chosen}, {COMMAND: run.plant.command_unit})


def _evenly(signals: np.ndarray, points: int) -> np.ndarray:
    """Indices of samples that lie evenly along the path of the signals, a row each, in units of their ranges."""
    if not np.isfinite(signals).all():
        signals = np.nan_to_num(signals)
    ranges = np.ptp(signals, axis=1, keepdims=True)
    steps = np.diff(signals, axis=1) / np.where(ranges == 0.0, 1.0, ranges)
    along = np.concatenate([[0.0], np.cumsum(np.sqrt(np.einsum("ij,ij->j", steps, steps)))])
    return np.searchsorted(along, np.linspace(0.0, along[-1], points)).clip(0, along.size - 1)
