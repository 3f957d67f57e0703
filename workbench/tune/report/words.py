"""What a tuning's numbers say, in words: who is best, what tuning was worth, what held it back."""

import math
from collections.abc import Iterable, Sequence

from workbench.tune.report.places import place_lines, seeds_line
from workbench.tune.report.rows import Basis, active, basis_of, broken, end_of, objective_of
from workbench.tune.report.tables import number, plain, shown_unit, with_interval, yardstick, yardstick_words
from workbench.tune.schema import FIGURES, TuneTable
from workbench.tune.study import Tuning
from workbench.tune.task import tune_table
from workbench.tune.tuning import Quantile, Tuned, infeasible

ALIKE = 1e-4
"""Objectives that differ by less than this share are the same: trials have gains of five digits."""

Found = tuple[Tuned, Quantile, Quantile]
"""A tuned controller with its objective before and after."""


def sentences(tuning: Tuning) -> list[str]:
    """All that is said of a tuning, the most wanted first."""
    if tune_table(tuning.study).per:
        return [*first_lines(tuning), *infeasible_lines(tuning), *seeds_line(tuning)]
    return [
        *first_lines(tuning),
        *infeasible_lines(tuning),
        *_ends(tuning),
        *_active(tuning),
        *seeds_line(tuning),
        *_fitted_to_draws(tuning),
    ]


def first_lines(tuning: Tuning) -> list[str]:
    """Who is best, by how much tuning helped, whether it changed the order."""
    basis = basis_of(tuning)
    if tune_table(tuning.study).per:
        return place_lines(tuning, basis)
    found = compared(tuning, basis)
    if not found:
        return ["No controller has gains that keep all constraints."]
    return [_best(tuning, found, basis), *_smaller(tuning, found, basis), *_helped(found), *_order(found)]


def infeasible_lines(tuning: Tuning) -> list[str]:
    """A line for each controller without gains that keep all constraints."""
    return [f"{one.task.label}: {infeasible(one)}." for one in tuning.found if one.score is None]


def compared(tuning: Tuning, basis: Basis) -> list[Found]:
    """Controllers that have an objective after tuning, the best first."""
    found: list[Found] = []
    for one in tuning.found:
        before, after = objective_of(one, "before", basis), objective_of(one, "after", basis)
        if before is not None and after is not None:
            found.append((one, before, after))
    return sorted(found, key=lambda each: each[2].value)


def shown(one: Quantile, share: float) -> str:
    """An objective, with its interval where it is the quantile of a `share` of draws."""
    return with_interval(one, share) if one.draws else number(one.value)


# --- who is best ---


def _best(tuning: Tuning, found: Sequence[Found], basis: Basis) -> str:
    (best, _, value), *others = found
    table = tune_table(tuning.study)
    what = {
        "declared": "objective",
        "searched": f"{table.quantile:g} quantile of the objective on the draws of the search",
        "fresh": f"{table.quantile:g} quantile of the objective on draws that the search has not seen",
    }[basis]
    share = table.quantile
    if not others:
        return f"{best.task.label} reaches {_a(what)} of {shown(value, share)}. {yardstick_words(tuning)}"
    said = f"Best is {best.task.label} with {_a(what)} of {shown(value, share)}"
    second, _, next_value = others[0]
    said += f", before {second.task.label} with {shown(next_value, share)}"
    if len(others) > 1:
        last, _, last_value = others[-1]
        said += f"; last is {last.task.label} with {shown(last_value, share)}"
    level = [one.task.label for one, _, other in others if basis != "declared" and _overlap(value, other)]
    if level:
        said += (
            f". The intervals of {best.task.label} and {_list(level)} overlap: on other machines the order may change"
        )
    return f"{said}. {yardstick_words(tuning)}"


def _smaller(tuning: Tuning, found: Sequence[Found], basis: Basis) -> list[str]:
    """Which smaller objectives of the table are not the best's, and why: each would contradict who is best."""
    best, _, value = found[0]
    said = []
    for one in tuning.found:
        before = objective_of(one, "before", basis)
        if before is not None and before.value < value.value and not math.isclose(before.value, value.value):
            breaks = broken(one.start)
            why = f"they break {_list(breaks)}" if breaks else "the search did not find them again"
            said.append(f"The gains of the study give {one.task.label} less ({number(before.value)}), but {why}.")
    if basis != "declared" and best.score is not None:
        declared = {one.task.label: one.score.nominal for one in tuning.found if one.score is not None}
        less = [f"{name} ({number(each)})" for name, each in declared.items() if each < best.score.nominal]
        if less:
            said.append(
                f"On the declared machine alone {_list(less)} {'have' if len(less) > 1 else 'has'} less than "
                f"{best.task.label} ({number(best.score.nominal)}); what counts is drawn machines."
            )
    return said


def _a(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _overlap(one: Quantile, other: Quantile) -> bool:
    return one.low <= other.high and other.low <= one.high


def _list(names: Iterable[str]) -> str:
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


# --- what tuning was worth ---


def _helped(found: Sequence[Found]) -> list[str]:
    """By how much the objective moved, for each controller."""
    lowered = [each for each in found if each[2].value < each[1].value and not _alike(each)]
    raised = [each for each in found if each[2].value > each[1].value and not _alike(each)]
    same = [each[0].task.label for each in found if _alike(each)]
    said = []
    if lowered:
        most_first = sorted(lowered, key=lambda each: each[2].value / each[1].value)
        said.append(f"Tuning lowered the objective of {_list(_moved(*each) for each in most_first)}.")
    for one, before, after in raised:
        lost = broken(one.start)
        why = (
            f"the gains of the study break {_list(lost)}"
            if lost
            else "the search found nothing as good as the gains of the study"
        )
        said.append(f"Tuning raised that of {_moved(one, before, after)}: {why}.")
    if same:
        said.append(f"It left that of {_list(same)} as it was.")
    return said


def _alike(each: Found) -> bool:
    return math.isclose(each[1].value, each[2].value, rel_tol=ALIKE)


def _moved(one: Tuned, before: Quantile, after: Quantile) -> str:
    change = after.value / before.value - 1.0
    by = f", {100.0 * change:+.0f} %" if math.isfinite(change) and math.isfinite(before.value) else ""
    return f"{one.task.label} ({number(before.value)} to {number(after.value)}{by})"


def _order(found: Sequence[Found]) -> list[str]:
    if len(found) < 2:
        return []
    after = [one.task.label for one, _, _ in found]
    before = [one.task.label for one, _, _ in sorted(found, key=lambda each: each[1].value)]
    if before == after:
        return [f"Tuning did not change the order: {', '.join(after)}."]
    return [f"Tuning changed the order: before {', '.join(before)}; after {', '.join(after)}."]


# --- what held it back ---


def _ends(tuning: Tuning) -> list[str]:
    """Which gains stand at an end of their range."""
    said, tuned = [], [one for one in tuning.found if one.best is not None]
    for one in tuned:
        assert one.best is not None
        for dimension in one.task.dimensions:
            end = end_of(dimension, one.best[dimension.name])
            if end:
                unit, scale = shown_unit(dimension)
                value = number(scale * one.best[dimension.name], 4) + (f" {unit}" if unit != "1" else "")
                said.append(f"{dimension.name} of {one.task.label} ({end}, {value})")
    if not said:
        return ["No tuned gain stands at an end of its range."] if tuned else []
    return [f"At an end of their range stand {_list(said)}: beyond it the objective may be lower still."]


def _active(tuning: Tuning) -> list[str]:
    """Which constraints hold whom back."""
    by_name: dict[str, list[str]] = {}
    free = []
    for one in tuning.found:
        if one.score is None:
            continue
        held = active(one)
        for name, count in held.items():
            trials = "" if count is None else f" ({count})"
            by_name.setdefault(name, []).append(f"{one.task.label}{trials}")
        if not held:
            free.append(one.task.label)
    said = [f"The constraint {name} holds back {_list(names)}." for name, names in by_name.items()]
    if said:
        said[-1] += (
            " In brackets: how many trials have a smaller objective and break it; without: the gains are near it."
        )
    if free:
        said.append(f"No constraint holds back {_list(free)}.")
    return said


def _fitted_to_draws(tuning: Tuning) -> list[str]:
    """Whether what was found on the draws of the search holds on others."""
    said, fine, quantile = [], [], tune_table(tuning.study).quantile
    for one in tuning.found:
        searched, fresh = objective_of(one, "after", "searched"), objective_of(one, "after", "fresh")
        if searched is None or fresh is None:
            continue
        if _overlap(searched, fresh):
            fine.append(one.task.label)
            continue
        share = 100.0 * (fresh.value / searched.value - 1.0)
        by = f", {share:+.0f} %" if math.isfinite(share) else ""
        said.append(
            f"{one.task.label} does otherwise on machines that the search has not seen: "
            f"{shown(fresh, quantile)} in place of {shown(searched, quantile)}{by}; "
            + ("it is fitted to its draws." if share > 0.0 else "the fresh draws happen to be kinder.")
        )
    if fine:
        said.append(f"No sign of overfitting of {_list(fine)}: the intervals on searched and on fresh draws overlap.")
    return said


# --- what was held equal ---


def held_equal(tuning: Tuning) -> list[str]:
    """What was the same for every controller."""
    table = tune_table(tuning.study)
    names = {column: name for name, column in FIGURES.items()}
    weights = " + ".join(
        f"{f'{weight:g} x ' if weight != 1.0 else ''}{plain(names[column])}"
        for column, weight in table.objective.used.items()
    )
    lines = [
        f"Budget: {table.seeds} {'searches' if table.seeds > 1 else 'search'} of {table.trials} trials each, of which "
        "the first has the gains of the study, the next classic tunings where there are any for these gains; "
        f"{'seeds' if table.seeds > 1 else 'seed'} "
        f"{', '.join(str(seed) for seed in range(table.seed, table.seed + table.seeds))}.",
        f"Objective: {weights}; each figure over that of {yardstick(tuning)} with the gains of the study in the same "
        f"case, and the mean over the {len(tuning.found[0].task.cases)} "
        f"{'cases that count' if len(tuning.found[0].task.cases) > 1 else 'case that counts'}.",
        f"Constraints: {', '.join(_constraints(table))}.",
    ]
    if table.draws:
        lines.append(
            f"Draws: the {table.quantile:g} quantile of the objective over {table.draws} drawn machines, the same for "
            f"every controller, is made small; {table.fresh_draws} others check it."
        )
    else:
        lines.append("Draws: none; the machine is as the study declares it.")
    return lines


def _constraints(table: TuneTable) -> list[str]:
    asked = table.constraints
    at = f"at {1e3 * asked.margin_speed:g} mm/s" if asked.margin_speed else "at the largest speed of each reference"
    found = [
        "every run ends as it should",
        f"the command is at its limit for at most {100.0 * asked.saturated:g} % of the time",
        f"the loop, linearised while the rod slides {at}, is stable with a gain margin of at least "
        f"{asked.gain_margin_dB:g} dB and a phase margin of at least {asked.phase_margin_deg:g} deg",
    ]
    if asked.limit_cycle:
        found.append("no limit cycle is sustained where a reference rests, or after a step that is held")
    return found
