"""Mutations of what a TOML file holds: one value, key or table changed, as a hand that knows the format would."""

import copy
import math
import sys
from collections.abc import Callable, Sequence
from random import Random
from typing import Any

from fuzz.values import odd_name, odd_value

Place = tuple[Any, Any]
"""What holds a value, a table or a list, and the key or index of the value in it."""


def places(data: object) -> list[Place]:
    """All places of a file's content."""
    entries = data.items() if isinstance(data, dict) else enumerate(data) if isinstance(data, list) else ()
    found: list[Place] = []
    for key, value in entries:
        found.append((data, key))
        found += places(value)
    return found


def mutated(data: dict[str, Any], random: Random, others: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """The content with one to three changes; `others` are files from which values and tables are taken."""
    changed = copy.deepcopy(data)
    for _ in range(random.choice((1, 1, 1, 2, 3))):
        random.choice(CHANGES)(changed, random, others)
    return changed


def _replaced(data: dict[str, Any], random: Random, others: Sequence[dict[str, Any]]) -> None:
    holder, key = _any(data, random)
    holder[key] = odd_value(random)


def _as_float(value: float) -> float:
    """A number, an integer beyond all floats as the largest of them."""
    return float(value) if abs(value) <= sys.float_info.max else sys.float_info.max


def _near(data: dict[str, Any], random: Random, others: Sequence[dict[str, Any]]) -> None:
    """A value changed and of its kind."""
    holder, key = _any(data, random, leaves=True)
    value = holder[key]
    if isinstance(value, bool):
        holder[key] = not value
    elif isinstance(value, int | float):
        scaled = _as_float(value) * random.choice((-1.0, 0.0, 10.0, 0.1, 1e6, 1e-6, 1e15, 1e-15))
        whole = isinstance(value, int) and math.isfinite(scaled) and random.random() < 0.7
        holder[key] = int(scaled) if whole else scaled
    elif isinstance(value, str) and value:
        number, *unit = value.split(" ", 1)
        place = random.randrange(len(value) + 1)
        holder[key] = random.choice(
            (
                " ".join([f"{number}e{random.choice((-30, -9, -3, 3, 9, 300))}", *unit]),
                f"-{value}",
                value[:place] + random.choice(("\0", "\x1b[1m", "é", "../", "$", "_", " ")) + value[place:],
                value[:place],
                number,
                value * random.choice((2, 50)),
            )
        )


def _renamed(data: dict[str, Any], random: Random, others: Sequence[dict[str, Any]]) -> None:
    """A key that is another; where it is a name, also what refers to it."""
    tables = [(holder, key) for holder, key in places(data) if isinstance(holder, dict)]
    if not tables:
        return
    holder, key = random.choice(tables)
    new = odd_name(random)
    holder[new] = holder.pop(key)
    for other, place in places(data):
        if other[place] == key and isinstance(key, str):
            other[place] = new


def _left_out(data: dict[str, Any], random: Random, others: Sequence[dict[str, Any]]) -> None:
    holder, key = _any(data, random)
    del holder[key]


def _added(data: dict[str, Any], random: Random, others: Sequence[dict[str, Any]]) -> None:
    holder, _ = _any(data, random)
    if isinstance(holder, list):
        holder.insert(random.randrange(len(holder) + 1), odd_value(random))
    else:
        holder[odd_name(random)] = odd_value(random)


def _many(data: dict[str, Any], random: Random, others: Sequence[dict[str, Any]]) -> None:
    """A list or a table of very many."""
    lists = [(holder, key) for holder, key in places(data) if isinstance(holder[key], list | dict) and holder[key]]
    if not lists:
        return
    holder, key = random.choice(lists)
    count = random.choice((4, 10, 10, 400))
    if isinstance(holder[key], list):
        one = holder[key][0]
        numbered = isinstance(one, int | float) and not isinstance(one, bool)
        holder[key] = [one + i if numbered else copy.deepcopy(one) for i in range(count)]
    else:
        name, one = next(iter(holder[key].items()))
        holder[key] |= {f"{name}_{i}": copy.deepcopy(one) for i in range(count)}


def _grafted(data: dict[str, Any], random: Random, others: Sequence[dict[str, Any]]) -> None:
    """A value or table of another file, at its place there."""
    other = random.choice(others)
    holder, key = _any(other, random)
    if holder is other or random.random() < 0.5:
        key = random.choice(list(other))
        data[key] = copy.deepcopy(other[key])
    else:
        ours, place = _any(data, random)
        ours[place] = copy.deepcopy(holder[key])


def _any(data: dict[str, Any], random: Random, leaves: bool = False) -> Place:
    found = [(holder, key) for holder, key in places(data) if not (leaves and isinstance(holder[key], dict | list))]
    if not found:
        data["title"] = ""
        return data, "title"
    return random.choice(found)


CHANGES: tuple[Callable[[dict[str, Any], Random, Sequence[dict[str, Any]]], None], ...] = (
    *(_replaced, _replaced, _near, _near, _near, _renamed, _renamed, _left_out, _added, _many, _grafted),
)
