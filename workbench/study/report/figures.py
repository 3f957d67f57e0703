"""Figures of a study: signals over time, signal against signal, figures of the results over an axis.

Each is written as PDF (for a thesis), SVG (for a page) and PNG.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg

from workbench.errors import UserError
from workbench.metrics.registry import axis_of
from workbench.publish.figure_text import literal
from workbench.publish.notebook import NotebookFigure
from workbench.publish.pictures import save
from workbench.publish.style import COLOURS, PANEL_HEIGHT, REFERENCE, WIDTH, LineStyle, figure_style, line_style, marker
from workbench.publish.tables import shown_number, with_unit
from workbench.publish.words import listed
from workbench.simulation.run import COMPLETED
from workbench.study.axis_values import are_names, numbers, shown_unit
from workbench.study.names import shown_factor, signal_units
from workbench.study.report.schema import Curve, FigureSpec, Panel
from workbench.study.report.select import rows, trajectory
from workbench.study.report.summary import count_of, counted, in_words, summary_unit, taken
from workbench.study.sections import Overlay

BAND: dict[str, Any] = {"alpha": 0.2, "linewidth": 0.0}
"""How what lies between two quantiles is shaded."""

BELOW_LABELS = 30.0
"""Points below a panel at which its note stands."""


def draw(spec: FigureSpec, frame: pd.DataFrame, folder: Path, measured: Sequence[Overlay] = ()) -> NotebookFigure:
    """Draw a figure from the results and trajectories in `folder`, over `measured` friction where it asks for it.

    Raises:
        UserError: a curve picks no case or several, or its trajectory was not kept.
    """
    with figure_style():
        figure = NotebookFigure(figsize=(WIDTH, PANEL_HEIGHT * len(spec.panels) + 0.4))
        FigureCanvasAgg(figure)
        figure.suptitle(spec.title)
        for axes, panel in zip(figure.subplots(len(spec.panels), squeeze=False)[:, 0], spec.panels, strict=True):
            _draw_panel(axes, panel, frame, folder, spec.name, measured)
        return figure


def write_figure(spec: FigureSpec, frame: pd.DataFrame, folder: Path, measured: Sequence[Overlay] = ()) -> list[Path]:
    """Draw a figure of the results in `folder` and write it to its folder `figures`."""
    notes = [panel.note for panel in spec.panels if panel.note]
    caption = " ".join(f"{text.removesuffix('.')}." for text in (spec.title, *notes, spec.source) if text)
    return save(draw(spec, frame, folder, measured), spec.name, folder / "figures", caption=caption)


def _draw_panel(
    axes: Axes, panel: Panel, frame: pd.DataFrame, folder: Path, name: str, measured: Sequence[Overlay]
) -> None:
    number, x_unit, y_unit = -1, _x_unit(panel, frame), _y_unit(panel, frame)
    counts = list[tuple[int, int]]()
    first_dash = int(any(curve.style == "reference" for curve in panel.curves))
    if panel.measured_rpm is not None:
        _draw_measured(axes, panel, x_unit, y_unit, measured)
    for name_of_level, level in panel.levels.items():
        axes.axhline(level, **REFERENCE, label=name_of_level)
    for i, curve in enumerate(panel.curves):
        labelled = any(earlier.label for earlier in panel.curves[:i])
        continued = labelled and not curve.label  # it goes on with the line before it
        number += curve.style != "reference" and not continued
        style = REFERENCE.copy() if curve.style == "reference" else line_style(number, first_dash)
        if curve.style == "points":
            style |= {"linestyle": "none", "marker": marker(number)}
        if panel.x in frame.columns:
            counts += _draw_column(axes, panel, x_unit, y_unit, curve, frame, number, style)
        else:
            table = trajectory(folder, frame, curve.where, f"figure {name}")
            _draw_signal(axes, panel, x_unit, y_unit, curve, table, style, signal_units(_axis(frame)))
    if panel.title:
        axes.set_title(panel.title)
    axes.set_xlabel(with_unit(panel.x_label, x_unit))
    axes.set_ylabel(with_unit(panel.y_label, y_unit))
    if panel.x_range:
        axes.set_xlim(*panel.x_range)
    if panel.y_range:
        axes.set_ylim(*panel.y_range)
    if note := ". ".join(text for text in (panel.note, _said(panel, counts) if panel.over else "") if text):
        below: dict[str, Any] = {"xycoords": "axes fraction", "textcoords": "offset points", "fontsize": "small"}
        axes.annotate(note, (1.0, 0.0), (0.0, -BELOW_LABELS), ha="right", va="top", **below)
    if panel.levels or panel.measured_rpm is not None or any(curve.label or curve.band for curve in panel.curves):
        beside: dict[str, Any] = {"loc": "upper left", "bbox_to_anchor": (1.01, 1.0), "borderaxespad": 0.0}
        placed: dict[str, Any] = beside if panel.legend == "outside" else {"loc": panel.legend}
        axes.legend(**placed)


def _x_unit(panel: Panel, frame: pd.DataFrame) -> str:
    """The unit in which a panel's x is shown."""
    if panel.x in frame.columns:
        return shown_unit(panel.x, frame[panel.x].dropna().tolist(), panel.x_unit)
    return signal_units(_axis(frame)).get(panel.x, "1") if panel.x_unit is None else panel.x_unit


def _axis(frame: pd.DataFrame) -> str:
    """The axis of the plants that results are of."""
    return axis_of([str(name) for name in frame.columns])


def _y_unit(panel: Panel, frame: pd.DataFrame) -> str:
    """The unit in which a panel's y is shown: where none is given that of all its curves, "1" where they differ."""
    if panel.y_unit is not None:
        return panel.y_unit
    of_signals = signal_units(_axis(frame))
    units = {
        summary_unit(curve, curve.y) if panel.x in frame.columns else of_signals.get(curve.y, "1")
        for curve in panel.curves
    }
    if panel.measured_rpm is not None:
        units.add("N")
    return units.pop() if len(units) == 1 else "1"


def _draw_measured(axes: Axes, panel: Panel, x_unit: str, y_unit: str, measured: Sequence[Overlay]) -> None:
    x_scale, y_scale = shown_factor("m/s", x_unit), shown_factor("N", y_unit)
    for number, curve in enumerate(curve for curve in measured if curve.rpm == panel.measured_rpm):
        axes.plot(curve.x * x_scale, curve.y * y_scale, label=None if number else "measured", **REFERENCE)


def _draw_signal(
    axes: Axes,
    panel: Panel,
    x_unit: str,
    y_unit: str,
    curve: Curve,
    table: pd.DataFrame,
    style: LineStyle,
    units: Mapping[str, str],
) -> None:
    x_name = curve.x or panel.x
    for name in (x_name, curve.y):
        if name not in table:
            raise UserError(f'the plant of that case has no signal "{name}"')
    time = table["time"].to_numpy()
    window = (time >= panel.start) & (time <= (panel.end if panel.end is not None else np.inf))
    x = table[x_name].to_numpy()[window] * shown_factor(units.get(x_name, "1"), x_unit)
    y = table[curve.y].to_numpy()[window] * shown_factor(units.get(curve.y, "1"), y_unit)
    label = curve.label
    if curve.fit and np.unique(x).size > FITS[curve.fit]:  # else too little is left of a run that ended early
        label = f"{label}\n{_fit(axes, x, y, curve.fit, style['color'])}".lstrip("\n")
    axes.plot(x, y, label=label or None, **style)


FITS = {"line": 1, "cubic": 3}
DIGITS = 4
"""Significant digits of what a fit says."""


def _fit(axes: Axes, x: np.ndarray, y: np.ndarray, kind: str, colour: str) -> str:
    """Draw the least-squares polynomial of y on x; returns it in words, with R^2.

    Terms that move y nowhere by one unit of the last digit shown are left out.
    """
    polynomial = np.polynomial.Polynomial.fit(x, y, FITS[kind])
    grid = np.linspace(np.min(x), np.max(x), 200)
    axes.plot(grid, polynomial(grid), color=colour, linewidth=0.8, alpha=0.6)
    reach, visible = float(np.max(np.abs(x))), 10.0**-DIGITS * float(np.max(np.abs(y)))
    formula = ""
    for power, coefficient in reversed(list(enumerate(polynomial.convert().coef.tolist()))):
        if abs(coefficient) * reach**power > visible:
            variable = "" if power == 0 else " x" if power == 1 else f" x$^{power}$"
            formula += f"{' - ' if coefficient < 0.0 else ' + '}{shown_number(abs(coefficient), DIGITS)}{variable}"
    formula = f"-{formula[3:]}" if formula.startswith(" -") else formula[3:]
    scatter = float(np.sum((y - np.mean(y)) ** 2))
    quality = f",  R$^2$ = {1.0 - float(np.sum((y - polynomial(x)) ** 2)) / scatter:.4f}" if scatter else ""
    return f"y = {formula or '0'}{quality}"


def _draw_column(
    axes: Axes,
    panel: Panel,
    x_unit: str,
    y_unit: str,
    curve: Curve,
    frame: pd.DataFrame,
    number: int,
    style: LineStyle,
) -> list[tuple[int, int]]:
    """Draw a curve over a column of the results; returns of how many of how many cases each of its points is."""
    found = rows(frame, curve.where).dropna(subset=[panel.x] if panel.over else [panel.x, curve.y])
    scale = shown_factor(summary_unit(curve, curve.y), y_unit)
    names = are_names(frame[panel.x].dropna().tolist())

    def placed(values: Sequence[float | str]) -> Sequence[float | str]:
        return list(map(literal, map(str, values))) if names else numbers(panel.x, values, x_unit)

    marked: LineStyle = {"marker": marker(number), **style}
    points = _points(found, panel, curve)
    x = placed([point.x for point in points])
    axes.plot(x, [point.y * scale for point in points], label=curve.label or None, **marked)
    if curve.band is not None:
        low, high = ([point.band[end] * scale for point in points] for end in (0, 1))
        first = next(each for each in panel.curves if each.band == curve.band) is curve
        label = f"{100.0 * curve.band[0]:g} to {100.0 * curve.band[1]:g} % of the cases" if first else None
        axes.fill_between(x, low, high, color=style["color"], label=label, **BAND)
    unlike = [point for point in points if point.outcomes]
    if unlike:
        outcomes = ", ".join(dict.fromkeys(outcome for point in unlike for outcome in point.outcomes))
        hollow: LineStyle = {**marked, "linestyle": "none"}
        x, y = placed([point.x for point in unlike]), [point.y * scale for point in unlike]
        axes.plot(x, y, label=outcomes, markerfacecolor="white", zorder=3, **hollow)
    if curve.published:
        axes.plot(
            placed(list(curve.published)),
            list(curve.published.values()),
            linestyle="none",
            marker="x",
            markersize=7,
            color=COLOURS[-1],
            label="published",
        )
    return [point.cases for point in points]


@dataclass(frozen=True)
class _Point:
    """A point of a curve: what is drawn there, between which quantiles a band lies, outcomes but "completed", and how
    many cases it is of.
    """

    x: Any
    y: float
    band: tuple[float, float]
    outcomes: Sequence[str]
    cases: tuple[int, int] = (1, 1)


def _points(found: pd.DataFrame, panel: Panel, curve: Curve) -> list[_Point]:
    """The points of a curve over a column of the results: one for each case, or for each x where it is over several."""
    if curve.take != "share" and any(isinstance(value, str) for value in found[curve.y]):
        raise UserError(f'curve of "{curve.y}": its values are words; a share of them can be drawn with over')
    outcomes = found["outcome"].astype(str)
    if not panel.over:
        columns = (found[panel.x], found[curve.y].astype(float), outcomes)
        return [
            _Point(x, y, (y, y), [outcome] if outcome != COMPLETED else [])
            for x, y, outcome in zip(*columns, strict=True)
        ]
    points = []
    for x, cases in found.groupby(panel.x, sort=False):
        values, unlike = cases[curve.y].tolist(), outcomes[cases.index]
        y = taken(values, curve, curve.y)
        if y is None or isinstance(y, str):
            continue  # no case has it, or one alone a standard deviation
        there = cases[curve.y].dropna()
        low, high = np.quantile(there.to_numpy(dtype=float), curve.band).tolist() if curve.band else (y, y)
        points.append(_Point(x, y, (low, high), [*dict.fromkeys(unlike[unlike != COMPLETED])], count_of(values, curve)))
    return points


def _said(panel: Panel, counts: Sequence[tuple[int, int]]) -> str:
    """What the points of a panel over several cases are."""
    takes = {curve.label: in_words(curve, curve.y) for curve in panel.curves}
    alike = len({*takes.values()}) == 1
    said = next(iter(takes.values())) if alike else "; ".join(f"{label}: {take}" for label, take in takes.items())
    return f"Over {listed(panel.over)}, {counted(counts)} a point: {said}"
