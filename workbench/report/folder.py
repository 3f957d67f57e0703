"""A report as files: report.tex with its tables and figures in `parts`, and report.pdf."""

import re
import shutil
from collections.abc import Sequence
from contextlib import ExitStack
from dataclasses import dataclass
from pathlib import Path

from workbench.errors import UserError
from workbench.publish.folders import ResultFolder
from workbench.publish.page_format import PageFormat, page_format
from workbench.report.compiling import PDF, TEX, check_latex, compile_report
from workbench.report.document import HEAD, document, figure_scale, label, text_width
from workbench.report.part import FigureFile, Part, read_part

PARTS = "parts"


def _is_report(path: Path) -> bool:
    try:
        return path.read_text(encoding="utf-8").startswith(HEAD)
    except (OSError, ValueError):
        return False


FOLDER = ResultFolder("report", (TEX, PDF, PARTS), _is_report)


@dataclass(frozen=True)
class Report:
    """A report that was written: the paths of report.tex and report.pdf, None without, and what to know of them."""

    tex: Path
    pdf: Path | None
    remarks: Sequence[str]


def write_report(
    folders: Sequence[Path], out: Path, page: str | None = None, *, pdf: bool = False, overwrite: bool = False
) -> Report:
    """Put the tables, figures and words of folders of results into one document.

    Args:
        folders: of `workbench run`, tune, decide, identify or diagnose.
        out: where report.tex goes, with all that it needs in `parts`.
        page: the format for which a study's figures are drawn anew: "ieee", "84 mm", ... (`page_format`).
        pdf: compile it too.
        overwrite: replace an earlier report.

    Raises:
        UserError: no folder of results, a missing file, no such format, no LaTeX, or a folder that does not serve.
    """
    if not folders:
        raise UserError("report: got no folder, expected one or more with results")
    asked = None if page is None else page_format(page)
    if pdf:
        check_latex()
    with FOLDER.claimed(out, overwrite), ExitStack() as stack:
        parts = {name: stack.enter_context(read_part(folder, page)) for name, folder in _named(folders).items()}
        width = text_width(asked)

        def write(beside: Path) -> list[str]:
            files = {name: _copied(name, part, beside) for name, part in parts.items()}
            (beside / TEX).write_text(document(parts, files, width), encoding="utf-8")
            return compile_report(beside) if pdf else []

        warnings = FOLDER.write(out, write)
    remarks = [line for name, part in parts.items() for line in _remarks(name, part, width, asked)]
    return Report(out / TEX, out / PDF if pdf else None, [*remarks, *warnings])


def _named(folders: Sequence[Path]) -> dict[str, Path]:
    """Folders by a name that LaTeX takes in a path and a label, each its own."""
    named: dict[str, Path] = {}
    for folder in folders:
        name = plain = _plain(folder.resolve().name)
        number = 1
        while name in named:
            number += 1
            name = f"{plain}-{number}"
        named[name] = folder
    return named


def _plain(name: str) -> str:
    return re.sub(r"[^A-Za-z0-9-]+", "-", name).strip("-") or "results"


def _copied(key: str, part: Part, folder: Path) -> dict[str, str]:
    """Copy tables, with labels of their own, and figures; their paths, by what they are."""
    own = folder / PARTS / key
    own.mkdir(parents=True)
    paths: dict[str, str] = {}
    for name, text in part.tables.items():
        path = _free(own, name, ".tex")
        labelled = text.replace(rf"\label{{tab:{name}}}", rf"\label{{{label('tab', key, name)}}}")
        path.write_text(labelled, encoding="utf-8")
        paths[f"table {name}"] = path.relative_to(folder).as_posix()
    for figure in part.figures:
        path = _free(own, figure.name, figure.path.suffix)
        shutil.copyfile(figure.path, path)
        paths[f"figure {figure.name}"] = path.relative_to(folder).as_posix()
    return paths


def _free(folder: Path, name: str, ending: str) -> Path:
    """A path of a name that LaTeX takes, at which there is nothing yet."""
    plain, number = _plain(name), 1
    path = folder / f"{plain}{ending}"
    while path.exists():
        number += 1
        path = folder / f"{plain}-{number}{ending}"
    return path


def _remarks(name: str, part: Part, width: float, asked: PageFormat | None) -> list[str]:
    """What is not as it was asked for: figures of another width, and those that do not fit a page in their size."""
    lines = []
    if asked is not None and (others := [each.name for each in part.figures if not _is_as_asked(each, asked)]):
        again = f"{part.contents.command} --out DIR --overwrite --format ..."
        lines.append(f"{name}: {len(others)} of its figures are not {asked.width:g} mm wide; {again} draws them so")
    small = {each.name: figure_scale(each, width) for each in part.figures}
    for figure, scale in small.items():
        if scale < 0.9:
            lines.append(
                f"{name}: {figure} is shown at {100.0 * scale:.0f} % of its size, since it is larger than a page"
            )
    return lines


def _is_as_asked(figure: FigureFile, asked: PageFormat) -> bool:
    """Whether a figure has a width of the format, to half a millimetre."""
    return any(abs(figure.width / 72.0 * 25.4 - width) < 0.5 for width in (asked.width, asked.double))
