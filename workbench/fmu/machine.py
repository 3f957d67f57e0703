"""An FMU in the place of a plant: which of its variables are the plant's inputs and outputs."""

from collections.abc import Sequence
from dataclasses import dataclass

from workbench.errors import UserError
from workbench.fmu.description import Fmu

OPTION = "--allow-fmu"

ABSENT, STILL = -1, -2
"""In the place of a channel among the outputs: no reading, and 0."""


@dataclass(frozen=True)
class Mapped:
    """A variable that serves: its reference, and what to multiply its value with to have SI."""

    reference: int
    factor: float


@dataclass(frozen=True)
class FmuMachine:
    """What runs in the place of a plant's equations.

    Attributes:
        fmu: the FMU.
        inputs: of the plant, in its order.
        outputs: which are the plant's states, in its order.
        channels: of what a rig measures, the place of each among the outputs, or `ABSENT` or `STILL`.
        parameters: references of the FMU's parameters that are set before it starts, and values in its own units.
        allowed: whether its code may be run.
    """

    fmu: Fmu
    inputs: tuple[Mapped, ...]
    outputs: tuple[Mapped, ...]
    channels: tuple[int, ...]
    parameters: tuple[tuple[int, float], ...]
    allowed: bool

    def check_allowed(self) -> None:
        """Raise UserError where its code may not be run."""
        if not self.allowed:
            raise UserError(
                f"{self.fmu.path}: an FMU is foreign code, which no study may run by itself; to trust it, add {OPTION}"
            )

    @property
    def content(self) -> tuple[object, ...]:
        """All on which a run depends."""
        return self.fmu.sha256, self.inputs, self.outputs, self.channels, self.parameters


def check_machines(machines: Sequence[FmuMachine]) -> None:
    """Raise UserError where one of them may not be run, or cannot be here."""
    from workbench.fmu.library import check_platform  # it imports what loads code

    for machine in machines:
        machine.check_allowed()
        check_platform(machine.fmu)
