"""Widths and sizes of text of a page on which figures are to stand: journals by name, or any width."""

import re
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass

from workbench.errors import UserError, nearest


@dataclass(frozen=True)
class PageFormat:
    """The width of a figure (mm) and the size of its text (pt), with who asks for them.

    `double` is the width (mm) of one that would be higher than a page otherwise; 0 where there is none.
    """

    width: float
    points: float
    source: str = ""
    double: float = 0.0


FORMATS: Mapping[str, PageFormat] = {
    "ieee": PageFormat(88.9, 8.0, "IEEE Author Center: one column, 3.5 in; text of 8 to 10 pt", 181.9),
    "ieee-double": PageFormat(181.9, 8.0, "IEEE Author Center: two columns, 7.16 in"),
    "elsevier": PageFormat(90.0, 7.0, "Elsevier, artwork sizing: single column; text of 7 pt", 190.0),
    "elsevier-middle": PageFormat(140.0, 7.0, "Elsevier, artwork sizing: 1.5 columns"),
    "elsevier-double": PageFormat(190.0, 7.0, "Elsevier, artwork sizing: double column"),
    "thesis": PageFormat(160.0, 11.0, "text block of an A4 page with margins of 25 mm, text of 11 pt"),
}
"""By name."""

WIDEST, NARROWEST = 400.0, 40.0
"""mm."""

POINTS = 8.0
"""Of a width without a size of text."""

_WIDTH = re.compile(r"(?P<width>\d+(?:\.\d+)?) ?mm(?:, ?(?P<points>\d+(?:\.\d+)?) ?pt)?")


def page_format(text: str) -> PageFormat:
    """The format of a name, such as "ieee", or of a width, such as "84 mm" or "84 mm, 9 pt".

    Raises:
        UserError: neither.
    """
    if text in FORMATS:
        return FORMATS[text]
    found = _WIDTH.fullmatch(text.strip())
    if found is None:
        raise UserError(f'format "{text}": {nearest(text, FORMATS)}, or a width such as "84 mm" or "84 mm, 9 pt"')
    width, points = float(found["width"]), float(found["points"] or POINTS)
    if not (NARROWEST <= width <= WIDEST and 4.0 <= points <= 24.0):
        raise UserError(f'format "{text}": expected {NARROWEST:g} to {WIDEST:g} mm with text of 4 to 24 pt')
    return PageFormat(width, points)


_asked: ContextVar[PageFormat | None] = ContextVar("page_format", default=None)


def asked_format() -> PageFormat | None:
    """The format that figures are drawn for at the moment; None: that of the program's own pages."""
    return _asked.get()


@contextmanager
def figures_at(page: str | None) -> Iterator[None]:
    """Within this context figures are saved for a page: drawn anew at its width, with text of its size.

    They are without their titles, which are a caption's there.

    Args:
        page: "ieee" or another journal's name (docs/papers.md), "84 mm" or "84 mm, 9 pt"; None: as ever.

    Raises:
        UserError: no such format.

    Example:
        >>> with wb.figures_at("ieee"):
        ...     results = wb.Study(small_study).run(folder / "for a journal")
    """
    token = _asked.set(None if page is None else page_format(page))
    try:
        yield
    finally:
        _asked.reset(token)
