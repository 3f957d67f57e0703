"""What a finished run has left, and what that was made of: where both are as they were, --resume has nothing to do.

Kept with the results: the study's text, whatever its numbers come from, the source of the whole program and the
versions of what draws; and of each file in the folder size and time. An edit of any of them, a file too few or too
many, and all is made again. A study with questions of their own, whose pages read other files, is never left standing.
"""

import hashlib
import json
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

from plants.plugins import OURS
from workbench.publish.run_record import PACKAGES, versions
from workbench.study.plan import Plan
from workbench.study.sections import sections_of
from workbench.study.store import DATABASE, FOLDER, finished_in, open_store

DRAWING = ("bokeh", "jinja2", "matplotlib", "pyarrow")
"""Packages on whose version, beside those of results, tables and pages may depend."""


@dataclass(frozen=True)
class Made:
    """What a run tells of its results: its Markdown tables, by their place in the folder, and lines to say."""

    tables: Sequence[str]
    lines: Sequence[str]


def standing(planned: Plan, folder: Path, *, keep_all: bool = False) -> Made | None:
    """What was made of the finished results in `folder`; None where anything is to be done.

    Args:
        planned: the study, checked.
        folder: of its results.
        keep_all: whether every trajectory is to be there.

    Raises:
        UserError: the results there are of another study or version, or another command is at work.
    """
    if sections_of(planned.study) or finished_in(folder) != len(planned.cases):
        return None
    with open_store(folder, planned.columns, planned.identity, resume=True) as store:
        kept = json.loads(store.made() or "{}")
        if kept.get("from") != _origin(planned, keep_all) or kept.get("files") != _files(folder):
            return None
        return Made(**kept["made"])


def leave_standing(planned: Plan, folder: Path, made: Made, *, keep_all: bool = False) -> None:
    """Keep in the finished results in `folder` what was made of them, for `standing`."""
    if sections_of(planned.study):
        return
    with open_store(folder, planned.columns, planned.identity, resume=True) as store:
        content = {"from": _origin(planned, keep_all), "files": _files(folder), "made": asdict(made)}
        store.keep_made(json.dumps(content))


def _origin(planned: Plan, keep_all: bool) -> str:
    """A hash of all that tables, figures and pages come from, beside the files of results."""
    study = planned.study
    said = [study.text, [text for _, text in study.sources.values()], planned.identity, len(planned.cases), keep_all]
    digest = hashlib.sha256(json.dumps([*said, versions((*PACKAGES, *DRAWING))]).encode())
    root = Path(__file__).parents[2]
    for path in (path for package in OURS for path in sorted((root / package).rglob("*"))):
        if path.is_file() and path.suffix != ".pyc":
            digest.update(path.relative_to(root).as_posix().encode() + path.read_bytes())
    return digest.hexdigest()


def _files(folder: Path) -> dict[str, list[int]]:
    """Size and time of each file of results, by its place; not of the database, in which they are kept, nor of what
    else the folder holds, which may be much.
    """
    found = {}
    own = [folder / name for name in (*FOLDER.names, *FOLDER.kept) if name != DATABASE]
    for path in sorted(path for each in own for path in (each, *each.rglob("*"))):
        if path.exists() and not path.is_dir():
            status = path.lstat()
            found[path.relative_to(folder).as_posix()] = [status.st_size, status.st_mtime_ns]
    return found
