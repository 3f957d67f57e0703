"""What is written of tuned gains: a file for each controller, which a study may name."""

import json
import math
from collections.abc import Iterator, Mapping
from importlib.metadata import version
from typing import Any

import control
import numpy as np

from workbench.study.gain_file import KEY
from workbench.tune.goal import margin_speed
from workbench.tune.loop import open_loop
from workbench.tune.search import SCORE, is_candidate
from workbench.tune.space import RPM, THRESHOLD
from workbench.tune.task import in_user_units, tune_table
from workbench.tune.tuning import Tuned

PACKAGES = ("optuna", "control", "casadi", "numpy", "scipy", "numba")
"""Whose versions a gain file keeps."""

LOWEST, POINTS = 0.01, 6000
"""rad/s, and number of frequencies up to Nyquist's, of the response whose margins a gain file carries."""

KEPT = ("trial", "value", "ended", "feasible")
"""What a gain file's history says of each trial, beside the point."""


def gain_file(found: Tuned) -> str:
    """The text of the gain file of a controller that has feasible gains: as `workbench.study.gain_file` reads it."""
    assert found.best is not None
    assert found.score is not None
    task, table = found.task, tune_table(found.task.study)
    tuned = in_user_units(task, found.best)
    rotation = {name: value for name, value in tuned.items() if name in (RPM, THRESHOLD)}
    own = {
        key: value for key, value in task.cases[0].tables["controllers"][task.name].items() if key not in ("type", KEY)
    }
    settings = {**own, **{name: value for name, value in tuned.items() if name not in rotation}}
    content: dict[str, Any] = {
        "title": f"{task.name}, tuned",
        "source": f"workbench tune, {task.study.path.name}: {task.study.file.title}",
        "type": str(task.cases[0].tables["controllers"][task.name]["type"]),
        "settings": settings,
        "rotation": rotation,
        "objective": {
            "value": found.score.value,
            "with_the_study_s_gains": found.on_searched["start"].value if found.on_searched else found.start.value,
            "on_the_declared_machine": found.score.nominal,
            "yardstick": table.yardstick or next(iter(task.study.file.controllers)),
            "weights": {name: weight for name, weight in table.objective.model_dump().items() if weight},
            **_draws(found),
        },
        "margins": _margins(found),
        "search": {
            "sampler": "optuna TPE",
            "seed": table.seed,
            "trials": len(found.trials),
            "best_trial": found.number,
            "polish": found.polished,
            "versions": {name: version(name) for name in PACKAGES},
        },
    }
    lines = list(_lines(content))
    for row in history(found):
        kept = {name: value for name, value in row.items() if name in KEPT or name in found.best}
        lines += ["", "[[history]]", *(f"{key} = {_toml(value)}" for key, value in kept.items())]
    return "\n".join(lines) + "\n"


def _margins(found: Tuned) -> dict[str, Any]:
    """The smallest margins over the cases by python-control, on a dense frequency response; those that are finite.

    The search has its own crossings, which are a hundred times quicker and the same.
    """
    task, asked, limits = found.task, tune_table(found.task.study).constraints, []
    for case in task.declared(found.best or {}):
        speed = margin_speed(case, asked)
        frequencies = np.geomspace(LOWEST, np.pi / case.setup.sample_time, POINTS)
        gain, phase, _, _ = control.margin(control.frd(open_loop(case.setup, speed), frequencies))
        limits.append((20.0 * math.log10(gain), float(phase), speed))
    gain, phase = (min(limit[i] for limit in limits) for i in range(2))
    known = {"gain_margin_dB": gain, "phase_margin_deg": phase}
    speed = min(limits, key=lambda limit: limit[1])[2]
    return {
        **{name: float(f"{value:.6g}") for name, value in known.items() if math.isfinite(value)},
        "speed": f"{1e3 * speed:.6g} mm/s",
    }


def _draws(found: Tuned) -> dict[str, Any]:
    """The quantiles on the draws of the search and on fresh ones, with their intervals."""
    out: dict[str, Any] = {}
    for kind, quantiles in (("searched", found.on_searched), ("fresh", found.on_fresh)):
        if "tuned" in quantiles:
            one = quantiles["tuned"]
            out[f"on_{kind}_draws"] = {"draws": one.draws, "value": one.value, "low": one.low, "high": one.high}
    return out


def _lines(table: Mapping[str, Any], path: str = "") -> Iterator[str]:
    """A table as TOML: its values, then its tables."""
    yield from (f"{key} = {_toml(value)}" for key, value in table.items() if not isinstance(value, Mapping))
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            yield from ("", f"[{path}{key}]")
            yield from _lines(value, f"{path}{key}.")


def _toml(value: Any) -> str:
    if isinstance(value, float) and not math.isfinite(value):
        return "inf" if value > 0.0 else "-inf"
    return json.dumps(value, ensure_ascii=False)


def history(found: Tuned) -> list[dict[str, Any]]:
    """A row a trial: its number, value, how it ended, what it breaks, margins, and the point (SI; rpm in rpm)."""
    return [
        {
            "controller": found.task.name,
            "trial": number,
            "value": trial.value if trial.value is not None else next(iter(trial.intermediate_values.values())),
            "ended": trial.state.name.lower(),
            "feasible": all(beyond <= 0.0 for beyond in trial.constraints.values()),
            "candidate": is_candidate(trial),
            "breaks": ", ".join(name for name in found.start.violations if trial.constraints[name] > 0.0),
            "nominal": trial.user_attrs[SCORE]["nominal"],
            "gain_margin_dB": trial.user_attrs[SCORE]["gain_margin_dB"],
            "phase_margin_deg": trial.user_attrs[SCORE]["phase_margin_deg"],
            **{name: value * 30.0 / math.pi if name == RPM else value for name, value in trial.params.items()},
        }
        for number, trial in enumerate(found.trials)
    ]
