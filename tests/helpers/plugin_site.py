"""The example of docs/plugin_example as an installer leaves it."""

import shutil
import tomllib
from pathlib import Path

from command import ROOT

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
