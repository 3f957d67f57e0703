"""workbench diagnose: what a plant lacks, by its records."""

from workbench.cli.options import ExperimentFile, Out, Overwrite, PageFormat, print_contents, say
from workbench.cli.progress import ProgressLine, stoppable


def command(experiment: ExperimentFile, out: Out, overwrite: Overwrite = False, page: PageFormat = None) -> None:
    """Say what the plant of an experiment lacks, and how sure that is."""
    from workbench.diagnose.diagnose import diagnose
    from workbench.diagnose.report.folder import claimed_folder, summary, write_diagnosis
    from workbench.diagnose.report.verdict import next_words
    from workbench.publish.page_format import figures_at

    with figures_at(page), stoppable(), ProgressLine() as progress, claimed_folder(out, overwrite):
        diagnosis = diagnose(experiment, progress)
        progress("tables, figures, page", 0.93)
        write_diagnosis(diagnosis, out)
    say(summary(diagnosis) + "\n")
    print_contents(out)
    if further := next_words(diagnosis, str(out)):
        say(further)
