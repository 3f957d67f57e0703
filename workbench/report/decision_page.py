"""The page of a decision: what was asked, the answer in words, figures, tables, what was assumed."""

from collections.abc import Sequence

import pandas as pd

from workbench.decide.decision import Decision
from workbench.report.comparison import plain_name
from workbench.report.comparison_figures import Picture
from workbench.report.decision_words import assumptions, paragraph, question
from workbench.report.html import html_environment

_HTML = """\
{% extends "frame" %}
{% block style -%}
th:first-child, td:first-child { text-align: left; }
.answer { border-left: 0.3em solid #0072B2; padding-left: 0.7em; }
.wide { overflow-x: auto; }
{% endblock %}
{% block body -%}
<h1>{{ title }}</h1>
{% if question %}<p>{{ question }}</p>
{% endif %}<p>{{ asked }}</p>
<p class="answer">{{ answer }}</p>
<h2>Assumed</h2>
<ul>{% for line in assumptions %}<li>{{ line }}</li>
{% endfor %}</ul>
<h2>Figures</h2>
{% for picture in pictures %}
<figure><img src="figures/{{ picture.path.name }}" alt="{{ picture.path.stem | plain }}">
<figcaption>{{ picture.caption }} (<a href="figures/{{ picture.path.stem }}.pdf">PDF</a>)</figcaption></figure>
{% endfor %}
<h2>Tables</h2>
{% for title, cells in tables %}
<div class="wide"><table>
<caption>{{ title }}</caption>
<tr>{% for name in cells.columns %}<th>{{ name }}</th>{% endfor %}</tr>
{% for row in cells.itertuples(index=False) %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table></div>
{% endfor %}
<p>Files: results.csv (each candidate at each speed and spread, SI), draws.parquet (every run), tables/, figures/,
<a href="study.toml">study.toml</a>.</p>
{% endblock %}
"""


def page(found: Decision, pictures: Sequence[Picture], tables: Sequence[tuple[str, pd.DataFrame]]) -> str:
    """The page as HTML; it names the figures in `figures/` beside it."""
    environment = html_environment()
    environment.filters["plain"] = plain_name
    return environment.from_string(_HTML).render(
        title=found.plan.study.file.title,
        question=found.plan.study.file.question,
        asked=question(found),
        answer=paragraph(found),
        assumptions=assumptions(found),
        pictures=pictures,
        tables=tables,
    )
