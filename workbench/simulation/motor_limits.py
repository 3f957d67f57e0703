"""Which samples of a run see its motor at a limit of torque, current or voltage."""

import numpy as np

from plants.motor import Motor, current_limit

AT = 0.999
"""Share of a limit from which the motor counts as being at it."""


def at_a_limit(current: np.ndarray, voltage: np.ndarray | None, motor: Motor) -> np.ndarray:
    """Whether |i| (A) or |V_m| (V, None: not driven by a voltage) is at its limit, in each sample."""
    limited = np.abs(current) >= AT * current_limit(motor)
    return limited if voltage is None else limited | (np.abs(voltage) >= AT * motor.motor_voltage_limit)
