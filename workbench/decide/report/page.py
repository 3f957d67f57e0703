"""The page of a decision: what was asked, the answer, the matrix, what rotating costs, figures, tables, assumptions."""

from collections.abc import Mapping, Sequence
from pathlib import Path

import pandas as pd

from workbench.decide.report.answer import sentences
from workbench.decide.report.map import fields, heads, key
from workbench.decide.report.words import assumptions, price, question
from workbench.decide.result import Decision
from workbench.publish.page.environment import page_environment
from workbench.publish.pictures import Picture

_HTML = """\
{% extends "frame.html" %}
{% from "parts.html" import cells, draw with context %}
{% block kind %}decision{% endblock %}
{% block picture %}{{ pictures | first }}{% endblock %}
{% block summary %}{{ answer | join(" ") }}{% endblock %}
{% block style -%}
.matrix td { color: #1c2126; text-align: left; border: 1px solid var(--line); padding: 0.4em 0.6em; min-width: 10em; }
.matrix td.asked { outline: 3px solid #000; outline-offset: -3px; }
.matrix th { text-align: left; }
.key span { color: #1c2126; padding: 0.1em 0.5em; border: 1px solid #ccc; }
{% endblock %}
{% block body -%}
<h1>{{ title }}</h1>
{% if question %}<p>{{ question }}</p>
{% endif %}<p>{{ asked }}</p>
<ul class="answer">
{% for line in answer %}<li>{{ line }}</li>
{% endfor %}</ul>
<div class="wide"><table class="matrix">
<caption>What suffices, over speed and spread of friction{% if boxed %} (framed: what was asked){% endif %}</caption>
<tr><th>spread</th>{% for head in heads %}<th>{{ head }}</th>{% endfor %}</tr>
{% for name, row in matrix.items() %}<tr><th>{{ name }}</th>
{%- for field in row %}<td style="background: {{ field.colour }}"{% if field.asked %} class="asked"{% endif %}>
<b>{{ field.word }}</b>{% for line in field.lines %}<br>{{ line }}{% endfor %}</td>{% endfor %}</tr>
{% endfor %}</table></div>
<p class="key">{% for word, colour, meaning in key %}<span style="background: {{ colour }}">{{ word }}</span>
{{ meaning }}{% if not loop.last %}; {% endif %}{% endfor %}.</p>
{% if price %}<h2>What rotating costs</h2>
<p>{{ price }}</p>
{% endif %}<h2>Figures</h2>
{% for name, picture in pictures.items() %}{{ draw(name, picture) }}
{% endfor %}
<h2>Tables</h2>
{% for title, frame in tables %}{% call cells(frame) %}<caption>{{ title }}</caption>
{% endcall %}
{% endfor %}
<h2>Assumed</h2>
<ul>{% for line in assumptions %}<li>{{ line }}</li>
{% endfor %}</ul>
<p>Files: results.csv (each candidate at each speed and spread, SI), draws.parquet (every run), tables/, figures/,
<a href="study.toml">study.toml</a>.</p>
{% endblock %}
"""


def page(
    decision: Decision, pictures: Mapping[str, Picture], tables: Sequence[tuple[str, pd.DataFrame]], folder: Path
) -> str:
    """The page as HTML, to lie in `folder`, whose figures are on it."""
    return (
        page_environment(folder)
        .from_string(_HTML)
        .render(
            title=decision.plan.study.file.title,
            question=decision.plan.study.file.question,
            asked=question(decision),
            answer=sentences(decision),
            matrix=fields(decision),
            heads=heads(decision),
            boxed=len(decision.cells) > 1,
            key=key(decision),
            price=price(decision),
            assumptions=assumptions(decision),
            pictures=pictures,
            tables=tables,
        )
    )
