"""Scenario files: named changes of the truth that any study can take by name.

What a study in FOLDER names on its axis `scenario` is its own table [scenarios.NAME], else FOLDER/scenarios/NAME.toml,
else the scenario of that name that comes with the program.
"""

from importlib import resources
from pathlib import Path
from typing import Any

from workbench import files
from workbench.files import Strict

FOLDER = "scenarios"

SHIPPED = Path(str(resources.files("workbench"))) / FOLDER
"""The scenarios that come with the program: a link to studies/scenarios, which an installed package holds in full."""


class ScenarioFile(Strict):
    """A scenario as it stands in a file: what is laid over the tables of a case; it changes the truth, never a belief.

    What its tables hold is checked with the plant and the sensors of each case.
    """

    title: str
    source: str
    plant: dict[str, Any] = {}
    sensors: dict[str, Any] = {}
    simulation: dict[str, Any] = {}

    @property
    def overrides(self) -> dict[str, Any]:
        """The tables that it has."""
        return self.model_dump(exclude={"title", "source"}, exclude_unset=True)


def scenario_files(study_folder: Path) -> dict[str, Path]:
    """The scenario files that a study can name: those beside it, which come before the shipped ones of their name."""
    beside, shipped = (sorted(folder.glob("*.toml")) for folder in (study_folder / FOLDER, SHIPPED))
    return {path.stem: path for path in (*shipped, *beside)}


def is_scenario(path: Path) -> bool:
    """Whether a file stands where studies look for scenarios."""
    return path.resolve().parent.name == FOLDER


def read_scenario(path: Path) -> tuple[ScenarioFile, str]:
    """A scenario file and its text.

    Raises:
        UserError: unreadable, not TOML, unknown or missing keys.
    """
    data, text = files.read_toml(path)
    return files.validate(ScenarioFile, data, path, text), text
