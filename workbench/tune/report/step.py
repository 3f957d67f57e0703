"""The figure of a step that is held, before and after tuning: the jump, and the error that is left of it."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import MaxNLocator

from workbench.metrics.window import first_sample
from workbench.publish.along import SHOWN, Shown
from workbench.publish.style import figure_style
from workbench.simulation.simulate import Run
from workbench.tune.report.panels import SIDES, Picture, grid, legend
from workbench.tune.report.traces import LOW, Trace, Traced, length_unit, say_failed

SETTLED = 0.1
"""Of a step: what is left of it when the rise is over."""

FINEST = 1e-4
"""Share of a step that the scale of what is left of it has at least: no rounding is magnified."""

SHOWN_RISE = 1.5
"""How much longer than the slowest rise the jump is drawn."""

SHORTEST = 0.02
"""Share of a step's duration that its jump is drawn for at least."""

LATE = 0.5
"""Share of a step's duration after which what is left of it is drawn."""


@dataclass(frozen=True, eq=False)
class StepPanel:
    """A step of a controller, of the runs that did not diverge, by when they are: the error (m) from the jump on, and
    that of the second half of the hold. `rise` (s) is how long the slowest jump takes to be drawn.
    """

    label: str
    errors: Mapping[str, Trace]
    late: Mapping[str, Trace]
    rise: float


@dataclass(frozen=True, eq=False)
class StepData:
    """The numbers of the figure: the step's level (m), and a panel a controller."""

    level: float
    panels: Sequence[StepPanel]
    axis: str

    @property
    def rise(self) -> float:
        """How long (s) jumps are drawn, until the slowest controller has come near."""
        return max((panel.rise for panel in self.panels if panel.errors), default=1.0)


def step_data(traced: Sequence[Traced]) -> StepData:
    """The numbers of the figure of these runs."""
    level, _ = largest_jump(next(iter(traced[0].held.values()))[1])
    return StepData(level, [_panel(each) for each in traced], traced[0].tuned.task.axis)


def _panel(traced: Traced) -> StepPanel:
    runs = {when: run for when, (_, run) in traced.held.items() if not run.diverged}
    errors = {when: _error(run) for when, run in runs.items()}
    rise = max((_rise(run) for run in runs.values()), default=0.0)
    return StepPanel(traced.tuned.task.label, errors, {when: _late(error) for when, error in errors.items()}, rise)


def largest_jump(run: Run) -> tuple[float, slice]:
    """The largest jump of a reference (m), that from where the rod starts among them, and its samples."""
    assert run.reference is not None
    asked = run.reference[0]
    edges = np.concatenate([[0], np.flatnonzero(np.diff(asked)) + 1, [asked.size]])
    before = np.concatenate([[run.state("position")[0]], asked[edges[1:-1] - 1]])
    jumps = asked[edges[:-1]] - before
    i = int(np.argmax(np.abs(jumps)))
    return float(jumps[i]), slice(int(edges[i]), int(edges[i + 1]))


def _error(run: Run) -> Trace:
    """Time from the largest jump (s) and true error (m) until the next."""
    _, samples = largest_jump(run)
    time = run.time[samples]
    return Trace(time - time[0], run.signals["error"][samples])


def _late(error: Trace) -> Trace:
    """The second half of the dwell."""
    time = error.time
    start = first_sample(time, LATE * float(time[-1])) if time.size > 1 else 0
    return Trace(time[start:], error.values[start:])


def _rise(run: Run) -> float:
    """For how long (s) the jump of a run is drawn."""
    error, (jump, _) = _error(run), largest_jump(run)
    moving, end = np.flatnonzero(np.abs(error.values) > SETTLED * abs(jump)), float(error.time[-1])
    until = float(error.time[moving[-1]]) if moving.size else 0.0
    return min(max(SHOWN_RISE * until, SHORTEST * end), LATE * end)


def step_picture(traced: Sequence[Traced]) -> Picture:
    """Position at the jump, and the error that is left of it, a row a controller."""
    data = step_data(traced)
    with figure_style():
        figure, panels = grid(len(data.panels), 2, "A step that is held, before and after", LOW, sharex="col")
        for (jump, left), panel in zip(panels, data.panels, strict=True):
            _draw(jump, left, panel, data.level, SHOWN[data.axis])
            jump.set_xlim(0.0, data.rise)
        panels[-1, 0].set_xlabel("time from the step (s)")
        panels[-1, 1].set_xlabel("time from the step (s)")
        legend(figure, list(panels.ravel()))
    caption = (
        f"A step of {SHOWN[data.axis].plain(data.level, 3)}, held. Left: position, until the slowest controller has "
        "come near. Right: the error in the second half of the hold, each on a scale of its own: a level line is a "
        "steady-state error, a wave that does not die out a limit cycle. "
        f"Scales are not finer than {100.0 * FINEST:g} % of the step."
    )
    return Picture(figure, caption)


def _draw(jump: Axes, left: Axes, panel: StepPanel, level: float, along: Shown) -> None:
    scale, unit = length_unit(panel.late.values(), along)
    for when, error in panel.errors.items():
        late = panel.late[when]
        jump.plot(error.time, along.factor * (level - error.values), **SIDES[when])
        left.plot(late.time, scale * late.values, **SIDES[when])
    if panel.errors:
        jump.axhline(along.factor * level, color="#666666", linewidth=0.8, label="reference")
        left.axhline(0.0, color="#666666", linewidth=0.8)
        finest = scale * FINEST * abs(level)
        low, high = left.get_ylim()
        left.set_ylim(min(low, -finest), max(high, finest))
    jump.xaxis.set_major_locator(MaxNLocator(5))
    for axes, what in ((jump, "position"), (left, "error, second half")):
        axes.set_title(f"{panel.label}: {what}", fontsize="small")
        if not panel.errors:
            say_failed(axes)
    jump.set_ylabel(f"position ({along.unit})")
    left.set_ylabel(f"error ({unit})")
