"""Mutants of studies and of the files that they name; each is what a command is given."""

import math
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from random import Random
from typing import Any

import tomli_w
from command import DRIVE, STUDIES, STUDY

from fuzz.damage import damaged
from fuzz.structure import mutated

MOST_CASES = 4
"""Of an original as it is; of one with more the axes are cut short."""

SMALL = 5000
"""Bytes of a study whose mutants come oftener."""

GAINS_STUDY = STUDY.replace('type = "pid"\nkp = "500 V/m"', 'gains = "tuned/mutant.toml"')
PARAMETERS_STUDY = STUDY.replace('"owen2001_simulation"', '"mutant_parameters.toml"')


@dataclass(frozen=True)
class Original:
    """A file of the project: its text, what it holds, where its mutants stand under studies/, and, for what a study
    names, the study that does.
    """

    text: str
    data: dict[str, Any]
    place: str
    named_by: str = ""


@dataclass(frozen=True)
class Mutant:
    """The bytes of a mutated file, where it stands, and the study that names it, "" where it is one."""

    content: bytes
    place: str
    named_by: str = ""


@cache
def originals() -> Sequence[Original]:
    """The project's files, and small studies that use much; studies oftener than the rest."""
    found = [_original(text, "mutant.toml") for text in (STUDY, DRIVE, RICH, RICH, DRAWN)]
    for path in sorted(STUDIES.rglob("*.toml")):
        folder, text = path.relative_to(STUDIES).parts[0], path.read_text(encoding="utf-8")
        if path.name in ("comparison_full.toml", "owen2001_friction.toml"):
            continue  # as comparison.toml; an experiment's table alone
        if folder == "tuned":
            if path.stem in ("pi", "lugre", "ekf"):
                found.append(_original(text, "tuned/mutant.toml", GAINS_STUDY))
        elif folder in ("machines", "scenarios"):
            axis = (
                f'machine = ["mutant"]\nscenario = ["{path.stem}"]' if folder == "machines" else 'scenario = ["mutant"]'
            )
            axis = axis.split("\n")[0]
            found.append(_original(text, f"{folder}/mutant.toml", STUDY.replace("rpm = [0, 460]", axis)))
        elif "parameters" in tomllib.loads(text):
            found.append(_original(text, "mutant_parameters.toml", PARAMETERS_STUDY))
        else:
            small = len(text) < SMALL
            found += [_original(text, str(path.relative_to(STUDIES).parent / "mutant.toml"))] * (3 if small else 1)
    for path in sorted((STUDIES.parent / "plants" / "parameters").glob("*.toml")):
        found.append(_original(path.read_text(encoding="utf-8"), "mutant_parameters.toml", PARAMETERS_STUDY))
    return found


def _original(text: str, place: str, named_by: str = "") -> Original:
    return Original(text, tomllib.loads(text), place, named_by)


def mutant(random: Random) -> Mutant:
    """Some mutant of some file."""
    original = random.choice(originals())
    short = _cut_short(original.data)
    if random.random() < 0.3:
        whole = original.text.encode() if short is original.data else written(short)
        return Mutant(damaged(whole, random), original.place, original.named_by)
    content = written(mutated(short, random, [other.data for other in originals()]))
    if random.random() < 0.1:
        content = damaged(content, random)
    return Mutant(content, original.place, original.named_by)


def written(data: dict[str, Any]) -> bytes:
    """The content as a file; lone surrogates, which no file can hold, are replaced."""
    return tomli_w.dumps(data).encode(errors="replace")


def _cut_short(data: dict[str, Any]) -> dict[str, Any]:
    """The content with a few cases and draws, checked in a blink; as it is where it has few."""
    axes = data["axes"] if isinstance(data.get("axes"), dict) else {}
    if math.prod(map(len, axes.values())) * max(len(data.get("cases", {})), 1) <= MOST_CASES and "tune" not in data:
        return data
    short = dict(data)
    for kind, most in (("cases", 2), ("controllers", 3), ("tables", 3), ("figures", 2)):
        if kind in data:
            kept = list(data[kind])[:most]
            short[kind] = {name: data[kind][name] for name in kept} if isinstance(data[kind], dict) else kept
    if axes:
        short["axes"] = {name: values[:1] for name, values in axes.items()}
        kept = axes.get("controller", [])[:1]
        short["controllers"] |= {name: data["controllers"][name] for name in kept if name in data["controllers"]}
    if "uncertainty" in data:
        short["uncertainty"] = {**data["uncertainty"], "draws": 1}
    return short


RICH = """\
title = "probes, records, tables and figures"
records = ["position", "valve_voltage"]
[plant]
model = "by_rpm"
parameters = "owen2001_simulation"
scale = { coulomb = 1.1 }

[axes]
rpm = [0, 460]
controller = ["p", "pi"]

[controllers]
p = { type = "pid", kp = "500 V/m" }
pi = { type = "pid", kp = "500 V/m", ki = "100 V/(m s)" }

[references.sine]
kind = "sine"
amplitude = "5 mm"
frequency = "4 Hz"

[simulation]
duration = "0.4 s"
transient = "0.1 s"

[cases]
plain = {}
heavy = { plant = { scale = { mass = 2.0 } } }

[probes]
furthest = { signal = "position", take = "maximum" }

[sensors]
position = { noise = "5 um" }

[[tables]]
name = "errors"
title = "Errors"
index = "rpm"
where = { case = "plain", controller = "p" }
[[tables.columns]]
result = "rms_error_m"
label = "rms error"
unit = "mm"
digits = 3
published = { "0" = 0.1 }

[[figures]]
name = "motion"
title = "Motion"
[[figures.panels]]
title = "position"
x_label = "time"
y_label = "position"
y_unit = "mm"
x_range = [0.0, 0.5]
curves = [
  { y = "position", where = { case = "plain", rpm = 0, controller = "p" }, label = "at rest" },
  { y = "reference_position", where = { case = "plain", rpm = 0, controller = "p" }, label = "$r_1$" },
]
[[figures.panels]]
x = "rpm"
x_label = "rotation"
y_label = "error"
curves = [{ y = "rms_error_m", where = { case = "plain", controller = "p" }, label = "P" }]
"""
"""A study with a bit of everything."""


DRAWN = f"""{STUDY}
[uncertainty]
draws = 2
scale.mass = {{ min = 0.8, max = 1.5 }}
noise.position = {{ max = "5 um" }}

[[tables]]
name = "spread"
title = "Errors over the draws"
index = "rpm"
over = ["draw"]
columns = [
  {{ result = "rms_error_m", label = "median", unit = "mm", take = "median" }},
  {{ result = "rms_error_m", label = "most below", unit = "mm", take = "quantile", level = 0.95 }},
  {{ result = "max_error_m", label = "small", unit = "%", take = "share_below", level = "1 mm" }},
  {{ result = "outcome", label = "completed", take = "share", of = ["completed"] }},
]

[[figures]]
name = "spread"
title = "Errors over the draws"
[[figures.panels]]
x = "rpm"
x_label = "rotation"
y_label = "error"
over = ["draw"]
curves = [{{ y = "rms_error_m", label = "P", take = "mean", band = [0.1, 0.9] }}]
"""
"""A study of drawn machines, and what it takes of them."""


def folder_of(place: str) -> Path:
    """The folder under studies/ in which the study of a mutant stands."""
    return Path(place).parent
