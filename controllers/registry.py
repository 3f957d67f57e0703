"""The position controllers by name: ours, and those that other packages bring by entry point."""

from collections.abc import Mapping

from controllers.compensation import offered
from controllers.disturbance_observer import DISTURBANCE_OBSERVER
from controllers.dither import DITHER
from controllers.ekf_compensation import ekf_compensator
from controllers.estimators import ESTIMATORS
from controllers.interface import Controller
from controllers.nonlinear_pi import NONLINEAR_PI
from controllers.open_loop import OPEN_LOOP
from controllers.pid import PID
from controllers.relay import RELAY
from controllers.settings import settings_of
from plants.plugins import Registry

_OURS = (
    PID,
    *(offered(name) for name in ESTIMATORS),
    ekf_compensator(),
    NONLINEAR_PI,
    DITHER,
    DISTURBANCE_OBSERVER,
    RELAY,
    OPEN_LOOP,
)


def _check(controller: Controller) -> None:
    settings_of(controller.Settings)


CONTROLLERS = Registry("friction_workbench.controllers", Controller, {item.name: item for item in _OURS}, _check)


def controllers() -> Mapping[str, Controller]:
    """All position controllers by name; ours first."""
    return CONTROLLERS.working()
