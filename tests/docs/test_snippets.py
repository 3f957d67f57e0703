"""Code blocks of README.md and docs/: each is of a kind that is run, or says why not; quick ones run here."""

from pathlib import Path

import pytest
from command import ROOT
from snippets.blocks import KINDS, LANGUAGES, Block, blocks, indented, pages
from snippets.commands import mistake, workbench_lines
from snippets.folders import missing_lines, prepared
from snippets.running import BlockError, run_quick


def is_tried(block: Block) -> bool:
    """Whether the tests do more with it than look at its commands."""
    return block.kind == "quick" or (block.language == "toml" and block.kind != "illustration")


PAGES = pages()
BLOCKS = [block for page in PAGES for block in blocks(page)]
QUICK = [page for page in PAGES if any(is_tried(block) for block in blocks(page))]


def test_every_block_says_what_it_is() -> None:
    wrong = [
        block.place
        for block in BLOCKS
        if block.language not in LANGUAGES
        or (block.kind and block.kind not in KINDS)
        or (block.kind in ("file", "part of", "illustration") and not block.said)
        or (block.language in ("text", "c", "matlab") and block.kind not in ("file", "output", "illustration"))
    ]
    assert wrong == []
    assert {page.name: indented(page) for page in PAGES if indented(page)} == {}


def test_commands_are_ones_that_the_program_takes() -> None:
    said = [(block, words) for block in BLOCKS if block.language == "sh" for words in workbench_lines(block)]
    assert len(said) > 40
    assert [f"{block.place}: {' '.join(words)}: {told}" for block, words in said if (told := mistake(words))] == []


@pytest.mark.parametrize("page", QUICK, ids=lambda page: page.stem)
def test_files_are_in_order_and_quick_blocks_run(page: Path, tmp_path: Path) -> None:
    assert run_quick(page, prepared(tmp_path / "page"))


def test_a_wrong_command_file_and_output_are_told(tmp_path: Path) -> None:
    assert "no-such" in mistake(["run", "a.toml", "--out", "b", "--no-such"])
    assert mistake(["run", "a.toml"])
    assert mistake(["bend"]) == "no command bend"
    assert missing_lines("a  b\nc\n", "x\n a b\n") == ["c"]
    page = tmp_path / "page.md"
    page.write_text('```toml\ntitle = "no plant"\n```\n', encoding="utf-8")
    with pytest.raises(BlockError, match="plant"):
        run_quick(page, prepared(tmp_path / "folder"))


def test_blocks_are_read_with_what_stands_above_them() -> None:
    first = blocks(ROOT / "docs" / "first_steps.md")
    assert [(block.language, block.kind) for block in first][:4] == [
        ("sh", "illustration"),
        ("toml", "file"),
        ("sh", "quick"),
        ("text", "output"),
    ]
    assert isinstance(first[0], Block)
