"""Which motor turns the rod, in words: its constants, its limits, and what of it a run asks for."""

import numpy as np

from plants.motor import Motor, current_limit

RPM = 60.0 / (2.0 * np.pi)

CONSISTENT = 1e-9
"""Relative difference below which the two constants are the same."""


def motor_in_words(motor: Motor) -> str:
    """Its constants and whether their powers agree, then its limits.

    `motor` is the true one of a case: `resolve(study, case).setup.parameters.motor`.
    """
    torque, emf = motor.torque_constant, motor.back_emf_constant
    constants = f"K_t {torque:.4g} N m/A and K_bemf {emf:.4g} V s/rad"
    if abs(emf - torque) <= CONSISTENT * torque:
        first = f"A power-consistent motor, {constants}: what enters at its terminals is shaft power and loss."
    else:
        share = 100.0 * (emf / torque - 1.0)
        first = (
            f"The motor's constants as printed, {constants}: apart from the winding's loss its terminals take "
            f"{abs(share):.2g} % {'less' if share < 0.0 else 'more'} power than reaches the rod."
        )
    return f"{first} {_limits(motor)}"


def _limits(motor: Motor) -> str:
    peak, voltage, speed = current_limit(motor), motor.motor_voltage_limit, motor.motor_speed_limit
    known = [
        f"{motor.torque_constant * peak:.3g} N m ({peak:.3g} A) at most" if np.isfinite(peak) else "",
        f"{voltage:.3g} V" if np.isfinite(voltage) else "",
        f"{speed * RPM:.4g} rpm" if np.isfinite(speed) else "",
    ]
    limits = ", ".join(item for item in known if item)
    nominal = motor.motor_nominal_torque
    rated = f"; {nominal:.3g} N m for ever" if np.isfinite(nominal) else ""
    return f"Its limits: {limits or 'none'}{rated}."
