"""The command line: a file a command."""

from workbench.cli.app import main

__all__ = ["main"]
