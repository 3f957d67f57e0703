"""What a loop on the bench does: its run, and the row that a study of it would have in results.csv."""

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from workbench.bench.balances import Left, balances_left
from workbench.bench.loop import BenchLoop
from workbench.bench.measured import RECORDED, MeasuredLoop
from workbench.errors import UserError
from workbench.linear.margins import Margins, Response, margins_of
from workbench.linear.open_loop import open_loop
from workbench.simulation.run import Run
from workbench.simulation.simulate import simulate
from workbench.study.case_runs import figures_of
from workbench.study.names import units_of

SLOW = 0.01
"""m/s, or rad/s. The speed of the slide about which a loop is linearised whose reference does not move."""


MOST_SAMPLES, MOST_STEPS = 1e6, 1e8
"""Of a run on the bench: seconds of work."""

OUTPUTS = ("position", "pressure_1", "pressure_2")
"""Channels of a record that a plant answers with."""


@dataclass(frozen=True)
class Outcome:
    """A loop and its run."""

    loop: BenchLoop
    run: Run

    @cached_property
    def figures(self) -> Mapping[str, float | str | None]:
        """The columns of results.csv, without those that take a second run."""
        return figures_of(self.loop.resolved, self.run)

    @cached_property
    def signals(self) -> Mapping[str, np.ndarray]:
        """The signals of the run, and what was measured beside it."""
        own = {"time": self.run.time, **self.run.signals}
        return {**own, **self.loop.signals(self.run)} if isinstance(self.loop, MeasuredLoop) else own

    @cached_property
    def units(self) -> Mapping[str, str]:
        """The SI unit of each."""
        units = units_of(self.run)
        recorded = {name: name.removeprefix(RECORDED) for name in self.signals if name.startswith(RECORDED)}
        return {**units, **{name: units.get(channel, "1") for name, channel in recorded.items()}}

    @cached_property
    def misfits(self) -> Mapping[str, float]:
        """Rms (SI) by which a run is off what was measured, by channel; nothing where nothing was."""
        signals = self.signals
        return {
            name.removeprefix(RECORDED): float(np.sqrt(np.mean((values - signals[name.removeprefix(RECORDED)]) ** 2)))
            for name, values in signals.items()
            if name.startswith(RECORDED) and name.removeprefix(RECORDED) in OUTPUTS
        }

    @cached_property
    def balances(self) -> Mapping[str, Left]:
        """What the record at hand leaves of the plant's balances; nothing where nothing was measured."""
        if not isinstance(self.loop, MeasuredLoop):
            return {}
        return balances_left(self.loop.record, self.loop.experiment.flow, self.loop.resolved.setup)

    @cached_property
    def speed(self) -> float:
        """The speed about which the loop is linearised: the largest of its reference."""
        if self.run.reference is None:
            return SLOW
        fastest = float(abs(self.run.reference[1]).max())
        return fastest if fastest > 0.0 else SLOW

    @cached_property
    def loop_gain(self) -> "LoopGain | str":
        """L about that slide; in words why there is none."""
        setup = self.loop.resolved.setup
        if setup.reference is None:
            return "open loop: there is no loop gain"
        try:
            loop = open_loop(setup, self.speed)
        except UserError as error:
            return str(error)
        return LoopGain(np.asarray(loop.A), np.asarray(loop.B), np.asarray(loop.C), setup.sample_time, self.speed)


@dataclass(frozen=True)
class LoopGain:
    """L(z) = C (zI - A)^-1 B of a loop about the rod's sliding at `speed`, sampled."""

    a: np.ndarray
    b: np.ndarray
    c: np.ndarray
    sample_time: float
    speed: float

    @cached_property
    def response(self) -> Response:
        """L over frequency (rad/s)."""
        return Response(self.a, self.b, self.c, self.sample_time)

    @cached_property
    def margins(self) -> Margins:
        """Gain and phase margin, and whether the loop is stable there."""
        return margins_of(self.a, self.b, self.c, self.sample_time, self.speed)


def outcome_of(loop: BenchLoop) -> Outcome:
    """Simulate a loop.

    Raises:
        UserError: a change that does not serve.
    """
    setup = loop.resolved.setup
    instants, steps = setup.duration / setup.sample_time, setup.duration / setup.integrator.step
    if instants > MOST_SAMPLES or steps > MOST_STEPS or setup.sensors.delay > setup.duration:
        raise UserError(
            f"on the bench a run has at most {MOST_SAMPLES:g} samples and {MOST_STEPS:g} steps, and no delay beyond "
            f"its end; got {instants:.3g} samples, {steps:.3g} steps, a delay of {setup.sensors.delay:g} s"
        )
    return Outcome(loop, simulate(setup))
