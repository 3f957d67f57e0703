"""What is written of tuned gains: a file for each controller, which a study may name."""

import json
import math
from collections.abc import Iterator, Mapping, Sequence
from importlib.metadata import version
from typing import Any

import control
import numpy as np

from workbench.linear.open_loop import open_loop
from workbench.toml.gain_file import KEY
from workbench.tune.objective import margin_speed
from workbench.tune.space import RPM, THRESHOLD
from workbench.tune.task import in_user_units, tune_table
from workbench.tune.tuning import Tuned

PACKAGES = ("optuna", "cobyqa", "scipy", "numpy", "numba")
"""Whose versions a gain file keeps."""

LOWEST, POINTS = 0.01, 6000
"""rad/s, and number of frequencies up to Nyquist's, of the response whose margins a gain file carries."""

DIGITS = 6
"""Significant digits of what a gain file says of the search; settings have all that were tried."""


def gain_file(tunings: Sequence[Tuned]) -> str:
    """The text of the gain file of a controller with feasible gains, as `workbench.toml.gain_file` reads it: an entry
    for each of these tunings of it.
    """
    task = tunings[0].task
    head = {
        "title": f"{task.name}, tuned" + (f", {task.at['machine']}" if "machine" in task.at else ""),
        "source": f"workbench tune, {task.study.path.name}: {task.study.file.title}",
        "type": task.cases[0].controller.type,
    }
    lines = list(_lines(head))
    for found in sorted(tunings, key=lambda one: one.task.rpm or 0.0):
        lines += ["", "[[at]]", *_lines(_entry(found), "at.")]
    return "\n".join(lines) + "\n"


def gain_files(tunings: Sequence[Tuned]) -> dict[str, str]:
    """The text of every gain file, by its name in the folder of gains: NAME.toml, or MACHINE/NAME.toml."""
    by_name: dict[str, list[Tuned]] = {}
    for found in tunings:
        if found.best is not None:
            folder = f"{found.task.at['machine']}/" if "machine" in found.task.at else ""
            by_name.setdefault(f"{folder}{found.task.name}.toml", []).append(found)
    return {name: gain_file(own) for name, own in by_name.items()}


def _entry(found: Tuned) -> dict[str, Any]:
    """[[at]] of one tuning."""
    assert found.best is not None
    assert found.score is not None
    task, table = found.task, tune_table(found.task.study)
    tuned = in_user_units(task, found.best)
    rotation = {name: value for name, value in tuned.items() if name in (RPM, THRESHOLD)}
    own = {key: value for key, value in task.cases[0].tables.controllers[task.name].items() if key not in ("type", KEY)}
    differ = found.seeds_differ
    return {
        **({} if task.rpm is None else {"rpm": task.rpm}),
        "settings": {**own, **{name: value for name, value in tuned.items() if name not in rotation}},
        "rotation": rotation,
        "objective": {
            "value": _short(found.score.value),
            "with_the_study_s_gains": _short(_start(found)),
            "on_the_declared_machine": _short(found.score.nominal),
            "yardstick": table.yardstick or next(iter(task.study.file.controllers)),
            "weights": {name: weight for name, weight in table.objective.model_dump().items() if weight},
            **_draws(found),
        },
        "margins": _margins(found),
        "search": {
            "by": "optuna TPE, then COBYQA",
            "trials": table.trials,
            "seeds": list(found.seeds),
            "objective_of_each": [math.inf if one is None else _short(one) for one in found.seeds.values()],
            **({} if differ is None else {"seeds_differ": _short(differ)}),
            "versions": {name: version(name) for name in PACKAGES},
        },
    }


def _start(found: Tuned) -> float:
    return found.on_searched["start"].value if found.on_searched else found.start.value


def _short(value: float) -> float:
    return float(f"{value:.{DIGITS}g}")


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
            out[f"on_{kind}_draws"] = {
                "draws": one.draws,
                **{key: _short(getattr(one, key)) for key in ("value", "low", "high")},
            }
    return out


def _lines(table: Mapping[str, Any], path: str = "") -> Iterator[str]:
    """A table as TOML: its values, then its tables."""
    yield from (f"{key} = {_toml(value)}" for key, value in table.items() if not isinstance(value, Mapping))
    for key, value in table.items():
        if isinstance(value, Mapping) and value:
            yield from ("", f"[{path}{key}]")
            yield from _lines(value, f"{path}{key}.")


def _toml(value: Any) -> str:
    if isinstance(value, list):
        return f"[{', '.join(map(_toml, value))}]"
    if isinstance(value, float) and not math.isfinite(value):
        return "inf" if value > 0.0 else "-inf"
    return json.dumps(value, ensure_ascii=False)


def history(found: Tuned) -> list[dict[str, Any]]:
    """A row a trial: its seed, number, value, what it breaks, margins, and the point (SI; rpm in rpm)."""
    draws = tune_table(found.task.study).draws
    return [
        {
            "controller": found.task.name,
            **found.task.at,
            "trial": number,
            "seed": trial.seed,
            "value": trial.value,
            "draws": trial.draws,
            "feasible": trial.feasible,
            "candidate": trial.feasible and trial.draws == draws,
            "breaks": ", ".join(name for name, beyond in trial.violations.items() if beyond > 0.0),
            "nominal": trial.nominal,
            "gain_margin_dB": trial.gain_margin_dB,
            "phase_margin_deg": trial.phase_margin_deg,
            **{name: value * 30.0 / math.pi if name == RPM else value for name, value in trial.point.items()},
        }
        for number, trial in enumerate(found.trials)
    ]
