"""The slow part of a plant, two poles from its command to its position, of the linearised plant as it slides.

Of a valve's actuator these are the integrator and the valve's lag, of a drive its mass and friction's slope.
"""

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from controllers.open_loop import OPEN_LOOP
from controllers.pid import PID
from controllers.pid import Settings as PidSettings
from plants.equation import fields
from plants.interface import Plant
from workbench.errors import UserError
from workbench.linear.linearise import jacobians
from workbench.linear.operating_point import slide, without_end_stops
from workbench.simulation.setup import Loop, Numbers, Setup

RADIUS = 0.1
"""rad/s. Of the circle on which 1/G is sampled: far below all that moves a rod, far above rounding."""

CIRCLE = 16
TRIED_FREQUENCIES = (30.0, 100.0, 200.0, 300.0)
"""rad/s. Crossovers of the makeshift loops that are tried to make the rod slide."""


@dataclass(frozen=True)
class SlowModel:
    """d2x/dt2 + a1 dx/dt + a0 x = b u: position x (m), command u; a1 in 1/s, a0 in 1/s^2, b in m/s^2 per command."""

    a0: float
    a1: float
    b: float

    def matrices(self) -> tuple[np.ndarray, np.ndarray]:
        """A and B over the states position and velocity."""
        return np.array([[0.0, 1.0], [-self.a0, -self.a1]]), np.array([[0.0], [self.b]])


def slow_model(setup: Setup, speed: float) -> SlowModel:
    """The two-pole model of the plant of `setup` about a slide at `speed` (m/s).

        1/G(s) = (a0 + a1 s + s^2) / b + O(s^3)

    G is the exact linearisation; its reciprocal is expanded at s = 0, so that the model is right at low frequency, and
    each faster lag counts with its time constant in a1 (the rule of the sum of small time constants). Do not use it
    near the slowest pole that it leaves out.

    The rod slides under the loop of `setup` where that can do it, else under a makeshift PD.

    Raises:
        UserError: no loop that was tried makes the rod slide steadily, or its command does not move it.
    """
    setup = without_end_stops(setup)
    for loop in _loops(setup, speed):
        point = slide(replace(setup, loop=loop), speed)
        if not point.trouble:
            return _two_poles(setup.plant, setup.parameters, point.state, point.inputs)
    raise UserError(
        f"plant {setup.plant.name} does not slide steadily at {speed:g} {setup.plant.axis}/s under any loop "
        "that was tried; take another speed, or give the setup a controller with which it slides"
    )


def _loops(setup: Setup, speed: float) -> Iterator[Loop]:
    """The setup's own, then PD loops whose gain is 1, and whose lead 45 degrees, at some frequency about a guess."""
    if setup.loop.controller is not OPEN_LOOP:
        yield setup.loop
    guess = setup.state._replace(velocity=speed)
    for frequency in TRIED_FREQUENCIES:
        gain = abs(_response(setup.plant, setup.parameters, guess, setup.inputs, np.array([1j * frequency]))[0])
        if gain > 0.0:
            kp = float(np.sqrt(0.5) / gain)
            settings = PidSettings(kp=kp, kd=kp / frequency)
            yield Loop(PID, PID.design(settings, setup.parameters, setup.sample_time))


def _response(plant: Plant, parameters: Numbers, state: Numbers, inputs: Numbers, s: np.ndarray) -> np.ndarray:
    """G(s) from the command to the position, in continuous time; shape of `s` (1-D, rad/s)."""
    a, b = jacobians(plant, parameters, state, inputs)
    names, scales = ([getattr(item, key) for item in fields(plant.State)] for key in ("name", "scale"))
    scaled = a * np.array(scales) / np.array(scales)[:, None]
    drive = b[:, [plant.input_index(plant.command)]] / np.array(scales)[:, None]
    position = names.index("position")
    solved = np.linalg.solve(s[:, None, None] * np.eye(len(a)) - scaled, drive[None])
    return np.asarray(solved[:, position, 0] * scales[position])


def _two_poles(plant: Plant, parameters: Numbers, state: Numbers, inputs: Numbers) -> SlowModel:
    """The model by the first three coefficients of 1/G at 0, which are means over a circle about it (Cauchy)."""
    circle = np.exp(2j * np.pi * np.arange(CIRCLE) / CIRCLE)
    response = _response(plant, parameters, state, inputs, RADIUS * circle)
    if not np.all(np.abs(response) > 0.0):
        raise UserError(f"plant {plant.name}: its command {plant.command} does not move it at this operating point")
    c0, c1, c2 = (float(np.mean(circle**-k / response).real) / RADIUS**k for k in range(3))
    return SlowModel(c0 / c2, c1 / c2, 1.0 / c2)
