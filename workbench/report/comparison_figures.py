"""Figures of a comparison: error against rpm, error against power with the non-dominated set, limit-cycle maps."""

from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from workbench.report.comparison import MM, error_column
from workbench.report.figures import save
from workbench.report.style import COLOURS, DASHES, MARKERS, PANEL_HEIGHT, WIDTH, figure_style
from workbench.study.schema import ComparisonTable

WORTH_TELLING = 0.8
"""A point of the non-dominated set is labelled if its error is below this share of the one labelled before."""

VERDICTS = ("none", "decaying", "sustained")
VERDICT_COLOURS = ("#f2f2f2", "#9ecae1", "#d55e00")


def write_figures(spec: ComparisonTable, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write all figures of the comparison; returns the PNGs."""
    pictures = []
    with figure_style():
        for scenario in frame["scenario"].unique():
            part = frame[frame["scenario"] == scenario]
            name = str(scenario).replace("_", " ")
            pictures.append(save(_errors(spec, part, name), f"error_against_rpm_{scenario}", folder))
            pictures.append(save(_trade(spec, part, name), f"error_against_power_{scenario}", folder))
        if frame["limit_cycle"].notna().any():
            pictures.append(save(_map(frame), "limit_cycle_map", folder))
    return [path for paths in pictures for path in paths if path.suffix == ".png"]


def _figure(rows: int, columns: int, title: str) -> tuple[Figure, np.ndarray]:
    figure = Figure(figsize=(WIDTH * columns * 0.75, PANEL_HEIGHT * rows + 0.5))
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, figure.subplots(rows, columns, squeeze=False)


def _style(controllers: list[str], controller: str) -> dict[str, object]:
    i = controllers.index(controller)
    return {
        "color": COLOURS[i % len(COLOURS)],
        "linestyle": DASHES[i % len(DASHES)],
        "marker": MARKERS[i % len(MARKERS)],
    }


def _label(spec: ComparisonTable, reference: str) -> str:
    return "steady-state error (mm)" if reference in spec.steps else "rms error (mm)"


def _errors(spec: ComparisonTable, rows: pd.DataFrame, scenario: str) -> Figure:
    """Error against rpm, one panel a reference, one line a controller."""
    references, controllers = list(rows["reference"].unique()), list(rows["controller"].unique())
    figure, grid = _figure(len(references), 1, f"Error against rotation: {scenario}")
    for axes, reference in zip(grid[:, 0], references, strict=True):
        error = error_column(spec, reference)
        for controller in controllers:
            line = rows[(rows["reference"] == reference) & (rows["controller"] == controller)]
            known = line.dropna(subset=[error])
            values = np.maximum(known[error].to_numpy(float), spec.negligible) * MM
            axes.plot(known["rpm"], values, label=controller.replace("_", " "), **_style(controllers, controller))
        axes.set_xscale("symlog", linthresh=10.0)
        axes.set_yscale("log")
        axes.set_title(reference.replace("_", " "))
        axes.set_xlabel("rotation (rpm)")
        axes.set_ylabel(_label(spec, reference))
    figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def non_dominated(cost: np.ndarray, error: np.ndarray) -> np.ndarray:
    """Which points no other one beats in cost and error at once, as a mask."""
    order = np.lexsort((error, cost))
    mask = np.zeros(cost.size, dtype=bool)
    least = np.inf
    for i in order:
        if error[i] < least:
            mask[i], least = True, error[i]
    return mask


def _trade(spec: ComparisonTable, rows: pd.DataFrame, scenario: str) -> Figure:
    """Error against total power, one panel a reference in motion, the non-dominated set ringed."""
    references = [name for name in rows["reference"].unique() if name not in spec.steps]
    controllers = list(rows["controller"].unique())
    figure, grid = _figure(len(references), 1, f"Error against power: {scenario}")
    for axes, reference in zip(grid[:, 0], references, strict=True):
        known = rows[rows["reference"] == reference].dropna(subset=["rms_error_m", "total_power_W"])
        for controller in controllers:
            group = known[known["controller"] == controller]
            style = _style(controllers, controller) | {"linestyle": "none"}
            axes.plot(group["total_power_W"], group["rms_error_m"] * MM, label=controller.replace("_", " "), **style)
        power, error = known["total_power_W"].to_numpy(float), known["rms_error_m"].to_numpy(float) * MM
        _ring(axes, power, error, known["rpm"].to_numpy(float))
        axes.set_xscale("log")
        axes.set_yscale("log")
        axes.set_title(reference.replace("_", " "))
        axes.set_xlabel("hydraulic plus rotary power (W)")
        axes.set_ylabel("rms error (mm)")
    figure.legend(*grid[0, 0].get_legend_handles_labels(), loc="outside lower center", ncols=4)
    return figure


def _ring(axes: Axes, power: np.ndarray, error: np.ndarray, rpm: np.ndarray) -> None:
    chosen = non_dominated(power, error)
    axes.plot(power[chosen], error[chosen], "o", markersize=10, fillstyle="none", color="black", label="non-dominated")
    told = np.inf
    for i in np.flatnonzero(chosen)[np.argsort(power[chosen])]:
        if error[i] < WORTH_TELLING * told:
            told = error[i]
            axes.annotate(
                f"{rpm[i]:g} rpm", (power[i], error[i]), (7, 3), textcoords="offset points", fontsize="x-small"
            )


def _map(frame: pd.DataFrame) -> Figure:
    """Verdicts on limit cycles, controller against rpm, one panel a scenario; amplitudes where one is sustained."""
    judged = frame.dropna(subset=["limit_cycle"])
    scenarios = list(judged["scenario"].unique())
    columns = min(2, len(scenarios))
    figure, grid = _figure(
        -(-len(scenarios) // columns), columns, "Limit cycles after steps (sustained: mm peak to peak)"
    )
    for axes, scenario in zip(grid.ravel(), scenarios, strict=False):
        rows = judged[judged["scenario"] == scenario]
        controllers, speeds = list(rows["controller"].unique()), sorted(rows["rpm"].unique())
        cells = np.full((len(controllers), len(speeds)), np.nan)
        for _, row in rows.iterrows():
            i, j = controllers.index(row["controller"]), speeds.index(row["rpm"])
            cells[i, j] = VERDICTS.index(row["limit_cycle"])
            if row["limit_cycle"] == "sustained":
                axes.text(j, i, f"{row['limit_cycle_amplitude_m'] * MM:.2g}", ha="center", va="center", fontsize=7)
        axes.imshow(cells, cmap=ListedColormap(VERDICT_COLOURS), vmin=0, vmax=2, aspect="auto")
        axes.set_xticks(range(len(speeds)), [f"{speed:g}" for speed in speeds])
        axes.set_yticks(range(len(controllers)), [name.replace("_", " ") for name in controllers])
        axes.grid(visible=False)
        axes.set_title(scenario.replace("_", " "))
        axes.set_xlabel("rotation (rpm)")
    handles = [
        axes.plot([], [], "s", color=colour, markeredgecolor="black", label=verdict)[0]
        for verdict, colour in zip(VERDICTS, VERDICT_COLOURS, strict=True)
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    for axes in grid.ravel()[len(scenarios) :]:
        axes.set_visible(False)
    return figure
