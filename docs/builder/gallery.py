"""The gallery: fast studies, run by the build; their tables and figures as the program writes them."""

import shutil
from collections.abc import Iterable
from pathlib import Path

import workbench as wb
from workbench.publish.contents import Contents
from workbench.report.study import study_contents

ROOT = Path(__file__).parents[2]

STUDIES = (
    "thesis_chapter3",
    "rotary_friction",
    "lugre_reference",
    "hunting",
    "hunting_rotation",
    "compensation",
    "rotation_on_demand",
    "rotary_drive",
)
"""Files of studies/, in their order on the page; together they take about a minute."""


def page(folder: Path) -> str:
    """A section for each study; its figures go into `folder`/gallery."""
    parts = [
        "# Gallery",
        "What the building of these pages has run: every number and picture below comes from the program as it stands. "
        "Each study's own page, `results.html` in its folder, has more: all cases, the motion of each, tables to sort.",
    ]
    for name in STUDIES:
        results = ROOT / "results" / "gallery" / name
        wb.Study(ROOT / "studies" / f"{name}.toml").run(results, resume=True)
        parts += section(name, study_contents(results), results, folder)
    return "\n\n".join(parts) + "\n"


def section(name: str, found: Contents, results: Path, folder: Path) -> list[str]:
    """One study: what it asks, how to run it, its figures and tables."""
    shown = folder / "gallery" / name
    shown.mkdir(parents=True, exist_ok=True)
    parts = [f"## {found.title}", found.question]
    parts += [f"```sh\nworkbench run studies/{name}.toml --out results/{name}\n```"]
    parts += found.notes[:1]
    for figure in found.figures:
        shutil.copy(results / "figures" / f"{figure}.svg", shown)
        parts += [f"![{figure.replace('_', ' ')}]({shown.relative_to(folder)}/{figure}.svg)"]
    parts += shown_tables(results, found.tables)
    parts += [f"[{name}.toml](../../studies/{name}.toml) is all of it."]
    return [part for part in parts if part]


def shown_tables(results: Path, names: Iterable[str]) -> list[str]:
    """Tables of a folder of results, as Markdown."""
    return [(results / "tables" / f"{name}.md").read_text(encoding="utf-8").strip() for name in names]
