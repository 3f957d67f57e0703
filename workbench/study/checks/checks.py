"""What a study asks of its results, checked before it runs: probes, tables and figures, and settings without use."""

import re
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from difflib import get_close_matches
from functools import cached_property, partial

import numpy as np
from pydantic import BaseModel

from plants.axis import LINEAR
from workbench.errors import nearest, shortened
from workbench.metrics.registry import names_along
from workbench.metrics.window import whole_periods
from workbench.simulation.references import ReferenceSignal, Steps
from workbench.simulation.setup import memory_names
from workbench.study.axis_values import are_names, shown_unit
from workbench.study.cases import Cases
from workbench.study.checks.load import unheld
from workbench.study.checks.rotation import rotation_warning
from workbench.study.checks.use import check_use
from workbench.study.names import in_words, shown_factor, signal_units, signals_of, unit_of_column
from workbench.study.report.schema import Column, Curve, FigureSpec, Panel, Row, TableSpec
from workbench.study.report.table_layout import LayoutError, lay_out
from workbench.study.resolve import Resolved, resolve
from workbench.study.sections import Checked, Overlay, overlays_of, placed, sections_of
from workbench.study.study import INDEX, Case, Study, check_name, located, named
from workbench.toml.quantities import check_along
from workbench.toml.reading import Key, SchemaError
from workbench.toml.units import QuantityError

MEMORY = "controller_"
"""What the names of signals of a controller's state begin with."""

CLOSE = 0.85
"""Likeness above which such a name is a slip of the pen: they all begin alike."""


WINDOWED = ("rms_error_m", "max_error_m")
"""Figures of all that comes after the transient."""

REACH_INSTANTS = 10_001
"""At most so many instants tell how far a reference goes."""


PLAIN = re.compile(r"(?:[^\\{}_^]|[_^]\w(?![_^]))*")
"""Mathematics that can always be set: symbols, with an index or a power of one letter or digit."""


@dataclass(frozen=True)
class Checks:
    """A study with those of its cases that stand for all, what these resolve to, and the figures of its results."""

    study: Study
    cases: Sequence[Case]
    resolved: Sequence[Resolved]
    every: Cases
    figures: Sequence[str]

    @cached_property
    def axes(self) -> dict[str, list[object]]:
        """The columns that tell the cases apart, each with its values."""
        return self.every.axes

    @cached_property
    def columns(self) -> list[str]:
        """All columns but those of probes that clash."""
        return [*self.axes, *self.figures, *self.study.file.probes]

    @cached_property
    def _known(self) -> dict[int, Resolved]:
        """What has been resolved, by the case's index."""
        return {case.index: item for case, item in zip(self.cases, self.resolved, strict=True)}

    def _item(self, index: int) -> Resolved:
        """What a case resolves to."""
        if index not in self._known:
            self._known[index] = resolve(self.study, self.every[index])
        return self._known[index]

    @property
    def axis(self) -> str:
        """Unit of the positions of the study's plants."""
        return self.resolved[0].setup.plant.axis if self.resolved else LINEAR

    def all(self) -> None:
        """Raise UserError for the first mistake."""
        self._references()
        self._probes()
        for i, name in enumerate(self.study.file.records):
            self._signal(("records", i), name, [*self._known])
        several = dict.fromkeys(section.name for section, _ in sections_of(self.study) if section.several)
        for kind in ("tables", "figures", *several):
            names = [str(getattr(item, "name", i)) for i, item in enumerate(getattr(self.study.file, kind))]
            for i, name in enumerate(names):
                if name in names[:i]:
                    raise self.study.error((kind, i, "name"), f'"{name}" is taken: expected another name')
        for i, table in enumerate(self.study.file.tables):
            self._table(("tables", i), table)
        for i, figure in enumerate(self.study.file.figures):
            self._figure(("figures", i), figure)
        for section, content, key in placed(self.study):
            self._along(content, key)
            section.check(content, replace(self._checked, key=key))
        if len(self.cases) == self.every.bases:  # what is of use in none of these may be in others
            check_use(self.study, self.cases, self.resolved)

    def _references(self) -> None:
        """Raise UserError where a reference, or what is fed to an input, is more than a number can hold."""
        seen: set[str] = set()
        for case, item in zip(self.cases, self.resolved, strict=True):
            setup, tables = item.setup, case.tables["references"]
            point = repr((tables, setup.duration, setup.plant.axis))
            if point in seen:
                continue
            seen.add(point)
            for signal in (setup.reference, *(feed.signal for feed in setup.feeds)):
                if signal is not None and not _is_finite(signal, setup.duration, setup.sample_time):
                    name = named(case, "reference")
                    key = ("references", name) if signal is setup.reference else ("references",)
                    message = f"grows beyond all numbers within {setup.duration:g} s; expected less, or slower"
                    raise located(self.study, case, key, message)

    def _along(self, content: BaseModel, key: Key) -> None:
        """Quantities of a question along the axis of the study's plants."""
        try:
            check_along(content, self.axis, key)
        except SchemaError as mistake:
            raise self.study.error(mistake.key, mistake.message) from None

    @property
    def _checked(self) -> Checked:
        """What the sections of other questions are handed."""
        several = partial(self._chosen, one=False)
        return Checked(self.study, self.cases, self.resolved, [*self.axes], self.figures, several)

    def _signal(self, key: Key, name: str, cases: Sequence[int]) -> None:
        """`name` has to be a signal of at least one of the cases of these indices."""
        setups = {i: self._item(i).setup for i in cases}
        known = dict.fromkeys(
            signal
            for setup in setups.values()
            for signal in signals_of(setup.plant, setup.loop.controller, setup.reference is not None)
        )
        if name in known:
            return
        if not name.startswith(MEMORY):
            raise self.study.error(key, f'unknown signal "{shortened(name)}"; {nearest(name, known)}')
        said = {}
        for i, setup in setups.items():
            controller = setup.loop.controller
            own = ", ".join(memory_names(controller)) or "none"
            said[f'"{named(self.every[i], "controller")}" (type {controller.name})'] = own
        owners = "; ".join(f"controller {who} has {own}" for who, own in said.items())
        close = get_close_matches(name, [signal for signal in known if signal.startswith(MEMORY)], n=1, cutoff=CLOSE)
        hint = f'did you mean "{close[0]}"? ' if close else ""
        raise self.study.error(key, f'no signal "{shortened(name)}" here; {hint}{owners}')

    def _unit(self, key: Key, unit: str, shown: str) -> None:
        try:
            shown_factor(unit, shown)
        except QuantityError as error:
            raise self.study.error(key, str(error)) from None

    def _probes(self) -> None:
        taken = {name.casefold() for name in (INDEX, *self.axes, *self.figures)}
        for name, probe in self.study.file.probes.items():
            if name.casefold() in taken:
                raise self.study.error(("probes", name), "the results have a column of this name already")
            taken.add(name.casefold())
            for case in probe.cases:
                check_name(self.study, ("probes", name, "cases"), "case", case, self.study.file.cases)
            probed = [case.index for case in self.cases if not probe.cases or case.name in probe.cases]
            self._signal(("probes", name, "signal"), probe.signal, probed)
            if probe.event is not None:
                self._signal(("probes", name, "event"), probe.event, probed)

    def _chosen(self, key: Key, where: Mapping[str, object], *, one: bool) -> list[int]:
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

    def _published(self, key: Key, values: Iterable[str], axis: str) -> None:
        numeric = not are_names(self.axes.get(axis, []))
        for value in values:
            if numeric and are_names([value]):
                raise self.study.error(key, f'got "{value}", expected a number as {axis} has them')

    def _table(self, key: Key, table: TableSpec) -> None:
        if table.index is not None:
            check_name(self.study, (*key, "index"), "axis", table.index, self.columns)
            self._chosen(key, table.where, one=False)
        if table.across is not None:
            check_name(self.study, (*key, "across"), "axis", table.across, self.axes)
        forms: dict[str, Sequence[Column | Row]] = {"columns": table.columns, "rows": table.rows}
        for form, items in forms.items():
            for i, item in enumerate(items):
                place = (*key, form, i)
                check_name(self.study, (*place, "result"), "figure", item.result, self.columns)
                self._unit((*place, "unit"), unit_of_column(item.result), item.unit)
                for name in item.against:
                    check_name(self.study, (*place, "against"), "reference of the table", name, table.references)
        for i, row in enumerate(table.rows):
            self._chosen((*key, "rows", i), {**table.where, **row.where}, one=True)
        for i, column in enumerate(table.columns):
            self._chosen((*key, "columns", i), {**table.where, **column.where}, one=False)
            place = (*key, "columns", i)
            self._published((*place, "published"), column.published, str(table.index))
            for name, values in column.against.items():
                self._published((*place, "against", name), values, str(table.index))
        if table.index in self.axes and {*table.where, *(k for c in table.columns for k in c.where)} <= {*self.axes}:
            rows = [self.every.columns(int(place)) for place in self.every.where(table.where)]
            try:
                lay_out(table, rows, [*self.axes])
            except LayoutError as error:
                raise self.study.error((*key, *error.key), str(error)) from None

    @cached_property
    def _overlays(self) -> list[Overlay]:
        """Measured curves that figures can draw."""
        return overlays_of(self.study)

    def _figure(self, key: Key, figure: FigureSpec) -> None:
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
        self._chosen(key, curve.where, one=False)
        if panel.y_unit is not None:
            self._unit((*key[:4], "y_unit"), unit_of_column(curve.y), panel.y_unit)
        try:
            if panel.x in self.axes:
                shown_unit(panel.x, self.axes[panel.x], panel.x_unit)
            elif panel.x_unit is not None:
                shown_factor(unit_of_column(panel.x), panel.x_unit)
        except QuantityError as error:
            raise self.study.error((*key[:4], "x" if panel.x_unit is None else "x_unit"), str(error)) from None
        self._published(key, curve.published, panel.x)

    def _curve_of_signals(self, key: Key, panel: Panel, curve: Curve) -> None:
        for name in curve.where:
            check_name(self.study, (*key, "where", name), "axis", name, self.axes)
        case = self._chosen(key, curve.where, one=True)[0]
        units = signal_units(self.axis)
        x_unit = units.get(panel.x, "1") if panel.x_unit is None else panel.x_unit
        y_unit = units.get(curve.y, "1") if panel.y_unit is None else panel.y_unit
        for coordinate, name, shown in (("x", curve.x or panel.x, x_unit), ("y", curve.y, y_unit)):
            place = key if coordinate == "y" or curve.x else key[:4]
            self._signal((*place, coordinate), name, [case])
            self._unit((*key[:4], f"{coordinate}_unit"), units.get(name, "1"), shown)

    def warnings(self) -> list[str]:
        """What may be meant, and seldom is: far references, too little after the transient, rotations not held."""
        found = dict.fromkeys(
            line for section, table in sections_of(self.study) for line in section.warnings(table, self._checked)
        )
        seen: set[str] = set()
        for case, item in zip(self.cases, self.resolved, strict=True):
            turned = repr((case.tables["plant"], item.setup.rotation_speed, item.belief, item.setup.sample_time))
            if turned not in seen:
                seen.add(turned)
                if message := rotation_warning(case, item):
                    found[str(located(self.study, case, ("plant", "rotation"), message))] = None
                if message := unheld(item.setup.plant, item.setup.parameters):
                    found[str(located(self.study, case, ("plant",), message))] = None
            name, travel = named(case, "reference"), item.setup.plant.travel(item.setup.parameters)
            point = (name, case.tables["references"].get(name), item.setup.duration, item.transient, travel)
            if item.signal is None or repr(point) in seen:
                continue
            seen.add(repr(point))
            if item.setup.reference is not None and (reach := _reach(item)) > 0.5 * travel:
                message = f"reaches {reach:g} {self.axis}, the stroke ends at +-{0.5 * travel:g} {self.axis}"
                found[str(located(self.study, case, ("references", name), message))] = None
            period, left = item.signal.period, item.setup.duration - item.transient
            if item.setup.reference is not None and period is not None and whole_periods(left, period) == 0:
                message = f'"{name}" has a period of {period:g} s, and after the transient only {left:g} s are left'
                found[str(located(self.study, case, ("simulation", "duration"), message))] = None
            if self._errors_are_asked_for and (jump := _last_jump(item)) is not None and jump < item.transient:
                message = (
                    f'"{name}" jumps for the last time at {jump:g} s, and the transient of {item.transient:g} s leaves '
                    f"nothing of that to {' and '.join(self._windowed)}; shorten it, or ask for steady-state errors"
                )
                found[str(located(self.study, case, ("simulation", "transient"), message))] = None
        return list(found)

    @property
    def _windowed(self) -> list[str]:
        called = names_along(self.axis)
        return [called[name] for name in WINDOWED]

    @cached_property
    def _errors_are_asked_for(self) -> bool:
        """Whether a table asks for the errors after the transient; without tables any figure may be meant."""
        tables = self.study.file.tables
        asked = {one.result for table in tables for one in table.columns}
        asked |= {one.result for table in tables for one in table.rows}
        return not tables or not asked.isdisjoint(self._windowed)


def _is_finite(signal: ReferenceSignal, duration: float, sample_time: float) -> bool:
    """Whether a signal and its derivatives are numbers from beginning to end."""
    instants = np.linspace(0.0, duration, min(round(duration / sample_time) + 1, REACH_INSTANTS))
    try:
        with np.errstate(over="raise", invalid="raise", divide="raise"):
            return all(bool(np.all(np.isfinite(values))) for values in signal(instants))
    except FloatingPointError:
        return False


def _reach(item: Resolved) -> float:
    """Largest magnitude (m) of a case's reference."""
    setup = item.setup
    instants = min(round(setup.duration / setup.sample_time) + 1, REACH_INSTANTS)
    return (
        float(np.max(np.abs(setup.reference(np.linspace(0.0, setup.duration, instants))[0])))
        if setup.reference
        else 0.0
    )


def _last_jump(item: Resolved) -> float | None:
    """When steps jump for the last time within a case (s)."""
    reference = item.setup.reference
    dwells = reference.dwells(item.setup.duration) if isinstance(reference, Steps) else []
    return dwells[-1][0] if dwells else None
