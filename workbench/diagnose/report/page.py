"""The page of a diagnosis: what was found, how sure it is, and the figures and tables by which to check it."""

from collections.abc import Mapping
from pathlib import Path

from workbench.diagnose.report.series import title_of
from workbench.diagnose.report.sureness import sureness
from workbench.diagnose.report.verdict import next_words, verdict_sentence
from workbench.diagnose.residuals.balance import SIMULATION
from workbench.diagnose.result import Diagnosis
from workbench.publish.along import SHOWN
from workbench.publish.page.environment import page_environment
from workbench.publish.pictures import Picture
from workbench.publish.tables import Table
from workbench.publish.words import plain_name

_HTML = """\
{% extends "frame.html" %}
{% from "parts.html" import show, draw with context %}
{% block title %}Diagnosis: {{ title }}{% endblock %}
{% block kind %}diagnosis{% endblock %}
{% block picture %}{{ pictures | first }}{% endblock %}
{% block summary %}{{ verdict }}{% endblock %}
{% block style -%}
td { white-space: nowrap; }
{% endblock %}
{% block body %}
<h1>{{ title }}</h1>
<p class="answer">{{ verdict }}</p>
<p>{{ scope }} <a href="plant.toml">plant.toml</a> is {{ plant }}.</p>
<h2>How sure</h2>
<ul>
{% for line in sureness %}<li>{{ line }}</li>
{% endfor %}</ul>
{% if "effects" in tables %}{{ show(tables["effects"]) }}{% endif %}
{{ show(tables["error"]) }}
{% if "effects" in tables %}<p><em>Before</em> is the declared plant with its own parameters fitted first, so that
nothing is called an effect that better parameters remove. <em>After</em> is the same plant with the effects that were
{{ "tried" if rejected else "found" }}, all refitted together.
{%- else %}<p>The errors are those of the declared plant with its own parameters fitted: nothing was added to it.
{%- endif %} The noise floor is what the sensors' noise alone leaves.</p>
{% for balance in balances %}
<h2>{{ balance.title }}</h2>
<p>{{ balance.words }}</p>
{% for name in balance.names %}{{ draw(name, pictures[name]) }}{% endfor %}
{% endfor %}
<h2>Parameters</h2>
{% if "parameters" in pictures %}{{ draw("parameters", pictures["parameters"]) }}{% endif %}
{{ show(tables["parameters"]) }}
<details><summary>Every candidate in numbers</summary>
{{ show(tables["evidence"]) }}
</details>
<p>Files: <a href="report.json">report.json</a> (SI, for programs), <a href="plant.toml">plant.toml</a>, tables/,
figures/.</p>
{% if next %}<p><strong>{{ next }}</strong></p>
{% endif %}{% endblock %}
"""

BALANCES = {
    "flow": "What the valve (or the pump) delivers, less what the piston and the compressed oil take up.",
    "force": "What drives the mass, less its inertia and the friction of the plant along the measured motion.",
    SIMULATION: "What the sensors would have shown of the plant, driven by the measured input alone; where a sensor "
    "with noise shows what drives it, kept beside the record by a filter. Nothing is smoothed "
    "here: where the plant lacks nothing, the sensors' noise is all that is left.",
}
"""Each balance for a reader who has not met it."""


def page(
    diagnosis: Diagnosis, pictures: Mapping[str, Picture], tables: Mapping[str, Table], plant: str, folder: Path
) -> str:
    """The page as HTML, to lie in `folder`, whose figures are on it."""
    balances = [
        {
            "title": title_of(result.balance),
            "words": SHOWN[diagnosis.axis].said(BALANCES.get(result.balance.name, "")),
            "names": [name for name, picture in pictures.items() if picture.section == result.balance.name],
        }
        for result in diagnosis.rounds
    ]
    template = page_environment(folder).from_string(_HTML)
    return template.render(
        title=diagnosis.experiment.title,
        verdict=verdict_sentence(diagnosis),
        scope=_scope(diagnosis),
        sureness=sureness(diagnosis),
        rejected=diagnosis.is_rejected,
        balances=balances,
        pictures=pictures,
        tables=tables,
        plant=plant,
        next=next_words(diagnosis, "DIR"),
    )


def _scope(diagnosis: Diagnosis) -> str:
    experiment = diagnosis.experiment
    records = diagnosis.results[0].balance.motions
    seconds = sum(float(motion.time[-1] - motion.time[0]) for motion in records)
    held_out = sum(spec.use == "held_out" for spec in experiment.records)
    tested = {0: "no record is held out", 1: "one is held out"}.get(held_out, f"{held_out} are held out")
    return (
        f"Declared plant: {experiment.plant.name}, {experiment.declared}. {len(records)} "
        f"record{'s' * (len(records) > 1)} of {seconds:.0f} s in all for the fit; {tested}. "
        f"Channels: {', '.join(plain_name(channel.called) for channel in experiment.channels.values())}."
    )
