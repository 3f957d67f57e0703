"""What a controller asks of the plant that it believes in, and how what is not there is told."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import NamedTuple

from plants.interface import Plant
from workbench.toml.reading import Key, SchemaError


@contextmanager
def designing(what: str, plant: Plant, belief: NamedTuple, key: Key) -> Iterator[None]:
    """While gains are designed: settings that do not serve, and parameters that the plant lacks, become mistakes.

    Args:
        what: who asks, such as 'controller type "lugre"'.
        plant: whose parameters are believed in.
        belief: these parameters.
        key: where the study says it.

    Raises:
        SchemaError: as told by the design, or a parameter of the belief that there is not.
    """
    try:
        yield
    except ValueError as error:
        raise SchemaError(key, str(error)) from None
    except AttributeError as error:
        if not _part_of(belief, error.obj):
            raise  # a slip in the code of a controller, not in the study
        own = ", ".join(belief._fields)
        raise SchemaError(
            key,
            f'{what} needs "{error.name}" among the parameters of its plant, and {plant.name} has {own}; expected '
            "another type, or another plant",
        ) from None


def _part_of(whole: object, part: object) -> bool:
    return whole is part or (isinstance(whole, tuple) and any(_part_of(item, part) for item in whole))
