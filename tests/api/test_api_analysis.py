"""Linear analysis from Python: equilibria of every cylinder, and margins that are python-control's."""

import warnings

import control
import numpy as np
import pytest
from short_loop import small

import workbench as wb
from plants.equation import fields, members
from plants.registry import plants

SET_OF = {"hydraulics": "owen2001_simulation", "pneumatics": "guenther2006"}
"""Of a cylinder that a valve feeds."""

FED = [
    (name, SET_OF[fluid]) for name, plant in plants().items() for fluid in SET_OF if fluid in members(plant.Parameters)
]


@pytest.mark.parametrize(("name", "parameters"), FED)
def test_the_rod_at_rest_is_an_equilibrium_of_every_cylinder_with_a_valve(name: str, parameters: str) -> None:
    rpm = {"rpm": 120} if plants()[name].rotary_command else {}
    rotation = {"plant": {"rotation": "ideal"}} if name.endswith("ideal") else {}
    gain = 500 if parameters == "owen2001_simulation" else 10
    loop = wb.setup(name, parameters, controller=wb.pid(kp=gain), **rpm, **rotation)
    model = wb.linearise(loop, outputs=["position", "axial_friction"])
    assert model.state_labels == [item.name for item in fields(loop.plant.State)]
    assert wb.linearise(loop, speed="20 mm/s").nstates == model.nstates


def test_a_point_that_is_no_equilibrium_is_told() -> None:
    loop = small()
    rest, holding = loop.plant.equilibrium(loop.parameters, 0.0)
    with pytest.raises(wb.UserError, match="no equilibrium of non_rotating: velocity changes at"):
        wb.linearise(loop, state=rest._replace(load_pressure=1e6))
    with pytest.raises(wb.UserError, match="spool_position changes at"):
        wb.linearise(loop, state=rest, inputs=holding._replace(valve_voltage=1.0))
    with pytest.raises(wb.UserError, match="got a speed and a point"):
        wb.linearise(loop, state=rest, speed=0.01)
    with pytest.raises(wb.UserError, match=r"speed: got \"3 mm\", expected a quantity in m/s"):
        wb.linearise(loop, speed="3 mm")


def test_margins_are_those_of_python_control() -> None:
    loop = small(controller=wb.pid(kp=2000))
    margins, gain = wb.margins(loop, speed="30 mm/s"), wb.loop_gain(loop, speed=0.03)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # that it interpolates
        factor, phase, *_ = control.margin(gain)
    assert margins.stable
    assert margins.gain_dB == pytest.approx(20.0 * np.log10(factor), abs=1e-3)
    assert margins.phase_deg == pytest.approx(phase, abs=1e-3)
