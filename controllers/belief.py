"""What a controller may ask of the plant that it believes in: parts of the plant's parameters, by name.

A `design` whose belief is one of these needs that part of every plant; one that takes any belief looks with
`isinstance` whether there is such a part. What a belief lacks is told where gains are designed.
"""

from typing import Protocol, runtime_checkable

from plants.anisotropic import Film, Guide
from plants.friction import HasFriction, LuGre
from plants.hydraulics import Hydraulic, Moving
from plants.motor import HasMotor


class Sliding(HasFriction, Moving, Protocol):
    """A mass that slides with friction."""


class HydraulicSliding(Hydraulic, Sliding, Protocol):
    """A mass that slides with friction, moved by a valve and a cylinder."""


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
