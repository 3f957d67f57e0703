"""How the page of a comparison is laid out, in Markdown and in HTML."""

MARKDOWN = """\
# {{ page.title }}

{{ page.question }}

{% for line in page.answer -%}
- {{ line }}
{% endfor %}
{{ page.scope }}
{% for matrix in page.matrices %}
## {{ matrix.title }}

| |{% for reference in matrix.references %} {{ reference | plain }} |{% endfor %}
|:--|{% for reference in matrix.references %}:--|{% endfor %}
{%- for row in matrix.rows %}
| {{ row.scenario | plain }} |
{%- for field in row.fields %}{% if field %} **{{ field.word }}**{% if field.margin %}<br>{{ field.margin }}{% endif %}
{%- if field.price %}<br>{{ field.price }}{% endif %}{% endif %} |{% endfor %}
{%- endfor %}
{% endfor %}
{%- for entry in page.key %}
- **{{ entry.word }}**: {{ entry.meaning }}
{%- endfor %}

{{ page.notation }}

## In words
{% for line in page.overview %}
- {{ line }}
{%- endfor %}

## Who was measured

{{ page.finalists.to_markdown(index=False, disable_numparse=True) }}
{% if page.changes %}
## What changes the verdicts
{% for line in page.changes %}
- {{ line }}
{%- endfor %}
{% endif %}
## How it is judged
{% for line in page.rules %}
- {{ line }}
{%- endfor %}
{% if page.left_out %}
## Left out
{% for line in page.left_out %}
- {{ line }}
{%- endfor %}
{% endif %}
{%- if page.assumptions %}
## Assumptions
{% for line in page.assumptions %}
- {{ line }}
{%- endfor %}
{% endif %}
{%- for scenario in page.scenarios %}
## {{ scenario.name | plain | capitalize }}
{% if scenario.title %}
{{ scenario.title }}.
{% endif %}
{%- for line in scenario.lines %}
- {{ line }}
{%- endfor %}
{% endfor %}
## Figures
{% for name, picture in page.pictures.items() %}
![{{ name | plain }}](figures/{{ name | urlencode }}.png)

*{{ picture.caption }}*
{% endfor %}
{%- for scenario in page.scenarios %}
## Tables of the draws of the choice: {{ scenario.name | plain }}
{% for pivot in scenario.pivots %}
**{{ pivot.title }}**

{{ pivot.cells.to_markdown(index=False, disable_numparse=True) }}
{% endfor %}
{%- endfor %}"""

HTML = """\
{% extends "frame.html" %}
{% from "parts.html" import cells, draw with context %}
{% block title %}{{ page.title }}{% endblock %}
{% block kind %}comparison{% endblock %}
{% block picture %}{{ page.pictures | first }}{% endblock %}
{% block summary %}{{ page.answer | join(' ') }}{% endblock %}
{% block style -%}
body { max-width: 84em; }
.matrices { display: flex; flex-wrap: wrap; gap: 1.5em; align-items: flex-start; }
.matrices table { flex: 1 1 36em; table-layout: fixed; }
.matrices td { color: #1c2126; }
.matrices td, .matrices th { text-align: left; vertical-align: top; border: 1px solid #666; padding: 0.4em;
  print-color-adjust: exact; -webkit-print-color-adjust: exact; }
.matrices th:first-child { width: 6em; }
.matrices td small { display: block; line-height: 1.3; color: inherit; }
.key { list-style: none; padding: 0; }
.key span { color: #1c2126; display: inline-block; border: 1px solid #666; padding: 0 0.4em; font-weight: bold;
  print-color-adjust: exact; -webkit-print-color-adjust: exact; }
.finalists td, .finalists th { text-align: left; }
{% endblock %}
{% block body -%}
<h1>{{ page.title }}</h1>
{% if page.question %}<p>{{ page.question }}</p>
{% endif %}<ul class="answer">{% for line in page.answer %}<li>{{ line }}</li>
{% endfor %}</ul>
<p>{{ page.scope }}</p>
<div class="matrices">
{% for matrix in page.matrices %}
<table>
<caption>{{ matrix.title }}</caption>
<tr><th></th>{% for reference in matrix.references %}<th>{{ reference | plain }}</th>{% endfor %}</tr>
{% for row in matrix.rows %}<tr><th>{{ row.scenario | plain }}</th>
{% for field in row.fields %}{% if field %}<td style="background: {{ field.colour }}"
 data-narrow='{{ matrix.narrowed(row, loop.index0) | tojson }}'><b>{{ field.word }}</b>
{% if field.margin %}<small>{{ field.margin }}</small>
{% endif %}{% if field.price %}<small>{{ field.price }}</small>{% endif %}</td>{% else %}<td></td>{% endif %}
{% endfor %}</tr>
{% endfor %}</table>
{% endfor %}
</div>
<ul class="key">{% for entry in page.key %}
<li><span style="background: {{ entry.colour }}">{{ entry.word }}</span> {{ entry.meaning }}</li>
{% endfor %}</ul>
<p>{{ page.notation }}</p>
<p class="note screen">A click on a field shows its cases below, with their motions.</p>
{% with section = page.cases %}{% include "every_case.html" %}{% endwith %}
<h2>In words</h2>
<ul>{% for line in page.overview %}<li>{{ line }}</li>
{% endfor %}</ul>
<h2>Who was measured</h2>
<div class="finalists">{{ cells(page.finalists) }}</div>
{% if page.changes %}
<h2>What changes the verdicts</h2>
<ul>{% for line in page.changes %}<li>{{ line }}</li>
{% endfor %}</ul>
{% endif %}
<h2>How it is judged</h2>
<ul>{% for line in page.rules %}<li>{{ line }}</li>
{% endfor %}</ul>
{% if page.left_out %}
<h2>Left out</h2>
<ul>{% for line in page.left_out %}<li>{{ line }}</li>
{% endfor %}</ul>
{% endif %}{% if page.assumptions %}
<h2>Assumptions</h2>
<ul>{% for line in page.assumptions %}<li>{{ line }}</li>
{% endfor %}</ul>
{% endif %}
{% for scenario in page.scenarios %}
<h2>{{ scenario.name | plain | capitalize }}</h2>
{% if scenario.title %}<p>{{ scenario.title }}.</p>{% endif %}
<ul>{% for line in scenario.lines %}<li>{{ line }}</li>
{% endfor %}</ul>
{% endfor %}
<h2>Figures</h2>
{% for name, picture in page.pictures.items() %}{{ draw(name, picture) }}
{% endfor %}
<h2 id="tables">Tables of the draws of the choice</h2>
{% for scenario in page.scenarios %}
<details><summary>{{ scenario.name | plain | capitalize }}</summary>
{% for pivot in scenario.pivots %}
{% call cells(pivot.cells) %}<caption>{{ pivot.title }}</caption>
{% endcall %}
{% endfor %}
</details>
{% endfor %}
{% endblock %}
"""
