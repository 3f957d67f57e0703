"""Effects of sensors: what they show is not what is there, and the machine itself does not know of it."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.interface import Effect, Moment, Number, Scales
from plants.equation import Scalar, equation, select
from plants.laws.interface import Nothing


class Backlash(NamedTuple):
    """The way that the sensor's coupling can move without it."""

    backlash_width: Annotated[float, "m"] = 0.0


class Gap(NamedTuple):
    """By how much the sensor is ahead of the rod."""

    sensor_gap: Annotated[float, "m", 1e-5] = 0.0


@equation
def behind(position: Scalar, moment: Moment, memory: Gap, p: Any, own: Backlash) -> Scalar:
    """The position (m) that a sensor behind a backlash shows."""
    half = 0.5 * own.backlash_width
    return position + np.minimum(np.maximum(memory.sensor_gap, -half), half)


@equation
def carried(slip: Scalar, command: Scalar, moment: Moment, memory: Gap, p: Any, own: Backlash) -> Gap:
    """Rate (m/s) of the gap: -v until a flank carries the sensor.

    A loose coupling between rod and sensor (Nordin and Gutman 2002). Looks like a position that rests at each reversal
    while oil flows; presliding looks alike, but the pressure then follows the position.
    """
    half, velocity = 0.5 * own.backlash_width, moment.velocity
    forward = select(memory.sensor_gap <= -half, np.minimum(velocity, 0.0), velocity)
    return Gap(-select(memory.sensor_gap >= half, np.maximum(forward, 0.0), forward))


def travel(scales: Scales) -> float:
    """m."""
    return scales.travel


BACKLASH = Effect(
    name="backlash",
    balance="sensor",
    words="the position sensor is coupled loosely to the rod",
    source="Nordin and Gutman 2002",
    numbers={"backlash_width": Number(0.0, 0.033, 1.67e-4, travel)},
    needs=("position",),
    Own=Backlash,
    Memory=Gap,
    readings={"position": behind},
    remember=carried,
)


class Offset(NamedTuple):
    """What the first pressure sensor shows too much."""

    pressure_1_offset: Annotated[float, "Pa"] = 0.0


@equation
def offset(pressure: Scalar, moment: Moment, memory: Nothing, p: Any, own: Offset) -> Scalar:
    """The pressure (Pa) that a transducer shows whose zero is off."""
    return pressure + own.pressure_1_offset


def pressure_scale(scales: Scales) -> float:
    """Pa."""
    return scales.pressure


PRESSURE_SENSOR_OFFSET = Effect(
    name="pressure_sensor_offset",
    balance="sensor",
    words="the first pressure sensor is off by a constant",
    source="zero of a transducer",
    numbers={"pressure_1_offset": Number(-0.34, 0.34, 0.0017, pressure_scale)},
    needs=("pressure_1", "pressure_2"),
    acts_on=("pressure_1",),
    requires=("pressure_1", "pressure_2"),
    Own=Offset,
    readings={"pressure_1": offset},
)
