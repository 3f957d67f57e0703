"""What a folder of results gives to a report: its words, its tables and figures as files, and the file behind them."""

import re
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from workbench.errors import UserError
from workbench.publish.contents import CONTENTS, Contents, read_contents
from workbench.publish.latex.table import HEAD
from workbench.publish.pictures import caption_of
from workbench.publish.words import plain_name
from workbench.report.study import is_study, study_contents, study_drawn

KINDS = "workbench run, tune, decide, identify or diagnose"

POINTS_PER_INCH = 72.0
"""Of PDF, and of `FigureFile`: big points."""

OLDER = ("tuning.html", "decision.html", "identified.json", "report.json")
"""Files by which a folder is known that was written before there were contents."""


@dataclass(frozen=True)
class FigureFile:
    """A figure as a file, with its caption, and its size in big points (1/72 in)."""

    name: str
    path: Path
    caption: str
    width: float
    height: float


@dataclass(frozen=True)
class Part:
    """A folder of results: what it says, its tables as LaTeX by name, and its figures."""

    contents: Contents
    tables: Mapping[str, str]
    figures: Sequence[FigureFile]


@contextmanager
def read_part(folder: Path, page: str | None) -> Iterator[Part]:
    """What a folder gives to a report, with figures for a page where the folder has what they are drawn of.

    Raises:
        UserError: it is no folder of results, or one of its files is missing or not ours.
    """
    if not folder.is_dir():
        what = "is a file, expected a folder" if folder.exists() else "no such folder, expected one"
        raise UserError(f"{folder}: {what} of results of {KINDS}")
    if (folder / CONTENTS).exists():
        yield _part(folder, folder, read_contents(folder))
    elif is_study(folder):
        with study_drawn(folder, page) as drawn:
            yield _part(folder, drawn, study_contents(drawn))
    else:
        raise UserError(f"{folder}: {_unlike(folder)}")


def _unlike(folder: Path) -> str:
    older = [name for name in OLDER if (folder / name).exists()]
    if older:
        return f"has {older[0]}, but no {CONTENTS}: it was written by an earlier version; run the command again"
    names = sorted(item.name for item in folder.iterdir())
    got = ", ".join([*names[:4], *(["..."] if len(names) > 4 else [])]) or "nothing"
    return f"got {got}; expected the results of {KINDS}"


def _part(folder: Path, drawn: Path, contents: Contents) -> Part:
    """What is `drawn` of a folder, which messages name."""
    names = (*contents.tables, *contents.details)
    tables = {name: _table(Path("tables", f"{name}.tex"), folder, drawn) for name in names}
    return Part(contents, tables, [_figure(name, folder, drawn) for name in contents.figures])


def _table(path: Path, folder: Path, drawn: Path) -> str:
    try:
        text = (drawn / path).read_text(encoding="utf-8")
    except (OSError, ValueError) as error:
        raise UserError(f"{folder / path}: {_reason(error)}, expected a table; make the tables again") from None
    if not text.startswith(HEAD):
        raise UserError(
            f"{folder / path}: got a table of an earlier version, or of another program; make the tables again, of a "
            f"study with workbench run STUDY.toml --out {folder} --resume"
        )
    return text


def _reason(error: Exception) -> str:
    return "no such file" if isinstance(error, FileNotFoundError) else f"cannot be read ({error})"


def _figure(name: str, folder: Path, drawn: Path) -> FigureFile:
    pdf, png = (Path("figures", f"{name}.{ending}") for ending in ("pdf", "png"))
    path = pdf if (drawn / pdf).exists() else png
    if not (drawn / path).exists():
        raise UserError(f"{folder / pdf}: no such file, expected a figure; make the figures again")
    size = _size(drawn / path)
    if size is None:
        raise UserError(f"{folder / path}: got no picture of ours, expected a PDF of a page; make the figures again")
    caption = caption_of(drawn / png) if (drawn / png).exists() else ""
    return FigureFile(name, drawn / path, caption or plain_name(name), *size)


def _size(path: Path) -> tuple[float, float] | None:
    """Width and height in big points."""
    if path.suffix == ".pdf":
        box = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+) ?\]", path.read_bytes())
        return None if box is None else (float(box[1]), float(box[2]))
    from PIL import Image

    with Image.open(path) as image:
        dots = image.info.get("dpi", (POINTS_PER_INCH, POINTS_PER_INCH))
        return image.width / dots[0] * POINTS_PER_INCH, image.height / dots[1] * POINTS_PER_INCH
