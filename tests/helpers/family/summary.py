"""Tables of many scores as Markdown: shares with their intervals, beside what is attainable, by kind of machine."""

import math
from collections.abc import Sequence

import pandas as pd

from .cases import LIMIT, NONE, OTHER, SEVERAL, STRONG, THREE
from .machines import KINDS
from .scoring import COVERING, FAILED, FLOOR_RANGE, NOTHING, WORSE

DEVIATES = 1.96
"""Of 95 % intervals."""


def wilson(right: float, count: float) -> tuple[float, float]:
    """The 95 % interval of a share (Wilson 1927)."""
    if not count:
        return math.nan, math.nan
    share, z = right / count, DEVIATES**2 / count
    middle = (share + 0.5 * z) / (1.0 + z)
    half = DEVIATES * math.sqrt(share * (1.0 - share) / count + 0.25 * z / count) / (1.0 + z)
    return max(middle - half, 0.0), min(middle + half, 1.0)


def _markdown(header: Sequence[str], rows: Sequence[Sequence[object]]) -> str:
    lines = ["| " + " | ".join(header) + " |", "|" + "---|" * len(header)]
    return "\n".join([*lines, *("| " + " | ".join(map(str, row)) + " |" for row in rows)])


def _of(right: float, count: float) -> str:
    return f"{int(right)}/{int(count)}" if count else ""


def _row(words: str, part: pd.DataFrame, right: str, count: str = "", power: str = "") -> list[str]:
    """A share: of the rows, or of what the column `count` counts in them."""
    whole = part[count].sum() if count else len(part)
    low, high = wilson(part[right].sum(), whole)
    best = f"{100 * part[power].mean():.0f} %" if power and len(part) else ""
    kinds = []
    for kind in KINDS:
        one = part[part["machine"] == kind]
        kinds.append(_of(one[right].sum(), one[count].sum() if count else len(one)))
    share = f"{100 * part[right].sum() / whole:.0f} %" if whole else ""
    between = f"{100 * low:.0f} to {100 * high:.0f} %" if whole else ""
    return [words, _of(part[right].sum(), whole), share, between, best, *kinds]


def shares(table: pd.DataFrame) -> str:
    """Markdown: every share that is asked of the suite."""
    by = {kind: table[table["kind"] == kind] for kind in (NONE, THREE, LIMIT, STRONG, SEVERAL, OTHER)}
    found = table.assign(some_named=~table["none_named"] & (table["first"] != FAILED))
    alone = by[OTHER][~by[OTHER]["stood_for"].astype(bool)]
    low, high = FLOOR_RANGE
    rows = [
        _row("no effect: one named (wrongly)", found[found["kind"] == NONE], "some_named"),
        _row(
            f"no effect: residuals over floors within {low} to {high}", by[NONE], "at_floor", power="floor_attainable"
        ),
    ]
    for kind, words in ((THREE, "3 limits"), (LIMIT, "1 limit"), (STRONG, "10 to 1000 limits")):
        part = by[kind]
        seen = part[part["detectable"].astype(bool)]
        rows += [
            _row(f"{words}: right first", part, "right_first", power="attainable"),
            _row(
                f"{words}: right first, of those that own parameters do not hide", seen, "right_first", "", "attainable"
            ),
            _row(f"{words}: the very effect first", part, "exactly_first", power="attainable"),
            _row(f"{words}: right among first and alternatives", part, "right_or_alternative", power="attainable"),
            _row(f"{words}: a wrong one named", part, "wrong_named"),
        ]
    rows += [
        _row("two or three: set right", by[SEVERAL], "set_right", power="attainable"),
        _row("two or three: set right, or an alternative", by[SEVERAL], "set_right_or_alternative", power="attainable"),
        _row("two or three: very set", by[SEVERAL], "exactly_right", power="attainable"),
        _row("two or three: a wrong one named", by[SEVERAL], "wrong_named"),
        _row("unlisted: unexplained, right balance and signal", by[OTHER], "right_unexplained", power="attainable"),
        _row("unlisted: none named", by[OTHER], "none_named"),
        _row("unlisted: none named, where no listed one can stand for it", alone, "none_named"),
    ]
    right = table[table["set_right"]]
    covers = f"90 % intervals (value +- {COVERING} std) that hold the true value"
    rows += [
        _row(f"effects: {covers}", table, "effect_covered", "effect_intervals"),
        _row(f"friction: {covers}", table, "friction_covered", "friction_intervals"),
        _row(f"friction, where the set is right: {covers}", right, "friction_covered", "friction_intervals"),
        _row(
            f"position error of the held-out free run more than {WORSE} times that before, and not rejected",
            table[table["position_ratio"].notna()],
            "made_worse",
        ),
        _row("failed", table.assign(failed=table["first"] == FAILED), "failed"),
    ]
    return _markdown(["", "cases", "share", "95 % interval", "attainable", *KINDS], [row for row in rows if row[1]])


def ratios(table: pd.DataFrame) -> str:
    """Markdown: quantiles of what has no right or wrong."""
    rows = []
    for kind in (NONE, THREE, LIMIT, STRONG, SEVERAL, OTHER):
        part = table[table["kind"] == kind]
        for words, column in (
            ("position error of the held-out free run, after over before", "position_ratio"),
            ("force residual over floor", "force_over_floor"),
            ("flow residual over floor", "flow_over_floor"),
        ):
            values = part[column].dropna()
            if len(values):
                quantiles = [f"{values.quantile(q):.3g}" for q in (0.1, 0.5, 0.9)] + [f"{values.max():.3g}"]
                rows.append([f"{kind}: {words}", len(values), *quantiles])
    return _markdown(["", "cases", "10 %", "median", "90 %", "largest"], rows)


def by_effect(table: pd.DataFrame) -> str:
    """Markdown: each effect alone, and what was named in its place."""
    rows = []
    single = table[table["kind"].isin([THREE, LIMIT, STRONG, OTHER])]
    for truth, part in single.groupby("truth", sort=True):
        others = part[~part["right_first"] & (part["first"] != NOTHING)]["first"].value_counts()
        cells = []
        for kind in (THREE, LIMIT, STRONG):
            one = part[part["kind"] == kind]
            cells += [_of(one["right_first"].sum(), len(one)), f"{one['attainable'].mean():.2f}" if len(one) else ""]
        rows.append([truth, *cells, ", ".join(f"{name} {count}" for name, count in others.items())])
    header = ["effect"]
    for words in ("3 limits", "1 limit", "strong"):
        header += [words, "attainable"]
    return _markdown([*header, "named in its place"], rows)


def times_line(times: pd.DataFrame) -> str:
    """Seconds in words."""
    parts = []
    for column, words in (("make_s", "to make"), ("diagnose_s", "to diagnose")):
        parts.append(f"{times[column].median():.1f} s {words} (median), {times[column].max():.1f} s the longest")
    return "; ".join(parts)


def summary(title: str, scores: pd.DataFrame, times: pd.DataFrame) -> str:
    """The whole of summary.md.

    *Right* is an effect that is there, or one that this record cannot tell from it: fitted in its place with the
    machine's own parameters it leaves a distance below the limit. *Attainable* is the mean power of tests that know the
    effect's form and direction, at 3 % false alarms for all of a machine's effects together, of the distance that the
    machine's own parameters leave; of one that no list has, that the nearest listed one leaves beside them.
    """
    words = " ".join((summary.__doc__ or "").split("\n\n", 1)[1].split())
    blocks = [f"# {title}: {len(scores)} cases", words, shares(scores), ratios(scores), by_effect(scores)]
    return "\n\n".join([*blocks, times_line(times)]) + "\n"
