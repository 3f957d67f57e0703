"""The page of a tuning: what the numbers say, what was held equal, tables and figures."""

from collections.abc import Mapping
from pathlib import Path

from workbench.publish.page.environment import page_environment
from workbench.tune.report.panels import Pictures
from workbench.tune.report.tables import Table
from workbench.tune.report.words import held_equal, sentences
from workbench.tune.result import Tuning

_HTML = """\
{% extends "frame.html" %}
{% from "parts.html" import show, draw with context %}
{% block title %}Tuning: {{ title }}{% endblock %}
{% block kind %}tuning{% endblock %}
{% block picture %}{{ (shared + own) | first }}{% endblock %}
{% block summary %}{{ words[:2] | join(' ') }}{% endblock %}
{% block style -%}
td:not(.words) { white-space: nowrap; }
.pairs { display: grid; grid-template-columns: repeat(auto-fit, minmax(26em, 1fr)); gap: 0 1em; }
{% endblock %}
{% block body %}
<h1>{{ title }}</h1>
{% if question %}<p>{{ question }}</p>{% endif %}
<ul class="answer">
{% for line in words[:2] %}<li>{{ line }}</li>
{% endfor %}</ul>
<ul>
{% for line in words[2:] %}<li>{{ line }}</li>
{% endfor %}</ul>
<h2>What was held equal</h2>
<ul>
{% for line in equal %}<li>{{ line }}</li>
{% endfor %}</ul>
<h2>Tables</h2>
{% for table in tables %}{{ show(table) }}
{% endfor %}
<h2>Figures</h2>
{% for name in shared %}{{ draw(name, pictures[name]) }}
{% endfor %}
<div class="pairs">
{% for name in own %}{{ draw(name, pictures[name]) }}
{% endfor %}</div>
{% for line in missing %}<p>{{ line }}</p>
{% endfor %}
<p>Files: tuned/NAME.toml (a study names one by <code>gains = "tuned/NAME.toml"</code>),
<a href="results.csv">results.csv</a> and <a href="trials.csv">trials.csv</a> (SI, for programs), tables/, figures/,
<a href="run.json">run.json</a>.</p>
{% endblock %}
"""


def page(tuning: Tuning, tables: Mapping[str, Table], pictures: Pictures, folder: Path) -> str:
    """The page as HTML, to lie in `folder`, whose figures are on it."""
    template = page_environment(folder).from_string(_HTML)
    return template.render(
        title=tuning.study.file.title,
        question=tuning.study.file.question,
        words=sentences(tuning),
        equal=held_equal(tuning),
        tables=list(tables.values()),
        pictures={**pictures.shared, **pictures.own},
        shared=list(pictures.shared),
        own=list(pictures.own),
        missing=pictures.missing,
    )
