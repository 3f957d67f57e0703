"""workbench export notebook: a study as an executed notebook of the Python interface."""

from workbench.cli.options import Out, StudyFile


def command(study: StudyFile, out: Out) -> None:
    """A study as a notebook in Python, executed."""
