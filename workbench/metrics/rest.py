"""What a run does where its reference rests: dwell by dwell, and the worst of them."""

from collections.abc import Sequence
from dataclasses import dataclass

from workbench.metrics import limit_cycle, tracking
from workbench.metrics.limit_cycle import LimitCycle
from workbench.metrics.window import find_dwells
from workbench.simulation.references import ReferenceSignal
from workbench.simulation.run import Run

AT_REST = (
    "steady_state_error_m",
    "steady_state_max_error_m",
    "limit_cycle",
    "limit_cycle_amplitude_m",
    "limit_cycle_period_s",
)
"""The columns that a longer dwell tells better."""

DWELLS = frozenset({*AT_REST, "settling_time_s"})
"""The columns that are found in dwells."""


@dataclass(frozen=True)
class Rest:
    """Of one dwell: limit cycle, and over its last part |mean error| and largest |error| (m); None in a transient."""

    cycle: LimitCycle
    mean_error: float | None
    max_error: float | None


def rests_of(run: Run, reference: ReferenceSignal, transient: float, resolution: float) -> list[Rest]:
    """Each dwell that ends after `transient` (s), in order; `resolution` (m): the noise band."""
    time, error, velocity = run.time, run.signals["error"], run.signals["velocity"]
    forcing = run.loop.controller.forcing
    forced = 0.0 if forcing is None else 1.0 / forcing(run.loop.gains)
    return [
        Rest(
            limit_cycle.judge(time[i], error[i], velocity[i], resolution, transient, forced, run.command[i]),
            *tracking.steady_state_errors(time, error, i, transient),
        )
        for i in find_dwells(time, reference, transient)
    ]


def rest_figures(rests: Sequence[Rest]) -> dict[str, float | str | None]:
    """The columns of `AT_REST`: the largest errors, the worst limit cycle; empty without dwells."""
    if not rests:
        return {}
    cycle = limit_cycle.worst([one.cycle for one in rests])
    means = [one.mean_error for one in rests if one.mean_error is not None]
    largest = [one.max_error for one in rests if one.max_error is not None]
    figures = max(means, default=None), max(largest, default=None), cycle.verdict, cycle.amplitude, cycle.period
    return dict(zip(AT_REST, figures, strict=True))
