"""What a report says of a case, against what is in it, and against what a test could have found at all."""

import math
from collections.abc import Mapping, Sequence
from itertools import permutations
from typing import Any

from scipy.stats import norm

from .cases import OTHER, Case
from .effects import EFFECTS
from .limits import LIMIT
from .unlisted import UNLISTED

NOTHING, FAILED = "nothing", "failed"

FAMILY_ALARM = 0.03
"""False alarms of a whole diagnosis at which the attainable power is stated."""

FLOOR_RANGE = (0.9, 1.15)
"""Residual over its floor where nothing is left."""

WORSE, REJECTED = 1.02, "rejected_on_held_out"
"""Error of position on held-out records, after over before, beyond which a diagnosis does harm; unless it says so."""

COVERING = 1.645
"""Standard deviations either side of 90 % intervals."""

FRICTION = ("coulomb", "stribeck", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping")

ALONG = {"torque": "force"}
"""Balances of a turning axis by the names that they have on a straight one."""

SHOWN_ABOVE_NOISE = 0.1
"""Error of position before, in squares and in the noise's, below which nothing is there to be lowered."""


def attainable(distance: float, tests: int, signed: bool) -> float:
    """Power of the best of `tests` tests at `FAMILY_ALARM` for all of them: Phi(d - z), z from the share of each.

    An effect of either sign has false alarms on both sides.
    """
    alarm = 1.0 - (1.0 - FAMILY_ALARM) ** (1.0 / tests)
    if not signed:
        return float(norm.sf(norm.isf(alarm) - distance))
    bound = norm.isf(0.5 * alarm)
    return float(norm.sf(bound - distance) + norm.cdf(-bound - distance))


def matches(named: Sequence[str], classes: Sequence[set[str]]) -> bool:
    """Whether each effect is named once, or another that no record could tell from it, and nothing besides."""
    if len(named) != len(classes):
        return False
    return any(all(name in one for name, one in zip(order, classes, strict=True)) for order in permutations(named))


def offered(found: Sequence[Mapping[str, Any]]) -> list[list[str]]:
    """The sets of effects that a report leaves open, the one that it names first.

    An alternative stands for the effect that has it, or where it is a set, "a + b", for that effect or for all.
    """
    named = [effect["name"] for effect in found]
    sets = [named]
    for place, effect in enumerate(found):
        for alternative in effect.get("alternatives") or []:
            names = [name.strip() for name in alternative.split("+")]
            sets.append([*named[:place], *names, *named[place + 1 :]])
            if len(names) > 1:
                sets.append(names)
    return sets


def score(case: Case, report: Mapping[str, Any], truth: Mapping[str, Any]) -> dict[str, Any]:
    """One row: what was named, whether it is right, how far errors went down, and which intervals cover.

    What held-out records reject is not named: the plant stays as it was declared.
    """
    found = [] if report.get("verdict") == REJECTED else report.get("effects") or []
    named = [effect["name"] for effect in found]
    first = FAILED if "failure" in report else (named[0] if named else NOTHING)
    alternatives = list(found[0].get("alternatives") or []) if found else []
    single = {name.strip() for one in alternatives for name in one.split("+")}
    inside = truth.get("effects") or {}
    classes = [{name, *inside.get(name, {}).get("class", [])} for name in case.effects]
    anyone = set().union(*classes)
    unexplained = report.get("unexplained") or {}
    return {
        "case": case.name,
        "kind": case.kind,
        "machine": case.machine,
        "motion": case.motion,
        "noise": case.noise,
        "truth": case.truth,
        "multiple": " ".join(f"{one:.3g}" for one in (truth.get("case") or {}).get("multiples", case.multiples)),
        "verdict": report.get("verdict", ""),
        "first": first,
        "named": " ".join(named),
        "alternatives": " | ".join(alternatives),
        **_limits(case, truth, classes),
        "exactly_first": first in case.effects,
        "right_first": first in anyone,
        "right_or_alternative": bool({first, *single} & anyone),
        "wrong_named": any(name not in anyone for name in named),
        "exactly_right": first != FAILED and sorted(named) == sorted(case.effects),
        "set_right": first != FAILED and matches(named, classes),
        "set_right_or_alternative": first != FAILED and any(matches(one, classes) for one in offered(found)),
        "none_named": not named and first != FAILED,
        "unexplained_balance": unexplained.get("balance", ""),
        "unexplained_signals": " ".join(unexplained.get("depends_on", [])),
        "right_unexplained": _right_unexplained(case, unexplained),
        **_floors(report),
        **_coverage(case, report, truth),
        "position_ratio": (ratio := _position_ratio(report, truth)),
        "made_worse": ratio > WORSE and report.get("verdict") != REJECTED,
        "error": report.get("failure", ""),
    }


def _limits(case: Case, truth: Mapping[str, Any], classes: Sequence[set[str]]) -> dict[str, Any]:
    """Distances of the weakest effect, the power that a test of each has, how many stand in its class; and of one that
    no list has, whether a listed one can stand for it: to be unexplained it has to be told from nothing and from each.
    """
    inside = (truth.get("effects") or {}).values()
    known = min((one["d_known"] for one in inside), default=math.nan)
    profiled = min((one["d_profiled"] for one in inside), default=math.nan)
    tests = max(len(truth.get("candidates") or []), 1)
    power = 1.0 if case.effects else math.nan
    for name, one in zip(case.effects, inside, strict=False):
        beside = one["d_free_class"].values() if case.kind == OTHER else ()
        power *= attainable(min([one["d_profiled"], *beside]), tests, name in EFFECTS and EFFECTS[name].signed)
    return {
        "d_known": known,
        "d_profiled": profiled,
        "detectable": profiled >= LIMIT,
        "attainable": power,
        "class_size": max((len(one) for one in classes), default=0),
        "stood_for": case.kind == OTHER
        and any(rest < LIMIT for one in inside for rest in one["d_free_class"].values()),
    }


def _right_unexplained(case: Case, unexplained: Mapping[str, Any]) -> bool:
    """Whether an unlisted effect is told of: on its balance, over one of its signals."""
    if case.kind != OTHER:
        return False
    expected, balance = UNLISTED[case.truth], unexplained.get("balance", "")
    return ALONG.get(balance, balance) == expected.balance and bool(
        set(unexplained.get("depends_on", [])) & set(expected.signals)
    )


def _floors(report: Mapping[str, Any]) -> dict[str, Any]:
    """Residual of each balance, which a report gives in floors, whether all are within `FLOOR_RANGE`, and how probable
    that is of one draw of noise beside the floor of many.
    """
    balances = (report.get("floor") or {}).items()
    ratios = {ALONG.get(name, name): one["after"] for name, one in balances if one["after"] is not None}
    low, high = FLOOR_RANGE
    at_floor = bool(ratios) and all(low <= ratio <= high for ratio in ratios.values())
    within = 1.0
    for spread in (one["spread"] for _, one in balances if one.get("spread")):
        within *= float(norm.cdf(high, 1.0, spread) - norm.cdf(low, 1.0, spread))
    return {
        "floor_attainable": within,
        "force_over_floor": ratios.get("force", math.nan),
        "flow_over_floor": max((r for name, r in ratios.items() if name != "force"), default=math.nan),
        "at_floor": at_floor,
    }


def _coverage(case: Case, report: Mapping[str, Any], truth: Mapping[str, Any]) -> dict[str, int]:
    """How many 90 % intervals there are of effects that were named rightly and of friction, and how many cover."""
    stated, covering = 0, 0
    for effect in [] if report.get("verdict") == REJECTED else report.get("effects") or []:
        true = (truth.get("effects") or {}).get(effect["name"], {}).get("parameters", {})
        one = [_covers(number, true[name]) for name, number in effect["parameters"].items() if name in true]
        stated, covering = stated + sum(c is not None for c in one), covering + sum(c is True for c in one)
    values, fitted = truth.get("values") or {}, report.get("fitted") or {}
    friction = [
        _covers(fitted[name], values[name])
        for name in FRICTION
        if name in fitted and name in values and fitted[name]["identified"]
    ]
    return {
        "effect_intervals": stated,
        "effect_covered": covering,
        "friction_intervals": sum(c is not None for c in friction),
        "friction_covered": sum(c is True for c in friction),
    }


def _covers(number: Mapping[str, Any], true: float) -> bool | None:
    """Whether the 90 % interval holds the true value; None where no interval is stated."""
    if number.get("std") is None or number.get("value") is None:
        return None
    return bool(abs(number["value"] - true) <= COVERING * number["std"])


def _position_ratio(report: Mapping[str, Any], truth: Mapping[str, Any]) -> float:
    """Error of position (rms) of the held-out free run after over before, the sensor's noise taken off in squares."""
    held_out = (report.get("error") or {}).get("held_out") or {}
    noise = (truth.get("noise") or {}).get("position", math.nan) ** 2
    squares = []
    for when in ("before", "after"):
        whole = held_out.get(when) or {}
        rms = next(
            (whole[key] for key in ("position_rms_m", "position_rms_rad") if whole.get(key) is not None), math.nan
        )
        squares.append(rms**2 - noise)
    before, after = squares
    if not before > SHOWN_ABOVE_NOISE * noise:
        return math.nan
    return math.sqrt(max(after, 0.0) / before)
