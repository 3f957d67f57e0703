"""Running on: a dwell that is too short to tell whether the loop hunts is made longer until it is not.

A cycle that decays slowly may be on its way to a smaller limit cycle, and a creep may be part of a slow one: they are
run on as well. Only the last dwell can be made longer. It is doubled, and doubled again, until its verdict is settled
or it is as long as the case's `hold_limit` allows; the case is run from its start each time, so that a row depends on
nothing but its case. The longer record gives the limit cycle and the steady-state errors of that dwell. All other
figures are those of the study's own duration. A dwell before the last that is too short is taken for what the last one
shows.
"""

from collections.abc import Collection
from dataclasses import replace

from workbench.metrics.evaluate import evaluate
from workbench.metrics.limit_cycle import NONE
from workbench.metrics.rest import DWELLS, Rest, rest_figures, rests_of
from workbench.simulation.references import Held
from workbench.simulation.run import Run
from workbench.simulation.simulate import simulate
from workbench.study.resolve import Resolved

LONGER = 2.0
"""By which a dwell that is too short is made longer."""


def evaluated(resolved: Resolved, run: Run, only: Collection[str] | None = None) -> dict[str, float | str | None]:
    """The figures of a case's run, as `evaluate` gives them, run on where its dwell is too short."""
    reference, rests = resolved.setup.reference, list[Rest]()
    if reference is not None and not run.diverged and (only is None or not DWELLS.isdisjoint(only)):
        rests = rests_of(run, reference, resolved.transient, resolved.band)
    figures = evaluate(run, resolved.signal, resolved.transient, resolved.band, only, rests)
    if all(one.cycle.settled for one in rests):
        return figures
    last = run_on(resolved)
    if last is None:
        return figures
    known = [replace(one, cycle=NONE) if one.cycle.verdict == "too_short" else one for one in rests[:-1]]
    return figures | rest_figures([*known, last])


def run_on(resolved: Resolved) -> Rest | None:
    """What the last dwell of a case shows once it is long enough, or as long as it may be.

    None where the reference does not end in a dwell, where that is as long as it may be, or the longer run diverges.
    """
    setup = resolved.setup
    spans = [] if setup.reference is None else setup.reference.dwells(setup.duration)
    if not spans or spans[-1][1] < setup.duration:
        return None
    assert setup.reference is not None
    begin = spans[-1][0]
    held, dwell = Held(setup.reference, 0.5 * (begin + setup.duration)), setup.duration - begin
    found: Rest | None = None
    while dwell < resolved.hold_limit and (found is None or not found.cycle.settled):
        dwell = min(LONGER * dwell, resolved.hold_limit)
        longer = simulate(replace(setup, reference=held, duration=begin + dwell))
        if longer.diverged:
            return None
        found = rests_of(longer, held, max(begin, resolved.transient), resolved.band)[-1]
    return found
