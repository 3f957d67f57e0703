"""What may be meant of a rotation, and seldom is: a speed at which nothing holds the rod, or that no motor gives."""

import numpy as np

from controllers import speed_servo
from workbench.study.resolve import Resolved
from workbench.study.study import Case

RPM = 60.0 / (2.0 * np.pi)

SCANNED = np.geomspace(0.05, 2000.0, 600)
"""rpm. Speeds among which the unstable ones are looked for."""


def rotation_warning(case: Case, item: Resolved) -> str | None:
    """Why a case's rotation is not what its rpm says, in words; None where nothing is known against it."""
    setup, speed = item.setup, abs(item.setup.rotation_speed)
    turned = setup.plant.rotary_command
    if turned is not None and "rpm" not in case.axes and all(feed.input != turned for feed in setup.feeds):
        return "no rpm is given: the rod does not turn; expected an rpm, 0 if that is meant"
    if setup.plant.rotary_command != "motor_voltage" or speed == 0.0:
        return None
    rpm, motor = speed * RPM, item.belief.motor
    if setup.rotary is None:
        if case.tables["plant"].get("rotation") != "voltage" or (band := unstable_band(item, rpm)) is None:
            return None
        return (
            f"a constant voltage holds no {rpm:.4g} rpm: from {band[0]:.3g} to {band[1]:.3g} rpm the believed friction "
            'falls faster with the speed than the motor damps it; expected rotation = "servo", or another rpm'
        )
    if speed > motor.motor_speed_limit * (1.0 + 1e-9):
        return (
            f"{rpm:.4g} rpm is beyond what the motor's drive is limited to, {motor.motor_speed_limit * RPM:.4g} rpm "
            "(motor_speed_limit), at which it turns; expected less, or motor_limits = false"
        )
    if not speed_servo.holds(item.belief, speed, setup.sample_time):
        return (
            f"at {rpm:.4g} rpm the believed friction falls so steeply that no servo sampled every "
            f"{setup.sample_time:g} s is sure to hold it; expected a shorter sample_time, or another rpm"
        )
    return None


def unstable_band(item: Resolved, rpm: float) -> tuple[float, float] | None:
    """The speeds (rpm) about `rpm` at which the believed motor needs the less voltage the faster it turns.

    R^2 dF/dw + K_t K_bemf / R_m < 0, friction's slope around the rod and the motor's own damping: there a rod that is
    a little too slow is slowed further. None where `rpm` is no such speed.
    """
    radius, plant = item.belief.motor.piston_radius, item.setup.plant
    believed = plant.bare or plant  # what controllers believe has no effects

    def falls(speed: float) -> bool:
        around = [speed * factor / RPM * radius for factor in (0.999, 1.001)]
        slower, faster = (believed.equilibrium(item.belief, w)[1].motor_voltage for w in around)
        return bool(faster < slower)

    if not falls(rpm):
        return None
    below = next((speed for speed in SCANNED[::-1] if speed < rpm and not falls(speed)), 0.0)
    above = next((speed for speed in SCANNED if speed > rpm and not falls(speed)), np.inf)
    return float(below), float(above)
