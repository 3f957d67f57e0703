"""Effects on what the valve's opening lets through: its overlap, and the curve of its flow gain."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.interface import COMMAND, Effect, Moment, Number
from plants.effects.scales import spool
from plants.equation import Scalar, changed, equation, select
from plants.hydraulics import Hydraulics, valve_opening
from plants.laws.interface import Nothing
from plants.pneumatics import Pneumatics

FLOW_GAIN = Hydraulics._fields.index("valve_flow_gain")
CONDUCTANCE = Pneumatics._fields.index("sonic_conductance")

VALVE_DEADBAND = Effect(
    name="valve_deadband",
    balance="flow",
    words="the spool has to move by its overlap before anything flows",
    source="Merritt 1967",
    numbers={
        "valve_overlap": Number(0.0, 0.33, 0.0033, spool),
        "valve_overlap_negative": Number(0.0, 0.33, 0.0033, spool),
    },
    apart=(("valve_overlap",), ("valve_overlap", "valve_overlap_negative")),
    needs=(COMMAND,),
)
"""Of both directions, or of each its own. A valve's hysteresis looks alike where the command goes one way only; it
stays where the command is large, and a dead band does not. Proportional valves have overlaps of up to a third of the
travel, servo valves of a few per cent (Jelali and Kroll 2003).
"""


# --- the gain over the opening --------------------------------------------------------------------------------


class Curve(NamedTuple):
    """By which share of itself the flow gain is larger at full opening than at a small one."""

    valve_gain_curvature: Annotated[float, "1"] = 0.0


@equation
def bent(own: Curve, moment: Moment, valve: Any) -> Scalar:
    """1 + c |x_o| / x_max (1), x_o (m) the opening: the flow goes with x_o (1 + c |x_o| / x_max).

    Ports that are no slots of one width (Merritt 1967): round holes and notches have a gain that changes with the
    opening. Looks like a flow gain that differs between slow and fast motion; a supply pressure that falls looks alike
    where the opening is large, but goes with the flow and not with the opening.
    """
    return 1.0 + own.valve_gain_curvature * np.abs(valve_opening(moment.spool_position, valve)) / valve.spool_limit


@equation
def bent_oil(h: Hydraulics, moment: Moment, memory: Nothing, p: Any, own: Curve) -> Hydraulics:
    """K <- K (1 + c |x_o| / x_max)."""
    return changed(h, FLOW_GAIN, h.valve_flow_gain * bent(own, moment, h))


@equation
def bent_air(air: Pneumatics, moment: Moment, memory: Nothing, p: Any, own: Curve) -> Pneumatics:
    """The same of the sonic conductance."""
    return changed(air, CONDUCTANCE, air.sonic_conductance * bent(own, moment, air))


VALVE_GAIN_CURVE = Effect(
    name="valve_gain_curve",
    balance="flow",
    words="the valve's gain changes with its opening",
    source="Merritt 1967",
    numbers={"valve_gain_curvature": Number(-0.5, 10.0, 0.05)},
    needs=(COMMAND,),
    requires=("spool_position",),
    Own=Curve,
    parameters={"hydraulics": bent_oil, "pneumatics": bent_air},
)
"""Below -1/2 more opening would let less through; at 10 the flow goes nearly with the square of the opening."""


# --- the gain of either direction -----------------------------------------------------------------------------


class Ratio(NamedTuple):
    """The flow gain of negative openings over that of positive ones."""

    valve_gain_ratio: Annotated[float, "1"] = 1.0


@equation
def one_sided(own: Ratio, moment: Moment) -> Scalar:
    """r for x_s < 0, else 1.

    Edges that are not ground alike (Jelali and Kroll 2003). Looks like a flow gain that differs with the direction;
    areas that differ look alike, but only the pressures of both chambers tell, as does a spool whose zero is off.
    """
    return select(moment.spool_position < 0.0, own.valve_gain_ratio, 1.0)


@equation
def one_sided_oil(h: Hydraulics, moment: Moment, memory: Nothing, p: Any, own: Ratio) -> Hydraulics:
    """K <- r K for x_s < 0."""
    return changed(h, FLOW_GAIN, h.valve_flow_gain * one_sided(own, moment))


@equation
def one_sided_air(air: Pneumatics, moment: Moment, memory: Nothing, p: Any, own: Ratio) -> Pneumatics:
    """The same of the sonic conductance."""
    return changed(air, CONDUCTANCE, air.sonic_conductance * one_sided(own, moment))


VALVE_GAIN_ASYMMETRY = Effect(
    name="valve_gain_asymmetry",
    balance="flow",
    words="the valve's gain differs between the two directions",
    source="Jelali and Kroll 2003",
    numbers={"valve_gain_ratio": Number(0.3, 3.0, 0.02)},
    needs=(COMMAND,),
    requires=("spool_position",),
    Own=Ratio,
    parameters={"hydraulics": one_sided_oil, "pneumatics": one_sided_air},
)
