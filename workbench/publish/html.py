"""What all HTML pages have in common: their head, and how text, tables and figures look."""

from jinja2 import DictLoader, Environment

_FRAME = """\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{% block title %}{{ title }}{% endblock %}</title>
<style>
body { font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; margin: 0.5em 0 1.5em; font-size: 0.85em; }
caption { text-align: left; font-weight: bold; padding: 0.3em 0; }
th, td { border-bottom: 1px solid #ccc; padding: 0.15em {% block gap %}0.8em{% endblock %}; text-align: right; }
{% block style %}{% endblock -%}
summary { cursor: pointer; font-weight: bold; margin: 0.5em 0; }
figure { margin: 1.5em 0; }
figcaption { font-size: 0.9em; }
img { max-width: 100%; }
</style>
</head>
<body>
{% block body %}{% endblock -%}
</body>
</html>
"""


_PARTS = """\
{% macro show(table) -%}
<div class="wide"><table>
<caption>{{ table.title }}</caption>
<tr>{% for name in table.cells.columns %}<th>{{ name }}</th>{% endfor %}</tr>
{% for row in table.cells.itertuples(index=False) %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table></div>
{% for line in table.notes %}<p>{{ line }}</p>
{% endfor %}
{%- endmacro %}
{% macro draw(name, picture) -%}
<figure><img src="figures/{{ name }}.png" alt="{{ picture.caption }}">
<figcaption>{{ picture.caption }} (<a href="figures/{{ name }}.pdf">PDF</a>)</figcaption></figure>
{%- endmacro %}
"""


def html_environment() -> Environment:
    """Where templates of pages are rendered: they extend "frame" and fill its blocks title, gap, style and body.

    "parts" has what they show alike: `show` a table with its notes, `draw` a picture of the folder `figures`.
    """
    loader = DictLoader({"frame": _FRAME, "parts": _PARTS})
    return Environment(loader=loader, autoescape=True, keep_trailing_newline=True)
