"""The command line. What a command does not need it does not import: help appears at once."""

import gc
import importlib
import io
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from functools import cache
from typing import Annotated, Any

import typer
from typer.core import TyperGroup
from typer.main import get_command

from workbench.cli.progress import AGAIN, stoppable
from workbench.errors import UserError, in_few_lines
from workbench.stopping import is_requested

COMMANDS = (
    "run",
    "bench",
    "check",
    "list",
    "table",
    "plot",
    "report",
    "index",
    "agree",
    "decide",
    "import",
    "identify",
    "diagnose",
    "design",
    "tune",
    "rehearse",
)
"""In the order in which help shows them; each is the function `command` of a file of its name, or of `FILES`."""

GROUPS = ("export",)
"""Commands with subcommands: each is the `app` of a folder of its name."""

FILES = {"import": "import_log"}
"""Files of commands whose names are words of Python."""


class _Commands(TyperGroup):
    """Typer would end a stopped command without a word."""

    def make_context(self, *args: Any, **options: Any) -> Any:
        with stoppable(AGAIN):
            return super().make_context(*args, **options)

    def invoke(self, ctx: Any) -> Any:
        with stoppable(AGAIN):
            return super().invoke(ctx)


app = typer.Typer(
    cls=_Commands,
    help="Friction Workbench: an actuator sticks. Compensate the friction, or avoid it?",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
    rich_markup_mode=None,
    context_settings={"help_option_names": ["-h", "--help"]},
)


@app.callback()
def _options(
    debug: Annotated[bool, typer.Option("--debug", help="Show the traceback of an error.")] = False,
) -> None:
    """Options of every command; `run` reads --debug itself."""


for name in COMMANDS:
    app.command(name)(importlib.import_module(f"workbench.cli.{FILES.get(name, name)}").command)
for name in GROUPS:
    app.add_typer(importlib.import_module(f"workbench.cli.{name}").app, name=name)


@cache
def _built() -> Any:
    """The command line with all its commands, made once for a program that calls it more than once."""
    return get_command(app)


@contextmanager
def mistakes_told() -> Iterator[None]:
    """A user's mistake, or a file system's, or one in a plug-in's code, is one to three lines and exit code 2."""
    try:
        yield
    except (UserError, OSError) as error:
        if "--debug" in sys.argv or is_requested():
            raise
        place = f"{error.filename}: {error.strerror}" if isinstance(error, OSError) and error.filename else str(error)
        print(f"error: {in_few_lines(place)}", file=sys.stderr)
        sys.exit(2)
    except Exception as error:
        from workbench.cli.mistakes import of_plugin

        mistake = of_plugin(error)
        if not mistake or "--debug" in sys.argv:
            raise
        print(f"error: {in_few_lines(mistake)} (--debug shows all of it)", file=sys.stderr)
        sys.exit(2)


def run() -> None:
    """Run the command line, with `mistakes_told`."""
    gc.set_threshold(50_000)  # a start makes thousands of classes to keep: garbage is not looked for after every 700th
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(line_buffering=True)  # a pipe gets each line when it is written
    with mistakes_told():
        _built()()
