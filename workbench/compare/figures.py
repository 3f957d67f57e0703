"""Figures of a comparison: error against real rpm, error against paid power, who hunts; a panel a motion and machine.

Many candidates stay legible: the best controller of each family (or of each class, against power) is drawn in colour
with its interval over the draws and is named in its panel, all others are grey.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import LinearSegmentedColormap
from matplotlib.figure import Figure

from workbench.compare.candidates import (
    CLASSES,
    MM,
    Candidate,
    Cell,
    Class,
    Family,
    cells_of,
    order,
    with_all_axes,
)
from workbench.compare.schema import ComparisonTable
from workbench.compare.verdicts import Verdict, size_of
from workbench.metrics.limit_cycle import HUNTING
from workbench.publish.pictures import Picture, save
from workbench.publish.style import COLOURS, figure_style, plain_numbers
from workbench.publish.words import plain_name

FAMILY_STYLE: dict[Family, dict[str, Any]] = {
    "plain": {"color": COLOURS[0], "marker": "o", "linestyle": "-"},
    "pressure": {"color": COLOURS[1], "marker": "s", "linestyle": "--"},
    "friction model": {"color": COLOURS[2], "marker": "^", "linestyle": "-."},
}
CLASS_STYLE: dict[Class, dict[str, Any]] = {
    "nothing": {"color": COLOURS[6], "marker": "o"},
    "compensate": {"color": COLOURS[0], "marker": "s"},
    "avoid": {"color": COLOURS[1], "marker": "^"},
    "both": {"color": COLOURS[3], "marker": "D"},
}
OTHERS: dict[str, Any] = {"color": "#b8b8b8", "linewidth": 0.8, "markersize": 3.0, "zorder": 1.8}

HUNTS = LinearSegmentedColormap.from_list("hunts", ["#ffffff", COLOURS[1]])

PANEL = (4.6, 3.3)
"""Width and height of a panel (inches)."""

NOT_RUN = "#dddddd"
"""Where a map has no case."""

Draw = Callable[[Axes, Cell, list[Candidate]], None]
"""Draws the candidates of a cell into its panel."""

HIGHEST = 100.0
"""What errs more than this many times the best of its panel is cut off: it is no rival, and would flatten the rest."""


def write_figures(
    spec: ComparisonTable, frame: pd.DataFrame, whole: pd.DataFrame, found: Mapping[Cell, Verdict], folder: Path
) -> dict[str, Picture]:
    """Write all figures of the comparison: errors on the draws of `frame`, that all have met; who hunts on any draw.

    `whole` has the fresh draws too.
    """
    drawn: dict[str, Picture] = {}
    cells = _with_flaws(cells_of(spec, frame), found)
    bars = (
        f"Means over the draws that all have met; bars: their {100 * spec.probability:g} % interval. Shaded: below "
        f"{spec.negligible * MM:g} mm, not told apart, and drawn in the middle of it."
    )
    with figure_style():
        for scenario in dict.fromkeys(cell.scenario for cell in cells):
            part = {cell: candidates for cell, candidates in cells.items() if cell.scenario == scenario}
            name = plain_name(scenario).capitalize()

            def over_speed(axes: Axes, _: Cell, candidates: list[Candidate]) -> None:
                _over_speed(axes, spec, candidates)

            figure = _panels(spec, part, f"{name}: error against real speed of rotation", over_speed)
            caption = (
                f"{name}: error against the rod's real mean speed. In colour: of each family the controller with the "
                f"least error that holds; grey: all others; crosses: hunts or does not complete on any draw. {bars} "
                f"Errors above {HIGHEST:g} times the least are cut off."
            )
            drawn[f"error_against_rpm_{scenario}"] = Picture(figure, caption)
            best = {cell: {one.key: kind for kind, one in found[cell].best.items()} for cell in part}

            def over_power(axes: Axes, cell: Cell, candidates: list[Candidate], chosen: Any = best) -> None:
                _over_power(axes, spec, candidates, chosen[cell])

            figure = _panels(spec, part, f"{name}: error against paid power", over_power)
            caption = (
                f"{name}: error against what pump and motor terminals pay together. In colour: who stands for each "
                f"class; grey: all others that hold. {bars}"
            )
            drawn[f"error_against_power_{scenario}"] = Picture(figure, caption)
        drawn |= {name: Picture(figure, caption) for name, figure, caption in _hunting(with_all_axes(whole))}
        for picture in drawn.values():
            picture.figure.set_dpi(mpl.rcParams["savefig.dpi"])
            picture.figure.draw_without_rendering()
            picture.figure.set_layout_engine("none")  # laid out once, not once a format
    for name, picture in drawn.items():
        save(picture.figure, name, folder, ("pdf", "png"))
    return drawn


def _with_flaws(cells: Mapping[Cell, list[Candidate]], found: Mapping[Cell, Verdict]) -> dict[Cell, list[Candidate]]:
    """The candidates, with the flaws that some show only where they were measured for the verdict."""
    flaws = {(cell, *one.key): one.flaw for cell, verdict in found.items() for one in verdict.candidates}
    return {
        cell: [replace(one, flaw=one.flaw or flaws.get((cell, *one.key), "")) for one in candidates]
        for cell, candidates in cells.items()
    }


def _figure(rows: int, columns: int, title: str) -> tuple[Figure, list[Axes]]:
    width, height = PANEL
    figure = Figure(figsize=(width * max(columns, 1.4), height * rows + 0.5))
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, list(figure.subplots(rows, columns, squeeze=False).ravel())


def _panels(spec: ComparisonTable, cells: Mapping[Cell, list[Candidate]], title: str, draw: Draw) -> Figure:
    """A figure of one scenario: a row a reference, a column a machine."""
    references, machines = (list(dict.fromkeys(cell[i] for cell in cells)) for i in (2, 0))
    figure, panels = _figure(len(references), len(machines), title)
    places = ((reference, machine) for reference in references for machine in machines)
    for axes, (reference, machine) in zip(panels, places, strict=True):
        cell = next((one for one in cells if (one.machine, one.reference) == (machine, reference)), None)
        if cell is None:
            axes.set_visible(False)
            continue
        axes.set_title(", ".join(filter(None, (plain_name(machine), plain_name(reference)))))
        draw(axes, cell, cells[cell])
        _scales(axes, spec, cells[cell])
        axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.2), ncols=2, fontsize="x-small")
    return figure


def _shown(spec: ComparisonTable, error: Any) -> Any:
    """Errors as drawn, in mm: none lies below the middle of the band of those that are not told apart."""
    return np.maximum(error, 0.5 * spec.negligible) * MM


def _scales(axes: Axes, spec: ComparisonTable, candidates: list[Candidate]) -> None:
    """A logarithmic axis for errors, with plain numbers, that always shows the band and so magnifies no noise."""
    floor = spec.negligible * MM
    sizes = [one.errors.mean() * MM for one in candidates if not one.flaw] or [floor]
    top = min(max(sizes), HIGHEST * max(min(sizes), floor))
    axes.set_yscale("log")
    axes.set_ylim(floor / 3.0, max(3.0 * floor, 3.0 * top))
    axes.axhspan(floor / 3.0, floor, color="#e4e4e4", zorder=0)
    plain_numbers(axes.yaxis)
    steps = bool(candidates) and candidates[0].error_column != "rms_error_m"
    axes.set_ylabel("largest error at rest (mm)" if steps else "rms error (mm)")


def _over_speed(axes: Axes, spec: ComparisonTable, candidates: list[Candidate]) -> None:
    """Error against real rpm, a line a controller."""
    lines: dict[str, list[Candidate]] = {}
    for one in sorted(candidates, key=lambda one: one.rpm):
        if not np.isnan(one.errors).all():
            lines.setdefault(one.controller, []).append(one)
    best = _best_of_families(candidates)
    for name, line in lines.items():
        x = [one.rpm if one.rpm == 0 else one.mean("rotation_speed_mean_rpm") for one in line]
        if name in best:
            style = {**FAMILY_STYLE[line[0].family], "label": f"{plain_name(name)} ({line[0].family})"}
            _bars(axes, spec, x, line, style)
        else:
            axes.plot(x, _shown(spec, [np.nanmean(one.errors) for one in line]), marker=".", **OTHERS)
        flawed = [(at, _shown(spec, np.nanmean(one.errors))) for at, one in zip(x, line, strict=True) if one.flaw]
        if flawed:
            axes.plot(*zip(*flawed, strict=True), "x", color="#444444", markersize=5, zorder=3)
    commands = sorted({one.rpm for one in candidates})
    least = next((rpm for rpm in commands if rpm > 0), 1.0)
    axes.set_xscale("symlog", linthresh=least, linscale=0.6)
    axes.set_xticks(commands, [f"{rpm:g}" for rpm in commands])
    axes.minorticks_off()
    axes.set_xlim(-0.15 * least, 1.3 * max(*commands, least))
    axes.set_xlabel("real mean speed (rpm)")


def _best_of_families(candidates: list[Candidate]) -> set[str]:
    """The controller of each family with the least error that holds."""
    best: dict[str, Candidate] = {}
    for one in sorted((one for one in candidates if not one.flaw), key=order):
        best.setdefault(one.family, one)
    return {one.controller for one in best.values()}


def _bars(axes: Axes, spec: ComparisonTable, x: list[float], line: list[Candidate], style: dict[str, Any]) -> None:
    """Mean errors with their intervals over the draws."""
    sizes = [size_of(spec, one) for one in line]
    mean, low, high = (
        _shown(spec, np.array([getattr(size, end) for size in sizes])) for end in ("mean", "low", "high")
    )
    axes.errorbar(x, mean, yerr=[mean - low, high - mean], capsize=2.5, zorder=2.5, **style)


def _over_power(
    axes: Axes, spec: ComparisonTable, candidates: list[Candidate], best: Mapping[tuple[str, float], Class]
) -> None:
    """Error against paid power, a point a candidate; those that stand for a class by controller and rpm in `best`."""
    holding = [one for one in candidates if not one.flaw]
    axes.plot(
        [one.paid for one in holding],
        _shown(spec, [one.errors.mean() for one in holding]),
        linestyle="none",
        marker=".",
        **{**OTHERS, "markersize": 5.0},
    )
    standing = {best[one.key]: one for one in candidates if one.key in best}
    for kind in CLASSES:
        if kind in standing:
            one = standing[kind]
            style = {**CLASS_STYLE[kind], "linestyle": "none", "markersize": 6, "label": f"{kind}: {one.words}"}
            _bars(axes, spec, [one.paid], [one], style)
    axes.set_xscale("log")
    plain_numbers(axes.xaxis)
    axes.tick_params(axis="x", labelsize="small")
    axes.set_xlabel("pump and motor terminals (W)")


def _hunting(frame: pd.DataFrame) -> Iterator[tuple[str, Figure, str]]:
    """The share of draws in which each controller hunts at each speed, a panel a machine and scenario."""
    judged = frame.dropna(subset=["limit_cycle"])
    judged = judged.assign(hunts=judged["limit_cycle"].isin(HUNTING))
    if not judged["hunts"].any():
        return
    scenarios, machines = list(judged["scenario"].unique()), list(judged["machine"].unique())
    controllers = list(judged["controller"].unique())
    speeds = sorted(judged["rpm"].unique())
    figure, panels = _figure(
        len(scenarios), len(machines), "Share of draws that hunt (colour), largest swing in mm (number)"
    )
    figure.set_figheight((0.17 * len(controllers) + 0.9) * len(scenarios) + 0.6)
    places = ((scenario, machine) for scenario in scenarios for machine in machines)
    for axes, (scenario, machine) in zip(panels, places, strict=True):
        rows = judged[(judged["scenario"] == scenario) & (judged["machine"] == machine)]
        if rows.empty:
            axes.set_visible(False)
            continue
        axes.set_facecolor(NOT_RUN)
        share = rows.pivot_table("hunts", "controller", "rpm", "mean").reindex(index=controllers, columns=speeds)
        size = rows[rows["hunts"]].pivot_table("limit_cycle_amplitude_m", "controller", "rpm", "max")
        shown: dict[str, Any] = {"cmap": HUNTS, "vmin": 0.0, "vmax": 1.0}
        axes.pcolormesh(share.to_numpy(float), edgecolors="#888888", linewidth=0.5, **shown)
        for controller in size.index:
            for rpm in size.columns[size.loc[controller].notna()]:
                dark = share.loc[controller, rpm] > 0.6
                place = (speeds.index(rpm) + 0.5, controllers.index(controller) + 0.5)
                style: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": "x-small"}
                axes.text(*place, f"{size.loc[controller, rpm] * MM:.2g}", color="white" if dark else "black", **style)
        axes.invert_yaxis()
        axes.set_xticks(np.arange(len(speeds)) + 0.5, [f"{speed:g}" for speed in speeds])
        axes.set_yticks(np.arange(len(controllers)) + 0.5, [plain_name(name) for name in controllers], fontsize="small")
        axes.grid(visible=False)
        axes.set_title(", ".join(filter(None, (plain_name(machine), plain_name(scenario)))))
        axes.set_xlabel("commanded speed (rpm)")
    caption = (
        "Who hunts, or may hunt, where the reference holds still: white in no draw, dark in all, grey not run; the "
        "number is the largest swing found (mm, peak to peak)."
    )
    yield "hunting_map", figure, caption
