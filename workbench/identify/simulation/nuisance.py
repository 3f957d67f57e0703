"""Systematic errors of sensors, as columns that are linear in unknown numbers with known standard deviations.

A column belongs to one output of one record, or of all records; the numbers are found with the parameters, and the
parameters' uncertainty includes theirs.
"""

from collections.abc import Mapping, Sequence

import numpy as np
from scipy.interpolate import BSpline

from workbench.fitting.replay import Observed

KNOT_SPACING = 0.02
"""m between the knots of a calibration curve: an error that varies slowly over the travel."""

WIDE = 1e-2
"""m. Standard deviation of a record's start: nothing is known of it beyond its first sample."""


def columns(
    observed: Sequence[Observed], values: np.ndarray, accuracies: Mapping[str, float]
) -> tuple[np.ndarray, list[str]]:
    """Columns of the stacked residuals (in the outputs' SI units), one a unit of standard deviation, and their names.

    `values` are the outputs without noise, stacked: simulated ones. With measured ones in their place a gain could make
    the noise itself smaller, and a fit would take that for the better.

    Every record has an offset of its own start. Beside it, what `accuracies` names, the same in all records, since a
    rig has one of each sensor: offset and gain of a pressure; a calibration curve of the position (cubic splines).
    """
    sizes = [part.size for item in observed for part in item.measured.values()]
    starts = np.concatenate([[0], np.cumsum(sizes)])
    parts = np.split(values, starts[1:-1])
    owners = [(i, name) for i, item in enumerate(observed) for name in item.measured]
    blocks = [(i, name, part) for (i, name), part in zip(owners, parts, strict=True)]
    stacked: list[np.ndarray] = []
    names: list[str] = []

    def add(name: str, places: Mapping[int, np.ndarray]) -> None:
        column = np.zeros(starts[-1])
        for block, numbers in places.items():
            column[starts[block] : starts[block + 1]] = np.nan_to_num(numbers)
        stacked.append(column)
        names.append(name)

    for block, (i, name, part) in enumerate(blocks):
        if name != "position":
            continue
        add(f"start_{i}", {block: np.full(part.size, WIDE)})
    positions = {block: part for block, (_, name, part) in enumerate(blocks) if name == "position"}
    if positions and "position_calibration" in accuracies:
        std, ends = accuracies["position_calibration"], np.cumsum([part.size for part in positions.values()])[:-1]
        for k, curve in enumerate(_splines(np.concatenate(list(positions.values())))):
            add(f"calibration_{k}", dict(zip(positions, np.split(std * curve, ends), strict=True)))
    for channel in ("pressure_1", "pressure_2"):
        members = {block: part for block, (_, name, part) in enumerate(blocks) if name == channel}
        if members and f"{channel}_offset" in accuracies:
            std = accuracies[f"{channel}_offset"]
            add(f"{channel}_offset", {block: np.full(part.size, std) for block, part in members.items()})
        if members and f"{channel}_gain" in accuracies:
            std = accuracies[f"{channel}_gain"]
            add(f"{channel}_gain", {block: std * part for block, part in members.items()})
    return (np.column_stack(stacked) if stacked else np.zeros((starts[-1], 0))), names


def _splines(position: np.ndarray) -> list[np.ndarray]:
    """Cubic B-splines over the range of the positions, at them."""
    low, high = np.nanmin(position), np.nanmax(position)
    inner = max(int(np.ceil((high - low) / KNOT_SPACING)), 1)
    knots = np.linspace(low, high, inner + 1)
    padded = np.concatenate([[low] * 3, knots, [high] * 3])
    known = np.isfinite(position)
    matrix = np.zeros((position.size, inner + 3))
    matrix[known] = BSpline.design_matrix(np.clip(position[known], low, high), padded, 3).toarray()
    return list(matrix.T)
