"""The page of a design: what to record, how surely it decides, what remains open, how to run it."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from workbench.design.report.words import answer, how_run, shapes, undecided, verdicts
from workbench.design.result import Design
from workbench.publish.page.environment import page_environment
from workbench.publish.pictures import Picture
from workbench.publish.tables import Table

_HTML = """\
{% extends "frame.html" %}
{% from "parts.html" import show, draw with context %}
{% block title %}What to record next: {{ title }}{% endblock %}
{% block kind %}design{% endblock %}
{% block picture %}{{ pictures | first }}{% endblock %}
{% block summary %}{{ answer }}{% endblock %}
{% block style -%}
td { white-space: nowrap; }
{% endblock %}
{% block body %}
<h1>What to record next: {{ title }}</h1>
<p class="answer">{{ answer }}</p>
<ul>
{% for line in verdicts %}<li>{{ line }}</li>
{% endfor %}</ul>
{% if undecided %}<h2>What remains open</h2>
<ul>
{% for line in undecided %}<li>{{ line }}</li>
{% endfor %}</ul>
{% endif %}<h2>The motion</h2>
{% for name, picture in pictures.items() %}{{ draw(name, picture) }}
{% endfor %}{{ show(tables["pieces"]) }}
<ul>
{% for line in how %}<li>{{ line }}</li>
{% endfor %}</ul>
<h2>How surely</h2>
{% if "pairs" in tables %}{{ show(tables["pairs"]) }}
<p>Records tell a hypothesis where it is likelier by odds of 20 to 1 than a rival that is fitted to them beside it. A
rival that can do all that it does, and more, is always likelier: there it counts that it is not so by these odds. An
interval holds the shares of machines that are drawn from what is known of the parameters.</p>
{% endif %}{% if "parameters" in tables %}{{ show(tables["parameters"]) }}
<p>Before and after, what is declared of the free parameters counts, with the deviation that the file gives or else
within a factor; the others are taken as declared. <code>workbench identify</code> knows the record alone, and counts
deviations that are declared of others against it: its own are larger where that matters.</p>
{% endif %}<h2>What is held against each other</h2>
{{ show(tables["hypotheses"]) }}
{% for line in shapes %}<p>{{ line }}</p>
{% endfor %}
<p>Files: {% for name in files %}<a href="{{ name }}">{{ name }}</a>, {% endfor %}<a href="design.json">design.json</a>
(SI, for programs), tables/, figures/.</p>
{% endblock %}
"""


def page(
    design: Design, pictures: Mapping[str, Picture], tables: Mapping[str, Table], files: Sequence[str], folder: Path
) -> str:
    """The page as HTML, to lie in `folder`, whose figures are on it."""
    template = page_environment(folder).from_string(_HTML)
    return template.render(
        title=design.experiment.title,
        answer=answer(design),
        verdicts=verdicts(design),
        undecided=undecided(design),
        shapes=shapes(design),
        how=how_run(design),
        pictures=pictures,
        tables=tables,
        files=files,
    )
