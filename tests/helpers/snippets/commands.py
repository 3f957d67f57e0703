"""Commands in blocks of sh: every `workbench` line has to be one that the program takes."""

import re
import shlex
from collections.abc import Iterator

import typer

from snippets.blocks import Block
from workbench.cli.app import app


def workbench_lines(block: Block) -> Iterator[list[str]]:
    """The words behind `workbench` of each command of a block, comments left out."""
    for line in block.text.replace("\\\n", " ").splitlines():
        for command in re.split(r"&&|;|\|\|", line.partition("#")[0]):
            words = shlex.split(command)
            if words and words[0].rpartition("/")[2] == "workbench":
                yield words[1:]


def mistake(words: list[str]) -> str:
    """What the command line would refuse of these words, "" where it takes them: names, options, what is needed."""
    group = typer.main.get_command(app)
    name, *arguments = words
    command = group.commands.get(name)  # type: ignore[attr-defined]
    if command is None:
        return f"no command {name}"
    try:
        command.make_context(name, [word for word in arguments if word not in ("...", "[...]")])
    except Exception as error:  # noqa: BLE001 - whatever the parser says of them
        return str(getattr(error, "message", error)) or type(error).__name__
    return ""
