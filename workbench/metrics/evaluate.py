"""The figures of a run, by all metrics that there are."""

from collections.abc import Callable, Collection, Sequence

from plants.plugins import reason_of
from workbench.errors import MetricError, UserError
from workbench.metrics.interface import Figures, Observed
from workbench.metrics.registry import METRICS, OUTCOME, SOLVER, columns
from workbench.metrics.rest import Rest, rests_of
from workbench.metrics.tracking import root_mean_square
from workbench.metrics.window import find_window
from workbench.simulation.references import ReferenceSignal
from workbench.simulation.run import Run


def evaluate(
    run: Run,
    reference: ReferenceSignal | None,
    transient: float,
    resolution: float = 0.0,
    only: Collection[str] | None = None,
    rests: Sequence[Rest] | None = None,
) -> dict[str, float | str | None]:
    """All of `columns` but those of `SOLVER`, in their order; None where a figure does not apply.

    Args:
        run: the finished run.
        reference: what the position was asked to do; in open loop the signal that drove it, which then only sets the
            window.
        transient: time (s) at the start that is left out.
        resolution: the larger of three standard deviations of the position noise and the sensor's step (m): the band
            of the limit-cycle verdict.
        only: the columns that are wanted (None: all); what takes long and is not stays None.
        rests: what the run does where its reference rests (`rests_of`), where that has been found before.

    Raises:
        MetricError: a metric of a plug-in fails, and why.
    """
    figures: dict[str, float | str | None] = dict.fromkeys([name for name in columns() if name not in _SOLVER_NAMES])
    figures[OUTCOME.name] = run.outcome
    window = None if run.diverged else find_window(run.time, reference, transient)
    if window is None:
        return figures

    def found() -> Sequence[Rest]:
        if rests is not None or reference is None:
            return rests or ()
        return rests_of(run, reference, transient, resolution)

    observed = Observed(run, window, reference, transient, found)
    wanted = {
        metric.figures: name  # several metrics may be found at once
        for name, metric in METRICS.working().items()
        if only is None or any(column.name in only for column in metric.columns)
    }
    for find, name in wanted.items():
        found_here = _figures(name, find, observed)
        if undeclared := [column for column in found_here if column not in figures]:
            raise MetricError(f"{METRICS.called(name)} finds {', '.join(undeclared)}, which its columns do not declare")
        figures.update(found_here)
    return figures


def rms_error(run: Run, reference: ReferenceSignal | None, transient: float) -> float | None:
    """The figure rms_error_m alone (m, or rad), as `evaluate` finds it."""
    window = None if run.diverged or reference is None else find_window(run.time, reference, transient)
    if window is None or run.reference is None:
        return None
    return root_mean_square((run.reference[0] - run.state("position"))[window.samples])


def _figures(name: str, find: Callable[[Observed], Figures], observed: Observed) -> Figures:
    """What a metric finds; of one that a plug-in brings a failure is told in one line."""
    try:
        return dict(find(observed))
    except UserError:
        raise
    except Exception as error:
        if name in METRICS.ours:
            raise
        raise MetricError(f"{METRICS.called(name)} fails: {reason_of(error)} (--debug shows all of it)") from error


_SOLVER_NAMES = {column.name for column in SOLVER}
