"""The page of a comparison, as Markdown and as HTML: what was run, what the tables say, the figures, the tables."""

from pathlib import Path

import pandas as pd
from jinja2 import Environment

from workbench.report.comparison import Pivot, sentences, write_tables
from workbench.report.comparison_figures import write_figures
from workbench.study.schema import StudyFile

_MARKDOWN = """\
# {{ title }}

{{ question }}

{{ scope }}
{% for line in assumptions %}
- {{ line }}
{%- endfor %}
{% for scenario, lines in words.items() %}
## {{ scenario | replace("_", " ") | capitalize }}
{% for line in lines %}
- {{ line }}
{%- endfor %}
{% endfor %}
## Figures
{% for picture in pictures %}
![{{ picture.stem | replace("_", " ") }}](figures/{{ picture.name }})
{% endfor %}
## Tables
{% for pivot in pivots %}
**{{ pivot.title }}**

{{ pivot.cells.to_markdown(index=False) }}
{% endfor %}"""

_HTML = """\
<!doctype html>
<html lang="en">
<head>
<meta charset="utf-8">
<title>{{ title }}</title>
<style>
body { font: 16px/1.5 sans-serif; max-width: 60em; margin: 2em auto; padding: 0 1em; color: #222; }
table { border-collapse: collapse; margin: 0.5em 0 1.5em; font-size: 0.85em; }
caption { text-align: left; font-weight: bold; padding: 0.3em 0; }
th, td { border-bottom: 1px solid #ccc; padding: 0.15em 0.8em; text-align: right; }
img { max-width: 100%; }
</style>
</head>
<body>
<h1>{{ title }}</h1>
<p>{{ question }}</p>
<p>{{ scope }}</p>
<ul>{% for line in assumptions %}<li>{{ line }}</li>{% endfor %}</ul>
{% for scenario, lines in words.items() %}
<h2>{{ scenario | replace("_", " ") | capitalize }}</h2>
<ul>{% for line in lines %}<li>{{ line }}</li>
{% endfor %}</ul>
{% endfor %}
<h2>Figures</h2>
{% for picture in pictures %}
<p><img src="figures/{{ picture.name }}" alt="{{ picture.stem | replace("_", " ") }}"></p>
{% endfor %}
<h2>Tables</h2>
{% for pivot in pivots %}
<table>
<caption>{{ pivot.title }}</caption>
<tr>{% for name in pivot.cells.columns %}<th>{{ name }}</th>{% endfor %}</tr>
{% for row in pivot.cells.itertuples(index=False) %}<tr>{% for cell in row %}<td>{{ cell }}</td>{% endfor %}</tr>
{% endfor %}</table>
{% endfor %}
</body>
</html>
"""


def write_comparison(file: StudyFile, frame: pd.DataFrame, folder: Path) -> list[Path]:
    """Write tables, figures, comparison.md and comparison.html of a study with a [comparison]; returns the pages."""
    spec = file.comparison
    if spec is None:
        return []
    made: list[Pivot] = write_tables(spec, frame, folder / "tables")
    content = {
        "title": file.title,
        "question": file.question,
        "scope": _scope(frame),
        "assumptions": spec.assumptions,
        "words": sentences(spec, frame),
        "pictures": write_figures(spec, frame, folder / "figures"),
        "pivots": made,
    }
    pages = []
    for name, template, escape in (("comparison.md", _MARKDOWN, False), ("comparison.html", _HTML, True)):
        environment = Environment(autoescape=escape, keep_trailing_newline=True)
        page = folder / name
        page.write_text(environment.from_string(template).render(content), encoding="utf-8")
        pages.append(page)
    return pages


def _scope(frame: pd.DataFrame) -> str:
    unusual = frame[frame["outcome"] != "completed"]["outcome"].value_counts()
    outcomes = "; ".join(f"{count} {outcome}" for outcome, count in unusual.items())
    return (
        f"{len(frame)} cases: {frame['controller'].nunique()} controllers, "
        f"{frame['rpm'].nunique()} speeds of rotation, "
        f"{frame['scenario'].nunique()} scenarios, {frame['reference'].nunique()} references."
        + (f" Not simply completed: {outcomes}." if outcomes else " All completed.")
    )
