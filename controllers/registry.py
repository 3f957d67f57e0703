"""The position controllers by name: ours, and those that other packages bring by entry point."""

from importlib.metadata import entry_points

from controllers.compensation import ESTIMATORS, compensator
from controllers.disturbance_observer import DISTURBANCE_OBSERVER
from controllers.dither import DITHER
from controllers.interface import Controller
from controllers.nonlinear_pi import NONLINEAR_PI
from controllers.open_loop import OPEN_LOOP
from controllers.pid import PID

ENTRY_POINT_GROUP = "friction_workbench.controllers"

_BUILT_IN = (PID, *(compensator(name) for name in ESTIMATORS), NONLINEAR_PI, DITHER, DISTURBANCE_OBSERVER, OPEN_LOOP)


def controllers() -> dict[str, Controller]:
    """All position controllers by name, in a fixed order: ours first."""
    known = {controller.name: controller for controller in _BUILT_IN}
    for point in sorted(entry_points(group=ENTRY_POINT_GROUP), key=lambda point: point.name):
        known[point.name] = point.load()
    return known
