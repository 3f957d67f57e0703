"""Effects of valve, supply, chambers and sensors."""

import numpy as np

from .forms import Column, Draw, Form, sign, single
from .machines import AIR, ROTARY, Rig, between


def _flow(rig: Rig) -> float:
    """Flow of the largest speed (m^3/s)."""
    return rig.machine.area_1 * rig.speed


def valve_deadband(rig: Rig, draw: Draw) -> Form:
    """An overlap of up to 20 % of the spool's way, the same for both directions or not."""
    way = 0.2 * rig.machine.spool_limit
    columns: dict[str, Column] = {
        "positive": lambda s: {"overlap_positive": way * s},
        "negative": lambda s: {"overlap_negative": way * s},
    }
    other = 1.0 if draw.random() < 0.6 else draw.uniform(0.0, 0.8)
    sides = ["positive", "negative"]
    draw.shuffle(sides)
    return Form(columns, {sides[0]: 1.0, sides[1]: other})


def internal_leakage(rig: Rig, draw: Draw) -> Form:
    """Up to 30 % of the flow of the largest speed, at half the supply pressure."""
    return single(lambda s: {"leakage": 0.6 * _flow(rig) / rig.machine.supply_pressure * s})


def internal_air_leakage(rig: Rig, draw: Draw) -> Form:
    """Up to a tenth of the valve's conductance from chamber to chamber."""
    most = 0.1 * rig.machine.flow_gain * rig.machine.spool_limit
    return single(lambda s: {"leakage": most * s})


def external_leakage(rig: Rig, draw: Draw) -> Form:
    """The same from one of the chambers to the tank; of air the conductance."""
    machine = rig.machine
    most = (
        0.6 * _flow(rig) / machine.supply_pressure if rig.kind != AIR else 0.1 * machine.flow_gain * machine.spool_limit
    )
    columns: dict[str, Column] = {
        "1": lambda s: {"leak_1": most * s},
        "2": lambda s: {"leak_2": most * s},
    }
    return Form(columns, {str(draw.choice(["1", "2"])): 1.0})


def supply_droop(rig: Rig, draw: Draw) -> Form:
    """Half the supply pressure at the flow of the largest speed."""
    return single(lambda s: {"droop": 0.5 * rig.machine.supply_pressure / _flow(rig) * s})


def entrained_air(rig: Rig, draw: Draw) -> Form:
    """Up to 10 % of the volume at atmospheric pressure, isothermal."""
    return single(lambda s: {"air": 0.1 * s})


def unequal_areas(rig: Rig, draw: Draw) -> Form:
    """The second area is up to twice or half the declared one."""
    return single(lambda s: {"area_2": float(rig.machine.area_2 * 2.0**s)}, -1.0 if draw.random() < 0.7 else 1.0)


def valve_gain_curve(rig: Rig, draw: Draw) -> Form:
    """Openings times 1 + c |x| / x_max, c up to 2 or down to -0.8."""
    return single(lambda s: {"gain_curve": s}, 2.0 if draw.random() < 0.5 else -0.8)


def valve_gain_asymmetry(rig: Rig, draw: Draw) -> Form:
    """The gain of negative openings over that of positive ones: 2.5^(+-s)."""
    return single(lambda s: {"gain_ratio": float(2.5**s)}, sign(draw))


def position_dependent_volume(rig: Rig, draw: Draw) -> Form:
    """The share by which chambers that are declared frozen at mid-stroke follow the position."""
    return single(lambda s: {"following": s})


def position_dependent_area(rig: Rig, draw: Draw) -> Form:
    """Areas times 1 + g xi, g up to 0.5."""
    return single(lambda s: {"area_gradient": 0.5 * s}, sign(draw))


def supply_ripple(rig: Rig, draw: Draw) -> Form:
    """Up to 30 % of the supply pressure, a sine of 0.3 to 10 Hz."""
    frequency, most = 2.0 * np.pi * between(draw, 0.3, 10.0), 0.3 * rig.machine.supply_pressure
    phase = draw.uniform(0.0, 2.0 * np.pi)
    columns: dict[str, Column] = {
        "own": lambda s: {"ripple": most * s, "ripple_frequency": frequency, "ripple_phase": phase},
        "beside": lambda s: {"ripple": most * s, "ripple_frequency": frequency, "ripple_phase": phase + 0.5 * np.pi},
    }
    return Form(columns, {"own": 1.0})


def command_delay(rig: Rig, draw: Draw) -> Form:
    """Up to 0.1 s."""
    return single(lambda s: {"delay": 0.1 * s})


def valve_hysteresis(rig: Rig, draw: Draw) -> Form:
    """The command is followed with a play of up to 20 % of its limit."""
    return single(lambda s: {"play": 0.2 * rig.machine.command_limit * s})


def spool_stiction(rig: Rig, draw: Draw) -> Form:
    """The spool stays until its target is up to 10 % of its way off, then goes there."""
    return single(lambda s: {"spool_band": 0.1 * rig.machine.spool_limit * s})


def backlash(rig: Rig, draw: Draw) -> Form:
    """The position sensor follows with a play of up to 10 % of the travel (full width)."""
    return single(lambda s: {"backlash": 0.1 * rig.travel * s})


def pressure_sensor_offset(rig: Rig, draw: Draw) -> Form:
    """Up to 10 % of the supply pressure on pressure 1."""
    return single(lambda s: {"offset_1": 0.1 * rig.machine.supply_pressure * s}, sign(draw))


def sensor_nonlinearity(rig: Rig, draw: Draw) -> Form:
    """Up to 10 % of a pitch, once a pitch: 3 to 40 in the travel, of a turning axis a turn."""
    pitch = 2.0 * np.pi if rig.kind == ROTARY else rig.travel / draw.uniform(3.0, 40.0)
    angle = draw.uniform(0.0, 2.0 * np.pi)
    columns: dict[str, Column] = {
        "cosine": lambda s: {"sensor_cosine": 0.1 * pitch * s, "sensor_pitch": float(pitch)},
        "sine": lambda s: {"sensor_sine": 0.1 * pitch * s, "sensor_pitch": float(pitch)},
    }
    return Form(columns, {"cosine": float(np.cos(angle)), "sine": float(np.sin(angle))})


def sensor_lag(rig: Rig, draw: Draw) -> Form:
    """The position sensor follows by a lag of up to 0.1 s."""
    return single(lambda s: {"sensor_lag": 0.1 * s})
