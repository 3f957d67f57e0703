"""A gain file: a controller's tuned settings, which a study names, and how they were found.

    [controllers.lugre]
    gains = "tuned/lugre.toml"

`type` and `[settings]` are what such a table may say itself; what stands beside `gains` goes before them.
"""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from workbench import files
from workbench.files import Strict

KEY = "gains"
"""The key of a controller's table that names a gain file."""


class MarginsTable(Strict):
    """[margins]: of the loop, linearised while it slides at `speed`; the smallest over the cases."""

    gain_margin_dB: float | None = None  # noqa: N815 - the unit's own spelling
    phase_margin_deg: float | None = None
    speed: str


class GainFile(Strict):
    """A whole gain file. A margin that is not there is infinite."""

    title: str
    source: str
    type: str
    settings: dict[str, float | str]
    rotation: dict[str, float | str] = {}
    objective: dict[str, Any]
    margins: MarginsTable
    search: dict[str, Any]
    history: list[dict[str, Any]] = []


def is_gain_file(data: Mapping[str, Any]) -> bool:
    """Whether the content of a file looks like one."""
    return {"type", "settings"} <= set(data)


def read_gain_file(path: Path) -> GainFile:
    """A gain file.

    Raises:
        UserError: unreadable, or not one.
    """
    data, text = files.read_toml(path)
    return files.validate(GainFile, data, path, text)


def with_gains(table: Mapping[str, Any], folder: Path) -> dict[str, Any]:
    """A controller's table with what the gain file says that it names: relative to `folder`.

    Raises:
        UserError: as `read_gain_file`.
    """
    own = {key: value for key, value in table.items() if key != KEY}
    found = read_gain_file(folder / str(table[KEY]))
    return {"type": found.type, **found.settings, **own}
