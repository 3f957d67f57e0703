"""A proposal as the text of an experiment file."""

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from unicodedata import category

from workbench.errors import UNSEEN, visible
from workbench.records.importing.proposal import Line, Proposal


def text_of(proposal: Proposal, folder: Path) -> str:
    """The experiment file; its records are named relative to `folder`."""
    return "\n".join(visible(" ".join(line.splitlines())) for line in _lines(proposal, folder)) + "\n"


def _lines(proposal: Proposal, folder: Path) -> Iterator[str]:
    yield "# Written by workbench import: behind each guess stands its reason, and `# ?` before what only you can know."
    yield f"title = {_toml(proposal.title)}"
    yield from ("", "[plant]")
    yield from _of_line(proposal.plant)
    if proposal.parameters:
        yield f"parameters = {_toml(proposal.parameters)}"
    if proposal.values:
        yield from ("", "[plant.set]")
        yield from _of_lines(proposal.values)
    yield from ("", "[fit]")
    yield from _of_lines(proposal.fit)
    yield from ("", "[channels]")
    yield from _of_lines(proposal.channels)
    yield from (f"# not used: {words}" for words in proposal.unused)
    for path, use, reason in proposal.records:
        yield from ("", "[[records]]", f"file = {_toml(_relative(path, folder))}{f'  # {reason}' * bool(reason)}")
        yield f'use = "{use}"'


def _of_lines(lines: Sequence[Line]) -> Iterator[str]:
    for line in lines:
        yield from _of_line(line)


def _of_line(line: Line) -> Iterator[str]:
    yield from (f"# ? {question.words}" for question in line.questions)
    if list(line.values) == [""]:
        value = line.values[""]
        text = value if isinstance(value, str) and value.startswith("[") else _toml(value)
    else:
        text = "{ " + ", ".join(f"{key} = {_toml(value)}" for key, value in line.values.items()) + " }"
    yield f"{line.name} = {text}" + (f"  # {line.reason}" if line.reason else "")


def _toml(value: str | float | int) -> str:
    if not isinstance(value, str):
        return f"{value:.10g}" if isinstance(value, int) or value != int(value) else f"{value:.1f}"
    escaped = value.replace("\\", "\\\\").replace('"', '\\"').replace("\t", "\\t")
    seen = (rf"\U{ord(letter):08X}" if category(letter) in UNSEEN else letter for letter in escaped)
    return f'"{"".join(seen)}"'


def _relative(path: Path, folder: Path) -> str:
    return Path(os.path.relpath(path.resolve(), folder.resolve())).as_posix()
