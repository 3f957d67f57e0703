"""workbench identify: a plant's parameters from records."""

from typing import Annotated

import typer

from workbench.cli.options import ExperimentFile, Out, Overwrite, PageFormat, print_contents, say
from workbench.cli.progress import ProgressLine, stoppable
from workbench.errors import UserError, nearest


def command(
    experiment: ExperimentFile,
    out: Out,
    method: Annotated[str | None, typer.Option(help="thesis, simulation or both.")] = None,
    overwrite: Overwrite = False,
    page: PageFormat = None,
) -> None:
    """Find friction and other parameters of a plant in records."""
    from workbench.identify.identification import identify
    from workbench.identify.report.folder import claimed_folder, write_identification
    from workbench.publish.page_format import figures_at
    from workbench.records.experiment import read_experiment
    from workbench.records.schema import METHODS

    if method is not None and method not in METHODS:
        raise UserError(f'--method "{method}": {nearest(method, METHODS)}')
    content = read_experiment(experiment)
    with figures_at(page), stoppable(), ProgressLine() as progress, claimed_folder(out, overwrite):
        paths = write_identification(identify(content, method, progress), out)
    for path in paths:
        say(path.read_text(encoding="utf-8"))
    print_contents(out)
