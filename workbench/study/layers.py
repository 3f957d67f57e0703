"""Layers: named changes of a case's tables, which any study can take by name along an axis.

A machine changes what is declared, and with it what controllers believe; a scenario changes the truth alone. What a
study in FOLDER names on the axis `scenario` is its own table [scenarios.NAME], else FOLDER/scenarios/NAME.toml, else
the scenario of that name that comes with the program; machines likewise.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from importlib import resources
from pathlib import Path
from typing import Any

from workbench.toml import reading as files
from workbench.toml.reading import Strict


class ScenarioFile(Strict):
    """A scenario as it stands in a file: what is laid over the tables of a case; it changes the truth, never a belief.

    What its tables hold is checked with the plant and the sensors of each case.
    """

    title: str
    """What is different."""
    source: str
    """Where that comes from."""
    plant: dict[str, Any] = {}
    """Laid over [plant]."""
    sensors: dict[str, Any] = {}
    """Laid over [sensors]."""
    simulation: dict[str, Any] = {}
    """Laid over [simulation]."""

    @property
    def overrides(self) -> dict[str, object]:
        """The tables that it has."""
        return self.model_dump(exclude={"title", "source"}, exclude_unset=True)


class MachineFile(ScenarioFile):
    """A machine as it stands in a file: the same, and what controllers believe of it where that is not what it says."""

    belief: dict[str, Any] = {}
    """Laid over [belief]."""


@dataclass(frozen=True)
class Layer:
    """A kind of layer: the axis that names one, the section of a study (and folder) that holds them, their file."""

    axis: str
    section: str
    File: type[ScenarioFile]

    @property
    def shipped(self) -> Path:
        """Those that come with the program: a link to a folder of studies/, whole in an installed package."""
        return Path(str(resources.files("workbench"))) / self.section

    def files(self, study_folder: Path) -> dict[str, Path]:
        """The files that a study can name: those beside it, which come before the shipped ones of their name."""
        beside, shipped = (sorted(folder.glob("*.toml")) for folder in (study_folder / self.section, self.shipped))
        return {path.stem: path for path in (*shipped, *beside)}

    def read(self, path: Path) -> tuple[ScenarioFile, str]:
        """A file and its text.

        Raises:
            UserError: unreadable, not TOML, unknown or missing keys.
        """
        data, text = files.read_toml(path)
        return files.validate(self.File, data, path, text), text


MACHINE = Layer("machine", "machines", MachineFile)
SCENARIO = Layer("scenario", "scenarios", ScenarioFile)

LAYERS: Mapping[str, Layer] = {layer.axis: layer for layer in (MACHINE, SCENARIO)}
"""By the axis that names them, in the order in which they are laid over a case."""


def layer_of(path: Path) -> Layer | None:
    """The layer whose files studies look for where this file stands."""
    return next((layer for layer in LAYERS.values() if path.resolve().parent.name == layer.section), None)
