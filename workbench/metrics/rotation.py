"""How the rod really turns, what of that leaves the Stribeck range, and what its motor gives for it."""

from collections.abc import Mapping

import numpy as np

from plants.friction import Friction, blended, helical_speed
from plants.motor import Motor
from workbench.metrics.tracking import root_mean_square
from workbench.simulation.motor_limits import at_a_limit

RPM = 60.0 / (2.0 * np.pi)


def real_speed(rotation_speed: np.ndarray) -> dict[str, float]:
    """Mean, least and largest speed (rpm) of a rod that turns at `rotation_speed` (rad/s)."""
    return {
        "rotation_speed_mean_rpm": float(RPM * np.mean(rotation_speed)),
        "rotation_speed_min_rpm": float(RPM * np.min(rotation_speed)),
        "rotation_speed_max_rpm": float(RPM * np.max(rotation_speed)),
    }


def below_stribeck_fraction(signals: Mapping[str, np.ndarray], samples: slice, friction: Friction) -> float:
    """Share of the samples in which the contact slides slower than the Stribeck velocity of its true friction along.

    v_h = sqrt(v^2 + w^2) < v_s, of sets that differ with direction that of the direction of motion.
    """
    along = signals["velocity"][samples]
    around = signals["surface_speed"][samples] if "surface_speed" in signals else np.zeros_like(along)
    speed = helical_speed(along, around)
    return float(np.mean(speed < blended(along / speed, along / speed, friction).stribeck_velocity))


def motor_figures(signals: Mapping[str, np.ndarray], samples: slice, motor: Motor) -> dict[str, float]:
    """Share of the samples at a limit of torque, current or voltage; rms torque (N m); motor's loss (W).

    Torque is K_t i. The loss is what enters at the terminals less what reaches the rod, F_rotary w.
    """
    current = signals["motor_current"][samples]
    voltage = signals["motor_voltage"][samples] if "motor_voltage" in signals else None
    return {
        "torque_limited_fraction": float(np.mean(at_a_limit(current, voltage, motor))),
        "motor_torque_rms_N_m": root_mean_square(motor.torque_constant * current),
        "motor_loss_W": float(np.mean((signals["motor_electric_power"] - signals["rotation_power"])[samples])),
    }
