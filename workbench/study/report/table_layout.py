"""Which case stands where in a table over an axis: a line for each value of the index and of the axes left open."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from workbench.study.names import comparable, in_words, matches
from workbench.study.report.schema import Column, TableSpec


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
    """One line: the values of the index and of the open axes, and by heading the place of its case, None without."""

    values: Mapping[str, object]
    cases: Sequence[int | None]


@dataclass(frozen=True)
class Layout:
    """Headings and lines of a table over an axis."""

    headings: Sequence[Heading]
    lines: Sequence[Line]


def lay_out(table: TableSpec, records: Sequence[Mapping[str, object]], axes: Sequence[str]) -> Layout:
    """The lines of a table over its index.

    Args:
        table: the table; each column may pick cases of its own by its `where`.
        records: columns of the cases by name.
        axes: those names that tell cases apart.

    Raises:
        LayoutError: two cases for one place, or one without a value on the axis `across`.
    """
    index = str(table.index)
    picked = [_picked(records, {**table.where, **column.where}) for column in table.columns]
    every = sorted({i for found in picked for i in found})
    told = {*table.where, index, str(table.across), *(name for column in table.columns for name in column.where)}
    others = [name for name in axes if name not in told and len({_value(records[i], name) for i in every}) > 1]
    headings, found = _headings(table, records, picked)
    lines: dict[tuple[float | str | None, ...], list[int | None]] = {}
    for number, (heading, cases) in enumerate(zip(headings, found, strict=True)):
        for i in cases:
            line = lines.setdefault(_place(records[i], (index, *others)), [None] * len(headings))
            before = line[number]
            if before is not None:
                raise _two_in_one(table, heading, records[before], records[i], axes)
            line[number] = i
    ordered = sorted(lines.values(), key=lambda line: min(i for i in line if i is not None))
    return Layout(headings, [Line(_named(records, line, (index, *others)), line) for line in ordered])


def _picked(records: Sequence[Mapping[str, object]], where: Mapping[str, object]) -> list[int]:
    return [i for i, record in enumerate(records) if matches(record, where)]


def _headings(
    table: TableSpec, records: Sequence[Mapping[str, object]], picked: Sequence[Sequence[int]]
) -> tuple[list[Heading], list[list[int]]]:
    """The headings, and the cases of each."""
    headings: list[Heading] = []
    found: list[list[int]] = []
    for i, (column, cases) in enumerate(zip(table.columns, picked, strict=True)):
        if table.across is None:
            headings.append(Heading(i, column))
            found.append(list(cases))
            continue
        for value in dict.fromkeys(_value(records[case], table.across) for case in cases):
            these = [case for case in cases if _value(records[case], table.across) == value]
            if value is None:
                raise LayoutError(("across",), f"{len(these)} of its cases have no {table.across}: leave them to where")
            headings.append(Heading(i, column, records[these[0]][table.across]))
            found.append(these)
    return headings, found


def _two_in_one(
    table: TableSpec, heading: Heading, one: Mapping[str, object], other: Mapping[str, object], axes: Sequence[str]
) -> LayoutError:
    apart = [name for name in axes if _value(one, name) != _value(other, name)] or [str(table.index)]
    place = in_words({str(table.index): one.get(str(table.index))})
    cases = " and ".join(in_words({name: case.get(name, "without") for name in apart}) for case in (one, other))
    return LayoutError(
        ("columns", heading.place),
        f'"{heading.column.label}" has two cases for {place}: {cases}; say which in its where, or in that of the table',
    )


def _value(record: Mapping[str, object], name: str) -> float | str | None:
    """A value to compare; None where there is none."""
    value = comparable(record.get(name))
    return None if record.get(name) is None or value != value else value


def _place(record: Mapping[str, object], names: Sequence[str]) -> tuple[float | str | None, ...]:
    return tuple(_value(record, name) for name in names)


def _named(
    records: Sequence[Mapping[str, object]], line: Sequence[int | None], names: Sequence[str]
) -> dict[str, object]:
    first = records[next(i for i in line if i is not None)]
    return {name: first.get(name) for name in names}
