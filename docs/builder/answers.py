"""What came out of the studies: docs/answers.md, whose numbers this writes between its lines `made:` and `end`.

make docs-answers                       # with all draws: an hour and a half
make docs-answers DRAWS=4 FRESH=12      # half an hour; the page says how many there were
"""

import argparse
import re
import sys
from pathlib import Path

import workbench as wb
from builder.gallery import ROOT, shown_tables
from workbench.report.study import study_contents

PAGE = ROOT / "docs" / "answers.md"

COMPARISON = "comparison"

BEHIND = "\n## Who was measured"
"""The heading of a comparison's page behind its matrices and what they say together."""

TABLES = {
    COMPARISON: (),
    "hunting_rotation": ("thesis_simulation_100_1000", "thesis_rig_100_1000"),
    "friction_model_worth": (),
    "rotation_on_demand": (),
    "rotary_friction": (),
}
"""The studies that answer, and which of their tables are shown; without a name the first."""


def main() -> None:
    """Run the studies, or go on with them, and write what they say into the page."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--draws", type=int, default=10)
    parser.add_argument("--fresh-draws", type=int, default=40)
    asked = parser.parse_args()
    text = PAGE.read_text(encoding="utf-8")
    for name, tables in TABLES.items():
        folder = ROOT / "results" / "answers" / name
        drawn = {"draws": asked.draws, "fresh_draws": asked.fresh_draws} if name == COMPARISON else {}
        wb.Study(ROOT / "studies" / f"{name}.toml").run(folder, resume=True, **drawn)
        parts = [_matrices(folder)] if name == COMPARISON else shown_tables(folder, tables or _first(folder))
        text = _between(text, name, "\n\n".join(parts))
        print(f"{name}: told in {PAGE.name}", flush=True)
    PAGE.write_text(text, encoding="utf-8")


def _first(folder: Path) -> list[str]:
    """The name of the first table of a study."""
    return list(study_contents(folder).tables[:1])


def _matrices(folder: Path) -> str:
    """The answer of a comparison in words, and its matrix for each machine."""
    said = (folder / "comparison.md").read_text(encoding="utf-8")
    answer = said[said.index("\n- ") :]
    machines = answer[: answer.index(BEHIND)]
    return machines.replace("\n## ", "\n### ").strip()


def _between(text: str, name: str, said: str) -> str:
    """The page with this said between the lines of that name."""
    begin, end = f"<!-- made: {name} -->", "<!-- end -->"
    pattern = re.compile(f"{re.escape(begin)}.*?{re.escape(end)}", flags=re.DOTALL)
    if len(pattern.findall(text)) != 1:
        sys.exit(f"{PAGE}: expected {begin} and {end} once")
    return pattern.sub(lambda _: f"{begin}\n\n{said}\n\n{end}", text)


if __name__ == "__main__":
    main()
