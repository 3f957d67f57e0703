"""workbench import: a first experiment file out of logs."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from workbench.cli.options import say
from workbench.errors import UserError


def command(
    logs: Annotated[
        list[Path], typer.Argument(help="Logs of one kind; of several the last is held out.", metavar="LOG")
    ],
    out: Annotated[Path, typer.Option(help="The experiment file to write.", metavar="EXPERIMENT.toml")],
    plant: Annotated[str | None, typer.Option(help="A plant of `workbench list plants`; else one that fits.")] = None,
    parameters: Annotated[
        str | None, typer.Option(help="A parameter set, or a file beside EXPERIMENT.toml; else values to begin with.")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="Replace EXPERIMENT.toml.")] = False,
) -> None:
    """Write a first experiment file out of logs."""
    from workbench.records.importing.importing import proposal_for
    from workbench.records.importing.writing import text_of

    if out.exists() and not force:
        raise UserError(f"{out}: is there already; --force replaces it")
    if not out.parent.is_dir():
        raise UserError(f"{out}: there is no folder {out.parent}")
    ask = _prompt if sys.stdin.isatty() else None
    proposal = proposal_for(logs, plant, parameters, out.parent, ask)
    out.write_text(text_of(proposal, out.parent), encoding="utf-8")
    left = len(proposal.questions)
    asked = f"{left} question{'s' * (left != 1)} in it (# ?)" if left else "no question is left"
    say(f"wrote {out}: plant {proposal.plant.values['']}, {asked}; next: workbench check {out}")


def _prompt(question: str, guess: str) -> str:
    return str(typer.prompt(question, default=guess))
