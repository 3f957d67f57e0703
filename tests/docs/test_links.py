"""Links between README.md, docs/ and the repository: each leads to a file, a heading, or a page that the site makes."""

import re
from pathlib import Path

import pytest
from command import ROOT
from snippets.blocks import pages
from snippets.site import PAGES

LINK = re.compile(r"\]\((?!https?:)([^)\s]+)\)")


def anchors(page: Path) -> set[str]:
    """The anchors of a page's headings, as GitHub and the site have them."""
    heads = re.findall(r"^#+ (.+)$", page.read_text(encoding="utf-8"), flags=re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", head.lower()).replace(" ", "-") for head in heads}


def dead(page: Path, target: str) -> bool:
    """Whether a link of a page leads nowhere."""
    name, _, anchor = target.partition("#")
    path = (page.parent / name).resolve() if name else page
    if path.parent == ROOT / "docs" / "made":
        return path.suffix != ".md" or path.stem not in PAGES
    return not path.exists() or (bool(anchor) and anchor not in anchors(path))


@pytest.mark.parametrize("page", pages(), ids=lambda page: page.stem)
def test_every_link_leads_somewhere(page: Path) -> None:
    targets = LINK.findall(page.read_text(encoding="utf-8"))
    assert [target for target in targets if dead(page, target)] == []


def test_a_dead_link_is_noticed() -> None:
    page = ROOT / "docs" / "tuning.md"
    assert dead(page, "no_such.md")
    assert dead(page, "study_files.md#no-such-heading")
    assert dead(page, "made/no_such.md")
    assert not dead(page, "study_files.md#results")
    assert not dead(page, "made/commands.md")
