"""From LaTeX to PDF, where a LaTeX is installed."""

import os
import re
import shutil
import subprocess
from pathlib import Path
from tempfile import TemporaryDirectory

from workbench.errors import UserError

TEX, PDF = "report.tex", "report.pdf"

INSTALL = "apt-get install texlive-latex-extra texlive-science latexmk"

LONGEST = 600.0
"""Seconds."""

_QUIETLY = ("-interaction=nonstopmode", "-halt-on-error", "-no-shell-escape")


def check_latex() -> None:
    """Raise UserError where there is no LaTeX."""
    if shutil.which("pdflatex") is None:
        raise UserError(f"--pdf: no pdflatex is found; install one ({INSTALL}), or leave --pdf out for {TEX} alone")


def compile_report(folder: Path) -> list[str]:
    """Make report.pdf of report.tex beside it, the same bytes for the same files; returns LaTeX's warnings.

    Raises:
        UserError: LaTeX stops, with the first thing that it complains of.
    """
    with TemporaryDirectory() as temporary:
        copy = Path(temporary) / "report"
        shutil.copytree(folder, copy)
        dated = {**os.environ, "SOURCE_DATE_EPOCH": "0", "FORCE_SOURCE_DATE": "1"}
        for _ in range(3):  # references, then widths of long tables
            answer = subprocess.run(
                ["pdflatex", *_QUIETLY, TEX], cwd=copy, env=dated, capture_output=True, timeout=LONGEST, check=False
            )
            log = (copy / "report.log").read_text(encoding="utf-8", errors="replace") if answer.returncode <= 1 else ""
            if answer.returncode:
                raise UserError(f"{folder / TEX}: pdflatex stops: {_complaint(log)}; pdflatex {TEX} there says more")
        shutil.copyfile(copy / PDF, folder / PDF)
    return warnings_in(log)


def warnings_in(log: str) -> list[str]:
    """The warnings in a log of LaTeX: its own, of packages, and of boxes that are too full or too empty."""
    own = r"(?:LaTeX|pdfTeX|Package \S+|Class \S+)(?: Font)? [Ww]arning.*"
    return re.findall(rf"^(?:{own}|(?:Over|Under)full .*)$", log, re.MULTILINE)


def _complaint(log: str) -> str:
    found = re.search(r"^! (?P<what>.*)$|^(?P<place>\S+:\d+: .*)$", log, re.MULTILINE)
    return (found[0].removeprefix("! ") if found else "no reason in its log").rstrip(".")
