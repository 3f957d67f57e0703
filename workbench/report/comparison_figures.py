"""Figures of a comparison: error against rpm, error against power with the non-dominated set, limit-cycle maps."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import ListedColormap
from matplotlib.figure import Figure

from workbench.report.comparison import MM, Best, beats, best, cases_of, error_column, plain_name
from workbench.report.figures import save
from workbench.report.style import PANEL_HEIGHT, WIDTH, figure_style, line_style, marker, plain_numbers
from workbench.study.report_schema import ComparisonTable

ACROSS = 2
"""Panels side by side."""

BESIDE = 0.06
"""How far apart the controllers' points of one speed stand, as a share of the distance between two speeds."""

ALIKE = 0.1
"""Powers that differ by less than this share are one power to the non-dominated set."""

TOLD_IN_A_LINE = 2

VERDICTS = ("none", "decaying", "sustained")
VERDICT_COLOURS = ("#ffffff", "#9ecae1", "#d55e00")


@dataclass(frozen=True)
class Picture:
    """A figure that was written: its PNG, and what it shows in words."""

    path: Path
    caption: str


def write_figures(spec: ComparisonTable, frame: pd.DataFrame, folder: Path) -> list[Picture]:
    """Write all figures of the comparison."""
    drawn: list[tuple[str, Figure, str]] = []
    level = f"{spec.negligible * MM:g} mm"
    with figure_style():
        for scenario in map(str, frame["scenario"].unique()):
            part, name = frame[frame["scenario"] == scenario], plain_name(scenario)
            caption = (
                f"{name.capitalize()}: error against rotation. The speeds stand at equal distances, the points of one "
                f"speed side by side; in the shaded band, below {level}, errors are not told apart (the lowest are "
                "drawn at half of it)."
            )
            drawn.append((f"error_against_rpm_{scenario}", _errors(spec, part, name), caption))
            caption = (
                f"{name.capitalize()}: error against power, for references in motion; each point is a controller at "
                "one speed. Ringed and named: non-dominated, by differences that count; of cases of one power (within "
                f"{ALIKE * 100:g} %) the best. Shaded: below {level}, not told apart."
            )
            drawn.append((f"error_against_power_{scenario}", _trade(spec, part, name), caption))
        if frame["limit_cycle"].isin(["decaying", "sustained"]).any():
            caption = "Limit cycles after steps, controller against rotation; where one is sustained, mm peak to peak."
            drawn.append(("limit_cycle_map", _map(frame), caption))
    return [Picture(save(figure, name, folder)[-1], caption) for name, figure, caption in drawn]


def _figure(panels: int, title: str) -> tuple[Figure, list[Axes]]:
    """A figure of panels in rows of `ACROSS`, the places left over empty."""
    rows, columns = -(-panels // ACROSS), min(ACROSS, panels)
    figure = Figure(figsize=(WIDTH * columns * 0.75, PANEL_HEIGHT * rows + 0.6))
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    grid = list(figure.subplots(rows, columns, squeeze=False).ravel())
    for axes in grid[panels:]:
        axes.set_visible(False)
    return figure, grid[:panels]


def _style(controllers: list[str], controller: str) -> dict[str, Any]:
    i = controllers.index(controller)
    return {**line_style(i), "marker": marker(i), "label": plain_name(controller)}


def _shown(spec: ComparisonTable, error: Any) -> Any:
    """Errors as drawn, in mm: none lies below the middle of the band of those that are not told apart."""
    return np.maximum(error, 0.5 * spec.negligible) * MM


def _scales(axes: Axes, spec: ComparisonTable, error: str) -> None:
    """A logarithmic axis for errors, with plain numbers, that always shows the band and so magnifies no noise."""
    floor = spec.negligible * MM
    axes.set_yscale("log")
    axes.set_ylim(floor / 3.0, max(3.0 * floor, 1.5 * axes.get_ylim()[1]))
    axes.axhspan(floor / 3.0, floor, color="#dddddd", zorder=0, label=f"not told apart (below {floor:g} mm)")
    plain_numbers(axes.yaxis)
    axes.set_ylabel("steady-state error (mm)" if error == "steady_state_error_m" else "rms error (mm)")


def _legend(figure: Figure, axes: Axes) -> None:
    figure.legend(*axes.get_legend_handles_labels(), loc="outside lower center", ncols=4)


def _errors(spec: ComparisonTable, rows: pd.DataFrame, scenario: str) -> Figure:
    """Error against rpm, one panel a reference, one line a controller."""
    references, controllers = list(rows["reference"].unique()), list(rows["controller"].unique())
    speeds = sorted(rows["rpm"].unique())
    figure, panels = _figure(len(references), f"Error against rotation: {scenario}")
    for axes, reference in zip(panels, references, strict=True):
        error = error_column(spec, reference)
        for i, controller in enumerate(controllers):
            line = rows[(rows["reference"] == reference) & (rows["controller"] == controller)].dropna(subset=[error])
            places = [speeds.index(rpm) + BESIDE * (i - 0.5 * (len(controllers) - 1)) for rpm in line["rpm"]]
            axes.plot(places, _shown(spec, line[error].to_numpy(float)), **_style(controllers, controller))
        _scales(axes, spec, error)
        axes.set_xticks(range(len(speeds)), [f"{speed:g}" for speed in speeds])
        axes.set_title(plain_name(reference))
        axes.set_xlabel("rotation (rpm)")
    _legend(figure, panels[0])
    return figure


def non_dominated(spec: ComparisonTable, cases: list[Best]) -> list[Best]:
    """From the least power on, the cases that beat all cheaper ones; of those of about one power, the best."""
    chosen: list[Best] = []
    left = sorted(cases, key=_power)
    while left:
        alike = [case for case in left if _power(case) <= (1.0 + ALIKE) * _power(left[0])]
        left = left[len(alike) :]
        if not chosen or beats(spec, best(alike), chosen[-1]):
            chosen.append(best(alike))
    return chosen


def _power(case: Best) -> float:
    return float(case.row["total_power_W"])


def _trade(spec: ComparisonTable, rows: pd.DataFrame, scenario: str) -> Figure:
    """Error against total power, one panel a reference in motion, the non-dominated set ringed and named."""
    references = [name for name in rows["reference"].unique() if name not in spec.steps]
    controllers = list(rows["controller"].unique())
    figure, panels = _figure(len(references), f"Error against power: {scenario}")
    for axes, reference in zip(panels, references, strict=True):
        known = rows[rows["reference"] == reference].dropna(subset=["rms_error_m", "total_power_W"])
        for controller in controllers:
            group = known[known["controller"] == controller]
            style = _style(controllers, controller) | {"linestyle": "none"}
            axes.plot(group["total_power_W"], _shown(spec, group["rms_error_m"].to_numpy(float)), **style)
        axes.set_xscale("log")
        axes.set_xlabel("hydraulic plus rotary power (W)")
        named = _ring(axes, spec, non_dominated(spec, cases_of(known, "rms_error_m")))
        axes.set_title(f"{plain_name(reference)}\n{named or 'no case has an error and a power'}")
        _scales(axes, spec, "rms_error_m")
        plain_numbers(axes.xaxis)
        axes.tick_params(axis="x", labelsize="small")
    _legend(figure, panels[0])
    return figure


def _ring(axes: Axes, spec: ComparisonTable, chosen: list[Best]) -> str:
    """Ring the cases with a letter each; returns what the letters stand for."""
    power, error = [_power(case) for case in chosen], [_shown(spec, case.error) for case in chosen]
    axes.plot(power, error, "o", markersize=11, fillstyle="none", color="black", label="non-dominated")
    letters = [chr(ord("a") + i) for i in range(len(chosen))]
    for letter, x, y in zip(letters, power, error, strict=True):
        axes.annotate(letter, (x, y), (-10, -10), textcoords="offset points", ha="center", va="center", weight="bold")
    told = [
        f"{letter}: {plain_name(case.controller)}, {case.rpm:g} rpm"
        for letter, case in zip(letters, chosen, strict=True)
    ]
    lines = [told[i : i + TOLD_IN_A_LINE] for i in range(0, len(told), TOLD_IN_A_LINE)]
    return "\n".join(";  ".join(line) for line in lines)


def _map(frame: pd.DataFrame) -> Figure:
    """Verdicts on limit cycles, controller against rpm, one panel a scenario; amplitudes where one is sustained."""
    judged = frame.dropna(subset=["limit_cycle"])
    scenarios = list(judged["scenario"].unique())
    figure, panels = _figure(len(scenarios), "Limit cycles after steps (sustained: mm peak to peak)")
    for axes, scenario in zip(panels, scenarios, strict=True):
        rows = judged[judged["scenario"] == scenario]
        controllers, speeds = list(rows["controller"].unique()), sorted(rows["rpm"].unique())
        cells = np.full((len(controllers), len(speeds)), np.nan)
        for _, row in rows.iterrows():
            i, j = controllers.index(row["controller"]), speeds.index(row["rpm"])
            cells[i, j] = VERDICTS.index(row["limit_cycle"])
            if row["limit_cycle"] == "sustained":
                axes.text(j + 0.5, i + 0.5, f"{row['limit_cycle_amplitude_m'] * MM:.2g}", ha="center", va="center")
        shown: dict[str, Any] = {"cmap": ListedColormap(VERDICT_COLOURS), "vmin": 0, "vmax": len(VERDICTS) - 1}
        axes.pcolormesh(cells, edgecolors="#666666", linewidth=0.6, **shown)
        axes.invert_yaxis()
        axes.set_xticks(np.arange(len(speeds)) + 0.5, [f"{speed:g}" for speed in speeds])
        axes.set_yticks(np.arange(len(controllers)) + 0.5, [plain_name(name) for name in controllers])
        axes.grid(visible=False)
        axes.set_title(plain_name(scenario))
        axes.set_xlabel("rotation (rpm)")
    handles = [
        axes.plot([], [], "s", color=colour, markeredgecolor="black", label=verdict)[0]
        for verdict, colour in zip(VERDICTS, VERDICT_COLOURS, strict=True)
    ]
    figure.legend(handles=handles, loc="outside lower center", ncols=3)
    return figure
