"""Both methods on the records of one experiment."""

from workbench.identify.readiness import check_experiment, check_records, method_of
from workbench.identify.result import Identification
from workbench.identify.simulation.method import identify_by_simulation
from workbench.identify.thesis.records import identify_by_thesis
from workbench.progress import Progress, silent
from workbench.records.experiment import Experiment
from workbench.records.reading import read_records


def identify(experiment: Experiment, method: str | None = None, progress: Progress = silent) -> Identification:
    """Identify the free parameters of an experiment from its fit records.

    `method` is "thesis", "simulation" or "both"; None: `method_of` the experiment. `progress` is told in words what is
    being done.

    Raises:
        UserError: a record or the plant does not serve.
    """
    chosen = method or method_of(experiment)
    check_experiment(experiment, chosen)
    progress("reading the records")
    records = read_records(experiment)
    check_records(experiment, records, chosen)
    thesis = identify_by_thesis(experiment, records, progress) if chosen in ("thesis", "both") else None
    simulation = identify_by_simulation(experiment, records, progress) if chosen in ("simulation", "both") else None
    return Identification(experiment, records, thesis, simulation)
