"""A decision in words, made from its numbers: what suffices, how sure that is, where it changes, what was assumed."""

import itertools
import math
from collections.abc import Sequence

from workbench.decide.decision import Decision
from workbench.decide.judgement import ALIKE, KINDS, Answer, Judged, Kind, of_kind
from workbench.metrics.statistics import SURE, share_interval, sign_test
from workbench.report.comparison import plain_name
from workbench.report.tables import shown_number
from workbench.study.decide_schema import DecideTable
from workbench.study.gain_file import KEY

MM = 1e3

NAMES: dict[Kind | None, str] = {
    "plain": "plain control",
    "compensation": "compensation",
    "rotation": "rotation",
    None: "nothing",
}

ERRORS = {"rms_error": "rms error", "max_error": "largest error"}
POWERS = {"total": "hydraulic plus rotary", "electric": "hydraulic, plus electric at the motor's terminals"}

LIKELY = 1.0 - SURE
"""A difference that chance makes more often than this tells nothing apart."""


def choice(row: Judged) -> str:
    """A candidate in words."""
    return f"{plain_name(row.controller)} {f'at {row.rpm:g} rpm' if row.rpm else 'without rotation'}"


def millimetres(value: float) -> str:
    """A length (m) as shown."""
    return f"{shown_number(value * MM, 3)} mm"


def watts(value: float) -> str:
    """A power (W) as shown."""
    return f"{shown_number(value, 3)} W"


def speed_of(value: float) -> str:
    """A speed (m/s) as shown."""
    return f"{value * MM:g} mm/s"


def deviations(spread: float) -> str:
    """A spread of friction as shown."""
    return f"{spread:g} standard deviation{'s' * (spread != 1.0)}"


def percent(table: DecideTable) -> str:
    """The probability that is asked for, as the share of a quantile."""
    return f"{100.0 * table.probability:g} %"


def chance(row: Judged) -> str:
    """A probability with its interval."""
    return f"{row.probability:.2f} ({row.low:.2f} to {row.high:.2f})"


def question(found: Decision) -> str:
    """What was asked."""
    table = found.table
    motion = f"a sine of {table.amplitude * MM:g} mm, {1.0 / table.period(table.speed):.3g} Hz"
    machines = (
        f", with a probability of at least {table.probability:g} over machines whose friction is spread by "
        + deviations(table.spread)
    )
    return (
        f"Asked: {'an' if table.figure == 'rms_error' else 'a'} {ERRORS[table.figure]} of at most "
        f"{table.accuracy * MM:g} mm at {speed_of(table.speed)} ({motion}) with at most {table.power:g} W "
        f"({POWERS[table.power_figure]}){machines if _several(found) else ', on the declared machine'}."
    )


def paragraph(found: Decision) -> str:
    """The answer in words."""
    given = found.answer(found.table.speed, found.table.spread)
    told = [_verdict(found, given), *_others(found, given), *_apart(found), *_doubt(found, given), *_changes(found)]
    return " ".join(told)


def _several(found: Decision) -> bool:
    return found.plan.draws > 1


def _does(found: Decision, row: Judged) -> str:
    """On how many machines a candidate meets what is asked, at which error and power."""
    table = found.table
    if not _several(found):
        kept = millimetres(row.error) if math.isfinite(row.error) else f"no error ({row.outcome})"
        return f"{choice(row)}, with {kept}{_at(row)}"
    sure = f"{100.0 * SURE:g} % interval {row.low:.2f} to {row.high:.2f}"
    return (
        f"{choice(row)} on {row.met} of {row.draws} machines (probability {row.probability:.2f}, {sure}), "
        f"with {_reached(row, table)}"
    )


def _reached(row: Judged, table: DecideTable) -> str:
    """The quantile of the error, and the mean power."""
    if not math.isfinite(row.error):
        return f"no error that {percent(table)} of them keep to, since too few runs complete ({row.outcome}){_at(row)}"
    return f"at most {millimetres(row.error)} on {percent(table)} of them{_at(row)} on average"


def _at(row: Judged) -> str:
    """At which mean power, if any run completes."""
    return f" at {watts(row.mean_power)}" if math.isfinite(row.mean_power) else ""


def _verdict(found: Decision, given: Answer) -> str:
    if given.kind is None:
        return f"Nothing that was tried suffices. Nearest is {_does(found, given.best)}: {_miss(found, given.best)}."
    start = "Only rotation suffices" if given.kind == "rotation" else f"{NAMES[given.kind].capitalize()} suffices"
    return f"{start}: {_does(found, given.best)}."


def _miss(found: Decision, row: Judged) -> str:
    """By how much a candidate misses accuracy and power."""
    table, missed = found.table, []
    if not math.isfinite(row.error):
        return "how far it misses the accuracy cannot be told"
    if row.error > table.accuracy:
        times = f"{row.error / table.accuracy:.3g} times what is allowed"
        missed.append(f"the accuracy by {millimetres(row.error - table.accuracy)} ({times})")
    if row.power > table.power:
        missed.append(f"the power by {watts(row.power - table.power)}")
    quantile = f"at the {percent(table)} quantile " if _several(found) else ""
    if not missed:
        return f"{quantile}it keeps to each limit, but to both together on too few machines"
    return f"{quantile}it misses {' and '.join(missed)}"


def _others(found: Decision, given: Answer) -> list[str]:
    """Of the kinds that are not the answer, what the best of each does."""
    told = []
    for kind in KINDS:
        best = of_kind(found.asked, kind, found.table)
        if kind == given.kind or best is None or best is given.best:
            continue
        if best.meets(found.table):
            told.append(f"{NAMES[kind].capitalize()} would too: {_does(found, best)}.")
        else:
            told.append(f"{NAMES[kind].capitalize()} does not; nearest {_does(found, best)}.")
    return told


def _apart(found: Decision) -> list[str]:
    """Whether the draws tell the best from the next, and from the best of another kind that meets what is asked."""
    if not _several(found) or len(found.asked) < 2 or not found.asked[0].met:
        return []
    first, second = found.asked[:2]
    meeting = [row for row in found.asked[1:] if row.meets(found.table)]
    other = next((row for row in meeting if row.kind != first.kind), second)
    return [_compared(first, rival) for rival in dict.fromkeys([second, other])]


def _compared(first: Judged, second: Judged) -> str:
    """Two candidates on the same machines."""
    overlap = first.low <= second.high and second.low <= first.high
    only_first, only_second, p = sign_test(first.passed, second.passed)
    apart = "told apart" if p < LIKELY else "not told apart"
    return (
        f"{choice(first).capitalize()} and {choice(second)} are {apart} by these draws: "
        f"{only_first} of the {first.draws} machines are met by the first alone, {only_second} by the second alone "
        f"(sign test, p = {shown_number(p, 2)}), and their intervals {'overlap' if overlap else 'do not overlap'}."
    )


def _doubt(found: Decision, given: Answer) -> list[str]:
    """That more draws may change the answer, and what they would not."""
    table = found.table
    if not _several(found) or given.settled:
        return []
    sure = next((row for row in found.asked if row.meets(table) and row.settled(table)), None)
    told = (
        f"{found.plan.draws} draws do not settle the answer: an interval on which it rests holds {table.probability:g}"
    )
    least = next(count for count in itertools.count(1) if share_interval(count, count)[0] > table.probability)
    if found.plan.draws < least:
        told += f" (at least {least} draws are needed to settle anything at that probability)"
    if sure is None:
        return [f"{told}, and no candidate is settled to meet it."]
    return [f"{told}. The first of the table that is settled to meet it is {choice(sure)}."]


def _changes(found: Decision) -> list[str]:
    """Where on the map the answer changes, along the speed and along the spread that were asked for."""
    plan, table, told = found.plan, found.table, []
    if len(plan.speeds) > 1:
        row = [found.answer(speed, table.spread) for speed in plan.speeds]
        told.append(f"At this spread {_along(row, [speed * MM for speed in plan.speeds], ' mm/s')}.")
    if len(plan.spreads) > 1:
        column = [found.answer(table.speed, spread) for spread in plan.spreads]
        told.append(f"At this speed {_along(column, plan.spreads, ' standard deviations')}.")
    cells = [found.answer(speed, spread) for speed in plan.speeds for spread in plan.spreads]
    open_cells = sum(not cell.settled for cell in cells)
    if told and _several(found):
        told.append(f"In {open_cells} of the map's {len(cells)} cells the draws do not settle the answer.")
    return told


def _along(answers: Sequence[Answer], values: Sequence[float], unit: str) -> str:
    """What suffices along an axis of the map, neighbours with one answer taken together."""
    parts, begin = [], 0
    for i in range(1, len(answers) + 1):
        if i == len(answers) or answers[i].kind != answers[begin].kind:
            span = f"at {values[begin]:g}" if i - begin == 1 else f"from {values[begin]:g} to {values[i - 1]:g}"
            settled = [one.settled for one in answers[begin:i]]
            doubt = "" if all(settled) else " (settled in part)" if any(settled) else " (not settled)"
            parts.append(f"{_suffices(answers[begin].kind)} {span}{unit}{doubt}")
            begin = i
    return ", ".join(parts)


def _suffices(kind: Kind | None) -> str:
    return f"{'only ' * (kind == 'rotation')}{NAMES[kind]} suffices"


def assumptions(found: Decision) -> list[str]:
    """What was assumed: what the draws are, how a run is judged, whose gains these are; then the study's own lines."""
    table, study = found.table, found.plan.study
    gains = study.file.controllers
    tuned = [plain_name(name) for name in dict.fromkeys(row.controller for row in found.rows) if KEY in gains[name]]
    return [
        _machines(found),
        f"Each run: {table.cycles} periods of the sine, of which the first is left out. A run that does not simply "
        "complete (diverged, stuck, end stop, saturated throughout) does not meet the accuracy.",
        "Controllers believe the plant as declared, whatever is drawn. "
        + (f"Tuned gains: {', '.join(tuned)}; all others as the study gives them." if tuned else "No gains are tuned."),
        "Plain: " + ", ".join(map(plain_name, table.plain)) + ". What suffices is the simplest that does: plain "
        "control before compensation before rotation; within a kind the least power, and of powers within "
        f"{100.0 * ALIKE:g} % of each other the least error.",
        *table.assumptions,
    ]


def _machines(found: Decision) -> str:
    """What is drawn, in words."""
    uncertainty, plant = found.plan.study.file.uncertainty, found.plan.study.file.plant
    if uncertainty is None:
        return "One machine, the declared one: the study has no [uncertainty]."
    parts = [f'friction by the standard deviations of "{plant.get("parameters")}" times the spread']
    for name, factor in uncertainty.scale.items():
        even = " (evenly in the logarithm)" if factor.scale == "log" else ""
        parts.append(f"{plain_name(name)} times {factor.min:g} to {factor.max:g}{even}")
    parts += [f"noise of {plain_name(name)} {noise.min} to {noise.max}" for name, noise in uncertainty.noise.items()]
    return (
        f"{found.plan.draws} machines are drawn (seed {uncertainty.seed}), the same for every candidate, speed and "
        f"spread: {'; '.join(parts)}."
    )
