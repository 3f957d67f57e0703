"""What a controller may ask of the plant that it believes in: parts of the plant's parameters, by name.

A `design` whose belief is a protocol needs that part of every plant; one that takes any belief looks whether there is
such a part with `isinstance`. What a belief lacks is told where gains are designed.
"""

from typing import Protocol, runtime_checkable

from plants.anisotropic import Film, Guide
from plants.friction import Friction, LuGre
from plants.hydraulics import Hydraulics, Mass
from plants.motor import Motor


@runtime_checkable
class Hydraulic(Protocol):
    """A plant with a valve and a cylinder: its command has a velocity gain, and the force is measured as pressures."""

    @property
    def hydraulics(self) -> Hydraulics:
        """Supply, valve and cylinder."""


@runtime_checkable
class HasFriction(Protocol):
    """A plant with a contact that LuGre's numbers describe."""

    @property
    def friction(self) -> Friction:
        """Of either direction of motion along."""


@runtime_checkable
class Sliding(HasFriction, Protocol):
    """A mass that slides with friction."""

    @property
    def body(self) -> Mass:
        """The mass and its load."""


class HydraulicSliding(Hydraulic, Sliding, Protocol):
    """A mass that slides with friction, moved by a valve and a cylinder."""


@runtime_checkable
class HasMotor(Protocol):
    """A plant with a motor that may turn its rod."""

    @property
    def motor(self) -> Motor:
        """The motor and the rod that it turns."""


class Turned(HasFriction, HasMotor, Protocol):
    """A rod with friction that a motor turns."""


@runtime_checkable
class Anisotropic(Protocol):
    """A plant whose friction around the rod differs from that along it."""

    @property
    def rotary(self) -> LuGre:
        """Around the rod, as forces and speeds at the surface."""

    @property
    def film(self) -> Film:
        """What turning leaves between the surfaces."""

    @property
    def guide(self) -> Guide:
        """A guide that does not turn along."""
