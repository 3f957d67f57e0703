"""What a study asks of its results, checked before it runs: probes, tables and figures, and settings without use."""

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from plants.equation import fields
from plants.interface import Plant
from plants.registry import plants
from workbench.errors import nearest
from workbench.files import Key
from workbench.parameters import FLOW_SHARE
from workbench.study.document import Case, Study, located
from workbench.study.names import in_words, matches, shown_factor, signal_units, signals_of, unit_of_column
from workbench.study.resolve import Resolved
from workbench.study.schema import Column, Curve, FigureSpec, Panel, Row, TableSpec
from workbench.study.store import INDEX
from workbench.units import QuantityError


@dataclass(frozen=True)
class Checks:
    """A study with what its cases resolve to, and the columns that its results will have."""

    study: Study
    cases: Sequence[Case]
    resolved: Sequence[Resolved]
    axes: Sequence[str]
    figures: Sequence[str]

    @cached_property
    def columns(self) -> list[str]:
        """All columns but those of probes that clash."""
        return [*self.axes, *self.figures, *self.study.file.probes]

    @cached_property
    def signals(self) -> list[list[str]]:
        """Names of the signals of each case."""
        return [
            signals_of(item.setup.plant, item.setup.loop.controller, item.setup.reference is not None)
            for item in self.resolved
        ]

    def all(self) -> None:
        """Raise UserError for the first mistake."""
        self._probes()
        for kind in ("tables", "figures"):
            names = [item.name for item in getattr(self.study.file, kind)]
            for i, name in enumerate(names):
                if name in names[:i]:
                    raise self.study.error((kind, i, "name"), f'"{name}" is taken: expected another name')
        for i, table in enumerate(self.study.file.tables):
            self._table(("tables", i), table)
        for i, figure in enumerate(self.study.file.figures):
            self._figure(("figures", i), figure)
        self._without_use()

    def _name(self, key: Key, what: str, name: str, valid: Iterable[str]) -> None:
        names = list(valid)
        if name not in names:
            raise self.study.error(key, f'unknown {what} "{name}"; {nearest(name, names)}')

    def _unit(self, key: Key, unit: str, shown: str) -> None:
        try:
            shown_factor(unit, shown)
        except QuantityError as error:
            raise self.study.error(key, str(error)) from None

    def _probes(self) -> None:
        taken = {name.casefold() for name in (INDEX, *self.axes, *self.figures)}
        signals = sorted({name for names in self.signals for name in names})
        for name, probe in self.study.file.probes.items():
            if name.casefold() in taken:
                raise self.study.error(("probes", name), "the results have a column of this name already")
            taken.add(name.casefold())
            self._name(("probes", name, "signal"), "signal", probe.signal, signals)
            if probe.event is not None:
                self._name(("probes", name, "event"), "signal", probe.event, signals)
            for case in probe.cases:
                self._name(("probes", name, "cases"), "case", case, self.study.file.cases)

    def _chosen(self, key: Key, where: Mapping[str, Any], *, one: bool) -> list[int]:
        """Places of the cases that `where` picks; all that may be, if it asks for a figure of the results."""
        for name in where:
            self._name((*key, "where", name), "column", name, self.columns)
        asked = {name: value for name, value in where.items() if name in self.axes}
        found = [i for i, case in enumerate(self.cases) if matches(case.columns, asked)]
        if not found or (one and len(found) > 1 and len(asked) == len(where)):
            what = f"{'no' if not found else len(found)} case{'s' * (len(found) > 1)}"
            wanted = f" {'has' if len(found) < 2 else 'have'} {in_words(asked)}" if asked else " to choose from"
            raise self.study.error((*key, "where"), f"{what}{wanted}, expected {'one' if one else 'at least one'}")
        return found

    def _published(self, key: Key, values: Iterable[str], axis: str) -> None:
        numeric = all(isinstance(case.columns.get(axis, 0), int | float) for case in self.cases)
        for value in values:
            if numeric and not _is_number(value):
                raise self.study.error((*key, "published"), f'got "{value}", expected a number as {axis} has them')

    def _table(self, key: Key, table: TableSpec) -> None:
        if table.index is not None:
            self._name((*key, "index"), "axis", table.index, self.columns)
            self._chosen(key, table.where, one=False)
        forms: dict[str, Sequence[Column | Row]] = {"columns": table.columns, "rows": table.rows}
        for form, items in forms.items():
            for i, item in enumerate(items):
                place = (*key, form, i)
                self._name((*place, "result"), "figure", item.result, self.columns)
                self._unit((*place, "unit"), unit_of_column(item.result), item.unit)
        for i, row in enumerate(table.rows):
            self._chosen((*key, "rows", i), {**table.where, **row.where}, one=True)
        for i, column in enumerate(table.columns):
            self._published((*key, "columns", i), column.published, str(table.index))

    def _figure(self, key: Key, figure: FigureSpec) -> None:
        for i, panel in enumerate(figure.panels):
            for j, curve in enumerate(panel.curves):
                place = (*key, "panels", i, "curves", j)
                if panel.x in self.columns:
                    self._curve_of_results(place, panel, curve)
                else:
                    self._curve_of_signals(place, panel, curve)

    def _curve_of_results(self, key: Key, panel: Panel, curve: Curve) -> None:
        self._name((*key, "y"), "figure", curve.y, self.columns)
        self._chosen(key, curve.where, one=False)
        self._unit((*key[:4], "y_unit"), unit_of_column(curve.y), panel.y_unit)
        self._published(key, curve.published, panel.x)

    def _curve_of_signals(self, key: Key, panel: Panel, curve: Curve) -> None:
        for name in curve.where:
            self._name((*key, "where", name), "axis", name, self.axes)
        case = self._chosen(key, curve.where, one=True)[0]
        units = signal_units()
        for coordinate, name, shown in (("x", curve.x or panel.x, panel.x_unit), ("y", curve.y, panel.y_unit)):
            place = key if coordinate == "y" or curve.x else key[:4]
            self._name((*place, coordinate), "signal", name, self.signals[case])
            self._unit((*key[:4], f"{coordinate}_unit"), units.get(name, "1"), shown)

    def _without_use(self) -> None:
        """Settings of the plant that change nothing in any case: a mistake, or the reader is misled."""
        idle: dict[Key, tuple[Case, str]] = {}
        used: set[Key] = set()
        for case, item in zip(self.cases, self.resolved, strict=True):
            family = _family(case, item.setup.plant)
            names = {field.name for plant in family for field in fields(plant.Parameters)} - {FLOW_SHARE}
            for key, applies in _settings(case, family, names).items():
                hint = nearest(str(key[-1]), sorted(names)) if len(key) > 2 else "leave it out"
                idle.setdefault(key, (case, f'plant "{family[0].name}" has no use for it; {hint}'))
                if applies:
                    used.add(key)
        for key, (case, message) in idle.items():
            if key not in used:
                raise located(self.study, case, key, message)


def _family(case: Case, plant: Plant) -> list[Plant]:
    """The plants that the model of a case stands for."""
    if case.tables["plant"].get("model") != "by_rpm":
        return [plant]
    return [plants()["non_rotating"], plants()["rotating_helical"]]


def _settings(case: Case, family: Sequence[Plant], parameters: Iterable[str]) -> dict[Key, bool]:
    """The settings of a case's plant and belief, and whether they mean something to it."""
    names = set(parameters)
    table = case.tables["plant"]
    rotates = any(plant.rotary_command is not None for plant in family)
    valve = any(field.name == FLOW_SHARE for plant in family for field in fields(plant.Parameters))
    features = {"bristle": rotates, "inertia": rotates, "rotation": rotates, "start": rotates, "flow": valve}
    features["command"] = table["model"] == "drive"
    found: dict[Key, bool] = {("plant", name): applies for name, applies in features.items() if name in table}
    for section in (("plant", "set"), ("plant", "scale"), ("belief", "set")):
        for name in case.tables[section[0]].get(section[1], {}):
            found[(*section, name)] = name in names
    return found


def _is_number(text: str) -> bool:
    try:
        float(text)
    except ValueError:
        return False
    return True
