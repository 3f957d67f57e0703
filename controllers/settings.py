"""What a controller's settings say of themselves: unit or choices, meaning, admissible range, and when they count.

    kp: Annotated[float, "command/m", About("gain on the position error")] = 500.0
    velocity: Annotated[str, "filter", "kalman", About("how the velocity is had"), Needs("kd")] = "filter"

`About`, `Needs` and `Tuned` may be left out: nothing is then said of the meaning, every value is admitted, it always
counts, and it is tuned only in a range that a study gives.
"""

import functools
import typing
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from controllers.interface import Controller

ANY = "any"
"""In place of choices: any name will do."""


@dataclass(frozen=True)
class About:
    """A few words of meaning, and the range (SI) of a number: from `least` to `most`; `above`: not `least` itself."""

    meaning: str
    least: float = 0.0
    most: float = np.inf
    above: bool = False

    def admits(self, number: float) -> bool:
        """Whether `number` (SI) is in the range."""
        return (number > self.least if self.above else number >= self.least) and number <= self.most

    @property
    def short(self) -> str:
        """The range in signs, "" where every number will do."""
        if self.most < np.inf:
            return f"{self.least:g} to {self.most:g}"
        return f"{'>' if self.above else '>='} {self.least:g}" if self.least > -np.inf else ""

    @property
    def expected(self) -> str:
        """The range in words."""
        if self.most < np.inf:
            return f"a value between {self.least:g} and {self.most:g}"
        if self.above:
            return f"a value above {self.least:g}"
        return f"a value of at least {self.least:g}" if self.least else "a value that is not negative"


@dataclass(frozen=True)
class Tuned:
    """The range within which a number is tuned, in SI; `by_factor`: in factors of the number that a study sets.

    `logarithmic`: what is looked for is its order of magnitude. A study may give a range of its own.
    """

    low: float
    high: float
    by_factor: bool = False
    logarithmic: bool = True

    @property
    def short(self) -> str:
        """The range in words."""
        of = " times the study's" if self.by_factor else ""
        return f"tuned from {self.low:g} to {self.high:g}{of}"


DECADES = Tuned(0.1, 10.0, by_factor=True)
"""A tenth to ten times what a study sets: for gains whose unit, and size, are the plant's."""

SHARE = Tuned(0.0, 1.5, logarithmic=False)
"""From nothing to half too much, for what is exact at 1 where the plant is as simple as its law."""


class Needs:
    """A setting counts only where another one is one of `choices` or, with none given, is not 0."""

    def __init__(self, name: str, *choices: str) -> None:
        self.name = name
        self.choices = choices

    def met(self, settings: NamedTuple) -> bool:
        """Whether these settings are such."""
        value = getattr(settings, self.name)
        return value in self.choices if self.choices else value != 0.0

    def __str__(self) -> str:
        return f"{self.name} = {' or '.join(self.choices)}" if self.choices else f"{self.name} not 0"


class Setting(NamedTuple):
    """One setting. `unit` is "" for a choice, `choices` is empty for a number, `default` None where it is needed."""

    name: str
    unit: str
    choices: tuple[str, ...]
    default: float | str | None
    about: About
    needs: Needs | None
    tuned: Tuned | None


@functools.cache
def settings_of(cls: type[NamedTuple]) -> dict[str, Setting]:
    """The settings of a class by name.

    Raises:
        TypeError: one is not Annotated[float, unit, ...] or Annotated[str, choice, ...], or needs what there is not.
    """
    hints = typing.get_type_hints(cls, include_extras=True)
    found = {name: _setting(cls, name, hint) for name, hint in hints.items()}
    for name, item in found.items():
        if item.needs is not None and item.needs.name not in found:
            raise TypeError(f'Settings.{name}: needs "{item.needs.name}", expected one of {", ".join(found)}')
    return found


def _setting(cls: type[NamedTuple], name: str, hint: object) -> Setting:
    kind, *said = typing.get_args(hint) if typing.get_origin(hint) is typing.Annotated else (None,)
    words = tuple(item for item in said if isinstance(item, str))
    if kind not in (float, str) or not words:
        raise TypeError(f"Settings.{name}: expected Annotated[float, unit] or Annotated[str, choice, ...]")
    about = next((item for item in said if isinstance(item, About)), About("", -np.inf))
    needs = next((item for item in said if isinstance(item, Needs)), None)
    tuned = next((item for item in said if isinstance(item, Tuned)), None)
    number = kind is float
    return Setting(
        name, words[0] if number else "", () if number else words, cls._field_defaults.get(name), about, needs, tuned
    )


def usable(controller: Controller) -> dict[str, Setting]:
    """The settings that some choice of the others gives a use to."""
    declared = settings_of(controller.Settings)
    return {name: item for name, item in declared.items() if name not in controller.unused}


def idle(controller: Controller, settings: NamedTuple) -> dict[str, str]:
    """Of each setting that changes nothing under these settings: why."""
    declared = settings_of(controller.Settings)
    failed = {name: _unmet(controller, declared, name, settings) for name in declared}
    used = ", ".join(name for name, need in failed.items() if need is None)
    reasons = {}
    for name, need in failed.items():
        if need == "":
            reasons[name] = f"{controller.name} has no use for it here; it uses {used}"
        elif isinstance(need, Needs) and need.choices:
            wanted = " or ".join(f'"{choice}"' for choice in need.choices)
            reasons[name] = (
                f"has no effect: it belongs to {need.name} = {wanted}, and {need.name} is "
                f'"{getattr(settings, need.name)}"; leave it out'
            )
        elif isinstance(need, Needs):
            reasons[name] = f"has no effect where {need.name} is 0; leave it out, or set {need.name}"
    return reasons


def _unmet(
    controller: Controller, declared: dict[str, Setting], name: str, settings: NamedTuple
) -> Needs | typing.Literal[""] | None:
    """What a setting lacks to count: a need, "" where nothing would help, None where it counts."""
    if name in controller.unused:
        return ""
    need = declared[name].needs
    if need is None:
        return None
    lacks = _unmet(controller, declared, need.name, settings)
    if lacks is not None:
        return lacks
    return None if need.met(settings) else need
