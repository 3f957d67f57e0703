"""The document: for each folder of results the answer, what was assumed, tables, figures, where it is from; then the
files behind them.
"""

import re
from collections.abc import Mapping, Sequence

from workbench.publish.latex.table import MM, TEXT_HEIGHT
from workbench.publish.latex.text import escaped, shown_text
from workbench.publish.page_format import PageFormat
from workbench.report.part import FigureFile, Part

HEAD = "% A report of Friction Workbench: pdflatex or lualatex, twice"
"""How every report begins."""

BIG_POINT = 72.27 / 72.0
"""Points of LaTeX."""

TEXT_WIDTH = 163.0
"""mm: what figures of the program's own width take."""

FIGURE_HEIGHT = 0.86 * TEXT_HEIGHT
"""Points: what a page has for a figure beside its caption."""

TOGETHER = 6
"""Tables or figures after which none waits any longer for a page."""

ITEM = 90
"""Characters of a line of a file."""

_PREAMBLE = r"""\documentclass[11pt,a4paper]{article}
\usepackage{iftex}
\ifpdftex
\usepackage[T1]{fontenc}
\usepackage{lmodern}
\fi
\usepackage[a4paper,textwidth=%(width).1fmm,textheight=235mm]{geometry}
\usepackage{array,booktabs,siunitx,threeparttable,threeparttablex,longtable,rotating,pdflscape}
\usepackage{graphicx,placeins,fancyvrb}
\sisetup{per-mode=symbol}
\raggedbottom
\emergencystretch=4em
\renewcommand{\topfraction}{0.9}
\renewcommand{\bottomfraction}{0.8}
\renewcommand{\textfraction}{0.05}
\renewcommand{\floatpagefraction}{0.75}
\title{%(title)s}
\author{}
\date{%(date)s}
\begin{document}
\maketitle
"""


def figure_scale(figure: FigureFile, width: float) -> float:
    """What a figure has to be multiplied with to fit a text of that width (mm): 1 or less."""
    across, up = figure.width * BIG_POINT, figure.height * BIG_POINT
    return min(1.0, width * MM / across, FIGURE_HEIGHT / up)


def text_width(page: PageFormat | None) -> float:
    """The width of the text (mm) that has room for figures of a page format."""
    return max((TEXT_WIDTH, *((page.width, page.double) if page is not None else ())))


def document(parts: Mapping[str, Part], files: Mapping[str, Mapping[str, str]], width: float) -> str:
    """The report as LaTeX.

    Args:
        parts: what is told, by the name of its folder.
        files: by that name the path of each table and figure, as "table NAME" or "figure NAME".
        width: of the text, in mm.
    """
    several = len(parts) > 1
    titles = [part.contents.title for part in parts.values()]
    dates = [str(part.contents.provenance.get("started", ""))[:10] for part in parts.values()]
    lines = [
        _PREAMBLE
        % {
            "width": width,
            "title": _prose("; ".join(titles) if len(titles) < 3 else f"{titles[0]}, and {len(titles) - 1} more"),
            "date": escaped(max(dates)),
        }
    ]
    for key, part in parts.items():
        if several:
            lines.append(rf"\section{{{_prose(part.contents.title)}}}")
        lines += _part(key, part, files[key], "subsection" if several else "section", width)
    lines.append("\\appendix")
    for key, part in parts.items():
        lines += _appendix(key, part, files[key], several)
    return "\n".join([HEAD, *lines, "\\end{document}", ""])


def _part(key: str, part: Part, files: Mapping[str, str], level: str, width: float) -> list[str]:
    contents = part.contents
    lines = [rf"\{level}{{Answer}}"]
    if contents.question:
        lines += [rf"\emph{{{_prose(contents.question)}}}", ""]
    for line in contents.answer:
        lines += [_prose(line), ""]
    if contents.notes:
        lines += [rf"\{level}{{Assumptions and notes}}", *_items(contents.notes)]
    if contents.tables:
        lines += [rf"\{level}{{Tables}}", _refer("tab", key, contents.tables, "Table", "Tables")]
        lines += _floats([rf"\input{{{files[f'table {name}']}}}" for name in contents.tables])
    if part.figures:
        names = [figure.name for figure in part.figures]
        lines += [rf"\{level}{{Figures}}", _refer("fig", key, names, "Figure", "Figures")]
        lines += _floats([_figure(key, figure, files[f"figure {figure.name}"], width) for figure in part.figures])
    return [*lines, rf"\{level}{{Provenance}}", *_items(_provenance(part))]


def _appendix(key: str, part: Part, files: Mapping[str, str], several: bool) -> list[str]:
    contents = part.contents
    of = f": {contents.title}" if several else ""
    lines = []
    if contents.details:
        lines += [rf"\section{{{_prose(f'Further tables{of}')}}}"]
        lines += [_refer("tab", key, contents.details, "Table", "Tables")]
        lines += _floats([rf"\input{{{files[f'table {name}']}}}" for name in contents.details])
    title = _prose(f"The file {contents.file}{of}")
    return [*lines, rf"\section{{{title}}}", *_listing(contents.text)]


def label(kind: str, key: str, name: str) -> str:
    """The label of a table ("tab") or figure ("fig") of a folder."""
    return f"{kind}:{key}:{name}"


def _refer(kind: str, key: str, names: Sequence[str], one: str, several: str) -> str:
    first, last = (rf"\ref{{{label(kind, key, names[end])}}}" for end in (0, -1))
    return f"{one}~{first}." if len(names) == 1 else f"{several}~{first} to~{last}."


def _floats(floats: Sequence[str]) -> list[str]:
    lines = []
    for number, each in enumerate(floats, 1):
        lines.append(each)
        if number % TOGETHER == 0 or number == len(floats):
            lines.append(r"\FloatBarrier")
    return lines


def _figure(key: str, figure: FigureFile, path: str, width: float) -> str:
    scale = figure_scale(figure, width)
    size = f"[width={scale * figure.width * BIG_POINT:.2f}pt]" if scale < 1.0 else ""
    return "\n".join(
        [
            r"\begin{figure}[htbp]",
            r"\centering",
            rf"\includegraphics{size}{{{path}}}",
            rf"\caption{{{_prose(figure.caption)}}}",
            rf"\label{{{label('fig', key, figure.name)}}}",
            r"\end{figure}",
        ]
    )


def _provenance(part: Part) -> list[str]:
    contents, record = part.contents, part.contents.provenance
    versions = record.get("versions")
    seeds = record.get("seeds")
    lines = [
        f"Source: {record['source']}." if record.get("source") else "",
        f"Made by: {contents.command}",
        f"Version of the program: {record['version of the program']}." if "version of the program" in record else "",
        f"Packages: {', '.join(f'{name} {version}' for name, version in versions.items())}."
        if isinstance(versions, dict)
        else "",
        f"Seeds: {', '.join(map(str, seeds))}." if isinstance(seeds, list) else "",
        f"Started: {record['started']}, {record['wall_seconds']:g} s." if "wall_seconds" in record else "",
    ]
    return [line for line in lines if line]


# --- text ---


def _prose(text: str) -> str:
    """Text of a paragraph: long names may break behind a slash and an underscore."""
    shown = shown_text(text)
    return re.sub(r"(/|\\_)(?=[^\s}])", r"\1\\allowbreak{}", shown)


def _items(lines: Sequence[str]) -> list[str]:
    return [r"\begin{itemize}", *(rf"\item {_prose(line)}" for line in lines), r"\end{itemize}"]


_KEPT = {"\\": r"\textbackslash{}", "{": r"\{", "}": r"\}", "'": r"\textquotesingle{}", "`": r"\textasciigrave{}"}


def _listing(text: str) -> list[str]:
    """A file as it is, with its long lines broken; characters that no font has by their number."""
    lines = [part for line in text.splitlines() for part in _cut("".join(map(_told, line.expandtabs(4))))]
    shown = ["".join(_KEPT.get(character) or _letter(character) for character in line) for line in lines]
    return [r"\begin{Verbatim}[commandchars=\\\{\},fontsize=\footnotesize]", *shown, r"\end{Verbatim}"]


def _told(character: str) -> str:
    """A character, or the number by which it is shown."""
    shown = _letter(character)
    return shown.removeprefix("{[}").join(("[", "")) if shown.startswith("{[}U+") else character


def _letter(character: str) -> str:
    return character if " " <= character <= "~" else escaped(character)


def _cut(line: str) -> list[str]:
    """A line in pieces that fit, each but the first behind an indent."""
    pieces, room = [], ITEM
    while len(line) > room:
        space = line.rfind(" ", room // 2, room)
        end = space + 1 if space > 0 else room
        pieces.append(line[:end])
        line, room = line[end:], ITEM - 4
    pieces.append(line)
    return [pieces[0], *(f"    {piece}" for piece in pieces[1:])]
