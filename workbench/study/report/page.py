"""The page of a study's results: what the figures say first, then tables, figures, and every case with its motion."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from workbench.metrics.limit_cycle import HUNTING
from workbench.metrics.registry import axis_of
from workbench.publish.folders import anew
from workbench.publish.page.environment import page_environment
from workbench.publish.page.stored import stored_table
from workbench.publish.pictures import Picture
from workbench.publish.words import listed, plain_name
from workbench.study.names import in_words
from workbench.study.report.cases import cases_of
from workbench.study.report.figures import draw
from workbench.study.report.select import axes_of
from workbench.study.report.shown_figures import FIGURES, column_along, shown_figure, shown_unit
from workbench.study.report.unusual import unusual
from workbench.study.sections import overlays_of
from workbench.study.store import DRAWS
from workbench.study.study import Study
from workbench.study.uncertainty_schema import drawn_from

PAGE = "results.html"

NAMED = 4
"""Cases that are named in a sentence, at most."""

SPANNED = ("phase_lag_deg", "rms_error_m", "steady_state_error_m")
"""Figures of which the page first says between what they lie."""

DIGITS = 3

_HTML = """\
{% extends "frame.html" %}
{% from "parts.html" import show, draw, drawn_elsewhere with context %}
{% block title %}{{ title }}{% endblock %}
{% block kind %}study{% endblock %}
{% block picture %}{{ ((pictures | list) + others) | first }}{% endblock %}
{% block summary %}{{ lines | join(" ") }}{% endblock %}
{% block body %}
<h1>{{ title }}</h1>
{% if question %}<p>{{ question }}</p>
{% endif %}<ul class="answer">
{% for line in lines %}<li>{{ line }}</li>
{% endfor %}</ul>
{% if drawn %}<p class="note">{{ drawn }} What differs between them is in <a href="draws.csv">draws.csv</a>.</p>
{% endif %}{% if tables %}<h2>Tables</h2>
{% for table in tables %}{{ show(table) }}
{% endfor %}{% endif %}
{% if pictures or others %}<h2>Figures</h2>
{% for name, picture in pictures.items() %}{{ draw(name, picture) }}
{% endfor %}{% for name in others %}{{ drawn_elsewhere(name) }}
{% endfor %}{% endif %}
{% with section = cases %}{% include "every_case.html" %}{% endwith %}
<p>Files: <a href="results.csv">results.csv</a> and results.parquet (every case, SI),
<a href="study.toml">study.toml</a> (the study; <code>workbench run study.toml</code> gives the same again),
{% if tables %}tables/ (CSV, Markdown, LaTeX), {% endif -%}
{% if pictures or others %}figures/ (PDF, SVG, PNG), {% endif -%}
<a href="run.json">run.json</a> (versions, seeds, duration).</p>
{% endblock %}
"""


def write_results_page(study: Study, frame: pd.DataFrame, folder: Path) -> Path:
    """Write the page of finished results, from the tables and figures that lie in `folder`; returns its path."""
    own = {spec.name: spec for spec in study.file.figures}
    drawn = sorted(path.stem for path in (folder / "figures").glob("*.png"))
    measured = overlays_of(study)
    path = folder / PAGE
    (
        page_environment(folder)
        .from_string(_HTML)
        .stream(
            title=study.file.title,
            question=study.file.question,
            lines=first_lines(frame),
            drawn=_drawn(study) if (folder / DRAWS).exists() else "",
            tables=[
                stored_table(path) for path in _ordered(folder / "tables", [spec.name for spec in study.file.tables])
            ],
            pictures={
                name: Picture(draw(spec, frame, folder, measured), spec.title)
                for name, spec in own.items()
                if name in drawn
            },
            others=[name for name in drawn if name not in own],
            cases=cases_of(frame, folder),
        )
        .dump(str(anew(path)), encoding="utf-8")  # piece by piece: sketches are large
    )
    return path


def _drawn(study: Study) -> str:
    """From what the machines of a study are drawn, in a sentence."""
    table = study.file.uncertainty
    if table is None:
        return ""
    friction = f"friction by {table.friction:g} times its standard deviations" if table.friction else ""
    return (
        f"Machines are drawn (seed {table.seed}): {'; '.join(part for part in (friction, *drawn_from(table)) if part)}."
    )


def _ordered(folder: Path, first: Sequence[str]) -> list[Path]:
    """The tables of a folder: those of the study in its order, then the others."""
    names = sorted(path.stem for path in folder.glob("*.md"))
    chosen = [name for name in first if name in names]
    return [folder / f"{name}.md" for name in [*chosen, *(name for name in names if name not in first)]]


def first_lines(frame: pd.DataFrame) -> list[str]:
    """What the figures of all cases say: what did not complete, who hunts, and between what errors lie."""
    lines = unusual(frame, frame) or [f"{len(frame)} case{'s' * (len(frame) > 1)}, all completed."]
    axes = axes_of(frame.columns)
    apart = [name for name in axes if frame[name].nunique(dropna=False) > 1]
    lines += _hunting(frame, apart)
    axis = axis_of([str(name) for name in frame.columns])
    words = dict(FIGURES)
    for name in SPANNED:
        lines += _span(frame, name, axis, words[name], apart)
    return [line if line.endswith(".") else f"{line}." for line in lines]


def _hunting(frame: pd.DataFrame, apart: Sequence[str]) -> list[str]:
    judged = frame[frame["limit_cycle"].notna()]
    if judged.empty:
        return []
    hunts = judged[judged["limit_cycle"].isin(HUNTING)]
    if hunts.empty:
        return [f"No limit cycle in {len(judged)} case{'s' * (len(judged) > 1)} that held still"]
    named = [_case(row, apart) for row in _rows(hunts.head(NAMED))]
    more = [f"{len(hunts) - NAMED} more"] if len(hunts) > NAMED else []
    return [f"{len(hunts)} of {len(judged)} cases that held still hunt: {listed([*named, *more])}"]


def _span(frame: pd.DataFrame, name: str, axis: str, words: str, apart: Sequence[str]) -> list[str]:
    """From the least to the largest magnitude of a figure, with the cases that have them."""
    column, unit = column_along(name, axis), shown_unit(name, axis)[0]
    sizes = pd.to_numeric(frame[column]).abs().dropna() if column in frame else pd.Series(dtype=float)
    if len(sizes) < 2 or sizes.max() == 0.0:
        return []
    ends = sizes.iloc[sizes.to_numpy().argsort(kind="stable")[[0, -1]]]
    cases = [_case(row, apart) for row in _rows(frame.loc[ends.index])]
    told = [
        f"{shown_figure(name, float(size), axis, DIGITS)} {unit} ({case})"
        for size, case in zip(ends, cases, strict=True)
    ]
    return [f"{words[:1].upper()}{words[1:]} from {' to '.join(told)}"]


def _rows(frame: pd.DataFrame) -> list[dict[str, object]]:
    return [{str(name): value for name, value in row.items()} for row in frame.to_dict("records")]


def _case(row: Mapping[str, object], apart: Sequence[str]) -> str:
    """A case by what tells it apart."""
    told = {name: row[name] for name in apart if row[name] is not None and row[name] == row[name]}
    shown = {
        name: f"{value:.12g}" if isinstance(value, float) else plain_name(str(value)) for name, value in told.items()
    }
    return in_words(shown)
