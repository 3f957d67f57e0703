"""What a run gives: its outcome in words, its states, inputs and measurements, and every signal by name."""

import functools
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from plants.equation import fields, from_array, leaves
from plants.interface import SENSORS, Plant
from workbench.simulation.arrays import arrays_told
from workbench.simulation.setup import Loop, memory_names

COMPLETED = "completed"
"""The outcome of a run with which nothing is wrong."""

MACHINE_FAILED = "FMU failed"
"""What the outcome of a run begins with whose machine, foreign code, fails; behind it stands what that says."""

TORQUE_LIMITED = "torque-limited"
"""The outcome of a run whose motor cannot give what holding the speed of rotation takes."""

EARLY = ("diverged", "step too small", "too many steps")
"""The outcomes of runs that end before their time, but for those of foreign machines."""

OUTCOMES = (
    COMPLETED,
    *EARLY,
    "end stop",
    "saturated throughout",
    "stuck",
    "hardly moves",
    "cavitates",
    TORQUE_LIMITED,
    MACHINE_FAILED,
)
"""All that a run may come to, in words; what fails of a foreign machine follows its last."""

FRICTION_ERROR = "friction_estimate_error"
"""The signal of a friction estimate less the friction along the rod, where a run has both."""

ESTIMATE, TRUE = "controller_friction", "axial_friction"
"""The signals of both."""

MEASURED = "measured_"
"""What stands before the name of a sensor's channel in the signals of a run."""

STUCK_SPEED = 1e-4
"""m/s. Slower than this counts as not moving."""

HARDLY_MOVES = 0.05
"""A rod that moves by less than this share of what it is asked for hardly moves; no phase lag is meant then."""


@dataclass(frozen=True)
class Run:
    """What happened. Arrays over the sample instants, which cannot be written to; `outcome` in words.

    `memory` holds the controller's state after each sample: its estimates, its integral.
    """

    plant: Plant
    loop: Loop
    parameters: Any
    time: np.ndarray
    states: np.ndarray
    inputs: np.ndarray
    measurements: np.ndarray
    memory: np.ndarray
    reference: tuple[np.ndarray, np.ndarray, np.ndarray] | None
    outcome: str
    steps: int

    def __post_init__(self) -> None:
        for array in (self.time, self.states, self.inputs, self.measurements, self.memory, *(self.reference or ())):
            array.flags.writeable = False

    @functools.cached_property
    def signals(self) -> Mapping[str, np.ndarray]:
        """All signals, by name, over time: the plant's, its inputs, the controller's state, reference and error.

        Raises:
            UserError: an equation of a plug-in takes no arrays.
        """
        with np.errstate(all="ignore"):  # a diverged run holds numbers beyond all bounds
            state = from_array(self.plant.State, self.states.T)
            inputs = from_array(self.plant.Inputs, self.inputs.T)
            with arrays_told(self.plant):
                values = self.plant.signals(self.time, state, inputs, self.parameters)
        names = [item.name for item in fields(self.plant.Signals)]
        named = dict(zip(names, leaves(values), strict=True))
        for i, item in enumerate(fields(self.plant.Inputs)):
            named.setdefault(item.name, self.inputs[:, i])
        for i, name in enumerate(SENSORS):
            named[f"{MEASURED}{name}"] = self.measurements[:, i]
        for i, name in enumerate(memory_names(self.loop.controller)):
            named[name] = self.memory[:, i]
        if ESTIMATE in named and TRUE in named:
            named[FRICTION_ERROR] = named[ESTIMATE] - named[TRUE]
        if self.reference is not None:
            named["reference_position"] = self.reference[0]
            named["reference_velocity"] = self.reference[1]
            named["error"] = self.reference[0] - named["position"]
        shape = self.time.shape
        return {
            name: _fixed(value) if np.shape(value) == shape else np.broadcast_to(value, shape)
            for name, value in named.items()
        }

    def state(self, name: str) -> np.ndarray:
        """One state of the plant over time."""
        names = [item.name for item in fields(self.plant.State)]
        return self.states[:, names.index(name)]

    @property
    def command(self) -> np.ndarray:
        """The realised command of the position loop."""
        return self.inputs[:, self.plant.input_index(self.plant.command)]

    @property
    def diverged(self) -> bool:
        """Whether it ended before its time."""
        return self.outcome in EARLY or self.outcome.startswith(MACHINE_FAILED)


def _fixed(values: np.ndarray) -> np.ndarray:
    """An array that cannot be written to."""
    values.flags.writeable = False
    return values
