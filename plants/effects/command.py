"""The command that comes late."""

from typing import Annotated, Any, NamedTuple

from plants.effects.interface import COMMAND, Effect, Moment, Number
from plants.effects.lags import followed_rate, lagged
from plants.equation import Scalar, equation, select


class Delay(NamedTuple):
    """By how much the command comes late."""

    command_delay: Annotated[float, "s"] = 0.0


class Delayed(NamedTuple):
    """The command as it arrives, in its unit."""

    delayed_command: Annotated[float, "1", 1.0] = 0.0


@equation
def late(command: Scalar, moment: Moment, memory: Delayed, p: Any, own: Delay) -> Scalar:
    """The command as it arrives."""
    return lagged(command, memory.delayed_command, own.command_delay)


@equation
def arriving(slip: Scalar, command: Scalar, moment: Moment, memory: Delayed, p: Any, own: Delay) -> Delayed:
    """d u_d/dt = (u - u_d)/T: a lag of first order in the place of the delay T."""
    rate = followed_rate(command, memory.delayed_command, own.command_delay)
    return Delayed(select(own.command_delay > 0.0, rate, 0.0))


COMMAND_DELAY = Effect(
    name="command_delay",
    balance="valve",
    words="the valve gets its command late",
    source="converters and networks",
    numbers={"command_delay": Number(0.0, 0.1, 0.001)},
    needs=(COMMAND,),
    Own=Delay,
    Memory=Delayed,
    inputs={COMMAND: late},
    remember=arriving,
    at_rest=Delayed,
)
"""Of a sample of a fast controller up to several cycles of a slow field bus."""
