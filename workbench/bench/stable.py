"""How far a gain may be turned before the linearised loop is unstable."""

from collections.abc import Callable

from workbench.bench.knobs import Knob
from workbench.bench.loop import BenchLoop
from workbench.bench.outcome import Outcome
from workbench.errors import UserError
from workbench.linear.open_loop import margins

PLACES = 24
"""Of a slider, at which the loop is looked at, before the ends are found between them."""

HALVINGS = 5


def stable_range(outcome: Outcome, knob: Knob, stop: Callable[[], bool]) -> tuple[float, float] | None:
    """The places (0 to 1) of a knob's slider between which the loop is stable around where it is.

    The loop is linearised about the slide at the reference's largest speed. None where it is not stable as it is, has
    no loop gain, or `stop` says that nobody waits for it any more.
    """
    if outcome.run.reference is None:
        return None
    here = knob.place

    def stable(place: float) -> bool:
        return not stop() and _is_stable(outcome.loop.changed(knob.change(knob.at(place))), outcome.speed)

    if not stable(here):
        return None
    ends = [_end(stable, here, end) for end in (0.0, 1.0)]
    return None if stop() else (ends[0], ends[1])


def _end(stable: Callable[[float], bool], here: float, end: float) -> float:
    """The farthest place towards `end` up to which all places are stable."""
    inside = here
    for number in range(1, PLACES + 1):
        outside = here + (end - here) * number / PLACES
        if not stable(outside):
            for _ in range(HALVINGS):
                middle = 0.5 * (inside + outside)
                inside, outside = (middle, outside) if stable(middle) else (inside, middle)
            return inside
        inside = outside
    return end


def _is_stable(loop: BenchLoop, speed: float) -> bool:
    try:
        return margins(loop.resolved.setup, speed).stable
    except UserError:  # a value that the controller does not take
        return False
