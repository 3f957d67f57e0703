"""Figures of runs before and after tuning: a step that is held, and the error over the last period of each case."""

from collections.abc import Iterable, Mapping, Sequence
from concurrent.futures import Executor
from dataclasses import dataclass
from typing import Any

import numpy as np
from matplotlib.axes import Axes

from workbench.metrics.window import first_sample
from workbench.report.style import figure_style
from workbench.report.tuning_panels import HEIGHT, SIDES, Picture, grid, legend, note
from workbench.report.tuning_rows import case_labels
from workbench.report.tuning_tables import plain
from workbench.simulation.simulate import Run, simulate
from workbench.study.resolve import Resolved
from workbench.study.tune_schema import ConstraintsTable
from workbench.tune.goal import hold, rests
from workbench.tune.study import Tuning
from workbench.tune.task import tune_table
from workbench.tune.tuning import Tuned

SETTLED = 0.02
"""Of a step: what is left of it when the rise is over."""

SHOWN_RISE = 1.5
"""How much longer than the slowest rise the jump is drawn."""

SHORTEST = 0.02
"""Share of a step's duration that its jump is drawn for at least."""

SPREAD = 4.0
"""An error more than this many times the middle one of its column does not set the scale of the column."""


@dataclass(frozen=True, eq=False)
class Traced:
    """Runs of a controller before and after tuning: of each case, and of a step that is held."""

    one: Tuned
    cases: Mapping[str, Sequence[tuple[Resolved, Run]]]
    held: Mapping[str, tuple[Resolved, Run]]


def traces_of(tuning: Tuning, executor: Executor) -> list[Traced]:
    """Run every controller's cases, and a step, on the declared machine."""
    return [_traced(one, executor) for one in tuning.found]


def _traced(one: Tuned, executor: Executor) -> Traced:
    points = {"before": one.task.start, **({} if one.best is None else {"after": one.best})}
    cases = {when: one.task.declared(point) for when, point in points.items()}
    held = {when: held_step(own, tune_table(one.task.study).constraints) for when, own in cases.items()}
    runs = {when: list(executor.map(lambda case: simulate(case.setup), own)) for when, own in cases.items()}
    return Traced(
        one,
        {when: list(zip(own, runs[when], strict=True)) for when, own in cases.items()},
        {when: (case, simulate(case.setup)) for when, case in held.items()},
    )


def held_step(cases: Sequence[Resolved], constraints: ConstraintsTable) -> Resolved:
    """The step on which a limit cycle is judged; where a reference of the study rests, the first such case."""
    resting = [case for case in cases if rests(case)]
    return resting[0] if resting else hold(cases, constraints.model_copy(update={"limit_cycle": True}))[0]


# --- a step that is held ---


def step_picture(traced: Sequence[Traced]) -> Picture:
    """Position at the jump, and the error that is left of it, a row a controller."""
    with figure_style():
        figure, panels = grid(len(traced), 2, "A step that is held, before and after", HEIGHT, sharex="col")
        rise = max(_rise(run) for each in traced for _, run in each.held.values())
        for (jump, left), each in zip(panels, traced, strict=True):
            _step(jump, left, each, rise)
        panels[-1, 0].set_xlabel("time from the step (s)")
        panels[-1, 1].set_xlabel("time from the step (s)")
        legend(figure, list(panels.ravel()))
    level = 1e3 * _jump(next(iter(traced[0].held.values()))[1])
    caption = (
        f"A step of {level:.3g} mm, held. Left: position, until the slowest controller has settled. Right: the error "
        "that is left from then on, each on its own scale: a level line is a steady-state error, a wave that does not "
        "die out is a limit cycle."
    )
    return Picture(figure, caption)


def _step(jump: Axes, left: Axes, each: Traced, rise: float) -> None:
    scale, unit = _length(
        error[time >= rise] for time, error in (_error(run) for _, run in each.held.values()) if time[-1] > rise
    )
    for when, (_, run) in each.held.items():
        time, error = _error(run)
        assert run.reference is not None
        jump.plot(time, 1e3 * (run.reference[0] - error - run.state("position")[0]), **SIDES[when])
        left.plot(time[time >= rise], scale * error[time >= rise], **SIDES[when])
    _, run = next(iter(each.held.values()))
    jump.axhline(1e3 * _jump(run), color="#666666", linewidth=0.8, label="reference")
    left.axhline(0.0, color="#666666", linewidth=0.8)
    jump.set_xlim(0.0, rise)
    jump.set_title(f"{each.one.task.name}: position", fontsize="small")
    left.set_title(f"{each.one.task.name}: error that is left", fontsize="small")
    jump.set_ylabel("position (mm)")
    left.set_ylabel(f"error ({unit})")


def _jump(run: Run) -> float:
    """The first level (m), from where the rod starts."""
    assert run.reference is not None
    return float(run.reference[0][0] - run.state("position")[0])


def _error(run: Run) -> tuple[np.ndarray, np.ndarray]:
    """Time and true error (m) over the first dwell."""
    assert run.reference is not None
    moved = np.flatnonzero(run.reference[0] != run.reference[0][0])
    first = slice(0, int(moved[0]) if moved.size else None)
    return run.time[first], run.signals["error"][first]


def _rise(run: Run) -> float:
    """For how long (s) the jump of a run is drawn."""
    time, error = _error(run)
    late = np.flatnonzero(np.abs(error) > SETTLED * abs(_jump(run)))
    until = float(time[late[-1]]) if late.size else 0.0
    longest = 0.5 * float(time[-1])
    return min(max(SHOWN_RISE * until, SHORTEST * float(time[-1])), longest)


# --- the error of each case ---


def error_picture(traced: Sequence[Traced]) -> Picture:
    """Error over the last period of each case, a row a controller, a column a case."""
    labels = case_labels(traced[0].one.task.cases)
    with figure_style():
        options: dict[str, Any] = {"sharex": "col", "sharey": "col"}
        figure, panels = grid(len(traced), len(labels), "Tracking error over the last period", HEIGHT, **options)
        cut = False
        for column, label in enumerate(labels):
            series = [_errors(each, column) for each in traced]
            scale, unit = _length(error for own in series for _, error in own.values())
            for axes, each, own in zip(panels[:, column], traced, series, strict=True):
                for when, (time, error) in own.items():
                    axes.plot(time, scale * error, **SIDES[when])
                axes.set_title(", ".join(part for part in (each.one.task.name, plain(label)) if part), fontsize="small")
                axes.set_ylabel(f"error ({unit})")
                if not own:
                    note(axes, "every run failed")
            cut |= _limit(panels[0, column], [scale * error for own in series for _, error in own.values()])
            panels[-1, column].set_xlabel("time (s)")
        legend(figure, list(panels.ravel()))
    caption = (
        "Reference less true position over the last period of each case, on the declared machine; one scale a case, so "
        "that controllers can be held against each other." + (" Larger errors are cut off." if cut else "")
    )
    return Picture(figure, caption)


def _errors(each: Traced, number: int) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Time from its beginning (s) and error (m) over the last period of a case, of runs that did not diverge."""
    found = {}
    for when, runs in each.cases.items():
        case, run = runs[number]
        if run.diverged or run.reference is None:
            continue
        period = case.signal.period if case.signal is not None else None
        begin = case.transient if period is None else max(float(run.time[-1]) - period, 0.0)
        start = first_sample(run.time, begin)
        found[when] = (run.time[start:], run.signals["error"][start:])
    return found


def _length(errors: Iterable[np.ndarray]) -> tuple[float, str]:
    """What to multiply lengths in m with to show them in the unit that suits them, and the unit."""
    largest = max((float(np.max(np.abs(one))) for one in errors if one.size), default=0.0)
    return (1e3, "mm") if largest >= 1e-4 else (1e6, "µm")


def _limit(axes: Axes, errors: Sequence[np.ndarray]) -> bool:
    """Let the largest errors not flatten all others; returns whether some are cut."""
    peaks = sorted(float(np.max(np.abs(one))) for one in errors if one.size)
    if not peaks:
        return False
    limit = min(peaks[-1], SPREAD * peaks[len(peaks) // 2])
    if limit > 0.0:
        axes.set_ylim(-1.1 * limit, 1.1 * limit)
    return peaks[-1] > limit
