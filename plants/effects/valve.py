"""What a spool does beyond gain and lag: its resonance and slew, its hysteresis, and what sticks.

Resonance and slew are given, not sought: a data sheet has them.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.interface import COMMAND, Effect, Moment, Number
from plants.effects.scales import voltage
from plants.equation import Scalar, equation, select

FOLLOWED = 1e-4
"""s. Time constant with which the memory follows what the hysteresis carries: play has no rate of its own."""

FADING = 0.05
"""Share of the slew below it over which what accelerates the spool fades: a sudden end would be a jump [assumed]."""


class Dynamics(NamedTuple):
    """A spool of second order in the place of a lag, where it has a natural frequency; and its largest speed (0: none).

    A data sheet's frequency at a phase of -90 degrees, for small amplitudes, is the natural frequency.
    """

    valve_natural_frequency: Annotated[float, "Hz"] = 0.0
    valve_damping_ratio: Annotated[float, "1"] = 0.7
    valve_slew: Annotated[float, "m/s"] = 0.0


class SpoolMotion(NamedTuple):
    """The spool's speed."""

    spool_velocity: Annotated[float, "m/s", 1e-2] = 0.0


@equation
def within_slew(rate: Scalar, own: Dynamics) -> Scalar:
    """A speed (m/s) of the spool within its slew."""
    return select(own.valve_slew > 0.0, np.minimum(np.maximum(rate, -own.valve_slew), own.valve_slew), rate)


@equation
def spool_speed(rate: Scalar, moment: Moment, memory: SpoolMotion, p: Any, own: Dynamics) -> Scalar:
    """dx_s/dt (m/s): the state of a valve of second order, else the lag's."""
    return within_slew(select(own.valve_natural_frequency > 0.0, memory.spool_velocity, rate), own)


@equation
def spool_acceleration(
    slip: Scalar, command: Scalar, moment: Moment, memory: SpoolMotion, p: Any, own: Dynamics
) -> SpoolMotion:
    """d2x_s/dt2 (m/s^2) = w^2 (K_sv V - x_s) - 2 D w dx_s/dt (Merritt 1967), fading to none towards the slew."""
    frequency = 2.0 * np.pi * own.valve_natural_frequency
    target = np.minimum(np.maximum(moment.spool_gain * command, -moment.spool_limit), moment.spool_limit)
    pushed = frequency**2 * (target - moment.spool_position)
    pushed = pushed - 2.0 * own.valve_damping_ratio * frequency * memory.spool_velocity
    layer = FADING * own.valve_slew
    short = select(layer > 0.0, own.valve_slew - np.sign(pushed) * memory.spool_velocity, 1.0)
    share = np.minimum(np.maximum(short / select(layer > 0.0, layer, 1.0), 0.0), 1.0)
    return SpoolMotion(share * pushed)


VALVE_DYNAMICS = Effect(
    name="valve_dynamics",
    balance="valve",
    words="the valve's spool swings and has a largest speed",
    source="Merritt 1967",
    numbers={
        "valve_natural_frequency": Number(0.0, 1000.0, 50.0),
        "valve_damping_ratio": Number(0.0, 5.0, 0.7),
        "valve_slew": Number(0.0, 10.0, 0.1),
    },
    needs=(COMMAND,),
    sought=False,
    Own=Dynamics,
    Memory=SpoolMotion,
    rates={"spool_position": spool_speed},
    remember=spool_acceleration,
)


class Play(NamedTuple):
    """By how much the command has to turn back before the spool does."""

    valve_hysteresis: Annotated[float, "V"] = 0.0


class Carried(NamedTuple):
    """The command that the spool follows."""

    carried_command: Annotated[float, "V", 1.0] = 0.0


@equation
def carried(command: Scalar, moment: Moment, memory: Carried, p: Any, own: Play) -> Scalar:
    """The command (V) behind the hysteresis: the value within half of it that is nearest to the one before."""
    return _nearest(command, memory, own)


@equation
def _nearest(command: Scalar, memory: Carried, own: Play) -> Scalar:
    half = 0.5 * own.valve_hysteresis
    return np.minimum(np.maximum(memory.carried_command, command - half), command + half)


@equation
def carrying(slip: Scalar, command: Scalar, moment: Moment, memory: Carried, p: Any, own: Play) -> Carried:
    """dV_h/dt (V/s): the nearest value within half the hysteresis of the command is followed with `FOLLOWED`.

    A play of that width (Visintin 1994): friction and magnetic remanence of the spool's drive. Looks like flow that
    goes on, or does not begin, while the command turns back; a dead band is about the middle alone, a delay goes with
    the command's rate.
    """
    rate = (_nearest(command, memory, own) - memory.carried_command) / FOLLOWED
    return Carried(select(own.valve_hysteresis > 0.0, rate, 0.0))


VALVE_HYSTERESIS = Effect(
    name="valve_hysteresis",
    balance="valve",
    words="the spool follows a command that turns back only beyond a play",
    source="Visintin 1994",
    numbers={"valve_hysteresis": Number(0.0, 0.2, 0.005, voltage)},
    needs=(COMMAND,),
    requires=("spool_position",),
    Own=Play,
    Memory=Carried,
    inputs={COMMAND: carried},
    remember=carrying,
    at_rest=Carried,
)
"""Data sheets state 0.2 % of the rated command for servo valves to 7 % for proportional ones without a spool sensor."""


# --- sticking -------------------------------------------------------------------------------------------------

RELEASE = 1e-4
"""s. Time constant with which a spool that has come free goes on, and one that has arrived sticks again: below the lag
of any valve [assumed]."""

STARTS = 1e-3
"""Share of the stiction beyond it over which a stuck spool comes free: a sudden start would be a jump [assumed]."""

ARRIVED = 0.02
"""Share of the stiction within which the spool has come to where it was to go, and sticks again [assumed]."""


class Stiction(NamedTuple):
    """By how much the command has to be away from where the spool sticks before that comes free."""

    spool_stiction: Annotated[float, "V"] = 0.0


class Stuck(NamedTuple):
    """Whether the spool goes: 0 stuck, 1 going."""

    spool_free: Annotated[float, "1", 1.0] = 0.0


@equation
def spool_away(command: Scalar, moment: Moment, own: Stiction) -> Scalar:
    """|K_sv V - x_s| (1) over K_sv times the stiction: how far a spool is from where it is to go."""
    target = np.minimum(np.maximum(moment.spool_gain * command, -moment.spool_limit), moment.spool_limit)
    band = moment.spool_gain * own.spool_stiction
    return np.abs(target - moment.spool_position) / select(band > 0.0, band, 1.0)


@equation
def stuck(command: Scalar, moment: Moment, memory: Stuck, p: Any, own: Stiction) -> Scalar:
    """x_s / K_sv + m (V - x_s / K_sv) (V), m = max(a, 2 r - 1), a 0 to 1 from the stiction to a little beyond it.

    The command that leaves a stuck spool where it is, and moves a free one as the valve does.
    """
    there = moment.spool_position / select(moment.spool_gain > 0.0, moment.spool_gain, 1.0)
    comes_free = np.minimum(np.maximum((spool_away(command, moment, own) - 1.0) / STARTS, 0.0), 1.0)
    moves = np.maximum(comes_free, 2.0 * memory.spool_free - 1.0)
    return select(own.spool_stiction > 0.0, there + moves * (command - there), command)


@equation
def sticking(slip: Scalar, command: Scalar, moment: Moment, memory: Stuck, p: Any, own: Stiction) -> Stuck:
    """dr/dt = (w - r)/T (1/s),  T = `RELEASE`, with the spool by d = |K_sv V - x_s| from where it is to go

        w = 1                                      where d > K_sv times the stiction
            1                                      where d > `ARRIVED` times that and r > 1/2: it goes on
            0                                      else: it sticks, or has arrived

    A spool that silt or a bent sleeve holds (Choudhury, Thornhill and Shah 2005): it stays until its command is far
    enough from where it is, then follows as the valve does, and sticks where it has arrived. Looks like flow in steps
    while the command moves slowly; hysteresis follows beyond its play, this jumps as far as its whole band.
    """
    away = spool_away(command, moment, own)
    goes_on = select(memory.spool_free > 0.5, ARRIVED, 1.0)
    wanted = select(away > goes_on, 1.0, 0.0)
    return Stuck(select(own.spool_stiction > 0.0, (wanted - memory.spool_free) / RELEASE, 0.0))


SPOOL_STICTION = Effect(
    name="spool_stiction",
    balance="valve",
    words="the spool sticks, and jumps when its command is far enough away",
    source="Choudhury, Thornhill and Shah 2005",
    numbers={"spool_stiction": Number(0.0, 0.2, 0.005, voltage)},
    needs=(COMMAND,),
    requires=("spool_position",),
    Own=Stiction,
    Memory=Stuck,
    inputs={COMMAND: stuck},
    remember=sticking,
)
