"""Controllers by type: a function for each that is registered, those of other packages included."""

import inspect
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from controllers.estimators import ESTIMATORS
from controllers.interface import Controller
from controllers.registry import CONTROLLERS
from controllers.settings import ANY, Setting, usable
from workbench.api.plain import Quantity
from workbench.errors import UserError, nearest


@dataclass(frozen=True)
class ControllerChoice:
    """A controller by its type and settings: the table [controllers.TYPE] of a study.

    Its settings are checked where it is used, since only a plant says in which unit its command is. Gains are designed
    there too, on the belief.

    Example:
        >>> wb.pid(kp="500 V/m", ki=2000).table
        {'type': 'pid', 'kp': '500 V/m', 'ki': 2000}
    """

    type: str
    settings: Mapping[str, Quantity]

    @property
    def table(self) -> dict[str, object]:
        """As a study file holds it."""
        return {"type": self.type, **self.settings}


def controller(kind: str, /, **settings: Quantity) -> ControllerChoice:
    """Any registered controller, that of another package included.

    Args:
        kind: its type, as `workbench list controllers` shows them.
        settings: of that type; SI floats, text with a unit, or the name of a choice.

    Raises:
        UserError: no such type. Settings are checked where the controller is used.

    Example:
        >>> wb.controller("pid", kp=500) == wb.pid(kp=500)
        True
        >>> wb.controller("tafazoly")
        Traceback (most recent call last):
        workbench.errors.UserError: unknown controller "tafazoly"; did you mean "tafazoli"?
    """
    known, broken = CONTROLLERS.working(), CONTROLLERS.broken()
    if kind in broken:
        raise UserError(broken[kind])
    if kind not in known:
        raise UserError(f'unknown controller "{kind}"; {nearest(kind, known)}')
    return ControllerChoice(kind, settings)


def controller_functions() -> dict[str, Callable[..., ControllerChoice]]:
    """A function for each registered controller, by its type: `pid(kp=500)` is `controller("pid", kp=500)`."""
    return {name: _function(name, registered) for name, registered in CONTROLLERS.working().items()}


def _function(name: str, registered: Controller) -> Callable[..., ControllerChoice]:
    def choose(**settings: Quantity) -> ControllerChoice:
        return controller(name, **settings)

    parameters = [
        inspect.Parameter(
            item.name,
            inspect.Parameter.KEYWORD_ONLY,
            default=inspect.Parameter.empty if item.default is None else item.default,
            annotation=Quantity if item.unit else str,
        )
        for item in usable(registered).values()
    ]
    choose.__name__ = choose.__qualname__ = name
    choose.__doc__ = _documentation(name, registered)
    choose.__dict__["__signature__"] = inspect.Signature(parameters, return_annotation=ControllerChoice)
    return choose


def _documentation(name: str, registered: Controller) -> str:
    """What it computes, its settings, and an example."""
    settings = usable(registered).values()
    needed = ", ".join(f"{item.name}=500.0" for item in settings if item.default is None)
    meaning = registered.summary[:1].upper() + registered.summary[1:]
    return "\n".join(
        [
            f"{meaning}.",
            "",
            _equation(name, registered),
            "",
            *(["Args:", *(f"    {item.name}: {_setting(item)}" for item in settings), ""] if settings else []),
            "Raises:",
            "    UserError: where the controller is used: an unknown setting, one out of its range or in a wrong unit,",
            "        or a plant that lacks what its design asks for.",
            "",
            "Example:",
            f"    >>> wb.{name}({needed}).type",
            f"    '{name}'",
        ]
    )


def _equation(name: str, registered: Controller) -> str:
    """The documentation of the equation that makes it what it is: of its estimator, or else of its step."""
    estimate = ESTIMATORS[name].estimate if name in ESTIMATORS else None
    documented = (inspect.getdoc(function) for function in (estimate, registered.step, registered.design) if function)
    return next((text for text in documented if text), "")


def _setting(item: Setting) -> str:
    """What a setting means, with unit or choices, range and default."""
    choices = [choice for choice in item.choices if choice != ANY]
    parts = [
        item.about.meaning,
        item.unit if item.unit else " or ".join(f'"{choice}"' for choice in choices),
        item.about.short if item.unit else "",
        f"with {item.needs}" if item.needs is not None else "",
        "needed" if item.default is None else f"default {item.default!r}",
    ]
    return "; ".join(part for part in parts if part)
