"""The studies that come with the program: what each asks, and by which command it is answered."""

from pathlib import Path

from builder.markdown import cell, table
from workbench.study.reading import read_study
from workbench.study.sections import other_command, sections_of
from workbench.study.study import Study

STUDIES = Path(__file__).parents[2] / "studies"

HEAD = """\
# Studies

The studies that come with the program. Each says at its head which assumptions it makes; `workbench check` says how
many cases it has.
"""


def page(folder: Path) -> str:
    """A line a study."""
    studies = [read_study(path) for path in sorted(STUDIES.glob("*.toml"))]
    return f"{HEAD}\n{table(['study', 'what it answers', 'by'], [_row(study) for study in studies])}\n"


def _row(study: Study) -> list[str]:
    path, only = study.path, other_command(study)
    first = only.command if only is not None else "run"
    commands = dict.fromkeys(
        [first, *(section.command for section, _ in sections_of(study) if section.command != "run")]
    )
    asked = cell(study.file.question or study.file.title)
    return [f"[{path.stem}](../../studies/{path.name})", asked, ", ".join(f"`workbench {name}`" for name in commands)]
