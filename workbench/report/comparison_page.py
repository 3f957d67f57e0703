"""The page of a comparison, as Markdown and as HTML: what was run, what the tables say, the figures, the tables."""

from pathlib import Path

import pandas as pd
from jinja2 import Environment

from workbench.report.comparison import exactness, plain_name, rule, sentences, write_tables
from workbench.report.comparison_figures import write_figures
from workbench.report.comparison_tuned import changes, of_tuned
from workbench.report.html import html_environment
from workbench.simulation.simulate import COMPLETED
from workbench.study.document import Study
from workbench.study.scenarios import read_scenario

_MARKDOWN = """\
# {{ title }}

{{ question }}

{{ scope }}
{% for line in assumptions %}
- {{ line }}
{%- endfor %}

Tables: {% for scenario in words %}[{{ scenario | plain }}](#tables-{{ scenario | replace("_", "-") }})
{%- if not loop.last %}, {% endif %}{% endfor %}.
{% for scenario, lines in words.items() %}
## {{ scenario | plain | capitalize }}
{% if titles[scenario] %}
{{ titles[scenario] }}.
{% endif %}
{%- for line in lines %}
- {{ line }}
{%- endfor %}
{% endfor %}
{%- if changes %}
## What tuning changes
{% for line in changes %}
- {{ line }}
{%- endfor %}
{% endif %}
## Figures
{% for picture in pictures %}
![{{ picture.path.stem | plain }}](figures/{{ picture.path.name }})

*{{ picture.caption }}*
{% endfor %}
{%- for scenario in words %}
## Tables: {{ scenario | plain }}
{% for pivot in pivots if pivot.scenario == scenario %}
**{{ pivot.title }}**

{{ pivot.cells.to_markdown(index=False, disable_numparse=True) }}
{% endfor %}
{%- endfor %}"""

_HTML = """\
{% extends "frame" %}
{% block body -%}
<h1>{{ title }}</h1>
<p>{{ question }}</p>
<p>{{ scope }}</p>
<ul>{% for line in assumptions %}<li>{{ line }}</li>
{% endfor %}</ul>
<p><a href="#figures">Figures</a>, <a href="#tables">tables</a></p>
{% for scenario, lines in words.items() %}
<h2>{{ scenario | plain | capitalize }}</h2>
{% if titles[scenario] %}<p>{{ titles[scenario] }}.</p>
{% endif %}
<ul>{% for line in lines %}<li>{{ line }}</li>
{% endfor %}</ul>
{% endfor %}
{% if changes %}<h2>What tuning changes</h2>
<ul>{% for line in changes %}<li>{{ line }}</li>
{% endfor %}</ul>
{% endif -%}
<h2 id="figures">Figures</h2>
{% for picture in pictures %}
<figure><img src="figures/{{ picture.path.name }}" alt="{{ picture.path.stem | plain }}">
<figcaption>{{ picture.caption }}</figcaption></figure>
{% endfor %}
<h2 id="tables">Tables</h2>
{% for scenario in words %}
<details><summary>{{ scenario | plain | capitalize }}</summary>
{% for pivot in pivots if pivot.scenario == scenario %}
<table>
<caption>{{ pivot.title }}</caption>
<tr>{% for name in pivot.cells.columns %}<th>{{ name | plain }}</th>{% endfor %}</tr>
{% for row in pivot.cells.itertuples(index=False) %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table>
{% endfor %}
</details>
{% endfor %}
{% endblock %}
"""


def write_comparison(study: Study, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write tables, figures, comparison.md and comparison.html; returns the pages. None without a [comparison]."""
    spec = study.file.comparison
    if spec is None:
        return []
    tuning, whole = changes(spec, frame), frame
    frame = of_tuned(spec, frame)
    content = {
        "title": study.file.title,
        "question": study.file.question,
        "scope": _scope(whole),
        "changes": tuning,
        "assumptions": [rule(spec), exactness(spec, frame), *spec.assumptions],
        "titles": {name: read_scenario(path)[0].title for name, (path, _) in study.sources.items()},
        "words": sentences(spec, frame),
        "pictures": write_figures(spec, frame, folder / "figures"),
        "pivots": write_tables(spec, frame, folder / "tables"),
    }
    pages = []
    markdown, html = Environment(autoescape=False, keep_trailing_newline=True), html_environment()
    for name, template, environment in (("comparison.md", _MARKDOWN, markdown), ("comparison.html", _HTML, html)):
        environment.filters["plain"] = plain_name
        page = folder / name
        page.write_text(environment.from_string(template).render(content), encoding="utf-8")
        pages.append(page)
    return pages


def _scope(frame: pd.DataFrame) -> str:
    unusual = frame[frame["outcome"] != COMPLETED]["outcome"].value_counts()
    outcomes = "; ".join(f"{count} {outcome}" for outcome, count in unusual.items())
    return (
        f"{len(frame)} cases: {frame['controller'].nunique()} controllers, "
        f"{frame['rpm'].nunique()} speeds of rotation, "
        f"{frame['scenario'].nunique()} scenarios, {frame['reference'].nunique()} references."
        + (f" Not simply completed: {outcomes}." if outcomes else " All completed.")
    )
