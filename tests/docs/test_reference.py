"""The reference that the site's build makes of the program: complete, and without a key that says nothing of itself."""

from pathlib import Path
from typing import Any

import pytest
import typer
from snippets.site import PAGES

from workbench import api
from workbench.catalogue import CATALOGUE
from workbench.cli.app import app
from workbench.parameters.sets import named_sets
from workbench.study.schema import PlantTable, SimulationTable
from workbench.tune.schema import TuneTable

HERE = Path()


def test_every_command_and_option_is_there() -> None:
    text = PAGES["commands"](HERE)
    top: dict[str, Any] = vars(typer.main.get_command(app))["commands"]
    groups = {name: command.commands for name, command in top.items() if hasattr(command, "commands")}
    commands = {name: command for name, command in top.items() if name not in groups}
    commands |= {f"{name} {inner}": command for name, group in groups.items() for inner, command in group.items()}
    assert {*groups} == {"export"}
    assert [name for name in commands if f"## workbench {name}\n" not in text] == []
    options = {name for command in commands.values() for item in command.params for name in item.opts if name[0] == "-"}
    assert len(options) >= 25
    assert [name for name in options if f"`{name}" not in text] == []


@pytest.mark.parametrize("page", ["study_file", "experiment_file", "machine_file"])
def test_every_key_says_what_it_is(page: str) -> None:
    rows = [line for line in PAGES[page](HERE).splitlines() if line.startswith("| `")]
    assert len(rows) > 25
    assert [row for row in rows if len(row.split(" | ")) != 4 or not row.split(" | ")[3].strip(" |")] == []


def test_keys_have_units_limits_and_defaults() -> None:
    text = PAGES["study_file"](HERE)
    for model in (PlantTable, SimulationTable, TuneTable):
        assert [name for name in model.model_fields if f"| `{name}` |" not in text] == []
    assert "| `sample_time` | quantity, s, above 0 | `0.001` |" in text
    assert '| `motor` | `"printed"` `"consistent"` | `printed` |' in text
    assert '### kind = "multisine"' in text


def test_names_sets_and_python_are_whole() -> None:
    names, sets, python = (PAGES[page](HERE) for page in ("names", "parameters", "python_names"))
    assert names.count("\n## ") == len(CATALOGUE)
    assert [name for name in named_sets() if f"## {name}\n" not in sets] == []
    assert "6e-5 m/V" in sets or "6e-05 m/V" in sets
    assert [name for name in api.__all__ if f"workbench.api.{name}\n" not in python] == []


def test_studies_say_what_they_ask() -> None:
    text = PAGES["studies"](HERE)
    assert "(../../studies/comparison.toml)" in text
    assert "`workbench decide`" in text
