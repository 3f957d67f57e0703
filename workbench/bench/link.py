"""The state of a bench as text in an address, and back: what differs from the loop as it was opened."""

import base64
import hashlib
import json
import zlib
from dataclasses import replace
from typing import Any

from workbench.bench.loop import BenchLoop
from workbench.errors import UserError

TABLES = ("controllers", "references")
"""Tables that choosing a name adds to."""

LARGEST = 1_000_000
"""Bytes of a state."""


def encoded(loop: BenchLoop, first: BenchLoop) -> str:
    """What a loop has that the first has not, fit for an address; "" where that is nothing."""
    state: dict[str, Any] = {"of": _mark(first)}
    if loop.changes:
        state["changes"] = dict(loop.changes)
    for section in TABLES:
        known, now = first.content.get(section, {}), loop.content.get(section, {})
        if added := {name: table for name, table in now.items() if name not in known}:
            state[section] = added
    if state.keys() == {"of"}:
        return ""
    packed = zlib.compress(json.dumps(state, sort_keys=True).encode(), 9)
    return base64.urlsafe_b64encode(packed).decode().rstrip("=")


def decoded(text: str, first: BenchLoop) -> BenchLoop:
    """The loop of which `encoded` made this text.

    Raises:
        UserError: it made it of another one, or never; or the loop cannot be run.
    """
    try:
        packed = base64.urlsafe_b64decode(text + "=" * (-len(text) % 4))
        state = json.loads(zlib.decompressobj().decompress(packed, LARGEST))
        if state["of"] != _mark(first):
            raise UserError("the address is that of another loop; what is shown is the loop as it was opened")
        content = {
            **first.content,
            **{section: {**state.get(section, {}), **first.content.get(section, {})} for section in TABLES},
        }
        loop = replace(first, content=content).changed(dict(state.get("changes", {})))
        _refuse_files(state)
        _ = loop.resolved
    except UserError:
        raise
    except Exception as error:
        raise UserError(FOREIGN) from error
    return loop


def _mark(first: BenchLoop) -> str:
    """By which a loop is known again."""
    return hashlib.sha256(json.dumps(first.content, sort_keys=True, default=str).encode()).hexdigest()[:12]


def _refuse_files(state: dict[str, Any]) -> None:
    """Raise UserError where a state names a file, which none of ours does but for a parameter file."""
    added = [key for section in TABLES for table in state.get(section, {}).values() for key in table]
    if {*added, *(key.rpartition(".")[2] for key in state.get("changes", {}))} & {"file", "gains"}:
        raise UserError(FOREIGN)


FOREIGN = "the address holds no state of this bench; what is shown is the loop as it was opened"
