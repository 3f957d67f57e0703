"""The page of a comparison, as Markdown and as HTML: the matrix first, then its words, who was measured, what changes
it, what it does not hold, and the details.
"""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import pandas as pd
from jinja2 import Environment

from workbench.compare.candidates import MM, RARE, Cell, of_tuned, with_all_axes
from workbench.compare.changes import changes
from workbench.compare.figures import write_figures
from workbench.compare.intervals import CLOSE
from workbench.compare.matrix import NOTATION, key, matrices, title_of
from workbench.compare.motor_words import motor_in_words
from workbench.compare.overview import answer, cell_name, exactness, hunting, overview
from workbench.compare.results import fresh_results
from workbench.compare.schema import ComparisonTable
from workbench.compare.tables import finalist_table, write_tables
from workbench.compare.templates import HTML, MARKDOWN
from workbench.compare.verdicts import COMPARISONS, Verdict, verdicts
from workbench.compare.words import sentences
from workbench.publish.html import html_environment
from workbench.publish.words import plain_name
from workbench.simulation.run import COMPLETED
from workbench.study.layers import MACHINE, SCENARIO
from workbench.study.resolve import resolve
from workbench.study.study import Study
from workbench.study.unfold import unfold


def write_comparison(spec: ComparisonTable, study: Study, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write tables, figures, comparison.md and comparison.html; returns the pages."""
    fresh = fresh_results(folder)
    found = verdicts(spec, frame, fresh)
    tuned = of_tuned(spec, frame)
    whole = tuned if fresh is None else pd.concat([tuned, fresh], ignore_index=True)
    content: dict[str, Any] = {
        "title": study.file.title,
        "question": study.file.question,
        "scope": scope(spec, frame, fresh),
        "answer": answer(spec, found),
        "matrices": matrices(spec, found),
        "key": key(),
        "notation": NOTATION,
        "overview": overview(spec, tuned, whole, found),
        "finalists": finalist_table(spec, found),
        "changes": changes(spec, frame, found),
        "rules": rules(spec, tuned, fresh),
        "left_out": spec.left_out,
        "assumptions": [*motors(study), *spec.assumptions],
        "titles": {
            name: SCENARIO.read(path)[0].title
            for (section, name), (path, _) in study.sources.items()
            if section == SCENARIO.section
        },
        "details": details(spec, tuned, whole, found),
        "pictures": write_figures(spec, tuned, whole, found, folder / "figures"),
        "pivots": write_tables(spec, tuned, found, folder / "tables"),
    }
    pages = []
    markdown, html = Environment(autoescape=False, keep_trailing_newline=True), html_environment()
    for name, template, environment in (("comparison.md", MARKDOWN, markdown), ("comparison.html", HTML, html)):
        environment.filters |= {"plain": plain_name, "machine": title_of}
        page = folder / name
        page.write_text(environment.from_string(template).render(content), encoding="utf-8")
        pages.append(page)
    return pages


def motors(study: Study) -> list[str]:
    """By machine, which motor turns its rod; nothing of a study without one.

    A folder of results has no gain files: any controller will do.
    """
    plain = {name: {"type": "pid", "kp": 1.0} for name in study.file.controllers}
    study = replace(study, file=study.file.model_copy(update={"controllers": plain}))
    turning = {case.axes.get(MACHINE.axis): case for case in reversed(unfold(study)) if case.rpm}
    told: dict[str, list[str]] = {}
    for name, case in reversed(turning.items()):
        motor = getattr(resolve(study, case).setup.parameters, "motor", None)
        if motor is not None:
            told.setdefault(motor_in_words(motor), []).append(title_of(str(name)) if name else "")
    return [f"{', '.join(names).capitalize()}: {words}" if all(names) else words for words, names in told.items()]


def scope(spec: ComparisonTable, frame: pd.DataFrame, fresh: pd.DataFrame | None) -> str:
    """How much was run, and what did not simply complete."""
    again = ""
    if fresh is not None:
        again = f" Measured again: {len(fresh)} cases on {fresh['draw'].nunique()} fresh draws."
    elif spec.fresh_draws:
        again = f" Not yet measured again on {spec.fresh_draws} fresh draws, as the study asks: go on with --resume."
    unusual = frame[frame["outcome"] != COMPLETED]["outcome"].value_counts()
    outcomes = "; ".join(f"{count} {outcome}" for outcome, count in unusual.items())
    whole = with_all_axes(frame)
    counted = [(whole[name].nunique(), words) for name, words in _COUNTED.items()]
    return (
        f"{len(frame)} cases: {', '.join(f'{count} {words}' for count, words in counted)}."
        + (f" Not simply completed: {outcomes}." if outcomes else " All completed.")
        + again
    )


_COUNTED = {
    "machine": "machine(s)",
    "controller": "controllers",
    "rpm": "speeds of rotation",
    "scenario": "scenario(s)",
    "reference": "motion(s)",
    "draw": "draw(s)",
}


def rules(spec: ComparisonTable, frame: pd.DataFrame, fresh: pd.DataFrame | None) -> list[str]:
    """In words, how a verdict is found."""
    draws = with_all_axes(frame)["draw"].nunique()
    if fresh is not None:
        source = "Verdicts rest on fresh draws, which no choice has seen: having picked the best does not flatter it."
    elif draws > 1:
        source = "Verdicts rest on the draws from which the best were chosen, which flatters the best."
    else:
        source = "There is one draw: no intervals, and another draw may give another verdict."
    different = (
        f"Errors count as different if they differ by more than {100 * CLOSE:g} % of the larger and "
        f"{spec.negligible * MM:g} mm (or the solver errors, where these are larger) together"
    )
    paired = [
        f"{different}; one beats another only if the whole interval of the paired comparison lies beyond that, and is "
        "level with it only if the whole interval lies within.",
        "That interval is of log((b + c) / (a + c)), a and b the errors on a draw and c "
        f"{spec.negligible / CLOSE * MM:g} mm, so that errors too small to count weigh nothing. The ratio told beside "
        "it is the geometric mean of b / a over the draws, the difference that of the mean errors.",
        f"Intervals: Student's t on paired draws, of logarithms for ratios; the {COMPARISONS} comparisons of a field "
        f"hold together with {100 * spec.probability:g} % (Bonferroni), the interval of a single error with as much "
        "alone.",
    ]
    rarely = (
        "Where one errs less than whoever holds of its class, but hunts on so few draws that it may be on no more than "
        f"{100 * RARE:g} % of the machines, a verdict that would be another with that one cannot be told."
    )
    hunted = rarely if fresh is None else f"Whoever stands behind it is then measured, until one holds. {rarely}"
    return [
        source,
        *(paired if draws > 1 or fresh is not None else [f"{different}."]),
        "What hunts, or may hunt, in any draw never wins in any motion of that scenario; nor does what does not "
        f"complete or is torque-limited. {hunted}",
        exactness(spec, with_all_axes(frame)),
    ]


def details(
    spec: ComparisonTable, frame: pd.DataFrame, whole: pd.DataFrame, found: Mapping[Cell, Verdict]
) -> dict[str, list[str]]:
    """By scenario, what is said of each of its cells, and who hunts on any draw; `whole` has the fresh ones too."""
    told: dict[str, list[str]] = {}
    for cell, verdict in found.items():
        name = cell_name(cell, machine=True)
        source = "" if verdict.fresh or len(with_all_axes(frame)["draw"].unique()) == 1 else " (draws of the choice)"
        lines = " ".join(sentences(spec, verdict))
        told.setdefault(cell.scenario, []).append(f"{name[:1].upper()}{name[1:]}{source}: {lines}")
    whole = with_all_axes(whole)
    return {scenario: [*lines, *hunting(whole[whole["scenario"] == scenario])] for scenario, lines in told.items()}
