"""The motor that rotates piston and rod, in forces and velocities at the piston's surface (thesis 3.3.1)."""

from typing import Annotated, NamedTuple, Protocol, runtime_checkable

import numpy as np

from plants.equation import Scalar, equation, select


class Motor(NamedTuple):
    """Brushless motor on the rod.

    `torque_constant` and `back_emf_constant` differ in SI units, as printed for a three-phase drive, so that
    the power at the terminals is not the sum of shaft power and winding loss: (K_bemf - K_t) i omega is the
    balance that the printed constants leave open.

    The limits are those of motor and drive together; a set that does not name them has none. `motor_nominal_torque`,
    what it may give for ever, limits nothing: more than it is reported. `motor_speed_limit` limits what a speed servo
    is asked for. `bearing_viscous` is the drag of what carries the part that turns, beside the friction of the rod.
    """

    rotary_inertia: Annotated[float, "kg m^2"]
    piston_radius: Annotated[float, "m"]
    torque_constant: Annotated[float, "N m/A"]
    back_emf_constant: Annotated[float, "V s/rad"]
    motor_inductance: Annotated[float, "H"]
    motor_resistance: Annotated[float, "ohm"]
    motor_nominal_torque: Annotated[float, "N m"] = np.inf
    motor_peak_torque: Annotated[float, "N m"] = np.inf
    motor_peak_current: Annotated[float, "A"] = np.inf
    motor_voltage_limit: Annotated[float, "V"] = np.inf
    motor_speed_limit: Annotated[float, "rad/s"] = np.inf
    bearing_viscous: Annotated[float, "N m s/rad"] = 0.0


class TurningCylinder(NamedTuple):
    """What turns where not the rod does but the cylinder around it (thesis 6.2)."""

    cylinder_inertia: Annotated[float, "kg m^2"]


@runtime_checkable
class HasMotor(Protocol):
    """Parameters of a motor that can turn the rod."""

    @property
    def motor(self) -> Motor: ...


LIMITS = ("motor_peak_torque", "motor_peak_current", "motor_voltage_limit", "motor_speed_limit")
"""What `motor_limits = false` lifts."""


@equation
def drive_voltage(voltage: Scalar, p: Motor) -> Scalar:
    """Voltage (V) that the drive gives when it is asked for `voltage` (V)."""
    return np.minimum(np.maximum(voltage, -p.motor_voltage_limit), p.motor_voltage_limit)


@equation
def current_limit(p: Motor) -> Scalar:
    """Largest current (A): the drive's, or that of the peak torque."""
    return np.minimum(p.motor_peak_current, p.motor_peak_torque / p.torque_constant)


@equation
def opposing_torque(rotary_friction: Scalar, surface_speed: Scalar, p: Motor) -> Scalar:
    """F_rotary R + B_b w / R (N m): friction around the rod, and the bearings' drag."""
    return rotary_friction * p.piston_radius + p.bearing_viscous * surface_speed / p.piston_radius


@equation
def surface_acceleration(current: Scalar, surface_speed: Scalar, rotary_friction: Scalar, p: Motor) -> Scalar:
    """dw/dt (m/s^2) = (K_t i - F_rotary R) R / J less the bearings' drag. Thesis (3.41), which takes M R^2 for J."""
    torque = p.torque_constant * current - opposing_torque(rotary_friction, surface_speed, p)
    return torque * p.piston_radius / p.rotary_inertia


@equation
def current_rate(current: Scalar, surface_speed: Scalar, voltage: Scalar, p: Motor) -> Scalar:
    """di/dt (A/s) = (V_m - R_m i - K_bemf w / R) / L_m, held at the largest current. Thesis (3.39) with limits."""
    back_emf = p.back_emf_constant * surface_speed / p.piston_radius
    rate = (drive_voltage(voltage, p) - p.motor_resistance * current - back_emf) / p.motor_inductance
    limit = current_limit(p)
    return select(current >= limit, np.minimum(rate, 0.0), select(current <= -limit, np.maximum(rate, 0.0), rate))


@equation
def holding_current(rotary_friction: Scalar, surface_speed: Scalar, p: Motor) -> Scalar:
    """Current (A) whose torque balances `rotary_friction` (N), and the bearings, at constant speed."""
    return opposing_torque(rotary_friction, surface_speed, p) / p.torque_constant


@equation
def holding_voltage(current: Scalar, surface_speed: Scalar, p: Motor) -> Scalar:
    """Voltage (V) that keeps `current` (A) flowing at `surface_speed` (m/s)."""
    return p.motor_resistance * current + p.back_emf_constant * surface_speed / p.piston_radius
