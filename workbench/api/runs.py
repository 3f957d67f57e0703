"""One run of a loop: its signals, what results.csv says of it, and its face in a notebook."""

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from workbench.api.loops import A_LOOP, LoopSetup
from workbench.api.plain import expect
from workbench.api.signals import frame_of, plot_signals
from workbench.metrics.evaluate import evaluate as metrics_of
from workbench.metrics.registry import names_along
from workbench.simulation import simulate as engine
from workbench.simulation.simulate import Run
from workbench.study.case_runs import figures_of
from workbench.study.names import units_of

if TYPE_CHECKING:
    from workbench.publish.notebook import NotebookFigure

SHOWN = ("phase_lag_deg", "steady_state_error_m", "rms_error_m", "limit_cycle", "total_power_W", "paid_power_W")
"""Columns that a run shows of itself in a notebook, where they apply."""

DRAWN = ("reference_position", "position", "error", "axial_friction")
"""Signals that it draws, of those it has two."""

FACE_PANELS = 2


@dataclass(frozen=True, eq=False, repr=False)
class LoopRun:
    """What a loop did. `run` holds states, inputs, measurements and memory as arrays over the samples.

    Example:
        >>> loop = wb.setup("non_rotating", "owen2001_simulation", controller=wb.pid(kp=500),
        ...                 reference=wb.sine("5 mm", "2 Hz"), duration="0.5 s")
        >>> run = wb.simulate(loop)
        >>> run
        LoopRun(completed, 501 samples, LoopSetup(non_rotating, pid, 0.5 s))
        >>> run.frame()["axial_friction"].shape, run.units["axial_friction"]
        ((501,), 'N')
    """

    setup: LoopSetup
    run: Run

    @property
    def outcome(self) -> str:
        """In words: completed, diverged, end stop, saturated throughout, stuck, hardly moves, and more.

        docs/study_files.md says what each is.
        """
        return self.run.outcome

    @property
    def time(self) -> np.ndarray:
        """Sample instants (s), shape (samples,)."""
        return self.run.time

    @property
    def units(self) -> dict[str, str]:
        """The SI unit of each signal, by name."""
        return units_of(self.run)

    def frame(self) -> pd.DataFrame:
        """All signals, a row a sample: `time` (s), those of the plant, inputs, measurements, the controller's state,
        reference and error. Their units are in `attrs["units"]`, by column.
        """
        return frame_of(self.run)

    def plot(self, *names: str, against: str = "time") -> "NotebookFigure":
        """A matplotlib figure of these signals, a panel for each unit, over time or another signal; SI units.

        Raises:
            UserError: no such signal.

        Example:
            >>> loop = wb.setup("non_rotating", "owen2001_simulation", controller=wb.pid(kp=500),
            ...                 reference=wb.sine("5 mm", "2 Hz"), duration="0.5 s")
            >>> wb.simulate(loop).plot("axial_friction", against="velocity").axes[0].get_xlabel()
            'velocity (m/s)'
        """
        return plot_signals(self.frame(), names, against, self._title)

    @property
    def _title(self) -> str:
        return f"{self.setup.plant.name.replace('_', ' ')}, {self.setup.controller.name.replace('_', ' ')}"

    def __repr__(self) -> str:
        return f"LoopRun({self.outcome}, {self.time.size} samples, {self.setup!r})"

    def _repr_html_(self) -> str:
        from workbench.publish.notebook import face

        resolved = self.setup.resolved
        values = metrics_of(self.run, resolved.signal, resolved.transient, resolved.band)
        called = names_along(self.run.plant.axis)
        shown = [(called[name], values[name]) for name in SHOWN if values[name] is not None]
        drawn = [name for name in DRAWN if name in self.units and name in self.run.signals]
        return face(
            f"{self._title}: {self.outcome}",
            table=pd.DataFrame(shown, columns=["metric", "value"]),
            figure=self.plot(*drawn[-FACE_PANELS:]) if drawn else None,
        )


def simulate(setup: LoopSetup) -> LoopRun:
    """Simulate a loop over its duration: dx/dt = f(t, x, u) between samples, the controller at each sample.

    A run that diverges is a result: it stops early, and its outcome says so.

    Args:
        setup: of `setup` or `Study.setup`.

    Raises:
        UserError: it is something else.

    Example:
        >>> loop = wb.setup("non_rotating", "owen2001_simulation", controller=wb.pid(kp=500),
        ...                 reference=wb.steps(["5 mm"], "1 s"), duration="1 s")
        >>> wb.simulate(loop).outcome
        'completed'
    """
    expect(setup, LoopSetup, "simulate", A_LOOP)
    return LoopRun(setup, engine.simulate(setup.simulation))


def evaluate(run: LoopRun, *, solver_error: bool = True) -> pd.Series:
    """The metrics of a run: the columns of results.csv, with their units in the names; None where one does not apply.

    Phase lag and amplitude ratio at the reference's fundamental, errors while moving and at rest, limit cycle, power
    of pump and motor, friction over velocity: `workbench.metrics` defines each of them.

    Args:
        run: of `simulate`.
        solver_error: whether the last two columns, the error of the integration, are found; that takes a second run.

    Returns:
        by name, in the order of results.csv; equal to the row of a study of this one case.

    Raises:
        UserError: it is no run.

    Example:
        >>> loop = wb.setup("rotating", "owen2001_simulation", rpm=120, controller=wb.pid(kp=500),
        ...                 reference=wb.sine("30 mm", "0.9 Hz"), transient="1.1 s")
        >>> row = wb.evaluate(wb.simulate(loop))
        >>> row["outcome"], round(row["phase_lag_deg"], 1), row["settling_time_s"]
        ('completed', 11.3, None)
    """
    expect(run, LoopRun, "evaluate", "a run; use wb.evaluate(wb.simulate(setup))")
    resolved = run.setup.resolved
    values = figures_of(resolved, run.run, engine.finer(resolved.setup, run.run) if solver_error else None)
    return pd.Series(values, dtype=object)
