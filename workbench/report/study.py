"""A study's folder of results: what it says, and its figures drawn for a page."""

import json
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

from workbench.errors import UserError
from workbench.publish.contents import Contents
from workbench.publish.page_format import figures_at
from workbench.study.reading import read_study
from workbench.study.report.folder import write_answers, write_figures, write_tables
from workbench.study.report.page import first_lines
from workbench.study.report.unusual import unusual
from workbench.study.sections import sections_of
from workbench.study.store import DATABASE, STUDY_COPY, read_results
from workbench.study.study import Study

if TYPE_CHECKING:
    import pandas as pd

MADE = ("tables", "figures")
"""What is made of a study's results, and can be made again."""

RECORD = "run.json"


def is_study(folder: Path) -> bool:
    """Whether a folder holds results of `workbench run`, finished or not."""
    return (folder / STUDY_COPY).exists() and (folder / DATABASE).exists()


@contextmanager
def study_drawn(folder: Path, page: str | None) -> Iterator[Path]:
    """The folder, or where a page format is asked for one like it, with tables and figures made anew for that."""
    if page is None:
        yield folder
        return
    with TemporaryDirectory() as temporary:
        like = Path(temporary) / folder.resolve().name
        like.mkdir()
        study, frame = _results(folder)
        for item in folder.iterdir():
            if item.name not in MADE and item.suffix not in (".html", ".md"):
                (like / item.name).symlink_to(item.resolve())
        study = read_study(like / STUDY_COPY)
        with figures_at(page):
            write_tables(study, frame, like)
            write_figures(study, frame, like)
            write_answers(study, frame, like)
        (like / "tables").mkdir(exist_ok=True)
        for name in _found(folder / "tables", "tex"):
            if not (like / "tables" / f"{name}.tex").exists():  # the run made it of what it had planned
                (like / "tables" / f"{name}.tex").symlink_to((folder / "tables" / f"{name}.tex").resolve())
        yield like


def study_contents(folder: Path) -> Contents:
    """What a study's results say.

    Raises:
        UserError: they are not finished, or a file of theirs cannot be read.
    """
    study, frame = _results(folder)
    file = study.file
    said = [section.said(table, study, frame, folder) for section, table in sections_of(study)]
    chosen = [name for each in said for name in each.tables]
    made = _found(folder / "tables", "tex")
    tables = [*(spec.name for spec in file.tables), *(chosen or made)]
    return Contents(
        title=file.title,
        question=file.question,
        answer=[line for each in said for line in each.answer] or first_lines(frame),
        notes=[*_remarks(study.text), *(line for each in said for line in each.notes), *unusual(frame, frame)],
        command=f"workbench run {STUDY_COPY}",
        tables=list(dict.fromkeys(tables)),
        details=[name for name in made if name not in tables],
        figures=list(dict.fromkeys([*(spec.name for spec in file.figures), *_found(folder / "figures", "pdf")])),
        provenance={"source": file.source, **_record(folder)},
        file=STUDY_COPY,
        text=study.text,
    )


def _results(folder: Path) -> "tuple[Study, pd.DataFrame]":
    return read_study(folder / STUDY_COPY), read_results(folder)


def _record(folder: Path) -> dict[str, object]:
    path = folder / RECORD
    try:
        return dict(json.loads(path.read_text(encoding="utf-8")))
    except (OSError, ValueError, TypeError) as error:
        raise UserError(f"{path}: cannot be read ({error}); run the study again with --resume") from None


def _found(folder: Path, ending: str) -> list[str]:
    return sorted(path.stem for path in folder.glob(f"*.{ending}"))


def _remarks(text: str) -> list[str]:
    """The comment at the head of a study file, by its paragraphs and the items of its lists."""
    remarks = [""]
    for line in text.splitlines():
        if not line.startswith("#"):
            break
        said = line.lstrip("#").strip()
        if said.startswith("- ") or not said:
            remarks.append("")
        remarks[-1] += f" {said.removeprefix('- ')}"
    return [remark.strip() for remark in remarks if remark.strip()]
