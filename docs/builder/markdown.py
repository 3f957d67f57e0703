"""Markdown that pages are made of."""

from collections.abc import Sequence


def cell(text: str) -> str:
    """Text of one cell of a table: on one line, its bars escaped, `<` no tag."""
    return " ".join(text.split()).replace("|", "\\|").replace("<", "&lt;")


def table(heads: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table; "" without rows."""
    if not rows:
        return ""
    lines = [heads, ["---"] * len(heads), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)
