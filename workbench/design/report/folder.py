"""A finished design as files: design.json, design.html, the reference, a study, tables and figures."""

import json
from pathlib import Path

from workbench.design.asked import MOST_CONDITIONS, MOST_HYPOTHESES
from workbench.design.report.figures import draw_motion, motion_data
from workbench.design.report.page import page
from workbench.design.report.study_file import STUDY, write_study
from workbench.design.report.tables import tables_of
from workbench.design.report.words import COMMAND, answer, how_run, undecided, verdicts
from workbench.design.result import Design
from workbench.publish.contents import CONTENTS, Contents, write_contents
from workbench.publish.folders import ResultFolder
from workbench.publish.pictures import save
from workbench.publish.run_record import made_by
from workbench.publish.tables import write_frame

RESULT = "design.json"
PAGE = "design.html"


def _is_design(path: Path) -> bool:
    try:
        return "told_apart" in json.loads(path.read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return False


FOLDER = ResultFolder(
    "design",
    (
        RESULT,
        PAGE,
        STUDY,
        "reference.csv",
        *(f"reference_{i}.csv" for i in range(1, MOST_CONDITIONS + 1)),
        *(f"hypothesis_{i}.toml" for i in range(1, MOST_HYPOTHESES + 1)),
        "tables",
        "figures",
        CONTENTS,
    ),
    _is_design,
)
claimed_folder = FOLDER.claimed


def write_design(design: Design, folder: Path) -> None:
    """Write everything, whole or not at all."""
    FOLDER.write(folder, lambda beside: _write(design, beside))


def _write(design: Design, folder: Path) -> None:
    tables, pictures = tables_of(design), {"motion": draw_motion(design, motion_data(design))}
    for name, table in tables.items():
        write_frame(name, table, folder / "tables")
    for name, picture in pictures.items():
        save(picture.figure, name, folder / "figures", caption=picture.caption)
    files = write_study(design, folder)
    experiment = design.experiment
    contents = Contents(
        title=f"What to record next: {experiment.title}",
        question="Which motion tells most of what is still open?",
        answer=[answer(design), *verdicts(design)],
        notes=[*undecided(design), *how_run(design)],
        command=f"{COMMAND} {Path(design.source).name}",
        tables=list(tables),
        figures=list(pictures),
        details=[],
        provenance=made_by("workbench/design", "workbench/diagnose"),
        file=experiment.path.name,
        text=experiment.path.read_text(encoding="utf-8"),
    )
    write_contents(contents, folder)
    (folder / PAGE).write_text(page(design, pictures, tables, files, folder), encoding="utf-8")
    (folder / RESULT).write_text(json.dumps(design.to_json(), indent=2, allow_nan=False) + "\n", encoding="utf-8")


def summary(design: Design) -> str:
    """What to record, how surely it decides, and what remains open, for a terminal."""
    tables = tables_of(design)
    shown = [
        tables[name].cells.to_markdown(index=False, disable_numparse=True)
        for name in ("pieces", "pairs")
        if name in tables
    ]
    lines = [f"- {line}" for line in (*verdicts(design), *undecided(design), *how_run(design))]
    return "\n\n".join([design.experiment.title, answer(design), *shown, "\n".join(lines)])
