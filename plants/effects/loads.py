"""Effects that add a force to the mass: it acts as a disturbance does, against the motion."""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.interface import DISTURBANCE, Effect, Moment, Number, Scales
from plants.equation import Scalar, equation
from plants.laws.interface import Nothing


def force(scales: Scales) -> float:
    """N."""
    return scales.force


CONSTANT_LOAD = Effect(
    name="constant_load",
    balance="force",
    words="a constant force acts on the rod",
    source="thesis (3.29)",
    numbers={"load_force": Number(-200.0, 200.0, 0.02, force)},
)


# --- over the velocity ----------------------------------------------------------------------------------------


class Drag(NamedTuple):
    """Resistance a squared velocity."""

    drag_coefficient: Annotated[float, "N s^2/m^2"] = 0.0


@equation
def drag(disturbance: Scalar, moment: Moment, memory: Nothing, p: Any, own: Drag) -> Scalar:
    """c v |v| (N).

    Turbulent flow through ports and lines (Merritt 1967). Looks like resistance that bends upward at speed; a Stribeck
    velocity that is off looks alike at low speed.
    """
    return disturbance + own.drag_coefficient * moment.velocity * np.abs(moment.velocity)


def force_by_speed_squared(scales: Scales) -> float:
    """N s^2/m^2."""
    return scales.force / scales.speed**2


QUADRATIC_DRAG = Effect(
    name="quadratic_drag",
    balance="force",
    words="a resistance grows with the square of the velocity",
    source="Merritt 1967",
    numbers={"drag_coefficient": Number(0.0, 200.0, 0.02, force_by_speed_squared)},
    Own=Drag,
    inputs={DISTURBANCE: drag},
)


# --- over the position ----------------------------------------------------------------------------------------


class Spring(NamedTuple):
    """Force a position."""

    spring_stiffness: Annotated[float, "N/m"] = 0.0


@equation
def spring(disturbance: Scalar, moment: Moment, memory: Nothing, p: Any, own: Spring) -> Scalar:
    """k x (N), x (m) from mid-stroke.

    What bends as it moves, such as hoses or a cable. Looks like a force in step with the position.
    """
    return disturbance + own.spring_stiffness * moment.position


def force_by_travel(scales: Scales) -> float:
    """N/m."""
    return scales.force / scales.travel


SPRING_LOAD = Effect(
    name="spring_load",
    balance="force",
    words="a force grows with the position, as of a hose or cable that bends",
    source="hoses and cables",
    numbers={"spring_stiffness": Number(-1000.0, 1000.0, 0.1, force_by_travel)},
    needs=("position",),
    Own=Spring,
    inputs={DISTURBANCE: spring},
)


# --- over the angle -------------------------------------------------------------------------------------------


class Ripple(NamedTuple):
    """Amplitudes of a force over the rod's angle."""

    cosine_force: Annotated[float, "N"] = 0.0
    sine_force: Annotated[float, "N"] = 0.0


class Angle(NamedTuple):
    """How far the rod has turned."""

    rotation_angle: Annotated[float, "rad", 1.0] = 0.0


@equation
def ripple(disturbance: Scalar, moment: Moment, memory: Angle, p: Any, own: Ripple) -> Scalar:
    """A cos(theta) + B sin(theta) (N).

    A bent rod, a coupling off its axis. Looks like a ripple with the angle theta (rad).
    """
    angle = memory.rotation_angle
    return disturbance + own.cosine_force * np.cos(angle) + own.sine_force * np.sin(angle)


@equation
def turning(slip: Scalar, command: Scalar, moment: Moment, memory: Angle, p: Any, own: Ripple) -> Angle:
    """d theta/dt = omega (rad/s)."""
    return Angle(moment.rotation_speed)


ROTATION_PERIODIC_FORCE = Effect(
    name="rotation_periodic_force",
    balance="force",
    words="a force repeats with every turn of the rod",
    source="a bent rod",
    numbers={"cosine_force": Number(-200.0, 200.0, 0.01, force), "sine_force": Number(-200.0, 200.0, 0.01, force)},
    needs=("rotation_angle",),
    Own=Ripple,
    Memory=Angle,
    inputs={DISTURBANCE: ripple},
    remember=turning,
)
