"""workbench rehearse: a study with its controllers as the C that is exported."""

from workbench.cli.options import Out, StudyFile


def command(study: StudyFile, out: Out) -> None:
    """Run a study with the exported C in the loop."""
