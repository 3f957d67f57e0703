"""What a controller may ask of the plant that it believes in: parts of the plant's parameters, by name.

A `design` whose belief is one of these needs that part of every plant; one that takes any belief looks with
`isinstance` whether there is such a part. What a belief lacks is told where gains are designed.
"""

from typing import Annotated, NamedTuple, Protocol, runtime_checkable

from plants.anisotropic import Film, Guide
from plants.friction import HasFriction, LuGre
from plants.hydraulics import Hydraulic, Moving, no_load_velocity_gain
from plants.motor import HasMotor
from plants.valve_axis import ValveDriven


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


class VelocityGain(NamedTuple):
    """How a velocity follows a voltage: gain and dead band of either direction, and the lag between them."""

    forward: Annotated[float, "m/(s V)"]
    backward: Annotated[float, "m/(s V)"]
    lag: Annotated[float, "s"]
    dead_band: Annotated[float, "V"]
    dead_band_negative: Annotated[float, "V"]

    @property
    def mean(self) -> float:
        """Of both directions (m/s per V), for a law that knows but one."""
        return 0.5 * (self.forward + self.backward)


def velocity_gain(belief: object, what: str) -> VelocityGain:
    """How the velocity of a believed plant follows its command; `what` needs to know.

    Raises:
        ValueError: a plant without a valve.
    """
    if isinstance(belief, Hydraulic):
        h = belief.hydraulics
        gain, band = float(no_load_velocity_gain(h)), h.valve_overlap / h.valve_position_gain
        return VelocityGain(gain, gain, h.valve_time_constant, band, band)
    if isinstance(belief, ValveDriven):
        valve, other = belief.valve, belief.valve.negative
        gains, bands = (valve.velocity_gain, other.velocity_gain), (valve.dead_band, other.dead_band)
        return VelocityGain(*gains, belief.axis_time_constant, *bands)
    raise ValueError(f"{what} needs a plant with a velocity gain (a hydraulic one); leave it out here")
