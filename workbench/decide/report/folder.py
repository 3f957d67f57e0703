"""A decision as files: decision.html, results, draws, tables, figures, and how it was made."""

import os
import platform
import time
from importlib.metadata import version
from pathlib import Path

from plants.equation import source_hash
from workbench.decide.decision import Decision
from workbench.decide.report.answer import paragraph
from workbench.decide.report.figures import write_figures
from workbench.decide.report.map import map_table
from workbench.decide.report.names import MM, confidence, percent, where
from workbench.decide.report.page import page
from workbench.decide.report.tables import candidate_table, short_table
from workbench.decide.report.words import price, question
from workbench.decide.results import results
from workbench.publish.folders import ResultFolder
from workbench.publish.tables import write_frame
from workbench.study.layers import LAYERS
from workbench.study.runner import PACKAGES, PROGRAM_FOLDERS
from workbench.study.store import STUDY_COPY, export, write_json, write_study

PAGE = "decision.html"
DRAWS = "draws.parquet"

FOLDER = ResultFolder(
    "decision",
    (
        *(PAGE, "results.csv", "results.parquet", DRAWS, "run.json", "tables", "figures", STUDY_COPY),
        *(layer.section for layer in LAYERS.values()),
    ),
)
check_folder = FOLDER.check


def write_decision(found: Decision, folder: Path, began: float, jobs: int | None) -> None:
    """Write everything; `began` is when the work did (s since the epoch). Stopped, nothing is written."""
    FOLDER.write(folder, lambda beside: _write(found, beside, began, jobs))


def _write(found: Decision, folder: Path, began: float, jobs: int | None) -> None:
    export(results(found.cells), folder)
    found.draws.to_parquet(folder / DRAWS, index=False)
    write_study(found.plan.study, folder)
    table = found.table
    candidates = ("candidates", f"Candidates {where(found)}, the best first", candidate_table(found))
    matrix = (
        "map",
        "What suffices, with the choice, its probability, and what fails of what is simpler",
        map_table(found),
    )
    notes = [
        f"Met: runs that complete with an error of at most {table.accuracy * MM:g} mm and at most {table.power:g} W, "
        "on machines on which the loop does not hunt. Probabilities are those of fresh draws; their exact intervals "
        f"hold with {confidence()}, all together; that of the {percent(table)} quantile is by order statistics."
    ]
    for name, title, cells in (candidates, matrix):
        write_frame(name, title, cells, notes, folder / "tables")
    pictures = write_figures(found, folder / "figures")
    (folder / PAGE).write_text(page(found, pictures, [candidates[1:]]), encoding="utf-8")
    write_json(folder / "run.json", _record(found, began, jobs))


def summary(found: Decision) -> str:
    """Question, answer and candidates, for a terminal."""
    cells = short_table(found)
    align = ["left" if name == "candidate" else "right" for name in cells.columns]
    shown = cells.to_markdown(index=False, disable_numparse=True, colalign=align)
    return "\n\n".join(part for part in (question(found), paragraph(found), price(found), shown) if part)


def _record(found: Decision, began: float, jobs: int | None) -> dict[str, object]:
    plan, file = found.plan, found.plan.study.file
    return {
        "title": file.title,
        "study": plan.study.fingerprint,
        "decide": plan.table.model_dump(mode="json"),
        "uncertainty": None if file.uncertainty is None else file.uncertainty.model_dump(mode="json"),
        "version of the program": source_hash((*PROGRAM_FOLDERS, "workbench/decide")),
        "runs": len(found.draws),
        "wall_seconds": round(time.time() - began, 3),
        "started": time.strftime("%Y-%m-%dT%H:%M:%SZ", time.gmtime(began)),
        "jobs": jobs or os.cpu_count(),
        "versions": {"python": platform.python_version(), **{name: version(name) for name in PACKAGES}},
        "machine": {"system": platform.system(), "machine": platform.machine(), "cores": os.cpu_count()},
    }
