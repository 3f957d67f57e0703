"""A plant with a friction gauge that no rig has: what would a perfect friction model be worth?

    plant = gauged(plant)          # its measurements carry the true axial friction, else the same plant

Nothing measures friction apart from the force that drives it. The gauge is an oracle for one question, asked for by a
study (`[sensors] friction_gauge = true`) and given to one controller, `friction_gauge`.
"""

import functools
from dataclasses import replace
from typing import Any

from plants.equation import equation, fields
from plants.interface import Measurement, Plant

SIGNAL = "axial_friction"
"""What the gauge reads."""


@functools.cache
def gauged(plant: Plant) -> Plant:
    """The plant with the gauge, whose reading is that of its inputs at 0.

    Raises:
        ValueError: a plant without that signal, or whose friction depends on an imposed speed.
    """
    names = [item.name for item in fields(plant.Signals)]
    if SIGNAL not in names:
        raise ValueError(f"a friction gauge needs a plant with the signal {SIGNAL}, and {plant.name} has none")
    if plant.rotary_command == "surface_speed":
        raise ValueError(f'{plant.name} has no friction gauge: its speed is imposed; take rotation = "servo"')
    bare, signals = plant.measure, plant.signals
    at_rest = plant.Inputs._make(0.0 for _ in fields(plant.Inputs))

    @equation
    def measure(state: Any, p: Any) -> Measurement:
        """What the plant measures, and the friction along the rod."""
        y = bare(state, p)
        friction = signals(0.0, state, at_rest, p).axial_friction
        return Measurement(y.position, y.pressure_1, y.pressure_2, y.rotation_speed, y.motor_current, friction)

    return replace(plant, measure=measure)
