"""The command line."""

from workbench.cli.commands import main

__all__ = ["main"]
