"""The map of who hunts: the share of plant samples by controller and speed, a panel a machine and scenario."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import LinearSegmentedColormap

from workbench.compare.candidates import MM
from workbench.compare.hunting import judged
from workbench.compare.report.panels import grid
from workbench.compare.result import Comparison
from workbench.publish.pictures import Picture
from workbench.publish.style import COLOURS
from workbench.publish.words import plain_name

HUNTS = LinearSegmentedColormap.from_list("hunts", ["#ffffff", COLOURS[1]])

NOT_RUN = "#dddddd"
"""Where a map has no case."""

DARK = 0.6
"""Share of hunting above which a number is white on its field."""


@dataclass(frozen=True)
class Swing:
    """The largest swing (m, peak to peak) of a controller at a speed, by their numbers, where it hunts on a `share`."""

    controller: int
    speed: int
    amplitude: float
    share: float


@dataclass(frozen=True, eq=False)
class HuntingPanel:
    """A machine in a scenario: the share of plant samples that hunt, a row a controller, a column a speed (NaN: not
    run), and how far they swing.
    """

    title: str
    share: np.ndarray
    swings: Sequence[Swing]


@dataclass(frozen=True, eq=False)
class HuntingMap:
    """The numbers of the figure: a row of panels a scenario, a column a machine; None where nothing was judged."""

    controllers: Sequence[str]
    speeds: Sequence[float]
    rows: Sequence[Sequence[HuntingPanel | None]]


def hunting_map(frame: pd.DataFrame) -> HuntingMap | None:
    """The numbers of the figure of these rows of results; None where nobody hunts."""
    known = judged(frame)
    if not known["hunts"].any():
        return None
    controllers, speeds = list(known["controller"].unique()), sorted(known["rpm"].unique())
    machines = list(known["machine"].unique())
    rows = [
        [
            _panel(known[(known["scenario"] == scenario) & (known["machine"] == machine)], controllers, speeds)
            for machine in machines
        ]
        for scenario in known["scenario"].unique()
    ]
    return HuntingMap(controllers, speeds, rows)


def _panel(rows: pd.DataFrame, controllers: list[str], speeds: list[float]) -> HuntingPanel | None:
    if rows.empty:
        return None
    share = rows.pivot_table("hunts", "controller", "rpm", "mean").reindex(index=controllers, columns=speeds)
    shares = share.to_numpy(float)
    size = rows[rows["hunts"]].pivot_table("limit_cycle_amplitude_m", "controller", "rpm", "max")
    swings = []
    for controller in size.index:
        for rpm in size.columns[size.loc[controller].notna()]:
            i, j = controllers.index(controller), speeds.index(rpm)
            swings.append(Swing(i, j, size.loc[controller, rpm], shares[i, j]))
    names = (plain_name(str(rows[axis].iloc[0])) for axis in ("machine", "scenario"))
    return HuntingPanel(", ".join(filter(None, names)), shares, swings)


def hunting_picture(comparison: Comparison) -> Picture | None:
    """The figure with its caption; None where nobody hunts."""
    data = hunting_map(comparison.every_run)
    if data is None:
        return None
    title = "Share of draws that hunt (colour), largest swing in mm (number)"
    figure, panels = grid(len(data.rows), len(data.rows[0]), title)
    figure.set_figheight((0.17 * len(data.controllers) + 0.9) * len(data.rows) + 0.6)
    for axes, panel in zip(panels, (each for row in data.rows for each in row), strict=True):
        if panel is None:
            axes.set_visible(False)
        else:
            _draw(axes, panel, data)
    caption = (
        "Who hunts, or may hunt, where the reference holds still: white in no draw, dark in all, grey not run; the "
        "number is the largest swing found (mm, peak to peak)."
    )
    return Picture(figure, caption)


def _draw(axes: Axes, panel: HuntingPanel, data: HuntingMap) -> None:
    axes.set_facecolor(NOT_RUN)
    axes.pcolormesh(panel.share, edgecolors="#888888", linewidth=0.5, cmap=HUNTS, vmin=0.0, vmax=1.0)
    for swing in panel.swings:
        axes.text(
            swing.speed + 0.5,
            swing.controller + 0.5,
            f"{swing.amplitude * MM:.2g}",
            color="white" if swing.share > DARK else "black",
            ha="center",
            va="center",
            fontsize="x-small",
        )
    axes.invert_yaxis()
    axes.set_xticks(np.arange(len(data.speeds)) + 0.5, [f"{speed:g}" for speed in data.speeds])
    names = [plain_name(name) for name in data.controllers]
    axes.set_yticks(np.arange(len(names)) + 0.5, names, fontsize="small")
    axes.grid(visible=False)
    axes.set_title(panel.title)
    axes.set_xlabel("commanded speed (rpm)")
