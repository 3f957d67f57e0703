"""A study as a notebook of the Python interface: its cells, executed beside it."""

import ast
import base64
import json
import os
from collections.abc import Mapping, Sequence
from contextlib import chdir
from pathlib import Path
from typing import NamedTuple

from workbench.export.one_file import new_file
from workbench.progress import Progress, silent
from workbench.publish.folders import write_whole
from workbench.study.plan import Plan

FORMAT = {
    "nbformat": 4,
    "nbformat_minor": 5,
    "metadata": {
        "kernelspec": {"display_name": "Python 3", "language": "python", "name": "python3"},
        "language_info": {"name": "python"},
    },
}
"""What a notebook holds beside its cells."""

FACES = {"text/html": "_repr_html_", "text/markdown": "_repr_markdown_", "image/png": "_repr_png_"}
"""How a value shows itself, by the kind of what it then gives."""

SHOWN = ("axial_friction", "velocity")
"""Signals of the run that is looked at: the first over the second, where its plant has both."""


class Cell(NamedTuple):
    """A cell: code, or `words` in Markdown."""

    text: str
    words: bool = False


def cells_of(planned: Plan, study: str, results: str, case: int, draws: int | None = None) -> list[Cell]:
    """The cells for a study: what it asks, its cases, its results with tables and figures, and one of its cases.

    Args:
        planned: the study, checked.
        study: the path of its file from where the notebook lies.
        results: the name of the folder beside the notebook for its results.
        case: the place of the case that is looked at more closely.
        draws: of machines, in place of what the study says.
    """
    file = planned.study.file
    drawn = f", draws={draws}" if draws is not None else ""
    asked = [file.question] if file.question else []
    source = [f"Source: {file.source}"] if file.source else []
    cells = [
        Cell("\n\n".join([f"# {file.title}", *asked, *source]), words=True),
        Cell(f"import workbench as wb\n\nstudy = wb.Study({study!r})\nstudy"),
        Cell("study.cases"),
        Cell(f"## Results\n\nWhat is finished lies in `{results}`, and is not run again.", words=True),
        Cell(f"results = study.run({results!r}, resume=True{drawn})\nresults"),
    ]
    cells += [Cell(f"results.table({table.name!r})") for table in file.tables]
    cells += [Cell(f"results.figure({figure.name!r})") for figure in file.figures]
    if not file.tables:
        cells.append(Cell("results.frame"))
    signals = [item for item in SHOWN if item in planned.declared[0].setup.plant.Signals._fields]
    drawing = "run.plot({!r}, against={!r})".format(*signals) if len(signals) == len(SHOWN) else 'run.plot("position")'
    return [
        *cells,
        Cell("## One case\n\nThe same loop in Python: simulated, judged, linearised at rest.", words=True),
        Cell(f"loop = study.setup({_arguments(planned.cases.columns(case))})\nrun = wb.simulate(loop)\nrun"),
        Cell("wb.evaluate(run).dropna()"),
        Cell(drawing),
        Cell("wb.linearise(loop)"),
    ]


def write_notebook(
    planned: Plan,
    out: Path,
    case: int = 0,
    *,
    draws: int | None = None,
    overwrite: bool = False,
    progress: Progress = silent,
) -> Path:
    """Execute the cells of a study and write the notebook; returns the folder of results, which lies beside it.

    Raises:
        UserError: a file of another ending, one that is there already, or what a cell raises.
    """
    results = out.with_name(f"{out.stem}_results")
    study = Path(os.path.relpath(planned.study.path, out.parent)).as_posix()
    with new_file(out, (".ipynb",), overwrite):
        with chdir(out.parent):
            executed = _executed(cells_of(planned, study, results.name, case, draws), progress)
        text = json.dumps({**FORMAT, "cells": executed}, indent=1) + "\n"
        write_whole(out, lambda path: path.write_text(text, encoding="utf-8"))
    return results


def _executed(cells: Sequence[Cell], progress: Progress) -> list[dict[str, object]]:
    """Cells as a notebook holds them, those of code executed one after another, with what they show."""
    names: dict[str, object] = {}
    made: list[dict[str, object]] = []
    count = 0
    for number, cell in enumerate(cells):
        progress(f"cell {number + 1} of {len(cells)}", number / len(cells))
        written = {"id": f"cell-{number}", "metadata": {}, "source": cell.text}
        if cell.words:
            made.append({**written, "cell_type": "markdown"})
            continue
        count += 1
        shown = {"output_type": "execute_result", "metadata": {}, "data": _bundle(_run(cell.text, names))}
        outputs = [{**shown, "execution_count": count}]
        made.append({**written, "cell_type": "code", "execution_count": count, "outputs": outputs})
    return made


def _run(source: str, names: dict[str, object]) -> object:
    """Execute a cell that ends in an expression; returns that one's value."""
    *statements, last = ast.parse(source).body
    assert isinstance(last, ast.Expr)
    exec(compile(ast.Module(statements, []), "<cell>", "exec"), names)
    return eval(compile(ast.Expression(last.value), "<cell>", "eval"), names)


def _bundle(value: object) -> dict[str, str]:
    """How a notebook shows a value: as text, and as the HTML or the picture that it makes of itself."""
    bundle = {"text/plain": repr(value)}
    for kind, method in FACES.items():
        face = getattr(value, method, None)
        if face is not None and (shown := face()) is not None:
            bundle[kind] = base64.b64encode(shown).decode("ascii") if isinstance(shown, bytes) else shown
    return bundle


def _arguments(columns: Mapping[str, object]) -> str:
    """Arguments that choose a case."""
    if all(name.isidentifier() for name in columns):
        return ", ".join(f"{name}={value!r}" for name, value in columns.items())
    return f"**{dict(columns)!r}"
