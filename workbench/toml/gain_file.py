"""A gain file: a controller's tuned settings, which a study names, and how they were found.

    [controllers.lugre]
    gains = "tuned/{machine}/lugre.toml"

`type` and the `settings` of an entry are what such a table may say itself; what stands beside `gains` goes before them.
What a tuning says beside, a file by hand need not have.
A file has one entry for all speeds of rotation, or one for each speed at which the controller was tuned; a case takes
that of its rpm. `{machine}` stands for the case's value on the axis machine.
"""

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import tomli_w
from pydantic import Field, model_validator

from workbench.errors import UserError
from workbench.toml import reading as files
from workbench.toml.file_names import file_name
from workbench.toml.reading import Strict

KEY = "gains"
"""The key of a controller's table that names a gain file."""

MACHINE = "{machine}"
"""What stands in the name of a gain file for the machine of a case."""

SAME_RPM = 1e-6
"""rpm within which two speeds are the same."""


class MarginsTable(Strict):
    """[at.margins]: of the loop, linearised while it slides at `speed`; the smallest over the cases."""

    gain_margin_dB: float | None = None  # noqa: N815 - the unit's own spelling
    """Smallest over the cases."""
    phase_margin_deg: float | None = None
    """Smallest over the cases."""
    speed: str
    """At which the loop slides."""


class Entry(Strict):
    """[[at]]: the settings for one speed of rotation, or for all of them. A margin that is not there is infinite."""

    rpm: float | None = None
    """Speed of rotation; without it the entry serves all."""
    settings: dict[str, int | float | str]
    """What a controller's table may say itself."""
    rotation: dict[str, float | str] = {}
    """A rotation that was tuned."""
    objective: dict[str, Any] = {}
    """What was reached."""
    margins: MarginsTable | None = None
    """Of the loop, linearised."""
    search: dict[str, Any] = {}
    """How it was found, and by how much seeds differ."""


class GainFile(Strict):
    """A whole gain file."""

    title: str = ""
    """Of the file."""
    source: str = ""
    """Which tuning wrote it."""
    type: str
    """The controller's."""
    at: list[Entry] = Field(min_length=1)
    """An entry, or one a speed of rotation."""

    @model_validator(mode="after")
    def _one_each(self) -> "GainFile":
        speeds = [entry.rpm for entry in self.at]
        if len(speeds) > 1 and (None in speeds or len(set(speeds)) < len(speeds)):
            raise ValueError("several [[at]] entries: expected each to have an rpm of its own")
        return self


def is_gain_file(data: Mapping[str, object]) -> bool:
    """Whether the content of a file looks like one."""
    return {"type", "at"} <= set(data)


def read_gain_file(path: Path) -> GainFile:
    """A gain file.

    Raises:
        UserError: unreadable, or not one.
    """
    data, text = files.read_toml(path)
    return files.validate(GainFile, data, path, text)


def gain_file_text(content: GainFile) -> str:
    """The text of a gain file, as `read_gain_file` reads it; what a file need not say is left out."""
    return tomli_w.dumps(content.model_dump(exclude_defaults=True))


def entry_at(content: GainFile, rpm: float) -> Entry:
    """The entry of a speed (rpm).

    Raises:
        UserError: there is none for it.
    """
    for entry in content.at:
        if entry.rpm is None or abs(entry.rpm - rpm) <= SAME_RPM:
            return entry
    speeds = ", ".join(f"{entry.rpm:g}" for entry in content.at)
    raise UserError(
        f"was not tuned at {rpm:g} rpm, only at {speeds} rpm; tune it there too, or take one of these speeds"
    )


def gain_path(table: Mapping[str, object], folder: Path, machine: str | None) -> Path:
    """The gain file that a controller's table names, relative to `folder`, for a machine.

    Raises:
        UserError: a file by machine in a study without machines.
    """
    name = str(table[KEY])
    if MACHINE not in name:
        return folder / name
    if machine is None:
        raise UserError(f'"{name}" goes by machine, and this case has none; give the study an axis machine')
    return folder / name.replace(MACHINE, file_name(machine))


def with_gains(
    table: Mapping[str, object],
    folder: Path,
    rpm: float,
    machine: str | None,
    read: Callable[[Path], GainFile] = read_gain_file,
) -> dict[str, object]:
    """A controller's table with what the gain file says that it names, relative to `folder`, for a speed (rpm) and a
    machine.

    Raises:
        UserError: as `read_gain_file` and `entry_at`; a file by machine in a study without machines.
    """
    own = {key: value for key, value in table.items() if key != KEY}
    path = gain_path(table, folder, machine)
    content = read(path)
    try:
        entry = entry_at(content, rpm)
    except UserError as error:
        raise UserError(f"{path}: {error}") from None
    return {"type": content.type, **entry.settings, **own}
