"""The folder in which a page's blocks run: the repository's files are there, and what the page writes stays there."""

import re
import shutil
import tomllib
from pathlib import Path
from typing import Any

import tomli_w
from command import ROOT

from snippets.blocks import Block

LINKED = ("docs", "benchmarks", "plants", "controllers", "workbench", "Makefile", "pyproject.toml")


def prepared(folder: Path) -> Path:
    """An empty folder with links to what is in the repository, and its studies, beside which files are written."""
    shutil.copytree(ROOT / "studies", folder / "studies")
    for name in LINKED:
        (folder / name).symlink_to(ROOT / name)
    return folder


def written(block: Block, folder: Path) -> Path | None:
    """The file that a block of toml stands for, or any block that has a name, written into the folder."""
    if block.kind == "file":
        path = folder / block.said
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(block.text, encoding="utf-8")
        return path
    if block.language != "toml" or block.kind == "illustration":
        return None
    path, text = folder / "snippet.toml", block.text
    if block.kind == "part of":
        base = folder / block.said.partition(",")[0]
        path = base.with_name(f"{base.stem}_changed.toml")
        whole = tomllib.loads(base.read_text(encoding="utf-8"))
        text = tomli_w.dumps(_laid_over(whole, tomllib.loads(block.text)))
    path.write_text(text, encoding="utf-8")
    return path


def _laid_over(whole: dict[str, Any], part: dict[str, Any]) -> dict[str, Any]:
    """Tables are merged, what else is replaced."""
    found = dict(whole)
    for key, value in part.items():
        both = isinstance(value, dict) and isinstance(found.get(key), dict)
        found[key] = _laid_over(found[key], value) if both else value
    return found


def missing_lines(expected: str, printed: str) -> list[str]:
    """Lines of an output block that were not printed; times and spaces aside."""
    told = {re.sub(r"\s+", " ", line.strip()) for line in printed.splitlines()}
    return [line for line in expected.splitlines() if line.strip() and re.sub(r"\s+", " ", line.strip()) not in told]
