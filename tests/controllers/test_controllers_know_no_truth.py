"""Controllers follow from their sensors alone, and what the compiled loop carries for them is plain numbers."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from position_loops import BELIEF, H, loop, replayed

from controllers import disturbance_observer, dither, nonlinear_pi
from controllers.disturbance_observer import DISTURBANCE_OBSERVER
from controllers.dither import DITHER
from controllers.interface import Controller, Reference
from controllers.nonlinear_pi import NONLINEAR_PI
from controllers.rotation_on_demand import SCHEDULED_ROTATION, SWITCHED_ROTATION
from plants.equation import to_array
from plants.interface import Measurement
from workbench.simulation.references import Sine
from workbench.simulation.sensors import Channel, Sensors
from workbench.simulation.simulate import simulate


@pytest.mark.parametrize(
    ("controller", "settings"),
    [
        (NONLINEAR_PI, nonlinear_pi.Settings(feedforward=1.0)),
        (DITHER, dither.Settings(ki=1000.0)),
        (DISTURBANCE_OBSERVER, disturbance_observer.Settings()),
    ],
    ids=["nonlinear_pi", "dither", "disturbance_observer"],
)
def test_commands_follow_from_the_position_sensor_alone(controller: Controller, settings: Any) -> None:
    """Truth is not what is believed: valve 0.8 times, friction 1.3 times, noise on every sensor.

    The commands of the run come again from the record of its sensors, with pressures and speed of rotation blotted out
    (NaN); and the plant's truth did matter: a plant as believed gives others.
    """
    wrong = loop(controller, settings, Sine(20e-3, 0.5), 0.5, valve_flow_gain=0.8 * 5.9e-4)
    friction = wrong.parameters.friction
    both = (one._replace(coulomb=1.3 * one.coulomb, stribeck=1.3 * one.stribeck) for one in friction)
    wrong = replace(
        wrong,
        parameters=wrong.parameters._replace(friction=type(friction)(*both)),
        sensors=Sensors({"position": Channel(2e-6, 1e-6), "pressure_1": Channel(1e4), "pressure_2": Channel(1e4)}),
    )
    run = simulate(wrong)
    assert run.reference is not None
    blotted = run.measurements.copy()
    blotted[:, 1:] = np.nan
    first = Measurement(0.0, np.nan, np.nan, np.nan)
    commands = replayed(wrong.loop, first, blotted, np.column_stack(run.reference), run.command)
    assert np.clip(commands, -10.0, 10.0) == pytest.approx(run.command, rel=1e-9, abs=1e-9)
    believed = simulate(replace(wrong, parameters=loop(controller, settings, Sine(20e-3, 0.5), 0.5).parameters))
    assert np.max(np.abs(believed.command - run.command)) > 0.05


def test_states_and_gains_are_plain_numbers() -> None:
    """What the compiled loop carries: vectors of finite numbers, the same length at every sample."""
    for controller in (
        NONLINEAR_PI,
        DITHER,
        DISTURBANCE_OBSERVER,
        *SCHEDULED_ROTATION.values(),
        *SWITCHED_ROTATION.values(),
    ):
        gains = controller.design(controller.Settings(), BELIEF, H)
        measured = Measurement(1e-3, 1e6, 1e6, 5.0, 1.0)
        state = controller.start(measured, gains)
        command, following = controller.step(Reference(2e-3, 0.0, 0.0), measured, state, gains, H)
        for value in (gains, state, following, controller.commit(command, following, gains, H)):
            assert np.all(np.isfinite(to_array(value)))
        assert to_array(following).size == to_array(state).size
