"""workbench export linear: the linear models of a study's plant, for MATLAB or python-control."""

from workbench.cli.options import Out, StudyFile


def command(study: StudyFile, out: Out) -> None:
    """Linear models of a study's plant, as .mat or .json."""
