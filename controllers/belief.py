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


class Velocities(NamedTuple):
    """K_q: the velocity that a volt at the valve gives without a load, either way; and the lag with which it comes."""

    forward: Annotated[float, "m/(s V)"]
    backward: Annotated[float, "m/(s V)"]
    time_constant: Annotated[float, "s"]


def velocities(belief: object) -> Velocities | None:
    """What a voltage is believed to do to the velocity; None of a plant whose command sets no velocity."""
    if not isinstance(belief, Hydraulic | Pneumatic):
        return None
    valve = authority.authority(belief)
    return Velocities(*authority.velocity_gains(valve), valve.time_constant)


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
