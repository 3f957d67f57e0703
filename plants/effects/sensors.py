"""Effects of sensors: what they show is not what is there, and the machine itself does not know of it."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.interface import Effect, Moment, Number
from plants.effects.lags import followed_rate, lagged
from plants.effects.scales import PITCHES, pitch, pressure, travel
from plants.effects.waves import wave
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


BACKLASH = Effect(
    name="backlash",
    balance="sensor",
    words="the position sensor is coupled loosely to the rod",
    source="Nordin and Gutman 2002",
    numbers={"backlash_width": Number(0.0, 0.03, 1.67e-4, travel)},
    needs=("position",),
    Own=Backlash,
    Memory=Gap,
    readings={"position": behind},
    remember=carried,
)


# --- along the sensor -----------------------------------------------------------------------------------------


class Nonlinearity(NamedTuple):
    """Amplitudes of the sensor's error over the position, and the way after which it repeats."""

    position_ripple_cosine: Annotated[float, "m"] = 0.0
    position_ripple_sine: Annotated[float, "m"] = 0.0
    position_ripple_pitch: Annotated[float, "m"] = 0.01


@equation
def uneven(position: Scalar, moment: Moment, memory: Nothing, p: Any, own: Nonlinearity) -> Scalar:
    """x + a cos(2 pi x / p) + b sin(2 pi x / p) (m).

    Interpolation between the lines of a scale, or a disc off its axis (Heydemann 1981). Looks like a velocity that
    ripples with the position while nothing pushes; cogging is a force that ripples, and the pressures show it.
    """
    angle = 2.0 * np.pi * position / own.position_ripple_pitch
    return position + wave(own.position_ripple_cosine, own.position_ripple_sine, angle)


SENSOR_NONLINEARITY = Effect(
    name="sensor_nonlinearity",
    balance="sensor",
    words="the position sensor's error repeats along its way",
    source="Heydemann 1981",
    numbers={
        "position_ripple_cosine": Number(-0.02, 0.02, 1e-4, travel),
        "position_ripple_sine": Number(-0.02, 0.02, 1e-4, travel),
        "position_ripple_pitch": Number(0.001, 2.0, 0.0, pitch, grid=PITCHES, period_of="position"),
    },
    needs=("position",),
    Own=Nonlinearity,
    readings={"position": uneven},
)


# --- behind a filter ------------------------------------------------------------------------------------------


class Lag(NamedTuple):
    """The time constant of the position sensor."""

    position_sensor_lag: Annotated[float, "s"] = 0.0


class Behind(NamedTuple):
    """By how much the position is ahead of what the sensor shows."""

    sensor_lead: Annotated[float, "m", 1e-4] = 0.0


@equation
def shown_late(position: Scalar, moment: Moment, memory: Behind, p: Any, own: Lag) -> Scalar:
    """The position (m) that a sensor with a lag shows: x - d."""
    return lagged(position, position - memory.sensor_lead, own.position_sensor_lag)


@equation
def lagging(slip: Scalar, command: Scalar, moment: Moment, memory: Behind, p: Any, own: Lag) -> Behind:
    """dd/dt = v - d/T (m/s): the reading x_m = x - d follows by dx_m/dt = (x - x_m)/T.

    A filter in the sensor or before its converter. Looks like pressures that come before the motion which they drive;
    a command that comes late leaves pressures and motion together, friction that follows late is no constant time.
    """
    rate = moment.velocity + followed_rate(0.0, memory.sensor_lead, own.position_sensor_lag)
    return Behind(select(own.position_sensor_lag > 0.0, rate, 0.0))


SENSOR_LAG = Effect(
    name="sensor_lag",
    balance="sensor",
    words="the position sensor shows what was",
    source="a filter of first order",
    numbers={"position_sensor_lag": Number(0.0, 0.1, 0.001)},
    needs=("position",),
    Own=Lag,
    Memory=Behind,
    readings={"position": shown_late},
    remember=lagging,
)


# --- pressure -------------------------------------------------------------------------------------------------


class Offset(NamedTuple):
    """What the first pressure sensor shows too much."""

    pressure_1_offset: Annotated[float, "Pa"] = 0.0


@equation
def offset(pressure: Scalar, moment: Moment, memory: Nothing, p: Any, own: Offset) -> Scalar:
    """The pressure (Pa) that a transducer shows whose zero is off."""
    return pressure + own.pressure_1_offset


PRESSURE_SENSOR_OFFSET = Effect(
    name="pressure_sensor_offset",
    balance="sensor",
    words="the first pressure sensor is off by a constant",
    source="zero of a transducer",
    numbers={"pressure_1_offset": Number(-0.05, 0.05, 0.0017, pressure)},
    needs=("pressure_1", "pressure_2"),
    acts_on=("pressure_1",),
    requires=("pressure_1", "pressure_2"),
    Own=Offset,
    readings={"pressure_1": offset},
)
"""Zero and thermal zero shift of industrial transducers stay within 1 % of their range, which is seldom more than five
times the supply's pressure [data sheets' usual figures].
"""
