"""The position controllers by name: ours, and those that other packages bring by entry point."""

from controllers.compensation import ESTIMATORS, compensator
from controllers.disturbance_observer import DISTURBANCE_OBSERVER
from controllers.dither import DITHER
from controllers.ekf_compensation import ekf_compensator
from controllers.interface import Controller
from controllers.nonlinear_pi import NONLINEAR_PI
from controllers.open_loop import OPEN_LOOP
from controllers.pid import PID
from plants.plugins import plugins

ENTRY_POINT_GROUP = "friction_workbench.controllers"

_BUILT_IN = (
    PID,
    *(compensator(name) for name in ESTIMATORS),
    ekf_compensator(),
    NONLINEAR_PI,
    DITHER,
    DISTURBANCE_OBSERVER,
    OPEN_LOOP,
)


def controllers() -> dict[str, Controller]:
    """All position controllers by name; ours first, and no other package can take their names."""
    ours = {controller.name: controller for controller in _BUILT_IN}
    return {**ours, **plugins(ENTRY_POINT_GROUP), **ours}
