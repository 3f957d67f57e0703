"""Scenario files: named changes of the truth that any study beside them can take by name.

A study in FOLDER names FOLDER/scenarios/NAME.toml on its axis `scenario`, unless a table [scenarios.NAME] of its own
has that name.
"""

from pathlib import Path
from typing import Any

from workbench import files
from workbench.files import Strict

FOLDER = "scenarios"


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
    """The scenario files beside a study, by name."""
    return {path.stem: path for path in sorted((study_folder / FOLDER).glob("*.toml"))}


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
