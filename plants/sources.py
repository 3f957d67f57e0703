"""What moves a drive: a force, or a voltage or a current through a gain. Of a turning axis it is a torque."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Annotated, Any, NamedTuple, Protocol, runtime_checkable

import numpy as np

from plants.equation import Equation, Scalar, equation


class ForceLimits(NamedTuple):
    """Of what gives any force at once."""

    force_limit: Annotated[float, "N"] = np.inf


class Amplifier(NamedTuple):
    """An amplifier whose voltage makes the force, and its limit."""

    force_gain: Annotated[float, "N/V"]
    voltage_limit: Annotated[float, "V"] = np.inf


class CurrentLoop(NamedTuple):
    """A motor whose current is controlled, and the limit of that current."""

    force_constant: Annotated[float, "N/A"]
    current_limit: Annotated[float, "A"] = np.inf


class Inputs(NamedTuple):
    drive_force: Annotated[float, "N"]
    spring_end: Annotated[float, "m"]


class PressedInputs(NamedTuple):
    """Of a mass on which oil or air presses too: the drive's force contains that, and seals feel it."""

    drive_force: Annotated[float, "N"]
    spring_end: Annotated[float, "m"]
    pressure_1: Annotated[float, "Pa"] = 0.0
    pressure_2: Annotated[float, "Pa"] = 0.0


class VoltageInputs(NamedTuple):
    drive_voltage: Annotated[float, "V"]
    spring_end: Annotated[float, "m"]


class CurrentInputs(NamedTuple):
    drive_current: Annotated[float, "A"]
    spring_end: Annotated[float, "m"]


@runtime_checkable
class Driven(Protocol):
    """Parameters of a drive."""

    @property
    def source(self) -> NamedTuple: ...


def force_of_command(own: NamedTuple) -> float:
    """Force (N) of a unit of the command of a source with these parameters."""
    return float(getattr(own, "force_gain", getattr(own, "force_constant", 1.0)))


@dataclass(frozen=True, eq=False)
class Source:
    """A source of force: the inputs that a drive has by it, of which the first is the command, and its parameters.

    gain(own) -> N a unit of the command, limit(own) -> the largest command
    """

    name: str
    words: str
    Inputs: type[NamedTuple]
    Parameters: type[NamedTuple]
    gain: Equation
    limit: Callable[[Any], float]


@equation
def unit_gain(own: ForceLimits) -> Scalar:
    """Force (N) of 1 N."""
    return 1.0


@equation
def force_gain(own: Amplifier) -> Scalar:
    """Force (N) of 1 V."""
    return own.force_gain


@equation
def force_constant(own: CurrentLoop) -> Scalar:
    """Force (N) of 1 A."""
    return own.force_constant


def force_limit(own: ForceLimits) -> float:
    """N."""
    return own.force_limit


def voltage_limit(own: Amplifier) -> float:
    """V."""
    return own.voltage_limit


def current_limit(own: CurrentLoop) -> float:
    """A."""
    return own.current_limit


FORCE = Source("force", "driven by a force", Inputs, ForceLimits, unit_gain, force_limit)
PRESSED = Source("pressed", "driven by a force", PressedInputs, ForceLimits, unit_gain, force_limit)
VOLTAGE = Source(
    "voltage", "driven by a voltage through a force gain", VoltageInputs, Amplifier, force_gain, voltage_limit
)
CURRENT = Source(
    "current", "driven by a current through a force constant", CurrentInputs, CurrentLoop, force_constant, current_limit
)
