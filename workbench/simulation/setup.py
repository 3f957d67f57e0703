"""Everything that a run depends on: plant, loops, reference, feeds, sensors, integrator. Made without a compiler."""

from dataclasses import dataclass, field, replace
from typing import Any, TypeAlias

import numpy as np

from controllers.interface import Controller
from controllers.open_loop import OPEN_LOOP
from controllers.open_loop import Gains as OpenLoopGains
from plants.equation import fields
from plants.interface import Plant
from workbench.fmu.machine import FmuMachine
from workbench.simulation.integrators.dormand_prince import DORMAND_PRINCE
from workbench.simulation.references import ReferenceSignal
from workbench.simulation.sensors import Sensors

Numbers: TypeAlias = tuple[object, ...]
"""A NamedTuple of numbers, possibly nested: some plant's state, inputs or parameters, SI."""

DEFAULT_TOLERANCE = 1e-6
"""Of the typical magnitude of a state and its own: an estimated error of a step, well below what a rig resolves."""

TIGHTER = 100.0
"""By which a tolerance is smaller (or twice, a step) where a run is to be as good as exact beside another."""

COMPANION, HALVED = 8.0, 2
"""By which the default method's tolerance is smaller in the run against which its error is found, and how many steps
that takes in a sample at least: where one step a sample suffices for either tolerance both runs would be the same, and
the distance nothing. The error of methods of lower order falls less steadily; they take `TIGHTER`."""

FARTHEST = 1e6
"""Times its typical magnitude and its initial value beyond which no state of a machine goes: it has diverged."""

DELAY_SLACK = 1e-9
"""A delay this close (in samples) to a whole number of samples is one."""


@dataclass(frozen=True)
class Integrator:
    """How to integrate: an error-controlled method with its `tolerance`, or a fixed-step one with its `step` (s).

    A fixed step is shortened so that a whole number of steps makes one sample. An error-controlled method takes
    `fewest` steps in a sample at least, and in each part of one that a delay ends within.
    """

    method: str = DORMAND_PRINCE.name
    step: float = 1e-4
    tolerance: float = DEFAULT_TOLERANCE
    fewest: int = 1

    def finer(self, tighter: float = TIGHTER) -> "Integrator":
        """The same with half the step, or a smaller tolerance."""
        return replace(self, step=self.step / 2.0, tolerance=self.tolerance / tighter)

    def companion(self) -> "Integrator":
        """The integrator against which this one's error is taken."""
        finer = self.finer(COMPANION if self.method == DORMAND_PRINCE.name else TIGHTER)
        return replace(finer, fewest=max(HALVED, self.fewest))


@dataclass(frozen=True)
class Loop:
    """A sampled controller with its gains, and the input of the plant that it `drives`: its command if none is said."""

    controller: Controller
    gains: Any
    drives: str = ""


@dataclass(frozen=True)
class Feed:
    """An input of the plant that follows a signal: open-loop commands, disturbances, moving spring ends.

    `linear`: a ramp from sample to sample; otherwise each sample's value is held. It comes late by `delay` (s): a held
    command of an open loop then changes within a sample, what else is fed is taken at each sample as it was then.
    """

    input: str
    signal: ReferenceSignal
    linear: bool = True
    delay: float = 0.0


NO_LOOP = Loop(OPEN_LOOP, OpenLoopGains(0.0))
"""No feedback: the command is what a feed gives."""


@dataclass(frozen=True)
class Setup:
    """Everything that a run depends on.

    `state` and `inputs` are where the plant starts and what its inputs are before any command is added.
    `rotary` drives the plant's rotary input from `rotation_speed` (rad/s), a constant wanted speed. Where there is a
    `machine`, it runs in the place of the plant's equations, with a solver and a start of its own. A state
    has diverged that is `farthest` times its typical magnitude and its initial value; a run ends early that takes more
    than `most_steps`.
    """

    plant: Plant
    parameters: Any
    state: Any
    inputs: Any
    duration: float
    loop: Loop = NO_LOOP
    reference: ReferenceSignal | None = None
    rotary: Loop | None = None
    rotation_speed: float = 0.0
    feeds: tuple[Feed, ...] = ()
    sensors: Sensors = field(default_factory=Sensors)
    integrator: Integrator = field(default_factory=Integrator)
    sample_time: float = 1e-3
    seed: int = 0
    machine: FmuMachine | None = None
    farthest: float = FARTHEST
    most_steps: float = np.inf


def memory_names(controller: Controller) -> list[str]:
    """Names of the signals that a controller's state gives: `controller_theta`, `controller_friction`, ..."""
    return [f"controller_{item.name}" for item in fields(controller.State)]
