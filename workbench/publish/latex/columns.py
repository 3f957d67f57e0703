"""Columns of a table for LaTeX: which are numbers, how siunitx aligns them, and how wide they are."""

import re
from collections.abc import Sequence
from dataclasses import dataclass, field

from workbench.publish.latex.text import display_name, escaped, shown_text
from workbench.publish.latex.units import latex_unit, unit_text

_NUMBER = re.compile(
    r"(?P<sign>[<>]?) ?(?P<number>(?P<plus>[+-]?)(?P<whole>\d+)(?:\.(?P<part>\d*))?(?:[eE](?P<power>[+-]?\d+))?)"
    r"(?P<behind> ?%| \([^()]*\))?"
)
"""A cell that is aligned by its decimal marker: "-0.31", "< 0.1", "4.5e-07", "0.31 (2)", "12 %"."""

_WITH_UNIT = re.compile(r"\(([^()]+(?:\([^()]*\))?[^()]*)\)")
"""What stands in brackets in a heading."""

_NARROW, _WIDE = "iljtfIr.,:;'|!()[]/- ", "mwMWQO%@"

MOST_LINES = 4
"""Of a heading."""


def text_width(text: str) -> float:
    """How wide text is, about, in em of Computer Modern; rather too wide than too narrow."""
    return sum(
        0.34 if character in _NARROW else 0.84 if character in _WIDE else 0.74 if character.isupper() else 0.52
        for character in text
    )


@dataclass(frozen=True)
class Word:
    """A part of a heading that is not broken, as LaTeX and as a reader sees it."""

    latex: str
    shown: str


@dataclass(frozen=True)
class Column:
    """A column of text, or of numbers where it has a `table_format`.

    `cells` are what its cells are in LaTeX, `shown` what a reader sees of them, about; `width` (em) is that of the
    widest.
    """

    heading: Sequence[Word]
    cells: Sequence[str]
    shown: Sequence[str]
    width: float
    table_format: str = ""
    is_text: bool = False
    lines: Sequence[str] = field(default=())


def column_of(heading: str, cells: Sequence[str], mark: str, words: bool) -> Column:
    """A column from its text: `words` of a column that holds text, `mark` is put behind its heading.

    A column of numbers is one of siunitx's S columns: what is no number in it stands in braces, in the middle.
    """
    head = [*_heading(heading), *([Word(rf"\tnote{{{mark}}}\,", "a")] if mark else [])]
    if heading == "unit":
        shown = [unit_text(cell) for cell in cells]
        return Column(head, shown, cells, max(map(text_width, cells), default=0.0), is_text=True)
    found = [_NUMBER.fullmatch(cell) for cell in cells]
    numbers = [number for number in found if number is not None]
    others = [cell for cell, number in zip(cells, found, strict=True) if number is None and cell]
    if words or not numbers or len(others) > len(numbers):
        named = [display_name(cell) for cell in cells]
        return Column(
            head, [shown_text(cell) for cell in cells], named, max(map(text_width, named), default=0.0), is_text=True
        )
    latex = [_braced(cell) if number is None else _aligned(number) for cell, number in zip(cells, found, strict=True)]
    width = max(_width(numbers), *map(text_width, others), 0.0)
    return Column(head, latex, cells, width, table_format(numbers))


def table_format(numbers: Sequence[re.Match[str]]) -> str:
    """siunitx's table-format that has room for all these numbers, with what stands before and behind them."""
    whole = max(len(number["whole"]) for number in numbers)
    part = max(len(number["part"] or "") for number in numbers)
    powers = [number["power"] for number in numbers if number["power"]]
    signs = "+" if any(number["plus"] for number in numbers) else ""
    said = "<" if any(number["sign"] for number in numbers) else ""
    text = f"{said}{signs}{whole}.{part}"
    if powers:
        minus = "-" if any(power.startswith("-") for power in powers) else ""
        text += f"e{minus}{max(len(power.lstrip('+-')) for power in powers)}"
    behind = max((_behind(number) for number in numbers), key=len)
    return f"{text}{{{behind}}}" if behind else text


def _behind(number: re.Match[str]) -> str:
    behind = (number["behind"] or "").strip()
    return "" if not behind else r"\,\%" if behind == "%" else f"~{escaped(behind)}"


def _aligned(number: re.Match[str]) -> str:
    """A number for an S column. A place or a deviation in brackets is text: siunitx takes digits there for its own."""
    behind = _behind(number)
    return f"{number['sign']}{number['number']}{f' {{{behind}}}' if behind else ''}"


def _braced(cell: str) -> str:
    return f"{{{shown_text(cell)}}}" if cell else ""


def _width(numbers: Sequence[re.Match[str]]) -> float:
    """The room of numbers, in em: siunitx parts groups of three digits, and writes a power out."""
    whole, part = (max(len(number[name] or "") for number in numbers) for name in ("whole", "part"))
    behind = max(text_width(number["behind"] or "") for number in numbers)
    power = 3.4 if any(number["power"] for number in numbers) else 0.0
    signs = 0.8 * (any(number["plus"] for number in numbers) + any(number["sign"] for number in numbers))
    return 0.52 * (whole + part) + 0.3 + 0.17 * ((whole - 1) // 3 + part // 3) + power + signs + behind


def _heading(heading: str) -> list[Word]:
    """The words of a heading, a unit in brackets by siunitx."""
    words: list[Word] = []
    place = 0
    for bracketed in _WITH_UNIT.finditer(heading):
        unit = latex_unit(bracketed[1])
        if unit is None:
            continue
        words += _words(heading[place : bracketed.start()])
        place = bracketed.end()
        behind = "," if heading[place : place + 1] == "," else ""
        place += len(behind)
        words.append(Word(f"({unit}){behind}", f"({bracketed[1]}){behind}"))
    return [*words, *_words(heading[place:])]


def _words(text: str) -> list[Word]:
    return [Word(shown_text(word), word) for word in display_name(text).split()]
