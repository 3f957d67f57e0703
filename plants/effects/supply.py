"""Effects on the supply: its pressure falls with the flow, or pulsates."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.interface import COMMAND, Effect, Moment, Number
from plants.effects.scales import pressure, pressure_by_flow, sampling
from plants.effects.waves import wave
from plants.equation import Scalar, changed, equation, select, when
from plants.hydraulics import Hydraulics, edge_flow, valve_opening
from plants.laws.interface import Nothing
from plants.pneumatics import Pneumatics

SUPPLY_PRESSURE = Hydraulics._fields.index("supply_pressure")
SUPPLY_PRESSURE_OF_AIR = Pneumatics._fields.index("supply_pressure")


class Droop(NamedTuple):
    """Fall of the supply pressure a flow."""

    droop_resistance: Annotated[float, "Pa s/m^3"] = 0.0


@equation
def drooped(h: Hydraulics, moment: Moment, memory: Nothing, p: Any, own: Droop) -> Hydraulics:
    """P_s <- P_s - R |Q|, Q (m^3/s) the pump's flow at the declared supply pressure.

    A supply line, or a pump at its limit. Looks like flow that saturates with speed; a smaller gain of the valve looks
    alike where speeds vary little.
    """
    flow = when(own.droop_resistance != 0.0, pump_flow, 0.0, moment, h)
    return changed(h, SUPPLY_PRESSURE, h.supply_pressure - own.droop_resistance * flow)


@equation
def pump_flow(moment: Moment, h: Hydraulics) -> Scalar:
    """|Q| (m^3/s) into the chamber that the valve feeds."""
    opening = valve_opening(moment.spool_position, h)
    fed = select(opening >= 0.0, moment.pressure_1, moment.pressure_2)
    return edge_flow(np.abs(opening), h.supply_pressure - fed, h)


SUPPLY_DROOP = Effect(
    name="supply_droop",
    balance="flow",
    words="the supply pressure falls when much oil is taken",
    source="Merritt 1967",
    numbers={"droop_resistance": Number(0.0, 1.0, 0.002, pressure_by_flow)},
    needs=(COMMAND,),
    Own=Droop,
    parameters={"hydraulics": drooped},
)


# --- over the time --------------------------------------------------------------------------------------------


class Pulsation(NamedTuple):
    """Amplitudes of the supply's pressure about its mean, and their frequency."""

    ripple_cosine: Annotated[float, "Pa"] = 0.0
    ripple_sine: Annotated[float, "Pa"] = 0.0
    ripple_frequency: Annotated[float, "Hz"] = 5.0


@equation
def pulsation(moment: Moment, own: Pulsation) -> Scalar:
    """a cos(2 pi f t) + b sin(2 pi f t) (Pa), t (s) since the record began.

    A pump's flow, or one that switches (Merritt 1967; Ivantysyn and Ivantysynova 2001). Looks like flow that swings
    with the time whatever the machine does; a controller that hunts has the same frequency in its command.
    """
    return wave(own.ripple_cosine, own.ripple_sine, 2.0 * np.pi * own.ripple_frequency * moment.time)


@equation
def pulsating_oil(h: Hydraulics, moment: Moment, memory: Nothing, p: Any, own: Pulsation) -> Hydraulics:
    """P_s <- P_s + pulsation."""
    return changed(h, SUPPLY_PRESSURE, h.supply_pressure + pulsation(moment, own))


@equation
def pulsating_air(air: Pneumatics, moment: Moment, memory: Nothing, p: Any, own: Pulsation) -> Pneumatics:
    """P_s <- P_s + pulsation."""
    return changed(air, SUPPLY_PRESSURE_OF_AIR, air.supply_pressure + pulsation(moment, own))


SUPPLY_RIPPLE = Effect(
    name="supply_ripple",
    balance="flow",
    words="the supply pressure pulsates",
    source="Merritt 1967",
    numbers={
        "ripple_cosine": Number(-0.3, 0.3, 0.003, pressure),
        "ripple_sine": Number(-0.3, 0.3, 0.003, pressure),
        "ripple_frequency": Number(
            1e-5, 0.5, 0.0, sampling, grid=(0.0003, 0.001, 0.003, 0.01, 0.03, 0.1), frequency_of="time"
        ),
    },
    needs=(COMMAND,),
    requires=("spool_position",),
    Own=Pulsation,
    parameters={"hydraulics": pulsating_oil, "pneumatics": pulsating_air},
)
