"""What a folder of results says, in its order, for whoever puts it into a document: contents.json."""

import json
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, fields
from pathlib import Path

from workbench.errors import UserError, spelled
from workbench.publish.folders import anew
from workbench.toml.file_names import is_file_name

CONTENTS = "contents.json"


@dataclass(frozen=True)
class Contents:
    """What one command found, in words, with the names of its tables and figures.

    Attributes:
        title: of what was asked.
        question: what was asked, in a sentence or none.
        answer: what was found, the most wanted first.
        notes: what was assumed, and what a reader must know.
        command: that made it.
        tables, figures: names of files in the folders of these names, in the order in which they are told.
        details: names of further tables.
        provenance: versions, seeds, and what else run.json of a study says.
        file: the name of the study or experiment file.
        text: what is in it.
    """

    title: str
    question: str
    answer: Sequence[str]
    notes: Sequence[str]
    command: str
    tables: Sequence[str]
    figures: Sequence[str]
    details: Sequence[str]
    provenance: Mapping[str, object]
    file: str
    text: str


def write_contents(contents: Contents, folder: Path) -> None:
    """Write contents.json, the same bytes for the same contents."""
    text = json.dumps(asdict(contents), indent=2, ensure_ascii=False) + "\n"
    anew(folder / CONTENTS).write_text(text, encoding="utf-8")


def read_contents(folder: Path) -> Contents:
    """What contents.json of a folder says.

    Raises:
        UserError: it is no such file.
    """
    path = folder / CONTENTS
    names = {item.name for item in fields(Contents)}
    try:
        read = json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError) as error:
        raise UserError(f"{path}: cannot be read ({error}); run the command that made the folder again") from None
    if not isinstance(read, dict) or set(read) != names:
        got = ", ".join(sorted(read)) if isinstance(read, dict) else type(read).__name__
        raise UserError(
            f"{path}: got {got or 'nothing'}, expected {', '.join(sorted(names))}; run the command that made it again"
        )
    if wrong := next((name for name in sorted(names) if not _serves(name, read[name])), None):
        raise UserError(f"{path}: {wrong}: got {spelled(read[wrong])}; run the command that made it again")
    return Contents(**read)


def _serves(name: str, value: object) -> bool:
    """Whether a value under this name is of its kind; tables and figures are files beside, and lead nowhere else."""
    if name == "provenance":
        return isinstance(value, dict)
    if name in ("tables", "figures", "details"):
        return isinstance(value, list) and all(map(is_file_name, value))
    if name in ("answer", "notes"):
        return isinstance(value, list) and all(isinstance(line, str) for line in value)
    return isinstance(value, str)
