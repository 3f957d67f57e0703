"""Cases of which a first record cannot tell the truth from a rival, and the folder that a diagnosis would leave."""

import json
from collections.abc import Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from family.cases import THREE, Case, make_cases
from family.experiments import declared_values, named, true_values, write_experiment
from family.limits import LIMIT, Acting, distances, free_parameters, with_all
from family.machines import HAND, OPEN, PROPORTIONAL, ROTARY, Rig
from family.making import Made, candidates, draw
from family.physics import DAMPING, FILTER, INTEGRAL, OPEN_GAIN
from family.records import USES, ImplausibleError, check_physical, loop_of, record

from plants.axis import name_along

SET = "designed"
"""Of the seeds: nothing was chosen on them."""

NONE = "none"

HIDDEN, NEAR = 0.5, 0.1
"""Of the limit: the distance at which a first record leaves an effect that it does not show, and its relative error."""

FACTORS, TRIES = (0.05, 100.0), 12
"""By which a strength is changed at a time to find it, and how often."""

OF_STROKE, FASTER = 0.45, 1.5
"""What a designed motion may use of a machine: nine tenths of its stroke, and so many times the largest speed that its
first motion was asked for, which is what the weakest valve of the generator reaches.
"""


@dataclass(frozen=True)
class Pair:
    """A case as it was made, its true effect, and the rival that its first record cannot tell from it: of several the
    likest, or no effect, where the machine's own parameters alone make up for the true one.
    """

    made: Made
    true: str
    rival: str
    profiled: float
    apart: float


def cases() -> Iterator[Case]:
    """Cases with one effect of three limits, of all machines that a computer commands, in a fixed order."""
    yield from (case for case in make_cases(SET, [THREE]) if case.motion != HAND)


def pair_of(case: Case) -> Pair | None:
    """The pair that a first record leaves open; None where it tells the truth from all else, or no machine serves."""
    try:
        made = draw(case)
        (true,) = case.effects
        found = distances(made.rig, made.effects, true, candidates(case))
        if found.profiled < LIMIT:
            return _hidden(made, true, found.profiled)
    except (RuntimeError, ImplausibleError):
        return None
    if not found.same:
        return None
    rival = min(found.same, key=lambda name: found.with_other[name])
    return Pair(made, true, rival, found.profiled, found.with_other[rival])


def _hidden(made: Made, true: str, profiled: float) -> Pair | None:
    """The pair of an effect and none, as strong as the effect may be without being shown: once the machine's parameters
    are fitted, `HIDDEN` of the limit is left. In units of a test that knows the machine it may be next to nothing.
    """
    rig, form, strength = made.rig, *made.effects[true]
    for _ in range(TRIES):
        if abs(profiled / (HIDDEN * LIMIT) - 1.0) < NEAR or (strength == 1.0 and profiled < HIDDEN * LIMIT):
            break
        strength = min(strength * float(np.clip(HIDDEN * LIMIT / max(profiled, 1e-12), *FACTORS)), 1.0)
        profiled = distances(rig, {true: Acting(form, strength)}, true, ()).profiled
    else:
        return None
    effects = {true: Acting(form, strength)}
    records = {use: record(rig, with_all(rig.machine, effects.values()), use) for use in USES}
    for one in records.values():
        check_physical(one)
    return Pair(replace(made, effects=effects, records=records), true, NONE, profiled, profiled)


def write(pair: Pair, folder: Path) -> None:
    """The experiment, and report.json as a diagnosis would leave it that could not decide, fitted at the machine."""
    made, rig = pair.made, pair.made.rig
    path = write_experiment(folder, rig, made.records, {})
    path.write_text(_with_design(path.read_text(encoding="utf-8"), rig), encoding="utf-8")
    axis = "rad" if rig.kind == ROTARY else "m"
    true, declared = true_values(rig), declared_values(rig)
    fitted = {
        name_along(named(rig, own), axis): {
            "value": true[named(rig, own)],
            "std": declared[named(rig, own)],
            "identified": True,
        }
        for own in free_parameters(rig)
    }
    report = {
        "title": f"rig {rig.seed}",
        "experiment": path.as_posix(),
        "verdict": "none_missing",
        "effects": [],
        "fitted": fitted,
        "baseline": fitted,
        "simulation": {"voltage_is_held": True},
    }
    (folder / "report.json").write_text(json.dumps(report) + "\n", encoding="utf-8")


def steered(rig: Rig) -> Rig:
    """The rig with its loop closed, where it was open."""
    return replace(rig, motion=PROPORTIONAL) if rig.motion == OPEN else rig


def _with_design(text: str, rig: Rig) -> str:
    """The experiment with the rig's controller, and with where it moves."""
    loop, axis = loop_of(steered(rig)), "rad" if rig.kind == ROTARY else "m"
    unit = "V" if rig.is_fluid or rig.plant.endswith("_voltage") else "N m" if rig.kind == ROTARY else "N"
    settings = {"type": "pid", "kp": f"{float(loop[OPEN_GAIN])!r} {unit}/{axis}"}
    if loop[INTEGRAL]:
        settings["ki"] = f"{float(loop[INTEGRAL])!r} {unit}/({axis} s)"
    if loop[DAMPING]:
        settings |= {
            "kd": f"{float(loop[DAMPING])!r} {unit} s/{axis}",
            "velocity_time_constant": f"{float(loop[FILTER])!r} s",
        }
    table = ", ".join(f"{name} = {json.dumps(value)}" for name, value in settings.items())
    travel = OF_STROKE * rig.machine.stroke
    limits = f'low = "{-travel} {axis}", high = "{travel} {axis}", speed = "{FASTER * rig.speed} {axis}/s"'
    return f"{text}[design]\ncontroller = {{ {table} }}\nlimits = {{ {limits} }}\n"
