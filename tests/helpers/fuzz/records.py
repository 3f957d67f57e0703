"""Mutants of records: a table of samples written in every format, with what logs from anywhere bring along."""

import gzip
import io
from collections.abc import Callable
from random import Random
from typing import Any

import numpy as np
import pandas as pd
import scipy.io

from fuzz.damage import damaged
from fuzz.values import NUMBERS, TEXTS, odd_name, odd_value

ENCODINGS = (*("utf-8",) * 5, "utf-8-sig", "utf-16", "utf-16-le", "utf-32", "cp1252", "latin-1", "shift_jis", "cp037")
SEPARATORS = (*(",",) * 4, ";", "\t", "|", " ", "  ", ":", "\x01")
SAMPLES = tuple(str(one) if isinstance(one, int) and abs(one) >= 2**63 else one for one in NUMBERS)
"""Numbers, of which those are text that no array holds."""

COLUMNS = {
    "time": ("time", "Time [s]", "t", "Zeit", "timestamp", "time_s"),
    "command": ("command", "u", "valve_voltage", "Sollwert [V]", "command_V"),
    "position": ("position", "x", "measured_position", "Weg [mm]", "position_mm"),
    "pressure_1": ("pressure_1", "p1 (bar)", "measured_pressure_1"),
    "force": ("force", "F/N", "Kraft [N]"),
}


def record(random: Random) -> tuple[str, bytes]:
    """Some mutant of some record: the name of its file, and its bytes."""
    table = _table(random)
    for _ in range(random.choice((0, 0, 1, 1, 2))):
        table = random.choice(CHANGES)(table, random)
    ending = random.choice(("csv", "csv", "csv", "txt", "tsv", "csv.gz", "parquet", "mat"))
    content = WRITERS[ending](table, random)
    if random.random() < 0.25:
        content = damaged(content, random)
    return f"record.{ending}", content


def _table(random: Random) -> "pd.DataFrame":
    count = random.choice((300, 300, 300, 60, 10, 2, 1, 0))
    time = np.arange(count) * random.choice((0.001, 0.01, 0.05, 1.0))
    numbers = np.random.default_rng(random.randrange(2**32))
    signals = {
        name: np.sin(time * (3.0 + i)) * 10.0**-i + numbers.normal(0.0, 1e-4, count) for i, name in enumerate(COLUMNS)
    }
    signals["time"] = time
    kept = ["time", "command", "position", *(name for name in ("pressure_1", "force") if random.random() < 0.4)]
    plain = random.random() < 0.6
    return pd.DataFrame({name if plain else random.choice(COLUMNS[name]): signals[name] for name in kept})


def _value(table: "pd.DataFrame", random: Random) -> "pd.DataFrame":
    """Single samples that are odd."""
    if table.empty or not len(table.columns):
        return table
    changed = table.astype(object)
    for _ in range(random.choice((1, 3, 40))):
        place = random.randrange(len(table)), random.randrange(len(table.columns))
        changed.iloc[place] = random.choice((*SAMPLES, *TEXTS[:12], None, "1,5", "1.2.3", "12:30:01", "--"))
    return changed


def _column(table: "pd.DataFrame", random: Random) -> "pd.DataFrame":
    """A whole column that is constant, unknown, huge, backwards, text, or not there."""
    if not len(table.columns):
        return table
    place = random.randrange(len(table.columns))
    changed: dict[str, Callable[[Any], Any]] = {
        "constant": lambda values: values * 0.0,
        "unknown": lambda values: values * np.nan,
        "huge": lambda values: values * 1e300,
        "infinite": lambda values: values + np.inf,
        "tiny": lambda values: values * 1e-320,
        "backwards": lambda values: values[::-1],
        "twice": lambda values: np.repeat(values[::2], 2)[: len(values)],
        "whole": lambda values: np.nan_to_num(values * 1e3).astype(np.int64),
        "flags": lambda values: values > 0.0,
        "text": lambda values: [random.choice(TEXTS[:20]) for _ in values],
        "stamps": lambda values: pd.date_range("2026-01-01", periods=len(values), freq="10ms"),
        "complex": lambda values: (values * 1j).astype(str),
    }
    values = pd.to_numeric(table.iloc[:, place], errors="coerce").to_numpy(dtype=float)
    with np.errstate(all="ignore"):
        made = random.choice(list(changed.values()))(values)
    columns = [table.iloc[:, i] if i != place else pd.Series(made) for i in range(len(table.columns))]
    return pd.concat(columns, axis=1).set_axis(table.columns, axis=1)


def _renamed(table: "pd.DataFrame", random: Random) -> "pd.DataFrame":
    names = [odd_name(random) if random.random() < 0.5 else str(name) for name in table.columns]
    if random.random() < 0.3 and len(names) > 1:
        names[1] = names[0]
    return pd.DataFrame(table.to_numpy(dtype=object), columns=names)


def _lost(table: "pd.DataFrame", random: Random) -> "pd.DataFrame":
    return table.iloc[:, : random.randrange(len(table.columns) + 1)]


def _wide(table: "pd.DataFrame", random: Random) -> "pd.DataFrame":
    return pd.concat([table] * random.choice((2, 40)), axis=1)


def _shuffled(table: "pd.DataFrame", random: Random) -> "pd.DataFrame":
    return table.sample(frac=1.0, random_state=random.randrange(1000))


CHANGES = (_value, _value, _column, _column, _column, _renamed, _lost, _wide, _shuffled)


def _text(table: "pd.DataFrame", random: Random) -> bytes:
    separator = random.choice(SEPARATORS)
    decimal = random.choice((".", ".", ",")) if separator != "," else "."
    fields = [[str(name) for name in table.columns]] if random.random() < 0.85 else []
    if random.random() < 0.2:
        fields.append([random.choice(("s", "V", "mm", "bar", "N", "")) for _ in table.columns])
    fields += [[_cell(value, decimal) for value in row] for row in table.itertuples(index=False)]
    ends = random.choice(("\n", "\r\n", "\r"))
    above = random.choice(("", "", "# a comment\n", "key: value\n\n", "%\n" * 30, "a;b,c\td\n"))
    text = above + ends.join(separator.join(row) for row in fields) + random.choice((ends, "", separator, "\x1a"))
    return text.encode(random.choice(ENCODINGS), errors="replace")


def _cell(value: object, decimal: str) -> str:
    if value is None:
        return ""
    if isinstance(value, str):
        return f'"{value}"' if "\n" in value else value
    return (f"{value:.9g}" if isinstance(value, float) else str(value)).replace(".", decimal)


def _parquet(table: "pd.DataFrame", random: Random) -> bytes:
    buffer = io.BytesIO()
    names = [
        f"{name}.{i}" if list(table.columns).index(name) != i else str(name) for i, name in enumerate(table.columns)
    ]
    renamed = table.set_axis(names, axis=1)
    for name in names:
        if renamed[name].dtype == complex:
            renamed[name] = renamed[name].astype(str)
        elif renamed[name].dtype == object:
            renamed[name] = renamed[name].map(lambda value: None if value is None else str(value))
    renamed.to_parquet(buffer, index=random.random() < 0.2)
    return buffer.getvalue()


def _mat(table: "pd.DataFrame", random: Random) -> bytes:
    buffer = io.BytesIO()
    held: dict[str, Any] = {}
    for i, name in enumerate(table.columns):
        values = table.iloc[:, i].to_numpy()
        plain = "".join(letter for letter in str(name) if letter.isascii() and letter.isalnum())[:20]
        if values.dtype == object or values.dtype.kind == "M":
            values = np.array([str(value)[:50].encode("ascii", "replace").decode() for value in values], dtype=object)
        held[f"v{plain}" if not plain[:1].isalpha() else plain] = values
    shape = random.choice(("columns", "rows", "matrix", "struct", "nested", "ragged", "cube"))
    if shape == "rows":
        held = {name: values.reshape(1, -1) for name, values in held.items()}
    elif shape == "matrix" and all(values.dtype.kind == "f" for values in held.values()) and held:
        held = {"data": np.column_stack(list(held.values()))}
    elif shape == "struct":
        held = {"log": held}
    elif shape == "nested":
        held = {
            "log": {"inner": held, "odd": [odd_value(random) if random.random() < 0.1 else 1.0 for _ in range(2)][0:0]}
        }
    elif shape == "ragged" and held:
        first = next(iter(held))
        held[first] = held[first][:-1]
    elif shape == "cube":
        held["cube"] = np.zeros((2, 3, 4))
    scipy.io.savemat(buffer, held, do_compression=random.random() < 0.3)
    return buffer.getvalue()


WRITERS: dict[str, Callable[["pd.DataFrame", Random], bytes]] = {
    "csv": _text,
    "txt": _text,
    "tsv": _text,
    "csv.gz": lambda table, random: gzip.compress(_text(table, random), mtime=0),
    "parquet": _parquet,
    "mat": _mat,
}

EXPERIMENT = """\
title = "a record in an experiment"
[plant]
model = "valve_axis"
parameters = "valve_axis/believed.toml"
[channels]
time = { column = "time", unit = "s" }
command = { column = "command", unit = "V" }
position = { column = "position", unit = "mm" }
[[records]]
file = "@"
"""
"""What reads a record by the names of its columns; "@" stands for its file."""
