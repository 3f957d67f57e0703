"""Objects by name: ours, and what other packages bring by entry point. A broken package never stops the others."""

import functools
import re
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Generic, NamedTuple, TypeAlias, TypeVar

from plants.equation import package_hash

T = TypeVar("T", covariant=True)
Check: TypeAlias = Callable[[Any], None]


GROUPS = "friction_workbench."
"""What the groups of entry points begin with."""

OURS = ("controllers", "plants", "workbench")
"""The packages of this program."""


class Plugin(NamedTuple):
    """Where an entry point leads: to an object, or to a failure in words; `package` as messages say it."""

    module: str
    package: str
    found: Any
    failure: str


@dataclass(frozen=True, eq=False)
class Registry(Generic[T]):
    """Objects of class `kind`: ours, and those behind the entry points of `group`, which cannot take our names."""

    group: str
    kind: type
    ours: Mapping[str, T]
    check: Check
    """Raises where an object of others does not declare what `kind` asks for."""

    def working(self) -> Mapping[str, T]:
        """All that can be used, ours first."""
        found = _usable(self.group, self.kind, self.check, tuple(sys.path))
        return {**self.ours, **{name: item for name, item in found.items() if name not in self.ours}}

    def broken(self) -> dict[str, str]:
        """Of each plug-in that cannot be used: why."""
        return {name: plugin.failure for name, plugin in self._plugins() if plugin.failure}

    @property
    def noun(self) -> str:
        """What the objects are, as messages say it."""
        return re.sub("(?<!^)([A-Z])", r" \1", self.kind.__name__).lower()

    def called(self, name: str) -> str:
        """An object in the words of a message, with the package that brings it."""
        package = next((plugin.package for known, plugin in self._plugins() if known == name), "")
        return f'{self.noun} "{name}"{package}'

    def source(self, name: str) -> str:
        """A hash of the source files of a plug-in, those of its whole package; "" for what is ours."""
        return next((package_hash(plugin.module) for known, plugin in self._plugins() if known == name), "")

    def _plugins(self) -> list[tuple[str, Plugin]]:
        found = _loaded(self.group, self.kind, self.check, tuple(sys.path))
        return [(name, plugin) for name, plugin in found.items() if name not in self.ours]


@functools.cache
def _usable(group: str, kind: type, check: Check, search_path: tuple[str, ...]) -> Mapping[str, Any]:
    """What works of plug-ins; every case of a study asks for it."""
    found = _loaded(group, kind, check, search_path)
    return {name: plugin.found for name, plugin in found.items() if not plugin.failure}


@functools.cache
def _loaded(group: str, kind: type, check: Check, search_path: tuple[str, ...]) -> Mapping[str, Plugin]:
    points = sorted(_points(search_path).select(group=group), key=lambda point: point.name)
    return {point.name: _load(point, kind, check) for point in points}


@functools.cache
def _points(search_path: tuple[str, ...]) -> Any:
    """Those of all packages: looking for them takes long, and serves every kind at once."""
    return entry_points()


def reason_of(error: Exception) -> str:
    """What an exception says, on one line."""
    return " ".join(f"{type(error).__name__}: {error}".split())


def owner_of(module: str) -> str:
    """The package, as messages say it, among whose plug-ins a module is; "" of any other module."""
    top, every = module.partition(".")[0], _points(tuple(sys.path))
    points = [point for group in every.groups if group.startswith(GROUPS) for point in every.select(group=group)]
    for point in points:
        if top not in OURS and _module_of(point).partition(".")[0] == top:
            return f'package "{point.dist.name}"' if point.dist else f"package {top}"
    return ""


def _load(point: EntryPoint, kind: type, check: Check) -> Plugin:
    package = f' of the package "{point.dist.name}"' if point.dist else ""
    try:
        if not _module_of(point):
            raise ValueError("an entry point is written MODULE:OBJECT")
        found = point.load()
        if not isinstance(found, kind):
            raise TypeError(f"got {type(found).__name__}, expected {kind.__name__}")
        check(found)
    except Exception as error:  # noqa: BLE001  the code of others may raise anything
        failure = f"{point.value}{package} cannot be used ({reason_of(error)}); mend or uninstall the package"
        return Plugin(_module_of(point), package, None, failure)
    return Plugin(_module_of(point), package, found, "")


def _module_of(point: EntryPoint) -> str:
    """The module of an entry point; "" of one that is written as none may be."""
    return point.module if point.pattern.match(point.value) else ""
