"""The page of an identification: what was found and how well it fits, figures, tables."""

from collections.abc import Mapping, Sequence
from pathlib import Path

from matplotlib.figure import Figure

from plants.axis import unit_along
from workbench.identify.report.published import SHOWN, scale_shown, unit_shown
from workbench.identify.result import Identification
from workbench.identify.simulation.found import SimulationFit
from workbench.identify.thesis.records import ThesisFit
from workbench.publish.page.environment import page_environment
from workbench.publish.pictures import Picture
from workbench.publish.tables import Table, shown_interval, shown_number
from workbench.publish.words import listed, plain_name
from workbench.records.schema import CHANNELS
from workbench.toml.units import factor

DIGITS = 4

NAMED = 6
"""Records that are named one by one."""

_HTML = """\
{% extends "frame.html" %}
{% from "parts.html" import show, draw with context %}
{% block title %}Identification: {{ title }}{% endblock %}
{% block kind %}identification{% endblock %}
{% block picture %}{{ pictures | first }}{% endblock %}
{% block summary %}{{ lines | join(" ") }}{% endblock %}
{% block body %}
<h1>{{ title }}</h1>
<ul class="answer">
{% for line in lines %}<li>{{ line }}</li>
{% endfor %}</ul>
<p>{{ scope }}</p>
{% for table in tables %}{{ show(table) }}
{% endfor %}
<h2>Figures</h2>
{% for name, picture in pictures.items() %}{{ draw(name, picture) }}
{% endfor %}
<p>Files: <a href="identified.json">identified.json</a> (SI, for programs),
{% if plant %}<a href="plant.toml">plant.toml</a> (the corrected plant, for a study), {% endif %}tables/, figures/.</p>
{% endblock %}
"""


def page(identification: Identification, tables: Sequence[Table], figures: Mapping[str, Figure], folder: Path) -> str:
    """The page as HTML, to lie in `folder`, whose figures are on it."""
    experiment = identification.experiment
    return (
        page_environment(folder)
        .from_string(_HTML)
        .render(
            title=experiment.title,
            lines=first_lines(identification),
            scope=f"Declared plant: {experiment.plant.name}, {experiment.declared}. {_records(identification)}",
            tables=tables,
            pictures={name: Picture(figure, plain_name(name).capitalize()) for name, figure in figures.items()},
            plant=bool(identification.corrected),
        )
    )


def _records(identification: Identification) -> str:
    names = [record.path.name for record in identification.records]
    if len(names) > NAMED:
        return f"{len(names)} records, {names[0]} to {names[-1]}."
    return f"Record{'s' * (len(names) > 1)}: {listed(names)}."


def first_lines(identification: Identification) -> list[str]:
    """What was found: each parameter with its interval, what could not be identified, and how well the plant fits."""
    fit, thesis = identification.simulation, identification.thesis
    if thesis is not None and len(thesis.groups) > 1:
        return _over_speeds(thesis, identification.experiment.plant.axis)
    if identification.refuted:
        lines = [f"Not identified: {identification.refuted}."]
    else:
        found = _found(identification)
        lines = [f"Identified: {listed(found)}."] if found else []
    lacking = [
        *(thesis.unidentified if thesis is not None and fit is None else ()),
        *(fit.unidentified if fit is not None else ()),
    ]
    if lacking:
        lines.append(f"These records do not identify {listed([plain_name(name) for name in lacking], 'or')}.")
    return lines if fit is None else [*lines, *_fits(identification, fit)]


def _over_speeds(fit: ThesisFit, axis: str) -> list[str]:
    """Each parameter at the first speed of rotation and at the last."""
    (first, before), *_, (last, after) = fit.groups.items()
    lines = []
    for name in before:
        scale = scale_shown(name, axis)
        ends = [
            f"{shown_number(scale * group[name].value, DIGITS)} {unit_shown(name, axis)} at {rpm:g} rpm"
            for rpm, group in ((first, before), (last, after))
            if name in group and group[name].value == group[name].value
        ]
        if len(ends) > 1:
            lines.append(f"{plain_name(name).capitalize()}: {', '.join(ends)}.")
    return lines


def _fits(identification: Identification, fit: SimulationFit) -> list[str]:
    """How far each output is from the records, as declared and as identified."""
    lines = []
    for name, before in fit.before.items():
        unit = unit_along(CHANNELS[name], identification.experiment.plant.axis)
        shown = SHOWN.get(unit, unit)
        ends = " to ".join(shown_number(factor(unit, shown) * value, 3) for value in (before, fit.rms[name]))
        lines.append(f"{plain_name(name).capitalize()}, simulated against measured: {ends} {shown} rms.")
    return lines


def _found(identification: Identification) -> list[str]:
    """The identified parameters in words."""
    told = []
    for name, parameter in identification.parameters.items():
        unit = SHOWN.get(parameter.unit, parameter.unit)
        scale = factor(parameter.unit, unit)
        fitted, thesis = parameter.simulation, parameter.thesis
        if fitted is not None and fitted.low is not None and fitted.high is not None:
            interval = shown_interval(scale * fitted.low, scale * fitted.high, DIGITS)
            told.append(f"{plain_name(name)} {shown_number(scale * fitted.value, DIGITS)} {unit} ({interval})")
        elif fitted is None and thesis is not None and thesis.value == thesis.value:
            told.append(f"{plain_name(name)} {shown_number(scale * thesis.value, DIGITS)} {unit}")
    return told
