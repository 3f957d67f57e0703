"""Docstrings for autodoc: equations that stand as text stay so, and bars of magnitudes are no markup."""

import re
from typing import Any

SECTION = re.compile(r"(Args|Attributes|Returns|Raises|Example):$")


def setup(app: Any) -> None:
    """Mend each docstring before napoleon reads its sections."""
    app.connect("autodoc-process-docstring", _mend, priority=100)


def _mend(app: Any, what: str, name: str, thing: Any, options: Any, lines: list[str]) -> None:
    mended: list[str] = []
    verbatim = section = False
    for line in lines:
        if not line.startswith(" ") and line:
            section, verbatim = bool(SECTION.match(line)), False
        elif line and not section and not verbatim and mended and not mended[-1]:
            mended += ["::", ""]
            verbatim = True
        plain = not verbatim and not line.lstrip().startswith((">>>", "...", "(", "'"))
        mended.append(re.sub(r"(?<!`)\|", r"\\|", line) if plain else line)
    lines[:] = mended
