"""A case's machine, drawn anew until what is wanted of it is plausible, and its folder."""

import json
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from .cases import OTHER, STRONG, Case
from .effects import EFFECTS, true_parameters
from .experiments import TRUTH, write_experiment
from .limits import LIMIT, Acting, Distances, distances, drawn_form, strength_at, with_all
from .machines import Rig, draw_rig, stream
from .records import FIT, USES, ImplausibleError, Record, check_physical, record, refined, unsolved
from .unlisted import UNLISTED

DRAWS = 60
"""Machines drawn until one serves."""

LEAST_STRONG = 10.0
"""Multiple of the limit to which a strong effect is taken down at most, where more is not plausible."""


@dataclass(frozen=True)
class Made:
    """A case as it was made."""

    case: Case
    rig: Rig
    effects: dict[str, Acting]
    multiples: tuple[float, ...]
    records: dict[str, Record]
    tries: int


def candidates(case: Case) -> list[str]:
    """The listed effects that the case's machine can have, and show as it is moved."""
    return [name for name, effect in EFFECTS.items() if effect.may_be(case.machine, case.motion)]


def draw(case: Case) -> Made:
    """The first machine of the case's seeds whose records are plausible.

    Raises:
        RuntimeError: none of `DRAWS` is.
    """
    why = ""
    for number in range(DRAWS):
        seed = int(np.random.default_rng([case.seed, number]).integers(2**31))
        try:
            rig = refined(draw_rig(case.machine, case.motion, case.noise, seed))
            effects, multiples = _effects(case, rig)
            machine = with_all(rig.machine, effects.values())
            records = {use: record(rig, machine, use) for use in USES}
            for made in records.values():
                check_physical(made)
        except ImplausibleError as mistake:
            why = str(mistake)
            continue
        return Made(case, rig, effects, multiples, records, number + 1)
    raise RuntimeError(f"{case.name}: none of {DRAWS} machines serves; the last one: {why}")


def _effects(case: Case, rig: Rig) -> tuple[dict[str, Acting], tuple[float, ...]]:
    """Each effect with the strength at which it is so many limits away from none; a strong one maybe less."""
    effects, multiples = {}, []
    for name, multiple in zip(case.effects, case.multiples, strict=True):
        form = UNLISTED[name].draw(rig, stream(rig.seed, f"form {name}")) if name in UNLISTED else drawn_form(rig, name)
        while True:
            try:
                strength, _ = strength_at(rig, form, multiple * LIMIT)
                break
            except ImplausibleError:
                if case.kind != STRONG or multiple <= LEAST_STRONG:
                    raise
                multiple = max(0.3 * multiple, LEAST_STRONG)
        effects[name] = Acting(form, strength)
        multiples.append(multiple)
    return effects, tuple(multiples)


def make(case: Case, folder: Path) -> Path:
    """Write the case's experiment; returns its path."""
    made = draw(case)
    apart = {name: distances(made.rig, made.effects, name, candidates(case)) for name in made.effects}
    machine = with_all(made.rig.machine, made.effects.values())
    truth = {
        "case": asdict(replace(case, multiples=made.multiples)),
        "draws": made.tries,
        "effects": {
            name: {
                "strength": acting.strength,
                "changes": acting.form.changes(acting.strength),
                "parameters": true_parameters(name, machine, made.rig.machine) if name in EFFECTS else {},
                **_about(apart[name], named=case.kind != OTHER),
            }
            for name, acting in made.effects.items()
        },
        "candidates": candidates(case),
        "unsolved": unsolved(made.records[FIT]),
        "machine": machine._asdict(),
    }
    return write_experiment(folder, made.rig, made.records, truth)


def _about(apart: Distances, named: bool) -> dict[str, object]:
    return {
        "d_known": apart.known,
        "d_profiled": apart.profiled,
        "d_free_class": dict(apart.with_other),
        "class": apart.same if named else [],
    }


def truth_of(folder: Path) -> dict[str, Any]:
    """What stands in a case's truth.json."""
    truth: dict[str, Any] = json.loads((folder / TRUTH).read_text(encoding="utf-8"))
    return truth
