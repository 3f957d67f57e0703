"""The command line."""

from workbench.cli import answers
from workbench.cli.commands import main

__all__ = ["answers", "main"]
