"""The pages of docs/made, each made of the program itself."""

from pathlib import Path

from builder import commands, files, gallery, names, parameters, python, studies

PAGES = {
    "commands": commands.page,
    "study_file": files.study_page,
    "experiment_file": files.experiment_page,
    "machine_file": files.machine_page,
    "studies": studies.page,
    "parameters": parameters.page,
    "names": names.page,
    "python_names": python.page,
    "gallery": gallery.page,
}
"""What makes the text of each page, from the folder that it stands in."""


def make(folder: Path) -> None:
    """Write every page."""
    folder.mkdir(exist_ok=True)
    for name, page in PAGES.items():
        (folder / f"{name}.md").write_text(page(folder), encoding="utf-8")
