"""A motor that moves its load through something that gives: a shaft, a gear, a belt."""

from typing import Annotated, NamedTuple, Protocol, runtime_checkable

from plants.equation import Scalar, equation, select

PLACES = {"motor": 0.0, "load": 1.0}
"""Where the position is measured, by name: the number that stands for it."""


class Coupling(NamedTuple):
    """The motor's own mass and viscous friction, what joins it to the load, and on which side the sensor is."""

    motor_mass: Annotated[float, "kg"]
    motor_viscous: Annotated[float, "N s/m"]
    coupling_stiffness: Annotated[float, "N/m"]
    coupling_damping: Annotated[float, "N s/m"]
    measured_at: Annotated[float, "1"] = PLACES["motor"]


@runtime_checkable
class Coupled(Protocol):
    """Parameters of a motor with a coupling to its load."""

    @property
    def coupling(self) -> Coupling: ...


@equation
def coupling_force(twist: Scalar, motor_velocity: Scalar, velocity: Scalar, p: Coupling) -> Scalar:
    """Force (N) of the coupling on the load: k s + c (v_m - v), with the twist s = x_m - x (m)."""
    return p.coupling_stiffness * twist + p.coupling_damping * (motor_velocity - velocity)


@equation
def motor_acceleration(force: Scalar, coupled: Scalar, motor_velocity: Scalar, p: Coupling) -> Scalar:
    """dv_m/dt (m/s^2) = (F - a_m v_m - F_coupling) / M_m."""
    return (force - p.motor_viscous * motor_velocity - coupled) / p.motor_mass


@equation
def measured_position(position: Scalar, twist: Scalar, p: Coupling) -> Scalar:
    """Position (m) of the load, or of the motor: x + s."""
    return select(p.measured_at > 0.5, position, position + twist)
