"""Plants, controllers and friction laws by name, those of plug-ins among them."""

from typing import TypeVar

from plants.plugins import Registry
from workbench.errors import nearest, shortened
from workbench.toml.reading import Key, SchemaError

T = TypeVar("T")


def registered(registry: Registry[T], name: str, key: Key, shorthands: tuple[str, ...] = ()) -> T:
    """The plant or controller of that name, which stands at `key`; `shorthands` are names that stand for several.

    Raises:
        SchemaError: there is none of that name, or its package cannot be used.
    """
    known = registry.working()
    if name in known:
        return known[name]
    if name in (broken := registry.broken()):
        raise SchemaError(key, broken[name])
    hint = nearest(name, dict.fromkeys((*shorthands, *known)))
    raise SchemaError(key, f'unknown {registry.noun} "{shortened(name)}"; {hint}')
