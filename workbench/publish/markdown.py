"""Text for Markdown: no tags, no ends of lines or of cells where they are not meant, nothing unseen."""

import re

from workbench.errors import visible

_TAG = re.compile(r"<(?=[A-Za-z/!?])")
"""What begins a tag of HTML; "< 0.01" begins none."""


def in_markdown(text: str) -> str:
    """Text of any origin in a paragraph, lines as they are."""
    return _TAG.sub(r"\<", visible(text))


def in_line(text: str) -> str:
    """Text of any origin on one line."""
    return in_markdown(" ".join(text.splitlines()) if "\n" in text or "\r" in text else text)


def in_cell(text: str) -> str:
    """Text of any origin in a cell of a table."""
    return in_line(text).replace("|", r"\|")


def plain(text: str) -> str:
    """What `in_line` was made of, but for ends of lines."""
    return text.replace(r"\<", "<")
