"""The answer of a decision in words, made from its numbers: what suffices, how sure that is, what fails elsewhere."""

import math
from collections.abc import Sequence

from workbench.decide.candidate import HUNTING, KINDS, CandidateResult, Kind
from workbench.decide.report.names import (
    MM,
    NAMES,
    choice,
    confidence,
    interval,
    machines,
    millimetres,
    percent,
    share,
    watts,
)
from workbench.decide.result import Answer, Decision
from workbench.metrics.statistics import SURE, settling_draws, sign_test
from workbench.publish.tables import shown_number

LIKELY = 1.0 - SURE
"""A difference that chance makes more often than this tells nothing apart."""


def paragraph(decision: Decision) -> str:
    """The answer in words."""
    return " ".join(sentences(decision))


def sentences(decision: Decision) -> list[str]:
    """The answer, point by point: what suffices, what else would and what not, what is told apart, what changes it."""
    given = decision.asked.answer()
    return [*_verdict(decision, given), *_others(decision, given), *_apart(decision), *_changes(decision)]


def _does(decision: Decision, row: CandidateResult) -> str:
    """On how many machines a candidate does what is asked, at which error and power."""
    if not decision.plan.several:
        kept = millimetres(row.error) if math.isfinite(row.error) else f"no error ({row.outcome})"
        return f"{choice(row)}, with {kept}{_at(row)}"
    sure = f", {confidence()} interval {interval(row)}" if row.stage == "fresh" else ""
    return (
        f"{choice(row)} on {machines(row)} (probability {share(row.probability)}{sure}), with {_reached(decision, row)}"
    )


def _reached(decision: Decision, row: CandidateResult) -> str:
    """The quantile of the error, and the mean power."""
    of_them = f"{percent(decision.table)} of them"
    if not math.isfinite(row.error):
        return f"no error that {of_them} keep to, since too few runs complete ({row.outcome}){_at(row)}"
    return f"at most {millimetres(row.error)} on {of_them}{_at(row)} on average"


def _at(row: CandidateResult) -> str:
    """At which mean power, if any run completes."""
    return f" at {watts(row.mean_power)}" if math.isfinite(row.mean_power) else ""


def _verdict(decision: Decision, given: Answer) -> list[str]:
    simpler = [row for row in given.open if given.kind is None or row.kind != given.kind]
    doubts = [_doubt(decision, row) for row in given.open]
    if given.kind is not None and not simpler:
        start = NAMES[given.kind].capitalize()
        start = f"Only {start.lower()}" if given.kind in ("rotation", "both") else start
        return [f"{start} suffices: {_does(decision, given.best)}.", *doubts]
    if given.kind is not None:
        return [*doubts, f"Surely {NAMES[given.kind]} suffices: {_does(decision, given.best)}."]
    if given.open:
        return ["It cannot be told whether anything that was tried suffices.", *doubts]
    if not given.settled:
        return [
            f"It cannot be told whether anything that was tried suffices: of each kind {decision.table.contenders} "
            f"contenders were measured again and fail, others were not. Nearest is {_does(decision, given.best)}."
        ]
    return [
        f"Nothing that was tried suffices. Nearest is {_does(decision, given.best)}: {_miss(decision, given.best)}."
    ]


def _doubt(decision: Decision, row: CandidateResult) -> str:
    """Of a candidate the draws do not tell, and how many would."""
    asked = decision.table.probability
    draws = settling_draws(row.probability, asked, row.sure)
    would = (
        "its share is so near that no number of draws would tell"
        if draws is None
        else f"about {draws} would tell if that share stays"
    )
    return (
        f"Whether {choice(row)} meets it cannot be told with {row.draws} fresh draws: it does on {row.met} of them "
        f"(probability {share(row.probability)}, {confidence()} interval {interval(row)}, which holds "
        f"{asked:g}); {would}."
    )


def _miss(decision: Decision, row: CandidateResult) -> str:
    """By how much a candidate misses accuracy and power."""
    table, missed = decision.table, []
    if row.hunting:
        return f"it hunts on {row.hunting} of {row.draws} machines while a step is held"
    if not math.isfinite(row.error):
        return "how far it misses the accuracy cannot be told"
    if row.error > table.accuracy:
        times = f"{row.error / table.accuracy:.3g} times what is allowed"
        missed.append(f"the accuracy by {millimetres(row.error - table.accuracy)} ({times})")
    if row.power > table.power:
        missed.append(f"the power by {watts(row.power - table.power)}")
    quantile = f"at the {percent(table)} quantile " if decision.plan.several else ""
    if not missed:
        return f"{quantile}it keeps to each limit, but to both together on too few machines"
    return f"{quantile}it misses {' and '.join(missed)}"


def failure(row: CandidateResult) -> str:
    """What fails of a candidate: "accuracy on 18 of 24 machines of the search"."""
    word = row.main_failure
    if word is None:
        return "nothing fails"
    drawn = "fresh machines" if row.stage == "fresh" else "machines of the search"
    return f"{failed_draws(row)} {drawn}" if row.draws > 1 else word


def failed_draws(row: CandidateResult) -> str:
    """The same without a word of the draws; empty where nothing fails."""
    word = row.main_failure
    if word is None or row.draws == 1:
        return word or ""
    return f"{word} on {row.hunting if word == HUNTING else row.failures[word]} of {row.draws}"


def nearest(decision: Decision, speed: float, spread: float, kind: Kind) -> CandidateResult | None:
    """The best of a kind at a speed (m/s) and a spread."""
    return next((row for row in decision.at(speed, spread).ordered if row.kind == kind), None)


def _others(decision: Decision, given: Answer) -> list[str]:
    """Of the kinds that are not the answer, what the best of each does, and what fails."""
    told, table = [], decision.table
    for kind in KINDS:
        row = nearest(decision, table.speed, table.spread, kind)
        if kind == given.kind or row is None or row is given.best or row in given.open:
            continue
        name, standing = NAMES[kind].capitalize(), row.standing(table)
        if standing == "meets":
            told.append(f"{name} would too: {_does(decision, row)}.")
        elif standing == "open":
            told.append(f"{name}: {_doubt(decision, row)}")
        else:
            told.append(f"{name} does not; nearest {_does(decision, row)}; what fails is {failure(row)}.")
    return told


def _apart(decision: Decision) -> list[str]:
    """Whether the fresh draws tell the choice from the next, and from the best of another kind that may meet it."""
    rows = [row for row in decision.asked.ordered if row.stage == "fresh" and row.standing(decision.table) != "fails"]
    if len(rows) < 2:
        return []
    first, second = rows[:2]
    other = next((row for row in rows[1:] if row.kind != first.kind), second)
    return [_compared(first, rival) for rival in ([second] if other is second else [second, other])]


def _compared(first: CandidateResult, second: CandidateResult) -> str:
    """Two candidates on the same machines."""
    only_first, only_second, p = sign_test(first.passed, second.passed)
    apart = "told apart" if p < LIKELY else "not told apart"
    return (
        f"{choice(first).capitalize()} and {choice(second)} are {apart} by how often they meet it: "
        f"{only_first} of the {first.draws} fresh machines are met by the first alone, {only_second} by the second "
        f"alone (sign test on pairs, p = {shown_number(p, 2)})."
    )


def _changes(decision: Decision) -> list[str]:
    """Where on the map the answer changes, along the speed and along the spread that were asked for."""
    plan, table, told = decision.plan, decision.table, []
    if len(plan.speeds) > 1:
        row = [decision.answer(speed, table.spread) for speed in plan.speeds]
        told.append(f"At this spread {_along(row, [speed * MM for speed in plan.speeds], ' mm/s')}.")
    if len(plan.spreads) > 1:
        column = [decision.answer(table.speed, spread) for spread in plan.spreads]
        told.append(f"At this speed {_along(column, plan.spreads, ' standard deviations')}.")
    cells = [decision.answer(speed, spread) for speed in plan.speeds for spread in plan.spreads]
    open_cells = sum(not cell.settled for cell in cells)
    if told and plan.several and open_cells:
        told.append(f"In {open_cells} of the map's {len(cells)} cells it cannot be told with these draws.")
    return told


def words_of(given: Answer) -> str:
    """What suffices in a cell, in words."""
    if not given.settled:
        return "cannot be told"
    return f"{'only ' * (given.kind in ('rotation', 'both'))}{NAMES[given.kind]} suffices"


def _along(answers: Sequence[Answer], values: Sequence[float], unit: str) -> str:
    """What suffices along an axis of the map, neighbours with one answer taken together."""
    parts, begin = [], 0
    for i in range(1, len(answers) + 1):
        if i == len(answers) or words_of(answers[i]) != words_of(answers[begin]):
            span = f"at {values[begin]:g}" if i - begin == 1 else f"from {values[begin]:g} to {values[i - 1]:g}"
            parts.append(f"{words_of(answers[begin])} {span}{unit}")
            begin = i
    return ", ".join(parts)
