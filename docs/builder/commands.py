"""The reference of the command line: every command with its arguments and options, from the program's own typer app."""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import typer

from builder.markdown import cell, table
from workbench.cli.app import app

TYPES = {int: "N", float: "NUMBER", str: "TEXT", Path: "PATH"}


def page(folder: Path) -> str:
    """Every command."""
    group = typer.main.get_command(app)
    parts = [
        "# Commands",
        "`workbench COMMAND --help` says the same. A mistake is told in one to three lines, with exit code 2; "
        "`workbench --debug COMMAND` shows the traceback behind it.",
    ]
    for name, command in _commands(group, ""):
        parts += [f"## workbench {name}", _usage(name, command), command.help, _arguments(command), _options(command)]
    return "\n\n".join(part for part in parts if part) + "\n"


def _commands(group: Any, before: str) -> Iterator[tuple[str, Any]]:
    """Every command with its name, those of a group one by one."""
    for name, command in group.commands.items():
        inner = getattr(command, "commands", None)
        yield from [(before + name, command)] if inner is None else _commands(command, f"{before}{name} ")


def _usage(name: str, command: Any) -> str:
    words = [_argument(item) for item in command.params if item.param_type_name == "argument"]
    needed = [f"{item.opts[0]} {_value(item)}" for item in command.params if _is_option(item) and item.required]
    return f"```text\n{' '.join(['workbench', name, *words, *needed, '[options]'])}\n```"


def _argument(item: Any) -> str:
    name = item.metavar or item.name.upper()
    name = f"{name} [{name}...]" if item.nargs == -1 else name
    return name if item.required or name.startswith("[") else f"[{name}]"


def _arguments(command: Any) -> str:
    rows = [[cell(f"`{_argument(item)}`"), cell(item.help or "")] for item in command.params if not _is_option(item)]
    return table(["argument", "meaning"], rows)


def _options(command: Any) -> str:
    options = [item for item in command.params if _is_option(item)]
    rows = [[cell(f"`{_names(item)}`"), _default(item), cell(item.help or "")] for item in options]
    return table(["option", "default", "meaning"], rows)


def _names(item: Any) -> str:
    return " ".join(word for word in (*item.opts, *item.secondary_opts, _value(item)) if word)


def _is_option(item: Any) -> bool:
    return item.param_type_name == "option"


def _value(item: Any) -> str:
    if item.is_flag:
        return ""
    return item.metavar or TYPES.get(item.type_descriptor.annotation, "VALUE")


def _default(item: Any) -> str:
    if item.required:
        return "needed"
    return "" if item.is_flag or item.default in (None, "", [], ()) else f"`{item.default}`"
