"""A test vector: what a controller saw and gave in a run of the program's own."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from plants.interface import Measurement
from workbench.export.c_controller import Exported
from workbench.export.recorded import Path
from workbench.simulation.run import Run
from workbench.simulation.setup import Setup
from workbench.simulation.simulate import first_reading

MOST = 20_000
"""Samples of a test vector."""

BOUNDS = {"double": 1e-10, "single": 1e-3}
"""By how much, of the command's limit, the C may differ from the run."""


class Replay(NamedTuple):
    """What a controller is given, and what is realised of its commands.

    Attributes:
        start: the reading from which it starts.
        references: position, velocity and acceleration at each sample, shape (samples, 3).
        measurements: all readings at each sample, shape (samples, channels).
        commands: as realised, shape (samples,).
    """

    start: tuple[float, ...]
    references: np.ndarray
    measurements: np.ndarray
    commands: np.ndarray


def replay_of(setup: Setup, run: Run, rotary: bool) -> Replay:
    """What the position controller of a run was given, or the `rotary` one."""
    count = min(run.time.size, MOST)
    references = np.zeros((count, 3))
    if rotary:
        references[:, 0] = setup.rotation_speed
    elif run.reference is not None:
        references = np.column_stack(run.reference)[:count]
    driven = setup.plant.rotary_command if rotary else (setup.loop.drives or setup.plant.command)
    assert driven is not None
    commands = run.inputs[:count, setup.plant.input_index(driven)]
    return Replay(first_reading(setup), references, run.measurements[:count], commands)


def vector_text(exported: Exported, replay: Replay) -> str:
    """The test vector as C."""
    used = exported.recorded.used

    def braced(values: Sequence[float], names: Sequence[str], paths: Sequence[Path]) -> str:
        chosen = [exported.numbers.number(float(values[names.index(path[0])])) for path in paths]
        return ", ".join(chosen) or "0"

    references, channels = ("position", "velocity", "acceleration"), Measurement._fields
    rows = [
        f"{{{{{braced(reference, references, used.reference)}}}, {{{braced(reading, channels, used.measurement)}}}, "
        f"{float(command)!r}}}"
        for reference, reading, command in zip(replay.references, replay.measurements, replay.commands, strict=True)
    ]
    largest = float(np.max(np.abs(replay.commands), initial=0.0)) or 1.0
    limit = exported.limit if np.isfinite(exported.limit) else largest
    return exported.text(
        "vector.h",
        rows=rows,
        start=braced(replay.start, channels, used.measurement),
        bound=repr(BOUNDS[exported.precision] * limit),
    )
