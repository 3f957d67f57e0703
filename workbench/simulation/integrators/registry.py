"""The integration methods by name: ours, and those that other packages bring by entry point."""

from plants.plugins import Registry
from workbench.simulation.integrators.bogacki_shampine import BOGACKI_SHAMPINE
from workbench.simulation.integrators.dormand_prince import DORMAND_PRINCE
from workbench.simulation.integrators.fixed_step import EULER, HEUN, RK4
from workbench.simulation.integrators.interface import IntegrationMethod, check
from workbench.simulation.integrators.ros34pw2 import ROS34PW2

_OURS = (EULER, HEUN, RK4, DORMAND_PRINCE, BOGACKI_SHAMPINE, ROS34PW2)

INTEGRATORS = Registry(
    "friction_workbench.integrators", IntegrationMethod, {method.name: method for method in _OURS}, check
)
