"""Reading TOML files: every mistake is one line with file, line, key, what was expected and the nearest name."""

import re
import tomllib
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from workbench.errors import MOST_LINES, UserError, nearest, shortened, spelled
from workbench.toml.sound import MOST_LEVELS, TOO_LONG, UnsoundError, check_sound

if TYPE_CHECKING:
    from pydantic_core import ErrorDetails

Key = tuple[str | int, ...]

MOST_BYTES = 64e6
"""Of a file of text: a study with a million values on an axis has some ten million."""

ModelT = TypeVar("ModelT", bound=BaseModel)


class Strict(BaseModel):
    """Base of all file schemas: unknown keys are mistakes, values do not change."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False, defer_build=True)


def check_regular(path: Path) -> None:
    """Raise UserError for a pipe or a device, which may never end; a file that is not there is another's to tell."""
    if path.exists() and not path.is_file() and not path.is_dir():
        raise UserError(f"{path}: is a pipe or a device, expected a file")


def read_text(path: Path) -> str:
    """The content of a text file.

    Raises:
        UserError: no such file, or not readable as text.
    """
    try:
        check_regular(path)
        if (size := path.stat().st_size) > MOST_BYTES:
            raise UserError(f"{path}: has {size / 1e6:.0f} MB, expected at most {MOST_BYTES / 1e6:g} MB of text")
        return path.read_text(encoding="utf-8-sig")
    except FileNotFoundError:
        siblings = sorted(p.name for p in path.parent.glob("*.toml")) if path.parent.is_dir() else []
        hint = nearest(path.name, siblings) if siblings else "check the path"
        raise UserError(f"{path}: no such file; {hint}") from None
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"{path}: cannot be read as text ({error})") from None


def read_toml(path: Path) -> tuple[dict[str, object], str]:
    """The content of a TOML file, as a dictionary and as text.

    Raises:
        UserError: no such file, not readable, or not TOML.
    """
    text = read_text(path)
    return parse_toml(path, text), text


def parse_toml(path: Path, text: str) -> dict[str, object]:
    """`text`, the content of the file at `path`, as a dictionary.

    Raises:
        UserError: not TOML.
    """
    try:
        data = tomllib.loads(text)
        check_sound(data)
    except tomllib.TOMLDecodeError as error:
        raise UserError(f"{path}: not a TOML file: {error}") from None
    except RecursionError:
        raise UserError(f"{path}: lists or tables in each other are too deep, expected at most {MOST_LEVELS}") from None
    except UnsoundError as error:
        raise at(path, text, error.key, error.message) from None
    except ValueError:  # of int, beyond the digits that Python reads
        raise UserError(f"{path}: {TOO_LONG}") from None
    return data


_HEADER = re.compile(r"^\s*\[(\[)?\s*(?P<name>[^\]]+?)\s*\]")
_ASSIGN = re.compile(
    r"^\s*(?P<name>(?:[A-Za-z0-9_-]+|\"[^\"]*\"|'[^']*')(?:\s*\.\s*(?:[A-Za-z0-9_-]+|\"[^\"]*\"))*)\s*="
)


def _parts(dotted: str) -> Key:
    return tuple(part.strip().strip("\"'") for part in re.findall(r"\"[^\"]*\"|'[^']*'|[^.]+", dotted))


def line_of(text: str, key: Key) -> int | None:
    """The line (from 1) on which `key` stands, or that of the nearest table above it, or None.

    A table without a line of its own, such as `plant` of `[plant.set]`, stands where something in it first does.
    """
    found: dict[Key, int] = {}
    implied: dict[Key, int] = {}
    table: Key = ()
    counts: dict[Key, int] = {}
    for number, line in enumerate(text.splitlines(), start=1):
        if header := _HEADER.match(line):
            table = _placed(_parts(header["name"]), counts)
            if header[1]:
                index = counts.get(table, -1) + 1
                counts[table] = index
                table = (*table, index)
            place = table
        elif assign := _ASSIGN.match(line):
            place = (*table, *_parts(assign["name"]))
        else:
            continue
        found.setdefault(place, number)
        for length in range(1, len(place)):
            implied.setdefault(place[:length], number)
    lines = {**implied, **found}
    return next((lines[key[:length]] for length in range(len(key), 0, -1) if key[:length] in lines), None)


def _placed(table: Key, counts: dict[Key, int]) -> Key:
    """A table inside an array of tables belongs to the latest element of that array."""
    for length in range(len(table) - 1, 0, -1):
        if table[:length] in counts:
            return (*table[:length], counts[table[:length]], *table[length:])
    return table


def at(path: Path, text: str, key: Key, message: str) -> UserError:
    """The error for a mistake at `key` of a file."""
    line = line_of(text, key)
    place = f"{path}{f':{line}' if line else ''}"
    name = ".".join(shortened(str(part)) for part in key)
    return UserError(f"{place}: {name}: {message}" if name else f"{place}: {message}")


def lines_of(mistakes: "Sequence[SchemaError]", told: "Callable[[SchemaError], UserError]") -> UserError:
    """Several mistakes as one error, a line each as `told` has it; of many the first, and how many there are more."""
    alike = list({(each.key, each.message): each for each in mistakes}.values())
    shown = alike if len(alike) <= MOST_LINES else alike[: MOST_LINES - 1]
    more = [f"... and {len(alike) - len(shown)} more"] * (len(shown) < len(alike))
    return UserError("\n".join([*(str(told(each)) for each in shown), *more]))


class SchemaError(Exception):
    """A mistake of a table: its key inside the table, and what is wrong; `others` are further ones of the table."""

    def __init__(self, key: Key, message: str, others: "Sequence[SchemaError]" = ()) -> None:
        super().__init__(message)
        self.key = key
        self.message = message
        self.others = tuple(others)


def together(mistakes: Sequence[SchemaError]) -> SchemaError:
    """One or several mistakes as one. A missing key that an unknown one beside it is taken for is not told twice."""
    first, *others = [
        item
        for item in mistakes
        if not any(f'did you mean "{item.key[-1]}"' in other.message for other in mistakes if _beside(other, item))
    ]
    return SchemaError(first.key, first.message, others)


def _beside(one: SchemaError, other: SchemaError) -> bool:
    return one is not other and one.key[:-1] == other.key[:-1]


def conform(model: type[ModelT], data: Mapping[str, object]) -> ModelT:
    """`data` as an instance of `model`.

    Raises:
        SchemaError: all unknown and missing keys, with the nearest valid names, or else the first mistake.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        mistakes = error.errors()
        unknown = [item for item in mistakes if item["type"] == "extra_forbidden"]
        missing = [item for item in mistakes if item["type"] == "missing"]
        raise together([_mistake(model, item) for item in [*unknown, *missing] or mistakes[:1]]) from None


def _mistake(model: type[BaseModel], error: "ErrorDetails") -> SchemaError:
    key = tuple(part for part in error["loc"] if not (isinstance(part, str) and part in _UNION_MEMBERS))
    return SchemaError(key, _message(model, error, key))


_UNION_MEMBERS = ("float", "str", "int", "list", "dict")
"""Pydantic names the member of a union in a mistake's place; the file has no such key."""


def validate(model: type[ModelT], data: Mapping[str, object], path: Path, text: str) -> ModelT:
    """`data`, the content of the file at `path`, as an instance of `model`.

    Raises:
        UserError: as `conform`, a line a mistake, with its place.
    """
    try:
        return conform(model, data)
    except SchemaError as error:
        raise lines_of((error, *error.others), lambda each: at(path, text, each.key, each.message)) from None


def _message(model: type[BaseModel], error: "ErrorDetails", key: Key) -> str:
    if error["type"] == "extra_forbidden":
        valid = _valid_keys(model, key[:-1])
        return f"unknown key; {nearest(str(key[-1]), valid)}"
    if error["type"] == "missing":
        return "is missing; this key is needed here"
    if error["type"] == "value_error":
        return str(error["ctx"]["error"])
    if error["type"] == "literal_error":
        return f"got {_quoted(error['input'])}, expected {error['ctx']['expected']}"
    if error["type"] == "too_short":
        return "is empty: expected at least one entry"
    if error["type"] == "too_long":
        return f"has {error['ctx']['actual_length']} entries, expected at most {error['ctx']['max_length']}"
    message = error["msg"]
    return f"got {spelled(error['input'])}: {message[0].lower()}{message[1:]}"


def _quoted(value: object) -> str:
    """Text in quotes, everything else likewise."""
    return f'"{shortened(str(value))}"'


def _valid_keys(model: type[BaseModel] | None, key: Key) -> list[str]:
    """Names of the fields of the model at `key` inside `model`; names and places in a container lead to its model."""
    for part in key:
        known = model.model_fields if model is not None else {}
        if part in known:
            model = _model_in(known[str(part)].annotation)
    return list(model.model_fields) if model is not None else []


def _model_in(annotation: object) -> type[BaseModel] | None:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for inner in getattr(annotation, "__args__", ()):
        if (found := _model_in(inner)) is not None:
            return found
    return None
