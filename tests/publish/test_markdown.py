"""Text in Markdown: tags, cells, lines and escapes of a terminal are shown, and read back as they were."""

from pathlib import Path

import pandas as pd
import pytest

from workbench.publish.markdown import in_cell, in_line, in_markdown, plain
from workbench.publish.page.stored import stored_table
from workbench.publish.tables import Table, write_frame


@pytest.mark.parametrize(
    ("text", "cell"),
    [
        ("a|b", r"a\|b"),
        ("<script>alert(1)</script>", r"\<script>alert(1)\</script>"),
        ("< 0.01", "< 0.01"),
        ("a\nb\r\nc", "a b c"),
        ("\x1b[31m", r"\x1b[31m"),
        ("é ± 摩", "é ± 摩"),
    ],
)
def test_a_cell(text: str, cell: str) -> None:
    assert in_cell(text) == cell
    assert in_line(text) == cell.replace(r"\|", "|")
    assert plain(in_line("a <b> | c")) == "a <b> | c"
    assert in_markdown("a\n<b>") == "a\n\\<b>"


def test_a_table_of_odd_text_has_its_rows_and_is_read_back(tmp_path: Path) -> None:
    cells = pd.DataFrame({"quantity": ["a|b\nc", "<b>"], "va|lue": ["1", "< 2"]})
    _, markdown, _ = write_frame("t", Table("The <title>\nof it", cells, ["a <note>"]), tmp_path)
    lines = markdown.read_text(encoding="utf-8").splitlines()
    assert lines[0] == r"**The \<title> of it**"
    assert [line.replace(r"\|", "").count("|") for line in lines if line.startswith("|")] == [3, 3, 3, 3]
    stored = stored_table(markdown)
    assert (stored.title, list(stored.notes)) == ("The <title> of it", ["a <note>"])
    assert stored.cells["quantity"].tolist() == ["a|b\nc", "<b>"]
