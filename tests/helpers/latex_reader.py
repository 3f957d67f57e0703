"""LaTeX read without LaTeX: what would stop it, or make it complain of references, told of a document and its files."""

import re
from collections.abc import Iterator
from pathlib import Path

GROUP = r"\{(?:[^{}]|\{(?:[^{}]|\{[^{}]*\})*\})*\}"
"""What stands in braces, three deep."""

NOT_ROWS = re.compile(r"\\(?:toprule|midrule|bottomrule|caption|insertTableNotes|multicolumn|end\w*(?:head|foot))")
"""How lines of a table begin that are no rows."""


def whole(path: Path) -> str:
    """A document with all files that it reads in their places."""
    text = path.read_text(encoding="utf-8")
    return re.sub(r"\\input\{([^}]+)\}", lambda found: whole(path.parent / found[1]), text)


def mistakes(path: Path) -> list[str]:
    """What is wrong with the document at `path`: braces, environments, rows, labels, files."""
    text = re.sub(r"(?<!\\)%.*", "", whole(path))
    bare, listings = re.subn(r"\\begin\{Verbatim\}.*?\\end\{Verbatim\}", "", text, flags=re.DOTALL)
    found = [] if listings else ["no listing"]
    found += _braces(text) + list(_environments(text)) + list(_rows(bare))
    labels, references = re.findall(r"\\label\{([^}]+)\}", bare), re.findall(r"\\ref\{([^}]+)\}", bare)
    found += [f"label {label} twice" for label in set(labels) if labels.count(label) > 1]
    found += [f"no label {label}" for label in references if label not in labels]
    pictures = re.findall(r"\\includegraphics(?:\[[^]]*\])?\{([^}]+)\}", bare)
    found += [f"no file {name}" for name in pictures if not (path.parent / name).is_file() or name.startswith("/")]
    math = re.sub(
        r"\\ensuremath\{(?:[^{}]|\{[^{}]*\})*\}|\\label\{[^}]*\}|\\(?:ref|includegraphics\S*?)\{[^}]*\}", "", bare
    )
    found += [f"bare {sign[0]!r}" for sign in re.findall(r"(?<!\\)[_^$#]", re.sub(r"\\[\^]\{\w\}", "", math))]
    return [*found, *(f"character {character!r}" for character in set(text) if not character.isascii())]


def _braces(text: str) -> list[str]:
    depth = 0
    for sign in re.findall(r"(?<!\\)[{}]", re.sub(r"\\\\", "", text)):
        depth += 1 if sign == "{" else -1
        if depth < 0:
            return ["a brace is closed that was not opened"]
    return ["a brace is not closed"] * (depth != 0)


def _environments(text: str) -> Iterator[str]:
    opened: list[str] = []
    for kind, name in re.findall(r"\\(begin|end)\{([A-Za-z*]+)\}", text):
        if kind == "begin":
            opened.append(name)
        elif not opened or opened.pop() != name:
            yield f"{name} is ended that was not begun last"
    if opened:
        yield f"{opened[-1]} is not ended"


def _rows(text: str) -> Iterator[str]:
    """Rows that have more or fewer cells than their table has columns."""
    bodies = rf"\\begin\{{(tabular\*?|longtable)\}}(?:\{{[\d.]*\\linewidth\}})?({GROUP})(.*?)\\end\{{\1\}}"
    for _, columns, body in re.findall(bodies, text, re.DOTALL):
        plain = re.sub(r"[>@]\{(?:[^{}]|\{[^{}]*\})*\}", "", columns)
        count = len(re.findall(r"S\[(?:[^]{]|\{[^}]*\})*\]|p\{[^}]*\}|l", plain))
        for line in body.strip().splitlines():
            row = line.removesuffix(r"\\").strip()
            if not row or NOT_ROWS.match(row):
                continue
            if (cells := len(re.findall(r"(?<!\\)&", row)) + 1) != count:
                yield f"{cells} cells in {count} columns: {row}"
