"""What nobody understands over two signals at once: the force that a plant lacks, over position and velocity.

As a curve (plants/effects/curves.py): a switch, ranges and values in the unit and with the sign of the balance's
residual. Between its nodes it is bilinear, beyond them constant: continuous, with kinks at the nodes, and nowhere
beyond them. No diagnosis offers one, since what a record shows of two signals lies along its motion alone.
"""

from typing import Annotated, Any

import numpy as np

from plants.effects.interface import DISTURBANCE, FREE, Effect, Moment, Number
from plants.effects.scales import Scales, force, travel
from plants.equation import Scalar, equation, named_tuple, select
from plants.laws.interface import Nothing

SIDE = 6
"""Nodes along either signal."""

NAME = "motion_force_map"

NODES = tuple(f"{NAME}_{i}{j}" for i in range(1, SIDE + 1) for j in range(1, SIDE + 1))
"""The names of the values: row i of the position, column j of the velocity."""


@equation
def surface(first: Scalar, second: Scalar, own: Any) -> Scalar:
    """The value of a map (share, low, high, low, high, y_11, y_12 ... y_66) at two signals.

    sum_ij y_ij h(r - i) h(c - j),  h(s) = max(1 - |s|, 0), with r and c the places of the signals among the nodes. A
    range without width has the width of 1 in each interval.
    """
    over = select(own[2] > own[1], (own[2] - own[1]) / (SIDE - 1), 1.0)
    across = select(own[4] > own[3], (own[4] - own[3]) / (SIDE - 1), 1.0)
    row = np.minimum(np.maximum((first - own[1]) / over, 0.0), SIDE - 1.0)
    column = np.minimum(np.maximum((second - own[3]) / across, 0.0), SIDE - 1.0)
    value = 0.0 * own[5]
    for i in range(SIDE):
        for j in range(SIDE):
            weight = np.maximum(1.0 - np.abs(row - i), 0.0) * np.maximum(1.0 - np.abs(column - j), 0.0)
            value = value + weight * own[5 + SIDE * i + j]
    return value


@equation
def lacking(disturbance: Scalar, moment: Moment, memory: Nothing, p: Any, own: Any) -> Scalar:
    """The force on the mass, off the disturbance that acts against it (N)."""
    return disturbance - own[0] * surface(moment.position, moment.velocity, own)


def speed(scales: Scales) -> float:
    """m/s."""
    return scales.speed


_POSITIONS, _VELOCITIES = ([f"{NAME}_{signal}_{end}" for end in ("low", "high")] for signal in ("position", "velocity"))

_UNITS = {
    f"{NAME}_share": "1",
    **dict.fromkeys(_POSITIONS, "m"),
    **dict.fromkeys(_VELOCITIES, "m/s"),
    **dict.fromkeys(NODES, "N"),
}

_members: dict[str, Any] = {name: Annotated[float, unit] for name, unit in _UNITS.items()}

FORCE_MAP = Effect(
    name=NAME,
    balance="force",
    words="not understood: what the force balance lacks, over the position and the velocity",
    source="bilinear interpolation",
    numbers={
        f"{NAME}_share": Number(0.0, 1.0, 1.0),
        **dict.fromkeys(_POSITIONS, Number(-FREE, FREE, 1.0, travel)),
        **dict.fromkeys(_VELOCITIES, Number(-FREE, FREE, 1.0, speed)),
        **dict.fromkeys(NODES, Number(-FREE, FREE, 0.02, force)),
    },
    sought=False,
    Own=named_tuple(
        "MotionForceMap",
        __name__,
        _members,
        {name: 1.0 if name.endswith("_high") else 0.0 for name in _UNITS},
        f"Share that acts (0: off), both ranges, and {SIDE} x {SIDE} values at even places over them.",
    ),
    inputs={DISTURBANCE: lacking},
)
