"""Tables as they lie in a folder of results, for a page that shows them."""

from pathlib import Path

import pandas as pd

from workbench.publish.markdown import plain
from workbench.publish.tables import Table


def stored_table(markdown: Path) -> Table:
    """The table that was written as this Markdown file: title and notes from there, cells from the CSV beside."""
    cells = pd.read_csv(markdown.with_suffix(".csv"), dtype=str, keep_default_na=False)
    title, *blocks = markdown.read_text(encoding="utf-8").strip().split("\n\n")
    return Table(plain(title.strip("*")), cells, [plain(block) for block in blocks if not block.startswith("|")])
