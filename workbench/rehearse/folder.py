"""What `workbench rehearse` leaves in its folder.

rehearsal.csv, rehearsal.md    a row a figure of a case: as the study has it, as rehearsed, and the difference (SI)
controllers/                   the C that was in the loops, a folder a controller
rehearsal.json                 the count of figures, and of those that are equal; it is there only where all is
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from workbench.publish.folders import ResultFolder
from workbench.publish.markdown import in_cell
from workbench.rehearse.rehearsal import Compared, Progress, rehearse
from workbench.study.plan import Plan
from workbench.study.store import write_json

FOLDER = ResultFolder("rehearsal", ("rehearsal.json", "rehearsal.csv", "rehearsal.md", "controllers"))


@dataclass(frozen=True)
class Rehearsed:
    """A rehearsal as written: the figures that apply, and the table of them."""

    figures: Sequence[Compared]
    table: Path

    @property
    def different(self) -> list[Compared]:
        """The figures that do not agree to the last printed digit."""
        return [item for item in self.figures if not item.equal]

    @property
    def summary(self) -> str:
        """What came out, in a line."""
        count, different = len(self.figures), self.different
        if not different:
            return f"{count} figures: study and rehearsal are equal to the last printed digit"
        worst = max(different, key=lambda item: abs(item.difference))
        at = ", ".join(f"{name} {value}" for name, value in worst.case.items())
        return (
            f"{len(different)} of {count} figures differ; the largest difference: {worst.column} {worst.printed[0]}, "
            f"rehearsed {worst.printed[1]}{f' ({at})' if at else ''}"
        )


def write_rehearsal(
    planned: Plan, out: Path, *, overwrite: bool = False, jobs: int | None = None, progress: Progress | None = None
) -> Rehearsed:
    """Rehearse a study into a folder, which is written whole or not at all.

    Raises:
        UserError: the folder does not serve, or as `rehearse`.
    """
    with FOLDER.claimed(out, overwrite):
        figures = FOLDER.write(out, lambda folder: _fill(planned, folder, jobs, progress))
    return Rehearsed(figures, out / "rehearsal.md")


def _fill(planned: Plan, folder: Path, jobs: int | None, progress: Progress | None) -> list[Compared]:
    sources = folder / "controllers"
    sources.mkdir()
    found = rehearse(planned, sources, jobs=jobs, progress=progress)
    for library in sources.rglob("*.so"):
        library.unlink()
    figures = [item for item in found if item.study is not None or item.rehearsed is not None]
    frame = frame_of(figures)
    frame.to_csv(folder / "rehearsal.csv", index=False, lineterminator="\n")
    shown = frame.map(lambda cell: in_cell(str(cell)))
    text = shown.to_markdown(index=False, disable_numparse=True)
    (folder / "rehearsal.md").write_text(f"{text}\n", encoding="utf-8")
    equal = sum(item.equal for item in figures)
    record = {"title": planned.study.file.title, "cases": len(planned.cases), "figures": len(figures), "equal": equal}
    write_json(folder / "rehearsal.json", record)
    return figures


def frame_of(figures: Sequence[Compared]) -> pd.DataFrame:
    """A row a figure of a case: as the study has it, as rehearsed, and the difference; all as results.csv prints it."""
    return pd.DataFrame([_row(item) for item in figures])


def _row(item: Compared) -> dict[str, object]:
    study, rehearsed = item.printed
    difference = "" if isinstance(item.study, str) or isinstance(item.rehearsed, str) else f"{item.difference:.3g}"
    return {**item.case, "figure": item.column, "study": study, "rehearsed": rehearsed, "difference": difference}
