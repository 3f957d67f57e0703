"""An FMU in the place of a plant: which of its variables are the plant's inputs and outputs."""

from dataclasses import dataclass

from workbench.errors import UserError, few_of
from workbench.fmu.description import Fmu
from workbench.fmu.platforms import binary_place, is_known, platform_here

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

    @property
    def content(self) -> tuple[object, ...]:
        """All on which a run depends."""
        return self.fmu.sha256, self.inputs, self.outputs, self.channels, self.parameters


def check_runs(fmu: Fmu, allowed: bool) -> None:
    """Raise UserError where an FMU may not be run, or has no binary for this platform."""
    if not allowed:
        trust = f"to trust it, add {OPTION} to workbench run"
        raise UserError(f"{fmu.path}: an FMU is foreign code, which no study runs by itself; {trust}")
    if not is_known() or binary_place(fmu.fmi, fmu.identifier) not in fmu.files:
        places = [name.split("/") for name in fmu.files if name.startswith("binaries/")]
        others = few_of(sorted({parts[1] for parts in places if len(parts) > 2}))
        raise UserError(f"{fmu.path}: has no binary for {platform_here()}; it has {others or 'none'}")
