"""Figures of a design: the motion, and where in it the hypotheses come apart."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.design.pieces import samples
from workbench.design.power import Told
from workbench.design.result import Design
from workbench.design.search import ODDS
from workbench.publish.along import SHOWN
from workbench.publish.pictures import Picture
from workbench.publish.style import REFERENCE, figure_style, line_style
from workbench.publish.thinning import thinned

WIDE, HIGH = 9.0, 5.6
"""Inches."""

PAIRS = 4
"""That are drawn, at most: those that come apart least."""

LEGEND = 0.22
"""Height, in inches, of a line of the legend below."""

POINTS = 1500
"""Buckets of samples of a curve."""


@dataclass(frozen=True, eq=False)
class MotionData:
    """What is drawn: time (s), the reference and the position under the first hypothesis, in shown units; when each
    piece begins (s), and its kind; of each pair a label, and half its T up to each of `instants` (s).
    """

    time: np.ndarray
    reference: np.ndarray
    position: np.ndarray
    begins: Sequence[tuple[float, str]]
    instants: np.ndarray
    gained: Sequence[tuple[str, np.ndarray]]


def motion_data(design: Design) -> MotionData:
    """The numbers of the figure."""
    rig, shown = design.rig, SHOWN[design.rig.axis]
    factor = shown.factor if rig.steering is not None else 1.0
    reference = factor * np.concatenate([leg.reference for leg in design.legs])
    position = shown.factor * np.concatenate([run.state("position") for run in design.runs[0]])
    begins, at = list[tuple[float, str]](), 0
    for i, piece in enumerate(design.pieces):
        begins.append((at * rig.sample_time, piece.kind))
        at += samples(piece, rig.reach)
        last = i + 1 == len(design.pieces) or design.pieces[i + 1].condition != piece.condition
        at += last  # a leg ends in the middle once more
    least = sorted(design.claimed, key=lambda one: one.distance)[:PAIRS]
    gained = [
        (f"if it is {design.name_of(one.true)}: not {design.name_of(one.rival)}", _gained(design, one)) for one in least
    ]
    sizes = _sizes(design)
    starts = np.cumsum([0, *(leg.reference.size for leg in design.legs)])[:-1]
    instants = np.concatenate(
        [
            rig.sample_time * (start + rig.grain * (np.arange(size) + 1))
            for start, size in zip(starts, sizes, strict=True)
        ]
    )
    return MotionData(rig.sample_time * np.arange(reference.size), reference, position, begins, instants, gained)


def _sizes(design: Design) -> list[int]:
    """Means of each leg."""
    return [-(-leg.reference.size // design.rig.grain) for leg in design.legs]


def _gained(design: Design, one: Told) -> np.ndarray:
    """Half the squares that a refitted rival leaves, up to the end of each mean, over all channels."""
    count, parts, at = len(design.rig.channels), list[np.ndarray](), 0
    for size in _sizes(design):
        rows = one.left[at : at + count * size].reshape(count, size)
        parts.append(np.sum(rows**2, axis=0))
        at += count * size
    return 0.5 * np.cumsum(np.concatenate(parts))


def draw_motion(design: Design, data: MotionData) -> Picture:
    """The figure."""
    shown, closed = SHOWN[design.rig.axis], design.rig.steering is not None
    with figure_style():
        height = HIGH + LEGEND * (len(data.gained) + 1) if data.gained else 0.6 * HIGH
        figure = Figure(figsize=(WIDE, height))
        FigureCanvasAgg(figure)
        figure.suptitle("The motion" + (", and where the hypotheses come apart in it" if data.gained else ""))
        panels = figure.subplots(2 if data.gained else 1, 1, squeeze=False, sharex=True)[:, 0]
        kept = thinned(data.reference, data.position, buckets=POINTS)
        panels[0].plot(data.time[kept], data.reference[kept], label="reference", **REFERENCE)
        if closed:
            panels[0].plot(
                data.time[kept], data.position[kept], label=f"position, if it is {design.name_of(0)}", **line_style(0)
            )
        panels[0].set_ylabel(
            f"position ({shown.unit})" if closed else f"command ({design.rig.along.plant.command_unit})"
        )
        panels[0].legend(loc="lower right", bbox_to_anchor=(1.0, 1.0), ncols=2, frameon=False)
        for axes in panels:
            for begin, _ in data.begins[1:]:
                axes.axvline(begin, color="#dddddd", linewidth=0.8, zorder=1.0)
        before = ""
        for begin, kind in data.begins:
            if kind != before:
                panels[0].annotate(
                    kind,
                    (begin, 1.0),
                    xycoords=("data", "axes fraction"),
                    xytext=(2, -10),
                    textcoords="offset points",
                    fontsize="x-small",
                )
            before = kind
        if data.gained:
            for number, (label, gained) in enumerate(data.gained):
                panels[1].plot(data.instants, np.maximum(gained, 1e-3), label=label, **line_style(number))
            panels[1].axhline(0.5 * ODDS, color="#555555", linewidth=0.8, linestyle=":", label="odds of 20 to 1")
            panels[1].set_yscale("log")
            panels[1].set_ylabel("log-likelihood ratio")
            panels[1].legend(loc="upper left", bbox_to_anchor=(0.0, -0.2), ncols=1, frameon=False)
        panels[-1].set_xlabel("time (s)")
    caption = (
        "Above, the motion. Below, by how much the record up to then makes the true hypothesis likelier than its "
        "rival, which is fitted to all of it: where a curve rises the two differ."
        if data.gained
        else "The motion."
    )
    return Picture(figure, caption)
