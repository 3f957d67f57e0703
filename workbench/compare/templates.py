"""How the page of a comparison is laid out, in Markdown and in HTML."""

MARKDOWN = """\
# {{ title }}

{{ question }}

{% for line in answer -%}
- {{ line }}
{% endfor %}
{{ scope }}
{% for matrix in matrices %}
## {{ matrix.machine | machine }}

| |{% for reference in matrix.references %} {{ reference | plain }} |{% endfor %}
|:--|{% for reference in matrix.references %}:--|{% endfor %}
{%- for scenario, fields in matrix.rows.items() %}
| {{ scenario | plain }} |
{%- for field in fields %}{% if field %} **{{ field.word }}**{% if field.margin %}<br>{{ field.margin }}{% endif %}
{%- if field.price %}<br>{{ field.price }}{% endif %}{% endif %} |{% endfor %}
{%- endfor %}
{% endfor %}
{%- for word, _, meaning in key %}
- **{{ word }}**: {{ meaning }}
{%- endfor %}

{{ notation }}

## In words
{% for line in overview %}
- {{ line }}
{%- endfor %}

## Who was measured

{{ finalists.to_markdown(index=False, disable_numparse=True) }}
{% if changes %}
## What changes the verdicts
{% for line in changes %}
- {{ line }}
{%- endfor %}
{% endif %}
## How it is judged
{% for line in rules %}
- {{ line }}
{%- endfor %}
{% if left_out %}
## Left out
{% for line in left_out %}
- {{ line }}
{%- endfor %}
{% endif %}
{%- if assumptions %}
## Assumptions
{% for line in assumptions %}
- {{ line }}
{%- endfor %}
{% endif %}
{%- for scenario, lines in details.items() %}
## {{ scenario | plain | capitalize }}
{% if titles[scenario] %}
{{ titles[scenario] }}.
{% endif %}
{%- for line in lines %}
- {{ line }}
{%- endfor %}
{% endfor %}
## Figures
{% for name, picture in pictures.items() %}
![{{ name | plain }}](figures/{{ name }}.png)

*{{ picture.caption }}*
{% endfor %}
{%- for scenario in details %}
## Tables of the draws of the choice: {{ scenario | plain }}
{% for pivot in pivots if pivot.scenario == scenario %}
**{{ pivot.title }}**

{{ pivot.cells.to_markdown(index=False, disable_numparse=True) }}
{% endfor %}
{%- endfor %}"""

HTML = """\
{% extends "frame" %}
{% block style -%}
body { max-width: 84em; }
p, li { max-width: 60em; }
.matrices { display: flex; flex-wrap: wrap; gap: 1.5em; align-items: flex-start; }
.matrices table { flex: 1 1 36em; table-layout: fixed; }
.matrices td, .matrices th { text-align: left; vertical-align: top; border: 1px solid #666; padding: 0.4em;
  print-color-adjust: exact; -webkit-print-color-adjust: exact; }
.matrices th:first-child { width: 6em; }
.matrices td small { display: block; line-height: 1.3; }
.key { list-style: none; padding: 0; }
.key span { display: inline-block; border: 1px solid #666; padding: 0 0.4em; font-weight: bold;
  print-color-adjust: exact; -webkit-print-color-adjust: exact; }
.answer { font-weight: bold; }
.wide { overflow-x: auto; }
.finalists td, .finalists th { text-align: left; }
{% endblock %}
{% block body -%}
<h1>{{ title }}</h1>
{% if question %}<p>{{ question }}</p>
{% endif %}<ul class="answer">{% for line in answer %}<li>{{ line }}</li>
{% endfor %}</ul>
<p>{{ scope }}</p>
<div class="matrices">
{% for matrix in matrices %}
<table>
<caption>{{ matrix.machine | machine }}</caption>
<tr><th></th>{% for reference in matrix.references %}<th>{{ reference | plain }}</th>{% endfor %}</tr>
{% for scenario, fields in matrix.rows.items() %}<tr><th>{{ scenario | plain }}</th>
{% for field in fields %}{% if field %}<td style="background: {{ field.colour }}"><b>{{ field.word }}</b>
{% if field.margin %}<small>{{ field.margin }}</small>
{% endif %}{% if field.price %}<small>{{ field.price }}</small>{% endif %}</td>{% else %}<td></td>{% endif %}
{% endfor %}</tr>
{% endfor %}</table>
{% endfor %}
</div>
<ul class="key">{% for word, colour, meaning in key %}
<li><span style="background: {{ colour }}">{{ word }}</span> {{ meaning }}</li>
{% endfor %}</ul>
<p>{{ notation }}</p>
<h2>In words</h2>
<ul>{% for line in overview %}<li>{{ line }}</li>
{% endfor %}</ul>
<h2>Who was measured</h2>
<div class="wide"><table class="finalists">
<tr>{% for name in finalists.columns %}<th>{{ name }}</th>{% endfor %}</tr>
{% for row in finalists.itertuples(index=False) %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table></div>
{% if changes %}
<h2>What changes the verdicts</h2>
<ul>{% for line in changes %}<li>{{ line }}</li>
{% endfor %}</ul>
{% endif %}
<h2>How it is judged</h2>
<ul>{% for line in rules %}<li>{{ line }}</li>
{% endfor %}</ul>
{% if left_out %}
<h2>Left out</h2>
<ul>{% for line in left_out %}<li>{{ line }}</li>
{% endfor %}</ul>
{% endif %}{% if assumptions %}
<h2>Assumptions</h2>
<ul>{% for line in assumptions %}<li>{{ line }}</li>
{% endfor %}</ul>
{% endif %}
{% for scenario, lines in details.items() %}
<h2>{{ scenario | plain | capitalize }}</h2>
{% if titles[scenario] %}<p>{{ titles[scenario] }}.</p>{% endif %}
<ul>{% for line in lines %}<li>{{ line }}</li>
{% endfor %}</ul>
{% endfor %}
<h2>Figures</h2>
{% for name, picture in pictures.items() %}
<figure><img src="figures/{{ name }}.png" alt="{{ name | plain }}">
<figcaption>{{ picture.caption }}</figcaption></figure>
{% endfor %}
<h2 id="tables">Tables of the draws of the choice</h2>
{% for scenario in details %}
<details><summary>{{ scenario | plain | capitalize }}</summary>
{% for pivot in pivots if pivot.scenario == scenario %}
<div class="wide"><table>
<caption>{{ pivot.title }}</caption>
<tr>{% for name in pivot.cells.columns %}<th>{{ name | plain }}</th>{% endfor %}</tr>
{% for row in pivot.cells.itertuples(index=False) %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table></div>
{% endfor %}
</details>
{% endfor %}
{% endblock %}
"""
