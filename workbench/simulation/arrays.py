"""Equations of others that run on numbers and not on arrays, such as one with an `if`: whose they are, in words."""

import traceback
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from types import TracebackType

from plants.effects.registry import EFFECTS
from plants.equation import Equation
from plants.interface import Plant
from plants.laws.registry import LAWS
from plants.plugins import reason_of
from plants.registry import PLANTS
from workbench.errors import UserError

AMBIGUOUS = "truth value of an array"
"""What NumPy says of an array in the place of a condition."""


@contextmanager
def arrays_told(plant: Plant) -> Iterator[None]:
    """Around a plant's equations on arrays: what is its author's mistake is one line, the rest in the traceback.

    Raises:
        UserError: the law, effect or plant, the place, and what to do.
    """
    try:
        yield
    except Exception as error:
        owner = owner_of(plant, error.__traceback__)
        if not owner and AMBIGUOUS not in str(error):
            raise
        last = traceback.extract_tb(error.__traceback__)[-1]
        reason = reason_of(error)
        if AMBIGUOUS in str(error):
            reason = 'in place of a condition ("if", "and", "max") use select(condition, a, b) or np.where'
        place = f'"{last.name}" ({Path(last.filename).name}, line {last.lineno})'
        raise UserError(
            f"{owner or PLANTS.called(plant.name)}: {place} takes no arrays; {reason} (--debug shows all of it)"
        ) from error


def owner_of(plant: Plant, trace: TracebackType | None) -> str:
    """Whose equation failed: the plug-in's law or effect, the innermost, as messages call it; "" if neither."""
    laws = {name: (law.friction, law.steady) for name, law in LAWS.working().items() if law.name == plant.friction}
    effects = {name: item.equations for name, item in EFFECTS.working().items() if item.name in plant.effects}
    codes = {
        _code(function): registry.called(name)
        for registry, owned in ((LAWS, laws), (EFFECTS, effects))
        for name, functions in owned.items()
        if name not in registry.ours
        for function in functions
    }
    owners = [codes[frame.f_code] for frame, _ in traceback.walk_tb(trace) if frame.f_code in codes]
    return owners[-1] if owners else ""


def _code(function: Equation) -> object:
    return getattr(function, "__code__", function)
