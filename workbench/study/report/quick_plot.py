"""Any stored signal of a study's cases, or a column of its results over an axis, drawn at once."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
import pandas as pd
from matplotlib.figure import Figure

from plants.axis import LINEAR, ROTARY
from workbench.errors import UserError, nearest
from workbench.metrics.registry import axis_of
from workbench.publish.along import SHOWN
from workbench.publish.pictures import FORMATS, save
from workbench.publish.tables import with_unit
from workbench.study.names import in_words, signal_units, unit_of_column, without_unit
from workbench.study.report.figures import draw
from workbench.study.report.schema import MOST_CURVES, Curve, FigureSpec, Panel
from workbench.study.report.select import axes_of, rows
from workbench.study.store import trajectory_path
from workbench.toml.file_names import file_name

MOST_NAMED = 20
"""Curves that a legend names, at most: of more the title says how many they are."""


def quick_plot(
    folder: Path, frame: pd.DataFrame, x: str, names: list[str], where: dict[str, str], out: Path | None
) -> tuple[Path, list[str]]:
    """Draw stored signals of the cases that `where` picks, or columns of the results over an axis; SI units.

    Returns:
        the picture, and in words the cases left out of it, whose plant has no such signal.

    Raises:
        UserError: unknown names, no stored trajectory, or a picture format that is not ours.
    """
    path = out or folder / "figures" / f"{file_name('_'.join([*names, 'over', x]))}.png"
    if path.suffix[1:] not in FORMATS:
        raise UserError(f'"{path.name}": expected a picture ending in .{", .".join(FORMATS)}')
    found = rows(frame, where)
    if found.empty:
        raise UserError(f"no case has {in_words(where)}")
    over_axis = x in frame.columns
    stored = {} if over_axis else _stored(folder, found)
    units = _units(frame, stored, over_axis)
    for name in (x, *names):
        if name not in units:
            raise _unknown(name, units, frame, stored, where)
    curves, left_out = _curves(frame, found, stored, x, names, where)
    if not curves:
        raise UserError(f'none of these cases has both "{x}" and "{names[0]}"')
    if len(curves) > MOST_CURVES:
        raise UserError(f"{len(curves)} curves, expected at most {MOST_CURVES}; choose among the cases with --where")
    if len(curves) > MOST_NAMED:
        curves = [curve.model_copy(update={"label": ""}) for curve in curves]
    figure = _drawn(_panel(x, names, None if over_axis else units[x], units, curves), where, frame, folder)
    own = path.parent if out is None else out.parent.resolve()  # where a user's own link leads is what is meant
    save(figure, path.stem, own, (path.suffix[1:],))
    return path, left_out


def _stored(folder: Path, found: pd.DataFrame) -> dict[int, list[str]]:
    """The signals with values in the trajectory of each of these cases that was kept; a sensor may be missing."""
    paths = {int(str(index)): trajectory_path(folder, int(str(index))) for index in found.index}
    tables = {index: pd.read_parquet(path) for index, path in paths.items() if path.exists()}
    return {index: [str(name) for name in table.columns[table.notna().any()]] for index, table in tables.items()}


def _units(frame: pd.DataFrame, stored: Mapping[int, Sequence[str]], over_axis: bool) -> dict[str, str]:
    """The units of what can be drawn, by name: any signal where no trajectory was kept, which is told later."""
    if over_axis:
        return {name: unit_of_column(name) for name in map(str, frame.columns)}
    declared = signal_units(axis_of([str(name) for name in frame.columns]))
    names = dict.fromkeys(name for signals in stored.values() for name in signals)
    return {name: declared.get(name, "1") for name in names} or declared


def _unknown(
    name: str, units: Mapping[str, str], frame: pd.DataFrame, stored: Mapping[int, object], where: Mapping[str, str]
) -> UserError:
    if name in frame.columns:
        return UserError(f'"{name}" is a column of the results: draw it against an axis of the study, such as --x rpm')
    of = f" of {in_words(where)}" if stored and where else ""
    return UserError(f'nothing called "{name}" is stored{of}; {nearest(name, units)}')


def _curves(
    frame: pd.DataFrame,
    found: pd.DataFrame,
    stored: Mapping[int, Sequence[str]],
    x: str,
    names: Sequence[str],
    where: Mapping[str, str],
) -> tuple[list[Curve], list[str]]:
    """A curve for each name and case, or over an axis for each value of the others; and the cases without it."""
    axes = axes_of(frame.columns)
    differing = [name for name in axes if found[name].nunique() > 1]
    told_apart = [axis for axis in differing if axis != x] if x in frame.columns else axes
    curves: list[Curve] = []
    left_out: dict[str, None] = {}
    for name in names:
        for index, case in found[told_apart].drop_duplicates().iterrows():
            told = {str(axis): value for axis, value in case.items() if pd.notna(value)}
            place = int(str(index))
            if place in stored and not {x, name} <= set(stored[place]):
                left_out[f"{in_words(told) or 'the only case'} (no {x if name in stored[place] else name})"] = None
                continue
            apart = [_axis_value(axis, value) for axis, value in told.items() if axis in differing]
            label = ", ".join([_in_plain_words(name)] * (len(names) > 1) + apart)
            curves.append(Curve(y=name, where={**where, **told}, label=label))
    return curves, list(left_out)


def _panel(x: str, names: Sequence[str], x_unit: str | None, units: Mapping[str, str], curves: list[Curve]) -> Panel:
    shared = {units[name] for name in names}
    alike = len(shared) == 1
    return Panel(
        x=x,
        x_label="rotation" if x == "rpm" else _in_plain_words(x),
        x_unit=x_unit,
        y_label=", ".join(with_unit(_in_plain_words(name), "1" if alike else units[name]) for name in names),
        y_unit=shared.pop() if alike else "1",
        legend="outside",
        curves=curves,
    )


def _drawn(panel: Panel, where: Mapping[str, str], frame: pd.DataFrame, folder: Path) -> Figure:
    """The figure, in mm where all is shorter than 1 m; of an axis that turns in deg."""
    title = ", ".join(_axis_value(axis, value) for axis, value in where.items()) or "all cases"
    if len(panel.curves) > MOST_NAMED:
        title += f", {len(panel.curves)} curves"
    figure = draw(FigureSpec(name="plot", title=title, panels=[panel]), frame, folder)
    turns = panel.y_unit in SHOWN[ROTARY].units
    if turns or (panel.y_unit == "m" and _largest(figure) < 1.0):
        shown = SHOWN[ROTARY if turns else LINEAR].units[str(panel.y_unit)]
        in_shown = panel.model_copy(update={"y_unit": shown})
        return draw(FigureSpec(name="plot", title=title, panels=[in_shown]), frame, folder)
    return figure


def _in_plain_words(name: str) -> str:
    """The name of a signal or a column as a reader sees it: without the unit that it ends in."""
    return without_unit(name).replace("_", " ")


def _axis_value(axis: str, value: object) -> str:
    """The value of an axis in a legend or a title: "460 rpm", "tafazoli", "coulomb 1.3"."""
    if axis == "rpm":
        return str(value) if "rpm" in str(value) else f"{value} rpm"
    return str(value).replace("_", " ") if isinstance(value, str) else f"{axis.split('.')[-1]} {value}"


def _largest(figure: Figure) -> float:
    """The largest magnitude drawn."""
    return max((float(np.nanmax(np.abs(line.get_ydata()), initial=0.0)) for line in figure.axes[0].lines), default=0.0)
