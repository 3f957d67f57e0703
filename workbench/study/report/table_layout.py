"""Which cases stand where in a table over an axis: a line for each value of the index and of the axes left open."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.study.names import comparable, in_words
from workbench.study.report.schema import Column, TableSpec

Columns = Mapping[str, Sequence[object]]
"""What tells cases apart: by name, a value for each case."""


class LayoutError(ValueError):
    """Cases that have no place of their own; `key` is what to change, within the table."""

    def __init__(self, key: tuple[str | int, ...], message: str) -> None:
        super().__init__(message)
        self.key = key


@dataclass(frozen=True)
class Heading:
    """One column of figures: `column`, of the cases that have the value `across` on the axis of that name, if any."""

    place: int
    column: Column
    across: object = None


@dataclass(frozen=True)
class Line:
    """One line: the values of the index and of the open axes, and by heading the places of its cases: one, or those
    that the table is over.
    """

    values: Mapping[str, object]
    cases: Sequence[Sequence[int]]


@dataclass(frozen=True)
class Layout:
    """Headings and lines of a table over an axis."""

    headings: Sequence[Heading]
    lines: Sequence[Line]


def lay_out(table: TableSpec, columns: Columns, axes: Sequence[str]) -> Layout:
    """The lines of a table over its index.

    Args:
        table: the table; each column may pick cases of its own by its `where`.
        columns: what the cases are, by name; those of the index and of every `where` among them.
        axes: those names that tell cases apart.

    Raises:
        LayoutError: two cases for one place, or one without a value on the axis `across`.
    """
    index = str(table.index)
    coded = _Coded(columns)
    picked = [coded.where({**table.where, **column.where}) for column in table.columns]
    every = np.unique(np.concatenate(picked))
    told = {*table.where, index, str(table.across), *(name for column in table.columns for name in column.where)}
    others = [name for name in axes if name not in told and name not in table.over and coded.differ(name, every)]
    headings, found = _headings(table, coded, picked)
    keys = coded.together((index, *others))
    lines: dict[int, list[Sequence[int]]] = {}
    for number, cases in enumerate(found):
        for together in _grouped(keys, cases):
            line = lines.setdefault(int(keys[together[0]]), [()] * len(headings))
            line[number] = together
    ordered = sorted(lines.values(), key=lambda line: min(cases[0] for cases in line if len(cases)))
    if not table.over:
        _check_single(table, headings, ordered, columns, axes)
    return Layout(headings, [Line(_named(columns, line, (index, *others)), line) for line in ordered])


class _Coded:
    """Columns as numbers, equal where their values compare equal; -1 where there is none."""

    def __init__(self, columns: Columns) -> None:
        self.columns = columns
        self._known: dict[str, tuple[np.ndarray, dict[float | str, int]]] = {}

    def column(self, name: str) -> tuple[np.ndarray, dict[float | str, int]]:
        """The codes of a column, and the code of each value that it has."""
        if name not in self._known:
            codes: dict[float | str, int] = {}
            of_value: dict[object, int] = {}
            for value in dict.fromkeys(map(_hashable, self.columns[name])):
                one = comparable(value)
                missing = value is None or one != one
                of_value[value] = -1 if missing else codes.setdefault(one, len(codes))
            self._known[name] = np.array([of_value[_hashable(value)] for value in self.columns[name]], dtype=int), codes
        return self._known[name]

    def where(self, wanted: Mapping[str, object]) -> np.ndarray:
        """Places of the cases that have these values; numbers are compared as numbers."""
        keep = np.ones(len(next(iter(self.columns.values()))), dtype=bool)
        for name, value in wanted.items():
            codes, known = self.column(name)
            keep &= codes == known.get(comparable(value), len(known))
        return np.flatnonzero(keep)

    def differ(self, name: str, places: np.ndarray) -> bool:
        """Whether these cases have more than one value in a column."""
        codes = self.column(name)[0][places]
        return bool(len(codes)) and bool((codes != codes[0]).any())

    def together(self, names: Sequence[str]) -> np.ndarray:
        """A number for each case, equal where they agree in all of these columns."""
        keys = np.zeros(len(self.column(names[0])[0]), dtype=int)
        for name in names:
            codes, known = self.column(name)
            _, keys = np.unique(keys * (len(known) + 1) + codes + 1, return_inverse=True)
        return keys


def _hashable(value: object) -> object:
    """A value that can be looked up: an array of a study as its text, and every NaN as the same."""
    if isinstance(value, list | dict):
        return str(value)
    return None if value != value else value


def _grouped(keys: np.ndarray, cases: np.ndarray) -> list[list[int]]:
    """Cases with equal keys together, each in the order of the cases."""
    order = cases[np.argsort(keys[cases], kind="stable")]
    ends = np.flatnonzero(np.diff(keys[order])) + 1
    return [group.tolist() for group in np.split(order, ends) if len(group)]


def _headings(table: TableSpec, coded: _Coded, picked: Sequence[np.ndarray]) -> tuple[list[Heading], list[np.ndarray]]:
    """The headings, and the cases of each."""
    if table.across is None:
        return [Heading(i, column) for i, column in enumerate(table.columns)], list(picked)
    headings: list[Heading] = []
    found: list[np.ndarray] = []
    codes, _ = coded.column(table.across)
    for i, (column, cases) in enumerate(zip(table.columns, picked, strict=True)):
        if missing := int((codes[cases] < 0).sum()):
            raise LayoutError(("across",), f"{missing} of its cases have no {table.across}: leave them to where")
        for code in dict.fromkeys(codes[cases].tolist()):
            these = cases[codes[cases] == code]
            headings.append(Heading(i, column, coded.columns[table.across][these[0]]))
            found.append(these)
    return headings, found


def _check_single(
    table: TableSpec,
    headings: Sequence[Heading],
    lines: Sequence[Sequence[Sequence[int]]],
    columns: Columns,
    axes: Sequence[str],
) -> None:
    """Raise LayoutError for the first place that two cases have."""
    index = str(table.index)
    for heading, cases in ((heading, line[i]) for i, heading in enumerate(headings) for line in lines):
        if len(cases) < 2:
            continue
        one, other = ({name: columns[name][case] for name in columns} for case in cases[:2])
        apart = [name for name in axes if _differ(one.get(name), other.get(name))] or [index]
        two = " and ".join(in_words({name: _said(case.get(name)) for name in apart}) for case in (one, other))
        raise LayoutError(
            ("columns", heading.place),
            f'"{heading.column.label}" has two cases for {in_words({index: one.get(index)})}: {two}; say which in its '
            f"where, or in that of the table",
        )


def _said(value: object) -> object:
    return "without" if value is None else value


def _differ(one: object, other: object) -> bool:
    one, other = _hashable(one), _hashable(other)
    return (one is None) != (other is None) or comparable(one) != comparable(other)


def _named(columns: Columns, line: Sequence[Sequence[int]], names: Sequence[str]) -> dict[str, object]:
    first = next(cases[0] for cases in line if len(cases))
    return {name: columns[name][first] for name in names}
