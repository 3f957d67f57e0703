"""The page of a comparison, as Markdown and as HTML: the matrix first, then its words, who was measured, what changes
it, what it does not hold, and the details.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import pandas as pd
from jinja2 import Environment

from workbench.compare.candidates import MM, RARE
from workbench.compare.intervals import CLOSE
from workbench.compare.report.figures import write_figures
from workbench.compare.report.matrix import KEY, NOTATION, KeyEntry, Matrix, matrices, title_of
from workbench.compare.report.motor import motor_in_words
from workbench.compare.report.overview import (
    answer,
    change_sentence,
    exactness_sentence,
    hunting_sentences,
    overview,
)
from workbench.compare.report.tables import Pivot, finalist_table, write_tables
from workbench.compare.report.templates import HTML, MARKDOWN
from workbench.compare.report.words import sentences
from workbench.compare.result import Comparison
from workbench.compare.verdicts import COMPARISONS
from workbench.publish.folders import anew
from workbench.publish.markdown import in_markdown
from workbench.publish.page.environment import page_environment
from workbench.publish.pictures import Picture
from workbench.publish.words import plain_name
from workbench.simulation.run import COMPLETED
from workbench.study.layers import MACHINE, SCENARIO
from workbench.study.report.cases import Cases, cases_of
from workbench.study.resolve import resolve
from workbench.study.study import Study
from workbench.study.unfold import unfold


@dataclass(frozen=True, eq=False)
class Scenario:
    """What the page says of a scenario: its own title, a line a cell and who hunts, and its tables."""

    name: str
    title: str
    lines: Sequence[str]
    pivots: Sequence[Pivot]


@dataclass(frozen=True, eq=False)
class Page:
    """All that stands on the page, in its order."""

    title: str
    question: str
    answer: Sequence[str]
    scope: str
    matrices: Sequence[Matrix]
    key: Sequence[KeyEntry]
    notation: str
    overview: Sequence[str]
    finalists: pd.DataFrame
    changes: Sequence[str]
    rules: Sequence[str]
    left_out: Sequence[str]
    assumptions: Sequence[str]
    scenarios: Sequence[Scenario]
    pictures: Mapping[str, Picture]
    cases: Cases


def write_comparison(comparison: Comparison, folder: Path) -> list[Path]:
    """Write tables, figures, comparison.md and comparison.html; returns the pages."""
    pictures, pivots = write_figures(comparison, folder / "figures"), write_tables(comparison, folder / "tables")
    content = page_of(comparison, pictures, pivots, cases_of(comparison.results, folder))
    pages = []
    markdown, html = Environment(autoescape=False, keep_trailing_newline=True, finalize=_text), page_environment(folder)
    for name, template, environment in (("comparison.md", MARKDOWN, markdown), ("comparison.html", HTML, html)):
        environment.filters["plain"] = plain_name
        path = folder / name
        environment.from_string(template).stream(page=content).dump(str(anew(path)), encoding="utf-8")
        pages.append(path)
    return pages


def _text(value: object) -> object:
    """What a template of Markdown shows; what is no text stays."""
    return in_markdown(value) if isinstance(value, str) else value


def page_of(comparison: Comparison, pictures: Mapping[str, Picture], pivots: Sequence[Pivot], cases: Cases) -> Page:
    """The content of the page, with these figures and tables on it."""
    file, table = comparison.study.file, comparison.table
    return Page(
        title=file.title,
        question=file.question,
        answer=answer(comparison),
        scope=scope(comparison),
        matrices=matrices(comparison),
        key=KEY,
        notation=NOTATION,
        overview=overview(comparison),
        finalists=finalist_table(comparison),
        changes=[change_sentence(change) for change in comparison.changes],
        rules=rules(comparison),
        left_out=table.left_out,
        assumptions=[*motors(comparison.study), *table.assumptions],
        scenarios=scenarios(comparison, pivots),
        pictures=pictures,
        cases=cases,
    )


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


def scope(comparison: Comparison) -> str:
    """How much was run, and what did not simply complete."""
    results, fresh, again = comparison.results, comparison.fresh, ""
    if fresh is not None:
        again = f" Measured again: {len(fresh)} cases on {fresh['draw'].nunique()} fresh draws."
    elif asked := comparison.table.fresh_draws:
        again = f" Not yet measured again on {asked} fresh draws, as the study asks: go on with --resume."
    unusual = results[results["outcome"] != COMPLETED]["outcome"].value_counts()
    outcomes = "; ".join(f"{count} {outcome}" for outcome, count in unusual.items())
    numbers = {words: results[axis].nunique() for axis, words in COUNTED.items()}
    counted = ", ".join(f"{number} {one if number == 1 else several}" for (one, several), number in numbers.items())
    ended = f" Not simply completed: {outcomes}." if outcomes else " All completed."
    return f"{len(results)} cases: {counted}.{ended}{again}"


COUNTED = {
    "machine": ("machine", "machines"),
    "controller": ("controller", "controllers"),
    "rpm": ("speed of rotation", "speeds of rotation"),
    "scenario": ("scenario", "scenarios"),
    "reference": ("motion", "motions"),
    "draw": ("draw", "draws"),
}
"""The axes whose values are counted, in words of one and of several."""


def rules(comparison: Comparison) -> list[str]:
    """In words, how a verdict is reached."""
    table, fresh, several = comparison.table, comparison.fresh is not None, comparison.samples > 1
    if fresh:
        source = "Verdicts rest on fresh draws, which no choice has seen: having picked the best does not flatter it."
    elif several:
        source = "Verdicts rest on the draws from which the best were chosen, which flatters the best."
    else:
        source = "There is one draw: no intervals, and another draw may give another verdict."
    different = (
        f"Errors count as different if they differ by more than {100 * CLOSE:g} % of the larger and "
        f"{table.negligible * MM:g} mm (or the solver errors, where these are larger) together"
    )
    paired = [
        f"{different}; one beats another only if the whole interval of the paired comparison lies beyond that, and is "
        "level with it only if the whole interval lies within.",
        "That interval is of log((b + c) / (a + c)), a and b the errors on a draw and c "
        f"{table.negligible / CLOSE * MM:g} mm, so that errors too small to count weigh nothing. The ratio told beside "
        "it is the geometric mean of b / a over the draws, the difference that of the mean errors.",
        f"Intervals: Student's t on paired draws, of logarithms for ratios; the {COMPARISONS} comparisons of a field "
        f"hold together with {100 * table.probability:g} % (Bonferroni), the interval of a single error with as much "
        "alone.",
    ]
    rarely = (
        "Where one errs less than whoever holds of its class, but hunts on so few draws that it may be on no more than "
        f"{100 * RARE:g} % of the machines, a verdict that would be another with that one cannot be told."
    )
    hunted = rarely if not fresh else f"Whoever stands behind it is then measured, until one holds. {rarely}"
    return [
        source,
        *(paired if several or fresh else [f"{different}."]),
        "What hunts, or may hunt, in any draw never wins in any motion of that scenario; nor does what does not "
        f"complete or is torque-limited. {hunted}",
        exactness_sentence(comparison),
    ]


def scenarios(comparison: Comparison, pivots: Sequence[Pivot]) -> list[Scenario]:
    """By scenario, what is said of each of its cells, who hunts on any plant sample, and its tables."""
    titles = {
        name: SCENARIO.read(path)[0].title
        for (section, name), (path, _) in comparison.study.sources.items()
        if section == SCENARIO.section
    }
    lines: dict[str, list[str]] = {}
    for cell, verdict in comparison.verdicts.items():
        name = cell.whole_words
        source = "" if verdict.fresh or comparison.samples == 1 else " (draws of the choice)"
        told = " ".join(sentences(comparison.table, verdict))
        lines.setdefault(cell.scenario, []).append(f"{name[:1].upper()}{name[1:]}{source}: {told}")
    return [
        Scenario(
            name,
            titles.get(name, ""),
            [*own, *hunting_sentences(comparison, name)],
            [pivot for pivot in pivots if pivot.scenario == name],
        )
        for name, own in lines.items()
    ]
