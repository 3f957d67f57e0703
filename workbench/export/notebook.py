"""A study as a notebook of the Python interface: its cells, executed beside it."""

import os
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from workbench.errors import UserError
from workbench.progress import Progress, silent
from workbench.publish.folders import faults_told, write_whole
from workbench.study.plan import Plan

if TYPE_CHECKING:
    from nbformat import NotebookNode

EXTRA = 'export notebook needs nbformat, nbclient and ipykernel: pip install "friction-workbench[notebook]"'

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
        UserError: a file of another ending, one that is there already, a library that is not installed, or a cell that
            fails.
    """
    if out.suffix != ".ipynb":
        raise UserError(f"{out}: expected a name that ends in .ipynb")
    if out.exists() and not overwrite:
        raise UserError(f"{out}: is there already; replace it with --overwrite")
    results = out.with_name(f"{out.stem}_results")
    study = Path(os.path.relpath(planned.study.path, out.parent)).as_posix()
    with faults_told(out.parent, "nothing is written: mend that and run it again"):
        out.parent.mkdir(parents=True, exist_ok=True)
        executed = _executed(cells_of(planned, study, results.name, case, draws), out, progress)
        write_whole(out, lambda path: path.write_text(executed, encoding="utf-8"))
    return results


def _executed(cells: list[Cell], out: Path, progress: Progress) -> str:
    """The notebook as it is written, its cells executed in the folder of `out`.

    Raises:
        UserError: a library is not installed, or a cell fails.
    """
    try:
        import ipykernel  # noqa: F401  the kernel that runs them
        import nbformat
        from nbclient import NotebookClient
        from nbclient.exceptions import CellExecutionError
    except ImportError:
        raise UserError(EXTRA) from None

    node = _node(cells)

    def told(cell: "NotebookNode", cell_index: int) -> None:
        progress(f"cell {cell_index + 1} of {len(cells)}", cell_index / len(cells))

    client = NotebookClient(
        node,
        timeout=None,
        record_timing=False,
        extra_arguments=["--IPKernelApp.log_level=40"],  # of the kernel, which warns of how it is reached
        on_cell_execute=told,
        resources={"metadata": {"path": str(out.parent)}},
    )
    try:
        client.execute()
    except CellExecutionError as error:
        raise UserError(f"{out}: not written, a cell fails: {error.evalue}") from None
    return str(nbformat.writes(node)) + "\n"


def _node(cells: list[Cell]) -> "NotebookNode":
    """The notebook, with the same names of cells each time."""
    from nbformat import v4

    made = [v4.new_markdown_cell(cell.text) if cell.words else v4.new_code_cell(cell.text) for cell in cells]
    for number, cell in enumerate(made):
        cell["id"] = f"cell-{number}"
    return v4.new_notebook(cells=made)


def _arguments(columns: Mapping[str, object]) -> str:
    """Arguments that choose a case."""
    if all(name.isidentifier() for name in columns):
        return ", ".join(f"{name}={value!r}" for name, value in columns.items())
    return f"**{dict(columns)!r}"
