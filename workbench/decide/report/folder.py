"""A decision as files: decision.html, results, draws, tables, figures, and how it was made."""

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from plants.equation import source_hash
from workbench.decide.batches import Kept
from workbench.decide.kept import DATABASE, kept_runs
from workbench.decide.plan import PROGRAM, Plan
from workbench.decide.report.answer import paragraph
from workbench.decide.report.figures import write_figures
from workbench.decide.report.map import map_table
from workbench.decide.report.names import MM, confidence, percent, where
from workbench.decide.report.page import page
from workbench.decide.report.rows import results
from workbench.decide.report.tables import candidate_table, short_table
from workbench.decide.report.words import assumptions, price, question
from workbench.decide.result import Decision
from workbench.publish.contents import CONTENTS, Contents, write_contents
from workbench.publish.folders import GrowingFolder, ResultFolder
from workbench.publish.run_record import ran_on
from workbench.publish.tables import Table, write_frame
from workbench.study.layers import LAYERS
from workbench.study.store import STUDY_COPY, export, write_json, write_study

PAGE = "decision.html"
DRAWS = "draws.parquet"

FOLDER = ResultFolder(
    "decision",
    (
        *(PAGE, "results.csv", "results.parquet", DRAWS, "run.json", "tables", "figures", CONTENTS, STUDY_COPY),
        *(layer.section for layer in LAYERS.values()),
    ),
)
RUNS = GrowingFolder("decision", "runs", (DATABASE,))
"""What is there before there is an answer."""


@contextmanager
def opened_folder(folder: Path, plan: Plan, *, resume: bool = False, overwrite: bool = False) -> Iterator[Kept]:
    """The folder of a decision, for this process alone, and the runs that are kept in it.

    With `resume` they stay, where there are any; an answer is replaced when there is another.

    Raises:
        UserError: it holds a decision or runs already, or of another study or version of the program, or files of the
            same names that no decision wrote; another command is at work there; or the disk fails.
    """
    FOLDER.check(folder, overwrite or (resume and (folder / DATABASE).exists()))
    with RUNS.opened(folder, resume=resume, overwrite=overwrite) as database, kept_runs(database, plan) as kept:
        yield kept


def write_decision(decision: Decision, folder: Path, began: float, jobs: int | str | None) -> None:
    """Write everything; `began` is when the work did (s since the epoch), `jobs` how many ran at a time, or the address
    of a cluster. Stopped, no answer is written."""
    FOLDER.write(folder, lambda beside: _write(decision, beside, began, jobs))


def _write(decision: Decision, folder: Path, began: float, jobs: int | str | None) -> None:
    export(results(decision.cells), folder)
    decision.draws.to_parquet(folder / DRAWS, index=False)
    write_study(decision.plan.study, folder)
    table = decision.table
    candidates = ("candidates", f"Candidates {where(decision)}, the best first", candidate_table(decision))
    matrix = (
        "map",
        "What suffices, with the choice, its probability, and what fails of what is simpler",
        map_table(decision),
    )
    notes = [
        f"Met: runs that complete with an error of at most {table.accuracy * MM:g} mm and at most {table.power:g} W, "
        "on machines on which the loop does not hunt. Probabilities are those of fresh draws; their exact intervals "
        f"hold with {confidence()}, all together; that of the {percent(table)} quantile is by order statistics."
    ]
    for name, title, cells in (candidates, matrix):
        write_frame(name, Table(title, cells, notes), folder / "tables")
    pictures = write_figures(decision, folder / "figures")
    (folder / PAGE).write_text(page(decision, pictures, [candidates[1:]], folder), encoding="utf-8")
    record = _record(decision, began, jobs)
    contents = Contents(
        title=decision.plan.study.file.title,
        question=question(decision),
        answer=[line for line in (paragraph(decision), price(decision)) if line],
        notes=assumptions(decision),
        command=f"workbench decide {decision.plan.study.path.name}",
        tables=[name for name, _, _ in (candidates, matrix)],
        figures=list(pictures),
        details=[],
        provenance=record,
        file=decision.plan.study.path.name,
        text=decision.plan.study.text,
    )
    write_contents(contents, folder)
    write_json(folder / "run.json", record)


def summary(decision: Decision) -> str:
    """Question, answer and candidates, for a terminal."""
    cells = short_table(decision)
    align = ["left" if name == "candidate" else "right" for name in cells.columns]
    shown = cells.to_markdown(index=False, disable_numparse=True, colalign=align)
    return "\n\n".join(part for part in (question(decision), paragraph(decision), price(decision), shown) if part)


def _record(decision: Decision, began: float, jobs: int | str | None) -> dict[str, object]:
    return {
        **decision.provenance,
        "version of the program": source_hash(PROGRAM),
        **ran_on(began, jobs),
    }
