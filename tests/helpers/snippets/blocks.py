"""Code blocks of Markdown, with the comment above each."""

import re
from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

from command import ROOT

DOCS = ROOT / "docs"

KINDS = ("file", "part of", "quick", "output", "illustration")
"""What a comment above a block may say first."""

LANGUAGES = ("sh", "toml", "python", "text", "c", "matlab")
"""What a block may be in, beside equations and directives of the site, which are no code."""

_FENCE = re.compile(r"^(?P<marks>`{3,})(?P<language>\S*)\s*$")
_MARK = re.compile(r"^<!-- (?P<kind>[a-z ]+?)(?:: (?P<said>.+?))? -->$")


class Block(NamedTuple):
    """A code block: its page, line, language, text, and what the comment above it says; kind "" without one."""

    page: Path
    line: int
    language: str
    text: str
    kind: str = ""
    said: str = ""

    @property
    def place(self) -> str:
        """Where it stands."""
        return f"{self.page.name}:{self.line}"


def pages() -> list[Path]:
    """README.md and the Markdown of docs/, without what the site's build makes."""
    found = sorted(path for path in DOCS.rglob("*.md") if "made" not in path.relative_to(DOCS).parts)
    return [ROOT / "README.md", *found]


def blocks(page: Path) -> list[Block]:
    """The code blocks of a page, in their order."""
    return [block for block in _all(page) if block.language != "math" and not block.language.startswith("{")]


def _all(page: Path) -> Iterator[Block]:
    lines = page.read_text(encoding="utf-8").splitlines()
    number = 0
    while number < len(lines):
        if opened := _FENCE.match(lines[number]):
            end = lines.index(opened["marks"], number + 1)
            mark = _MARK.match(lines[number - 1]) if number else None
            kind, said = (mark["kind"], mark["said"] or "") if mark else ("", "")
            text = "\n".join(lines[number + 1 : end]) + "\n"
            yield Block(page, number + 1, opened["language"], text, kind, said)
            number = end
        number += 1


def indented(page: Path) -> list[str]:
    """Lines of indented code, a block without a language and a comment."""
    lines = page.read_text(encoding="utf-8").splitlines()
    fenced = False
    found = []
    for before, line in zip(["", *lines], lines, strict=False):
        fenced ^= line.startswith("```")
        if not fenced and line.startswith("    ") and not before.strip():
            found.append(line)
    return found
