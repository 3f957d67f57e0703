"""What a controller may ask of the plant that it believes in: parts of the plant's parameters, by name.

A `design` whose belief is one of these needs that part of every plant; one that takes any belief looks with
`isinstance` whether there is such a part. What a belief lacks is told where gains are designed.
"""

from typing import Annotated, NamedTuple, Protocol, runtime_checkable

from plants import authority
from plants.anisotropic import Film, Guide
from plants.coupling import Coupled
from plants.friction import HasFriction, LuGre
from plants.hydraulics import Bored, Hydraulic, Moving
from plants.motor import HasMotor
from plants.pneumatics import Pneumatic
from plants.sources import Driven, force_of_command
from plants.valve_axis import ValveDriven


class Sliding(HasFriction, Moving, Protocol):
    """A mass that slides with friction."""


def moved_mass(belief: Moving) -> float:
    """The mass (kg) that a force moves: with a coupling between motor and load, which is believed stiff, both."""
    motor = belief.coupling.motor_mass if isinstance(belief, Coupled) else 0.0
    return belief.body.mass + motor


def drive_gain(belief: object) -> float:
    """The force (N) of a unit of a drive's command; 1 of one that is commanded in N, and of a valve."""
    return force_of_command(belief.source) if isinstance(belief, Driven) else 1.0


class HydraulicSliding(Hydraulic, Sliding, Protocol):
    """A mass that slides with friction, moved by a valve and a cylinder."""


def bored(belief: object) -> Bored | None:
    """The believed cylinder of a plant whose pressures say what force drives it; None of any other."""
    if isinstance(belief, Pneumatic):
        return belief.pneumatics
    return belief.hydraulics if isinstance(belief, Hydraulic) else None


class Turned(HasFriction, HasMotor, Protocol):
    """A rod with friction that a motor turns."""


@runtime_checkable
class Anisotropic(Protocol):
    """Friction around the rod that differs from that along it, as forces and speeds at the rod's surface."""

    @property
    def rotary(self) -> LuGre: ...

    @property
    def film(self) -> Film: ...

    @property
    def guide(self) -> Guide: ...


class VelocityGain(NamedTuple):
    """How a velocity follows a voltage: gain and dead band of either direction, and the lag between them."""

    forward: Annotated[float, "m/(s V)"]
    backward: Annotated[float, "m/(s V)"]
    lag: Annotated[float, "s"]
    dead_band: Annotated[float, "V"]
    dead_band_negative: Annotated[float, "V"]


def velocity_gain(belief: object, what: str) -> VelocityGain:
    """How the velocity of a believed plant follows its command; `what` needs to know.

    Raises:
        ValueError: a plant without a valve.
    """
    if isinstance(belief, Hydraulic | Pneumatic):
        valve = authority.authority(belief)
        return VelocityGain(*authority.velocity_gains(valve), valve.time_constant, valve.dead_band, valve.dead_band)
    if isinstance(belief, ValveDriven):
        ahead, back = belief.valve, belief.valve.negative
        gains, bands = (ahead.velocity_gain, back.velocity_gain), (ahead.dead_band, back.dead_band)
        return VelocityGain(*gains, belief.axis_time_constant, *bands)
    raise ValueError(f"{what} needs a plant with a velocity gain (one with a valve); leave it out here")
