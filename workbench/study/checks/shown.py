"""What a study's tables and figures show of its results, checked before it runs."""

import re
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.errors import shortened
from workbench.metrics.registry import WORDS
from workbench.study.axis_values import are_names, shown_unit
from workbench.study.cases import Cases
from workbench.study.names import comparable, in_words, shown_factor, signal_units, unit_of_column
from workbench.study.report.schema import Column, Curve, FigureSpec, Panel, Row, Summary, TableSpec
from workbench.study.report.summary import level_of, summary_unit
from workbench.study.report.table_layout import LayoutError, lay_out
from workbench.study.sections import Overlay, overlays_of
from workbench.study.study import DRAW, Study, check_name
from workbench.toml.reading import Key
from workbench.toml.units import QuantityError

PLAIN = re.compile(r"(?:[^\\{}_^]|[_^]\w(?![_^]))*")
"""Mathematics that can always be set: symbols, with an index or a power of one letter or digit."""


JOINS = "a line joins"
SAY_WHICH = 'say which in its where, or draw them with style = "points"'
OVER_DRAWS = f'take a figure of all draws with over = ["{DRAW}"] and a take, or draw them with style = "points"'
"""What is said of a line through several cases at one value of its axis."""


@dataclass(frozen=True)
class Shown:
    """A study with all its cases, the columns of its results, and the axis of its plants.

    `signal` raises UserError where none of the cases of some indices has a signal of that name.
    """

    study: Study
    every: Cases
    columns: Sequence[str]
    axis: str
    signal: Callable[[Key, str, Sequence[int]], None]

    @property
    def axes(self) -> Mapping[str, Sequence[object]]:
        """The columns that tell the cases apart, each with its values."""
        return self.every.axes

    def table(self, key: Key, table: TableSpec) -> None:
        """Raise UserError for the first mistake of a table."""
        if table.index is not None:
            check_name(self.study, (*key, "index"), "axis", table.index, self.columns)
        if table.across is not None:
            check_name(self.study, (*key, "across"), "axis", table.across, self.axes)
        self._over((*key, "over"), table.over)
        forms: dict[str, Sequence[Column | Row]] = {"columns": table.columns, "rows": table.rows}
        for form, items in forms.items():
            for i, item in enumerate(items):
                place = (*key, form, i)
                check_name(self.study, (*place, "result"), "figure", item.result, self.columns)
                self._summary(place, item, item.result)
                self._unit((*place, "unit"), summary_unit(item, item.result), item.unit)
                for name in item.against:
                    check_name(self.study, (*place, "against"), "reference of the table", name, table.references)
        for i, row in enumerate(table.rows):
            place = (*key, "rows", i)
            found = self.chosen(place, {**table.where, **row.where}, one=not table.over)
            if table.over and {*table.where, *row.where} <= {*self.axes}:
                self._differ_over(place, table.over, found)
        for i, column in enumerate(table.columns):
            self.chosen((*key, "columns", i), {**table.where, **column.where}, one=False)
            place = (*key, "columns", i)
            self._published((*place, "published"), column.published, str(table.index))
            for name, values in column.against.items():
                self._published((*place, "against", name), values, str(table.index))
        if table.index in self.axes and {*table.where, *(k for c in table.columns for k in c.where)} <= {*self.axes}:
            try:
                places = [self.every.where({**table.where, **column.where}) for column in table.columns]
                lay_out(table, self.every.columns_of(np.unique(np.concatenate(places))), [*self.axes])
            except LayoutError as error:
                raise self.study.error((*key, *error.key), str(error)) from None

    def figure(self, key: Key, figure: FigureSpec) -> None:
        """Raise UserError for the first mistake of a figure."""
        self._can_be_set((*key, "title"), figure.title)
        for i, panel in enumerate(figure.panels):
            for name in ("title", "x_label", "y_label", "note"):
                self._can_be_set((*key, "panels", i, name), getattr(panel, name))
            for level in panel.levels:
                self._can_be_set((*key, "panels", i, "levels", level), level)
            for j, curve in enumerate(panel.curves):
                self._can_be_set((*key, "panels", i, "curves", j, "label"), curve.label)
            if panel.measured_rpm is not None and not self._overlays:
                message = "there is no [friction_curves] with a file of measured curves"
                raise self.study.error((*key, "panels", i, "measured_rpm"), message)
            for j, curve in enumerate(panel.curves):
                place = (*key, "panels", i, "curves", j)
                if panel.x in self.columns:
                    self._curve_of_results(place, panel, curve)
                else:
                    self._curve_of_signals(place, panel, curve)

    def chosen(self, key: Key, where: Mapping[str, object], *, one: bool) -> list[int]:
        """Indices of the cases that `where` picks; all that may be, if it asks for a figure of the results."""
        for name in where:
            check_name(self.study, (*key, "where", name), "column", name, self.columns)
        asked = {name: value for name, value in where.items() if name in self.axes}
        found = [int(place) for place in self.every.where(asked)]
        if not found or (one and len(found) > 1 and len(asked) == len(where)):
            what = f"{'no' if not found else len(found)} case{'s' * (len(found) > 1)}"
            wanted = f" {'has' if len(found) < 2 else 'have'} {in_words(asked)}" if asked else " to choose from"
            raise self.study.error((*key, "where"), f"{what}{wanted}, expected {'one' if one else 'at least one'}")
        return found

    def joined(self) -> list[str]:
        """Lines that would join several cases at one value of their axis: figures that are seldom meant."""
        return [
            str(self.study.error(("figures", i, "panels", j, "curves", k), f"{JOINS} {two}; {hint}"))
            for i, figure in enumerate(self.study.file.figures)
            for j, panel in enumerate(figure.panels)
            for k, curve in enumerate(panel.curves)
            if curve.style == "line" and not panel.over and panel.x in self.columns
            if (two := self._two_at_one_x(panel, curve, self.chosen((), curve.where, one=False)))
            for hint in [OVER_DRAWS if DRAW in self.axes else SAY_WHICH]
        ]

    def _summary(self, key: Key, summary: Summary, column: str) -> None:
        """What is taken of a column has to be something that its values allow."""
        if column in WORDS and summary.take not in (None, "share"):
            message = f'got "{summary.take}" of {column}, which is words; expected "share"'
            raise self.study.error((*key, "take"), message)
        for word in summary.of if column in WORDS else ():
            check_name(self.study, (*key, "of"), "word", word, WORDS[column])
        if summary.take == "share_below":
            try:
                level_of(summary, column)
            except QuantityError as error:
                raise self.study.error((*key, "level"), str(error)) from None

    def _over(self, key: Key, axes: Sequence[str]) -> None:
        """Raise UserError for an axis that there is not."""
        for axis in axes:
            if axis == DRAW and DRAW not in self.axes:
                raise self.study.error(key, f'no axis "{DRAW}": draw machines first, with draws = 100 in [uncertainty]')
            check_name(self.study, key, "axis", axis, self.axes)

    def _differ_over(self, key: Key, over: Sequence[str], cases: Sequence[int]) -> None:
        """Cases of which one figure is taken may differ in the axes that it is over, and in no other."""
        for axis, values in self.every.columns_of(np.array(cases)).items():
            other = next((value for value in values if value != values[0]), None)
            if axis not in over and other is not None:
                cases_of = f"{axis} {values[0]} and {axis} {other}"
                raise self.study.error((*key, "where"), f"is of cases of {cases_of}; say which, or name {axis} in over")

    @cached_property
    def _overlays(self) -> list[Overlay]:
        """Measured curves that figures can draw."""
        return overlays_of(self.study)

    def _can_be_set(self, key: Key, text: str | None) -> None:
        """Raise UserError where a text of a figure has mathematics that matplotlib cannot set."""
        if not text or all(map(PLAIN.fullmatch, text.split("$")[1::2])):
            return
        from workbench.publish.figure_text import mathematics_fails  # whoever has indices and powers alone does without

        if why := mathematics_fails(text):
            message = (
                f'got "{shortened(text)}", whose mathematics between $ cannot be set ({why}); write \\$ for a dollar'
            )
            raise self.study.error(key, message) from None

    def _curve_of_results(self, key: Key, panel: Panel, curve: Curve) -> None:
        check_name(self.study, (*key, "y"), "figure", curve.y, self.columns)
        if curve.y in WORDS and curve.take is None:
            raise self.study.error((*key, "y"), f"{curve.y} is words; a share of them can be drawn with over")
        self._summary(key, curve, curve.y)
        found = self.chosen(key, curve.where, one=False)
        if panel.y_unit is not None:
            self._unit((*key[:4], "y_unit"), summary_unit(curve, curve.y), panel.y_unit)
        try:
            if panel.x in self.axes:
                shown_unit(panel.x, self.axes[panel.x], panel.x_unit)
            elif panel.x_unit is not None:
                shown_factor(unit_of_column(panel.x), panel.x_unit)
        except QuantityError as error:
            raise self.study.error((*key[:4], "x" if panel.x_unit is None else "x_unit"), str(error)) from None
        self._published(key, curve.published, panel.x)
        self._over((*key[:4], "over"), panel.over)
        if panel.over and (two := self._two_at_one_x(panel, curve, found)):
            raise self.study.error((*key, "where"), f"has {two}; say which in its where, or name that axis in over")

    def _two_at_one_x(self, panel: Panel, curve: Curve, found: Sequence[int]) -> str:
        """The first two cases of a curve over an axis at one value of it that an axis beside `over` tells apart, in
        words; "" where there are none.
        """
        if panel.x not in self.axes or not {*curve.where} <= {*self.axes}:
            return ""
        columns = self.every.columns_of(np.array(found))
        others = [axis for axis in columns if axis not in (panel.x, *panel.over)]
        seen: dict[object, int] = {}
        for i, x in enumerate(columns[panel.x]):
            if x is None:
                continue  # it is not drawn
            first = seen.setdefault(comparable(x), i)
            for axis in others:
                one, other = (columns[axis][case] for case in (first, i))
                if one != other:
                    return f"two cases for {panel.x} {x}: {axis} {one} and {axis} {other}"
        return ""

    def _curve_of_signals(self, key: Key, panel: Panel, curve: Curve) -> None:
        for name in curve.where:
            check_name(self.study, (*key, "where", name), "axis", name, self.axes)
        if panel.over:
            message = f'belongs to a panel of results: expected as x an axis, not the signal "{panel.x}"'
            raise self.study.error((*key[:4], "over"), message)
        case = self.chosen(key, curve.where, one=True)[0]
        units = signal_units(self.axis)
        x_unit = units.get(panel.x, "1") if panel.x_unit is None else panel.x_unit
        y_unit = units.get(curve.y, "1") if panel.y_unit is None else panel.y_unit
        for coordinate, name, shown in (("x", curve.x or panel.x, x_unit), ("y", curve.y, y_unit)):
            place = key if coordinate == "y" or curve.x else key[:4]
            self.signal((*place, coordinate), name, [case])
            self._unit((*key[:4], f"{coordinate}_unit"), units.get(name, "1"), shown)

    def _unit(self, key: Key, unit: str, shown: str) -> None:
        try:
            shown_factor(unit, shown)
        except QuantityError as error:
            raise self.study.error(key, str(error)) from None

    def _published(self, key: Key, values: Iterable[str], axis: str) -> None:
        numeric = not are_names(self.axes.get(axis, []))
        for value in values:
            if numeric and are_names([value]):
                raise self.study.error(key, f'got "{value}", expected a number as {axis} has them')
