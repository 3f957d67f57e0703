"""Effects that add a force to the mass: it acts as a disturbance does, against the motion.

A load beyond what drives the machine would not be moved: that bounds them.
"""

from typing import Annotated, Any, NamedTuple

import numpy as np

from plants.effects.interface import DISTURBANCE, Effect, Moment, Number
from plants.effects.scales import PITCHES, drive, drive_by_speed_squared, drive_by_travel, pitch, travel
from plants.effects.waves import wave
from plants.equation import Scalar, equation, select
from plants.laws.interface import Nothing

CONSTANT_LOAD = Effect(
    name="constant_load",
    balance="force",
    words="a constant force acts on the rod",
    source="thesis (3.29)",
    numbers={"load_force": Number(-1.0, 1.0, 0.005, drive)},
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


QUADRATIC_DRAG = Effect(
    name="quadratic_drag",
    balance="force",
    words="a resistance grows with the square of the velocity",
    source="Merritt 1967",
    numbers={"drag_coefficient": Number(0.0, 1.0, 0.005, drive_by_speed_squared)},
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


SPRING_LOAD = Effect(
    name="spring_load",
    balance="force",
    words="a force grows with the position, as of a hose or cable that bends",
    source="hoses and cables",
    numbers={"spring_stiffness": Number(-10.0, 10.0, 0.02, drive_by_travel)},
    needs=("position",),
    Own=Spring,
    inputs={DISTURBANCE: spring},
)


class Cogging(NamedTuple):
    """Amplitudes of a force over the position, and the way after which it repeats."""

    cogging_cosine: Annotated[float, "N"] = 0.0
    cogging_sine: Annotated[float, "N"] = 0.0
    cogging_pitch: Annotated[float, "m"] = 0.01


@equation
def cogging(disturbance: Scalar, moment: Moment, memory: Nothing, p: Any, own: Cogging) -> Scalar:
    """a cos(2 pi x / p) + b sin(2 pi x / p) (N).

    Magnets over slots, teeth, balls of a screw (Otten, de Vries, van Amerongen, Rankers and Gaal 1997). Looks like a
    force that ripples with the position, whatever the direction; friction along the stroke changes its sign with it.
    """
    angle = 2.0 * np.pi * moment.position / own.cogging_pitch
    return disturbance + wave(own.cogging_cosine, own.cogging_sine, angle)


COGGING = Effect(
    name="cogging",
    balance="force",
    words="a force repeats along the way, as of magnets or teeth",
    source="Otten et al. 1997",
    numbers={
        "cogging_cosine": Number(-0.5, 0.5, 0.0025, drive),
        "cogging_sine": Number(-0.5, 0.5, 0.0025, drive),
        "cogging_pitch": Number(0.001, 2.0, 0.0, pitch, grid=PITCHES, period_of="position"),
    },
    needs=("position",),
    Own=Cogging,
    inputs={DISTURBANCE: cogging},
)


class Cushion(NamedTuple):
    """A spring from a place on, beside the end stops: a positive start pushes back beyond it, a negative one below."""

    cushion_stiffness: Annotated[float, "N/m"] = 0.0
    cushion_start: Annotated[float, "m"] = 0.02


@equation
def cushion(disturbance: Scalar, moment: Moment, memory: Nothing, p: Any, own: Cushion) -> Scalar:
    """k max(x - x_c, 0) for a start x_c >= 0, else k min(x - x_c, 0) (N), x (m) from mid-stroke.

    What is met before the stroke ends: a buffer, a cushion, a hose that tightens. Looks like a force at one end of the
    way alone; a spring load acts over the whole way, friction along the stroke changes its sign with the velocity.
    """
    way = moment.position - own.cushion_start
    return disturbance + own.cushion_stiffness * select(
        own.cushion_start >= 0.0, np.maximum(way, 0.0), np.minimum(way, 0.0)
    )


CUSHION = Effect(
    name="cushion",
    balance="force",
    words="a spring is met towards one end of the way",
    source="buffers and hoses",
    numbers={
        "cushion_stiffness": Number(0.0, 100.0, 0.05, drive_by_travel),
        "cushion_start": Number(-0.5, 0.5, 0.0, travel, grid=(-0.4, -0.3, -0.2, -0.1, 0.0, 0.1, 0.2, 0.3, 0.4)),
    },
    needs=("position",),
    Own=Cushion,
    inputs={DISTURBANCE: cushion},
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
    return disturbance + wave(own.cosine_force, own.sine_force, memory.rotation_angle)


@equation
def turning(slip: Scalar, command: Scalar, moment: Moment, memory: Angle, p: Any, own: Ripple) -> Angle:
    """d theta/dt = omega (rad/s)."""
    return Angle(moment.rotation_speed)


ROTATION_PERIODIC_FORCE = Effect(
    name="rotation_periodic_force",
    balance="force",
    words="a force repeats with every turn of the rod",
    source="a bent rod",
    numbers={"cosine_force": Number(-1.0, 1.0, 0.0025, drive), "sine_force": Number(-1.0, 1.0, 0.0025, drive)},
    needs=("rotation_angle",),
    Own=Ripple,
    Memory=Angle,
    inputs={DISTURBANCE: ripple},
    remember=turning,
)
