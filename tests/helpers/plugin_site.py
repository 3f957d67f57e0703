"""The example of docs/plugin_example, and other plug-ins, as an installer leaves them."""

import shutil
import sys
import tomllib
from pathlib import Path

import pytest
from command import ROOT, write

EXAMPLE = ROOT / "docs" / "plugin_example"


def site(folder: Path) -> Path:
    """A folder of packages that holds the example as an installer leaves it."""
    description = tomllib.loads((EXAMPLE / "pyproject.toml").read_text(encoding="utf-8"))
    project = description["project"]
    for module in description["tool"]["setuptools"]["py-modules"]:
        shutil.copy(EXAMPLE / f"{module}.py", folder)
    information = folder / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
    information.mkdir()
    metadata = f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
    (information / "METADATA").write_text(metadata, encoding="utf-8")
    groups = project["entry-points"]
    lines = [f"[{group}]\n" + "".join(f"{k} = {v}\n" for k, v in groups[group].items()) for group in groups]
    (information / "entry_points.txt").write_text("\n".join(lines), encoding="utf-8")
    return folder


def brings(folder: Path, group: str, line: str) -> None:
    """A distribution `other` in `folder` with one entry point."""
    information = folder / "other-1.0.dist-info"
    information.mkdir()
    write(information, "Metadata-Version: 2.1\nName: other\nVersion: 1.0\n", "METADATA")
    write(information, f"[{group}]\n{line}\n", "entry_points.txt")


def visible(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Python finds packages in the folder too, until the test ends."""
    monkeypatch.setattr(sys, "path", [str(folder), *sys.path])
    monkeypatch.delitem(sys.modules, "deadband_p", raising=False)
