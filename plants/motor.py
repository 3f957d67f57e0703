"""The motor that rotates piston and rod, in forces and velocities at the piston's surface (thesis 3.3.1)."""

from typing import Annotated, NamedTuple

from plants.equation import Scalar, equation


class Motor(NamedTuple):
    """Brushless motor on the rod.

    `torque_constant` and `back_emf_constant` differ in SI units, as printed for a three-phase drive, so that
    the power at the terminals is not the sum of shaft power and winding loss: (K_bemf - K_t) i omega is the
    balance that the printed constants leave open.
    """

    rotary_inertia: Annotated[float, "kg m^2"]
    piston_radius: Annotated[float, "m"]
    torque_constant: Annotated[float, "N m/A"]
    back_emf_constant: Annotated[float, "V s/rad"]
    motor_inductance: Annotated[float, "H"]
    motor_resistance: Annotated[float, "ohm"]


@equation
def surface_acceleration(current: Scalar, rotary_friction: Scalar, p: Motor) -> Scalar:
    """dw/dt (m/s^2) = (K_t i - F_rotary R) R / J. Thesis (3.41), which takes M R^2 for J."""
    torque = p.torque_constant * current - rotary_friction * p.piston_radius
    return torque * p.piston_radius / p.rotary_inertia


@equation
def current_rate(current: Scalar, surface_speed: Scalar, voltage: Scalar, p: Motor) -> Scalar:
    """di/dt (A/s) = (V_m - R_m i - K_bemf w / R) / L_m. Thesis (3.39)."""
    back_emf = p.back_emf_constant * surface_speed / p.piston_radius
    return (voltage - p.motor_resistance * current - back_emf) / p.motor_inductance


@equation
def holding_current(rotary_friction: Scalar, p: Motor) -> Scalar:
    """Current (A) whose torque balances `rotary_friction` (N) at constant speed."""
    return rotary_friction * p.piston_radius / p.torque_constant


@equation
def holding_voltage(current: Scalar, surface_speed: Scalar, p: Motor) -> Scalar:
    """Voltage (V) that keeps `current` (A) flowing at `surface_speed` (m/s)."""
    return p.motor_resistance * current + p.back_emf_constant * surface_speed / p.piston_radius
