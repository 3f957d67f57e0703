"""What a tuning's numbers say, in words: who is best, what tuning was worth, what held it back."""

import math
from collections.abc import Iterable, Sequence

from workbench.publish.along import SHOWN
from workbench.tune.report.places import place_lines, seeds_line
from workbench.tune.report.rows import Basis, active, basis_of, broken, end_of, objective_of
from workbench.tune.report.tables import number, plain, reference_words, shown_unit, with_interval
from workbench.tune.result import ControllerTuning, Quantile, Tuning, infeasible
from workbench.tune.schema import METRICS, TuneTable, reference_controller, tune_table

ALIKE = 1e-4
"""Objectives that differ by less than this share are the same: trials have gains of five digits."""

Ranked = tuple[ControllerTuning, Quantile, Quantile]
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
    ranking = compared(tuning, basis)
    if not ranking:
        return ["No controller has gains that keep all constraints."]
    return [_best(tuning, ranking, basis), *_smaller(tuning, ranking, basis), *_helped(ranking), *_order(ranking)]


def infeasible_lines(tuning: Tuning) -> list[str]:
    """A line for each controller without gains that keep all constraints."""
    return [f"{tuned.task.label}: {infeasible(tuned)}." for tuned in tuning.tuned if tuned.score is None]


def compared(tuning: Tuning, basis: Basis) -> list[Ranked]:
    """Controllers that have an objective after tuning, the best first."""
    ranking: list[Ranked] = []
    for tuned in tuning.tuned:
        before, after = objective_of(tuned, "before", basis), objective_of(tuned, "after", basis)
        if before is not None and after is not None:
            ranking.append((tuned, before, after))
    return sorted(ranking, key=lambda each: each[2].value)


def shown(quantile: Quantile, share: float) -> str:
    """An objective, with its interval where it is the quantile of a `share` of draws."""
    return with_interval(quantile, share) if quantile.draws else number(quantile.value)


# --- who is best ---


def _best(tuning: Tuning, ranking: Sequence[Ranked], basis: Basis) -> str:
    (best, _, value), *others = ranking
    table = tune_table(tuning.study)
    what = {
        "declared": "objective",
        "searched": f"{table.quantile:g} quantile of the objective on the draws of the search",
        "fresh": f"{table.quantile:g} quantile of the objective on draws that the search has not seen",
    }[basis]
    share = table.quantile
    if not others:
        return f"{best.task.label} reaches {_a(what)} of {shown(value, share)}. {reference_words(tuning)}"
    lines = f"Best is {best.task.label} with {_a(what)} of {shown(value, share)}"
    second, _, next_value = others[0]
    lines += f", before {second.task.label} with {shown(next_value, share)}"
    if len(others) > 1:
        last, _, last_value = others[-1]
        lines += f"; last is {last.task.label} with {shown(last_value, share)}"
    level = [tuned.task.label for tuned, _, other in others if basis != "declared" and _overlap(value, other)]
    if level:
        lines += (
            f". The intervals of {best.task.label} and {_list(level)} overlap: on other machines the order may change"
        )
    return f"{lines}. {reference_words(tuning)}"


def _smaller(tuning: Tuning, ranking: Sequence[Ranked], basis: Basis) -> list[str]:
    """Which smaller objectives of the table are not the best's, and why: each would contradict who is best."""
    best, _, value = ranking[0]
    lines = []
    for tuned in tuning.tuned:
        before = objective_of(tuned, "before", basis)
        if before is not None and before.value < value.value and not math.isclose(before.value, value.value):
            breaks = broken(tuned.start)
            why = f"they break {_list(breaks)}" if breaks else "the search did not find them again"
            lines.append(f"The gains of the study give {tuned.task.label} less ({number(before.value)}), but {why}.")
    if basis != "declared" and best.score is not None:
        declared = {tuned.task.label: tuned.score.nominal for tuned in tuning.tuned if tuned.score is not None}
        less = [f"{name} ({number(each)})" for name, each in declared.items() if each < best.score.nominal]
        if less:
            lines.append(
                f"On the declared machine alone {_list(less)} {'have' if len(less) > 1 else 'has'} less than "
                f"{best.task.label} ({number(best.score.nominal)}); what counts is drawn machines."
            )
    return lines


def _a(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiou' else 'a'} {noun}"


def _overlap(quantile: Quantile, other: Quantile) -> bool:
    return quantile.low <= other.high and other.low <= quantile.high


def _list(names: Iterable[str]) -> str:
    *first, last = names
    return f"{', '.join(first)} and {last}" if first else last


# --- what tuning was worth ---


def _helped(ranking: Sequence[Ranked]) -> list[str]:
    """By how much the objective moved, for each controller."""
    lowered = [each for each in ranking if each[2].value < each[1].value and not _alike(each)]
    raised = [each for each in ranking if each[2].value > each[1].value and not _alike(each)]
    same = [each[0].task.label for each in ranking if _alike(each)]
    lines = []
    if lowered:
        most_first = sorted(lowered, key=lambda each: each[2].value / each[1].value)
        lines.append(f"Tuning lowered the objective of {_list(_moved(*each) for each in most_first)}.")
    for tuned, before, after in raised:
        lost = broken(tuned.start)
        why = (
            f"the gains of the study break {_list(lost)}"
            if lost
            else "the search found nothing as good as the gains of the study"
        )
        lines.append(f"Tuning raised that of {_moved(tuned, before, after)}: {why}.")
    if same:
        lines.append(f"It left that of {_list(same)} as it was.")
    return lines


def _alike(each: Ranked) -> bool:
    return math.isclose(each[1].value, each[2].value, rel_tol=ALIKE)


def _moved(tuned: ControllerTuning, before: Quantile, after: Quantile) -> str:
    change = after.value / before.value - 1.0
    by = f", {100.0 * change:+.0f} %" if math.isfinite(change) and math.isfinite(before.value) else ""
    return f"{tuned.task.label} ({number(before.value)} to {number(after.value)}{by})"


def _order(ranking: Sequence[Ranked]) -> list[str]:
    if len(ranking) < 2:
        return []
    after = [tuned.task.label for tuned, _, _ in ranking]
    before = [tuned.task.label for tuned, _, _ in sorted(ranking, key=lambda each: each[1].value)]
    if before == after:
        return [f"Tuning did not change the order: {', '.join(after)}."]
    return [f"Tuning changed the order: before {', '.join(before)}; after {', '.join(after)}."]


# --- what held it back ---


def _ends(tuning: Tuning) -> list[str]:
    """Which gains stand at an end of their range."""
    lines, feasible = [], [tuned for tuned in tuning.tuned if tuned.best is not None]
    for tuned in feasible:
        assert tuned.best is not None
        for dimension in tuned.task.dimensions:
            end = end_of(dimension, tuned.best[dimension.name])
            if end:
                unit, scale = shown_unit(dimension)
                value = number(scale * tuned.best[dimension.name], 4) + (f" {unit}" if unit != "1" else "")
                lines.append(f"{dimension.name} of {tuned.task.label} ({end}, {value})")
    if not lines:
        return ["No tuned gain stands at an end of its range."] if feasible else []
    return [f"At an end of their range stand {_list(lines)}: beyond it the objective may be lower still."]


def _active(tuning: Tuning) -> list[str]:
    """Which constraints hold whom back."""
    by_name: dict[str, list[str]] = {}
    free = []
    for tuned in tuning.tuned:
        if tuned.score is None:
            continue
        held = active(tuned)
        for name, count in held.items():
            trials = "" if count is None else f" ({count})"
            by_name.setdefault(name, []).append(f"{tuned.task.label}{trials}")
        if not held:
            free.append(tuned.task.label)
    lines = [f"The constraint {name} holds back {_list(names)}." for name, names in by_name.items()]
    if lines:
        lines[-1] += (
            " In brackets: how many trials have a smaller objective and break it; without: the gains are near it."
        )
    if free:
        lines.append(f"No constraint holds back {_list(free)}.")
    return lines


def _fitted_to_draws(tuning: Tuning) -> list[str]:
    """Whether what was found on the draws of the search holds on others."""
    lines, fine, quantile = [], [], tune_table(tuning.study).quantile
    for tuned in tuning.tuned:
        searched, fresh = objective_of(tuned, "after", "searched"), objective_of(tuned, "after", "fresh")
        if searched is None or fresh is None:
            continue
        if _overlap(searched, fresh):
            fine.append(tuned.task.label)
            continue
        share = 100.0 * (fresh.value / searched.value - 1.0)
        by = f", {share:+.0f} %" if math.isfinite(share) else ""
        lines.append(
            f"{tuned.task.label} does otherwise on machines that the search has not seen: "
            f"{shown(fresh, quantile)} in place of {shown(searched, quantile)}{by}; "
            + ("it is fitted to its draws." if share > 0.0 else "the fresh draws happen to be kinder.")
        )
    if fine:
        lines.append(f"No sign of overfitting of {_list(fine)}: the intervals on searched and on fresh draws overlap.")
    return lines


# --- what was held equal ---


def held_equal(tuning: Tuning) -> list[str]:
    """What was the same for every controller."""
    table = tune_table(tuning.study)
    names = {column: name for name, column in METRICS.items()}
    weights = " + ".join(
        f"{f'{weight:g} x ' if weight != 1.0 else ''}{plain(names[column])}"
        for column, weight in table.objective.used.items()
    )
    lines = [
        f"Budget: {table.seeds} {'searches' if table.seeds > 1 else 'search'} of {table.trials} trials each, of which "
        "the first has the gains of the study, the next classic tunings where there are any for these gains; "
        f"{'seeds' if table.seeds > 1 else 'seed'} "
        f"{', '.join(str(seed) for seed in range(table.seed, table.seed + table.seeds))}.",
        f"Objective: {weights}; each figure over that of {reference_controller(tuning.study)} with the gains of the "
        f"study in the same case, and the mean over the {len(tuning.tuned[0].task.cases)} "
        f"{'cases that count' if len(tuning.tuned[0].task.cases) > 1 else 'case that counts'}.",
        f"Constraints: {', '.join(_constraints(table, tuning.tuned[0].task.axis))}.",
    ]
    if table.draws:
        lines.append(
            f"Draws: the {table.quantile:g} quantile of the objective over {table.draws} drawn machines, the same for "
            f"every controller, is made small; {table.fresh_draws} others check it."
        )
    else:
        lines.append("Draws: none; the machine is as the study declares it.")
    return lines


def _constraints(table: TuneTable, axis: str) -> list[str]:
    asked = table.constraints
    at = (
        f"at {SHOWN[axis].speed(asked.margin_speed)}"
        if asked.margin_speed
        else "at the largest speed of each reference"
    )
    lines = [
        "every run ends as it should",
        f"the command is at its limit for at most {100.0 * asked.saturated:g} % of the time",
        f"the loop, linearised while the rod slides {at}, is stable with a gain margin of at least "
        f"{asked.gain_margin_dB:g} dB and a phase margin of at least {asked.phase_margin_deg:g} deg",
    ]
    if asked.limit_cycle:
        lines.append("no limit cycle is sustained where a reference rests, or after a step that is held")
    return lines
