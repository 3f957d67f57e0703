"""CSV, or any other text with a row a sample, under a header of any number of rows or none."""

import codecs
import csv
import gzip
import re
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.records.formats.interface import UNITS, RecordFormat
from workbench.records.spelled import is_unit

if TYPE_CHECKING:
    import pandas as pd

LINES_LOOKED_AT = 400
"""Of a file, to see where its numbers begin and how they are separated."""

SEPARATORS = (";", "\t", ",", "|", " ")
"""In the order in which they are believed; a space stands for any number of them."""

COMMENTS = "#%!"
"""What comments begin with; a header may be one."""

NUMBER = re.compile(r"[+-]?(\d+(\.\d*)?|\.\d+)([eEdD][+-]?\d+)?|[+-]?(nan|inf|infinity)", re.IGNORECASE)
CLOCK = re.compile(r"(\d{2,4}[-/.]\d{1,2}[-/.]\d{1,4}[T ]?)?(\d{1,2}:\d{2}(:\d{2}([.,]\d+)?)?)?(Z|[+-]\d\d:?\d\d)?")


@dataclass(frozen=True)
class Layout:
    """How a text holds its table: separator, decimal mark, the line of its first row from 0, names and units."""

    separator: str
    decimal: str
    first: int
    names: Sequence[str] | None
    units: Sequence[str]


def read(path: Path) -> "pd.DataFrame":
    """A text file of any separator, also compressed (.gz); a first row of numbers alone is no header, but data.

    Above the names there may be comments, and below them a row of units, which become the table's.
    """
    import pandas as pd

    encoding = _encoding(path)
    layout = _layout(list(islice(_lines(path, encoding), LINES_LOOKED_AT)))
    if layout is None:
        return pd.read_csv(path, sep=None, engine="python", skipinitialspace=True, encoding=encoding)
    table = pd.read_csv(
        path,
        sep=r"\s+" if layout.separator == " " else layout.separator,
        decimal=layout.decimal,
        skiprows=layout.first,
        header=None,
        names=None if layout.names is None else _distinct(layout.names),
        index_col=False,
        skipinitialspace=True,
        encoding=encoding,
        low_memory=False,
    )
    if layout.decimal == ",":  # a word in a column leaves its numbers text
        texts = table.select_dtypes(exclude="number")
        table = table.assign(**{str(name): texts[name].str.replace(",", ".") for name in texts if name in table})
    if layout.names is not None:
        table = table.drop(columns=[name for name in table if not str(name)])  # behind a separator at the end of lines
        table.attrs[UNITS] = {
            name.strip(): unit for name, unit in zip(layout.names, layout.units, strict=False) if unit and name.strip()
        }
    return table


def _encoding(path: Path) -> str:
    """The encoding, by its mark, or by what can be read."""
    with _opened(path) as file:
        start = file.read(1 << 16)
    if start.startswith((codecs.BOM_UTF16_LE, codecs.BOM_UTF16_BE)):
        return "utf-16"
    try:
        codecs.getincrementaldecoder("utf-8")().decode(start)
    except UnicodeDecodeError:
        return "cp1252"
    return "utf-8-sig"


def _opened(path: Path) -> "gzip.GzipFile":
    return gzip.open(path) if path.suffix == ".gz" else path.open("rb")  # type: ignore[return-value]


def _lines(path: Path, encoding: str) -> Iterator[str]:
    with _opened(path) as file:
        for line in codecs.iterdecode(file, encoding, errors="replace") if encoding != "utf-16" else ():
            yield line.rstrip("\r\n")
        if encoding == "utf-16":
            yield from file.read().decode(encoding).splitlines()


def _layout(lines: Sequence[str]) -> Layout | None:
    """How the lines hold a table: the separator by which most numbers stand in rows of one length; None without any."""
    best: tuple[int, Layout] | None = None
    for separator in SEPARATORS:
        for decimal in (".", ","):
            if decimal == separator:
                continue
            rows = [_fields(line, separator) for line in lines]
            first, last, count = _longest_run(rows, decimal)
            numbers = sum(_is_number(field, decimal) for row in rows[first:last] for field in row)
            if last == first or (best is not None and numbers <= best[0]) or (count == 1 and separator != ","):
                continue
            names, units = _header(lines[:first], separator, count)
            best = numbers, Layout(separator, decimal, first, names, units)
    return None if best is None else best[1]


def _fields(line: str, separator: str) -> list[str]:
    if separator == " ":
        return line.split()
    if '"' in line:
        return [field.strip() for field in next(csv.reader([line], delimiter=separator, skipinitialspace=True))]
    return [field.strip() for field in line.split(separator)] if line.strip() else []


def _is_number(field: str, decimal: str) -> bool:
    return bool(NUMBER.fullmatch(field.replace(",", ".") if decimal == "," and "." not in field else field))


def _is_datum(field: str, decimal: str) -> bool:
    return not field or _is_number(field, decimal) or bool(CLOCK.fullmatch(field))


def _longest_run(rows: Sequence[Sequence[str]], decimal: str) -> tuple[int, int, int]:
    """First row, and one beyond the last, of the longest run of rows of one length with numbers in half of their fields
    or more; and that length.
    """
    best, first, count = (0, 0, 0), 0, 0
    for place, row in enumerate(rows):
        data = [_is_datum(field, decimal) for field in row]
        whole = (
            bool(row) and any(row) and any(_is_number(field, decimal) for field in row) and 2 * sum(data) >= len(row)
        )
        if not whole or len(row) != count:
            first, count = (place, len(row)) if whole else (place + 1, 0)
        if whole and place + 1 - first > best[1] - best[0]:
            best = (first, place + 1, count)
    return best


def _header(lines: Sequence[str], separator: str, count: int) -> tuple[Sequence[str] | None, Sequence[str]]:
    """Names and units out of the lines above the numbers: rows as long as those, one below the other."""
    block: list[list[str]] = []
    for line in reversed(lines):
        row = _fields(line.lstrip(COMMENTS + "/ ") if line.strip()[:1] in COMMENTS else line, separator)
        if not row and block:
            break
        if not row:
            continue
        if len(row) not in (count, count - 1) or not any(row):
            break
        block.insert(0, row + [""] * (count - len(row)))
    block = block[-3:]
    units = next((row for row in reversed(block) if len(block) > 1 and _are_units(row)), [])
    above = [row for row in block if row is not units]
    if not above:
        return None, []
    named = above[-1] if not units or block.index(units) > block.index(above[-1]) else above[0]
    kinds = [row for row in above if not _are_units(row)]
    return (kinds[-1] if named not in kinds and kinds else named), [unit.strip("[]() ") for unit in units]


def _are_units(row: Sequence[str]) -> bool:
    """Whether most of the fields are words of units; numbers are none."""
    words = [field for field in row if field.strip("[]() ")]
    return bool(words) and 2 * sum(map(is_unit, words)) > len(words)


def _distinct(names: Sequence[str]) -> list[str]:
    """Names, numbered where several are the same."""
    found: list[str] = []
    for name in map(str.strip, names):
        count = sum(other == name or other.startswith(f"{name}.") for other in found)
        found.append(f"{name}.{count}" if name in found else name)
    return found


TEXT = RecordFormat(
    "text",
    "CSV or other text of any separator, with a header of any rows or without; .gz too",
    (".csv", ".txt", ".tsv", ".gz"),
    read,
)
