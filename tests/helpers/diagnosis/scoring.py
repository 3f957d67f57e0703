"""What a report says of a case, against what is in it; tables of many."""

import math
from collections.abc import Mapping, Sequence
from typing import Any

import pandas as pd

from .cases import Case
from .effects import EFFECTS, UNLISTED

FIGURES = ("position_rms_m", "load_pressure_rms_Pa", "force_rms_N", "flow_rms_m3_per_s")

FIGURE_OF = {"force": "force_rms_N", "flow": "flow_rms_m3_per_s", "valve": "flow_rms_m3_per_s"}
"""The residual in which an effect on a balance shows."""

FIGURE_OF_SENSOR = {"backlash": "flow_rms_m3_per_s", "pressure_sensor_offset": "force_rms_N"}

NOTHING, FAILED = "nothing", "failed"
"""Columns of the confusion table beside the effects."""


def figure_of(effect: str) -> str:
    """Name of the error figure that the effect raises."""
    return FIGURE_OF_SENSOR.get(effect) or FIGURE_OF[EFFECTS[effect].balance]


def _number(report: Mapping[str, Any], *keys: str) -> float:
    """A number deep in a report; nan where there is none."""
    found: Any = report
    for key in keys:
        if not isinstance(found, Mapping) or found.get(key) is None:
            return math.nan
        found = found[key]
    return float(found)


def _floor(report: Mapping[str, Any], use: str, figure: str) -> float:
    """The noise floor that a report states for a figure, in any of the places where it may stand."""
    places = (("error", use, "noise_floor"), ("error", use, "floor"), ("error", "noise_floor"), ("noise_floor",))
    values = [_number(report, *place, figure) for place in places]
    return next((value for value in values if not math.isnan(value)), math.nan)


def score(case: Case, report: Mapping[str, Any]) -> dict[str, Any]:
    """One row: what was named, whether it is right, and the errors before and after."""
    effects = report.get("effects") or []
    named = [effect["name"] for effect in effects]
    alternatives = list(effects[0].get("alternatives") or []) if effects else []
    unexplained = report.get("unexplained") or {}
    first = named[0] if named else NOTHING
    row: dict[str, Any] = {
        "case": case.name,
        "kind": case.kind,
        "truth": case.truth,
        "strength": case.strength,
        "seed": case.seed,
        "verdict": report.get("verdict", ""),
        "first": first,
        "named": " ".join(named),
        "alternatives": " ".join(alternatives),
        "right_first": first in case.effects,
        "right_or_alternative": bool({first, *alternatives} & set(case.effects)),
        "all_named": set(case.effects) <= set(named),
        "wrong_named": sum(name not in case.effects for name in named),
        "none_named": not named,
        "unexplained_balance": unexplained.get("balance", ""),
        "unexplained_signals": " ".join(unexplained.get("depends_on", [])),
        "right_unexplained": _right_unexplained(case, report, unexplained, named),
        "error": report.get("failure", ""),
    }
    for use in ("fit", "held_out"):
        for figure in FIGURES:
            for when in ("before", "after"):
                row[f"{use}_{when}_{figure}"] = _number(report, "error", use, when, figure)
            row[f"{use}_floor_{figure}"] = _floor(report, use, figure)
    ratios = [row[f"held_out_after_{f}"] / _or_nan(row[f"held_out_before_{f}"]) for f in map(figure_of, case.effects)]
    row["held_out_ratio"] = max(ratios, default=math.nan)
    return row


def _or_nan(value: float) -> float:
    return value or math.nan


def _right_unexplained(case: Case, report: Mapping[str, Any], unexplained: Mapping[str, Any], named: list[str]) -> bool:
    """Whether an unlisted effect is reported as such: no name, the right balance and one of its signals."""
    if case.kind != "unlisted" or named or report.get("verdict") != "unexplained":
        return False
    expected = UNLISTED[case.truth]
    signals = set(unexplained.get("depends_on", []))
    return unexplained.get("balance") == expected.balance and bool(signals & set(expected.signals))


def add_floor_ratio(table: pd.DataFrame) -> pd.DataFrame:
    """`over_floor`: the held-out residual after, over its floor, the larger of the effects' figures.

    The floor is the report's own; where it states none, the median of the residuals of this table's records without
    effect, before.
    """
    silent = table[table["kind"] == "none"]
    ratios = []
    for _, row in table.iterrows():
        names = [name for name in row["truth"].split("+") if name in EFFECTS]
        figures = {figure_of(name) for name in names} or {"force_rms_N", "flow_rms_m3_per_s"}
        found = []
        for figure in sorted(figures):
            floor = row[f"held_out_floor_{figure}"]
            if math.isnan(floor):
                floor = silent[f"held_out_before_{figure}"].median()
            found.append(row[f"held_out_after_{figure}"] / _or_nan(floor))
        ratios.append(max((ratio for ratio in found if not math.isnan(ratio)), default=math.nan))
    return table.assign(over_floor=ratios)


def _share(values: pd.Series) -> str:
    return f"{int(values.sum())}/{len(values)}"


def _median(values: pd.Series) -> str:
    return "" if values.isna().all() else f"{values.median():.2f}"


def _markdown(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join([*lines, *("| " + " | ".join(map(str, row)) + " |" for row in rows)])


def confusion(table: pd.DataFrame) -> str:
    """Markdown: what is in the record, against what is named first; only columns that occur."""
    counts = pd.crosstab(table["truth"], table["first"])
    order = [*EFFECTS, NOTHING, FAILED]
    columns = [name for name in order if name in counts] + sorted(set(counts) - set(order))
    short = [f"{i}. {name}" for i, name in enumerate(columns, 1)]
    rows = []
    for truth in dict.fromkeys(table["truth"]):
        names = truth.split("+")
        cells = [counts.loc[truth, name] for name in columns]
        marked = [f"**{n}**" if c in names else n for c, n in zip(columns, cells, strict=True)]
        rows.append([truth, *(cell or "" for cell in marked)])
    return _markdown(["in the record \\ named first", *short], rows)


def _measures(part: pd.DataFrame) -> list[str]:
    return [
        _share(part["right_first"]),
        _share(part["right_or_alternative"]),
        _share(part["all_named"]),
        _share(part["none_named"]),
        _share(part["wrong_named"] > 0),
        _median(part["held_out_ratio"]),
        _median(part["over_floor"]),
    ]


MEASURES = (
    "right first",
    "right first or alternative",
    "all named",
    "none named",
    "a wrong one named",
    "held-out error after/before (median)",
    "residual over floor (median)",
)


def figures(table: pd.DataFrame) -> str:
    """Markdown: the shares of right answers by kind and strength, by effect, and for what must not be named."""
    rows = []
    single = table[table["kind"] == "effect"]
    for strength, part in sorted(single.groupby("strength"), reverse=True):
        rows.append([f"one effect, strength {strength:g}", *_measures(part)])
    pairs = table[table["kind"] == "pair"]
    if len(pairs):
        rows.append(["two effects", *_measures(pairs)])
    blocks = [_markdown(["", *MEASURES], rows)] if rows else []
    effects = [[name, *_measures(part)] for name, part in single.groupby("truth", sort=False)]
    if effects:
        blocks.append(_markdown(["effect, all strengths", *MEASURES], effects))
    rest = []
    silent, unlisted = table[table["kind"] == "none"], table[table["kind"] == "unlisted"]
    if len(silent):
        rest.append(["no effect: none named", _share(silent["none_named"])])
    for name, part in unlisted.groupby("truth", sort=False):
        rest.append([f"{name}: unexplained, right balance and signal, no name", _share(part["right_unexplained"])])
        rest.append([f"{name}: no name", _share(part["none_named"])])
    if (failed := table[table["first"] == FAILED]).size:
        rest.append(["failed", _share(table["case"].isin(failed["case"]))])
    if rest:
        blocks.append(_markdown(["", "cases"], rest))
    return "\n\n".join(blocks)
