"""How strong an effect has to be to be found: distances between records in standard deviations of their noise.

    d^2 = (y1 - y0)' Sigma^-1 (y1 - y0)

y0 and y1 are what the sensors show without noise under one input, without the effect and with it. A test that knows
machine, initial state and form has at false alarms of 1 % a power of 50 % where d = 2.326: that is the limit. Of a
record by hand, whose input is noisy, y is what a filter does not foresee that has the one or the other machine in it.
"""

from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from .effects import EFFECTS
from .forms import Column, Form
from .machines import HAND, Rig, resting, stream
from .parameters import DRIVE, HYDRAULIC, Machine
from .physics import P1, P2, SHOWN, SPOOL, X, Z
from .records import FIT, ImplausibleError, Record, check_physical, outputs, record, whitened

LIMIT = 2.326
"""Standard normal deviates of 1 % false alarms, one-sided: the distance at which half of all cases are found."""

NEAR, TRIES = 0.03, 14
"""Relative error of a distance, and records tried until it is met."""

SMALLEST = 1e-11
"""Strength at which a search begins at the lowest."""

LINEAR_SIZE = (0.3, 50.0)
"""Distances between which a difference quotient is taken: above the integrator's own error, below what bends."""

FRICTION = (
    "coulomb",
    "stribeck",
    "viscous",
    "stribeck_velocity",
    "bristle_stiffness",
    "bristle_damping",
)


def free_parameters(rig: Rig) -> tuple[str, ...]:
    """Names of `Machine` that an experiment leaves free."""
    if rig.machine.actuator == DRIVE:
        return FRICTION
    return (*FRICTION, "flow_gain", "bulk_modulus" if rig.machine.actuator == HYDRAULIC else "polytropic")


def drawn_form(rig: Rig, name: str) -> Form:
    """The form that the rig's seed draws of a listed effect."""
    return EFFECTS[name].draw(rig, stream(rig.seed, f"form {name}"))


def with_form(machine: Machine, form: Form, strength: float) -> Machine:
    """A machine with an effect."""
    return machine._replace(**form.changes(strength))


def coarse(rig: Rig) -> Rig:
    """The rig with steps that are stable alone: what they are off is the same with an effect and without."""
    return replace(rig, fineness=1)


def distance(rig: Rig, form: Form, strength: float, base: Machine | None = None) -> tuple[float, Record]:
    """d of a strength on the fit record that the machine with the effect makes, and that record."""
    without = base or rig.machine
    made = record(rig, with_form(without, form, strength), FIT)
    if not np.all(np.isfinite(made.clean)):
        return np.inf, made
    with np.errstate(over="ignore", invalid="ignore"):  # what runs away is infinitely far
        seen = outputs(made, made.machine) if rig.motion == HAND else whitened(made, made.clean)
        apart = seen - outputs(made, without)
    return float(np.linalg.norm(apart)) if np.all(np.isfinite(apart)) else np.inf, made


def strength_at(rig: Rig, form: Form, wanted: float) -> tuple[float, float]:
    """Strength (at most 1) at which the distance is `wanted`, and the distance that it has.

    A secant over the logarithms of both, held within what is known to be too little and too much, on coarse steps.

    Raises:
        ImplausibleError: the strength would be more than anybody would believe, or no record is physical.
    """
    rig = coarse(rig)
    low, high = SMALLEST, 1.0
    strength = 1e-3
    last: tuple[float, float] | None = None
    for _ in range(TRIES):
        found, made = distance(rig, form, strength)
        if abs(found / wanted - 1.0) < NEAR:
            check_physical(made)
            return strength, found
        if found < wanted:
            low = strength
        else:
            high = strength
        if found < wanted and strength >= 1.0:
            raise ImplausibleError(f"a strength of 1 has a distance of {found:.3g} of {wanted:.3g}")
        slope = 1.0
        if last is not None and found not in (0.0, np.inf) and last[1] not in (0.0, np.inf) and found != last[1]:
            slope = float(np.clip(np.log(found / last[1]) / np.log(strength / last[0]), 0.3, 3.0))
        last = (strength, found)
        factor = (wanted / found) ** (1.0 / slope) if 0.0 < found < np.inf else (0.01 if found else 30.0)
        strength = float(np.clip(strength * factor, low * 1.02, high if high == 1.0 else high * 0.98))
    raise ImplausibleError("no strength has the wanted distance")


# --- what a fit takes away -------------------------------------------------------------------------------------


class Acting(NamedTuple):
    """An effect that a machine has."""

    form: Form
    strength: float


def with_all(machine: Machine, effects: Iterable[Acting]) -> Machine:
    """A machine with several effects."""
    for form, strength in effects:
        machine = with_form(machine, form, strength)
    return machine


@dataclass(frozen=True)
class Distances:
    """Of a case's fit record: with all known, after the plant's own parameters and the initial state are fitted, and
    after another effect is fitted beside them, by its name.
    """

    known: float
    profiled: float
    with_other: Mapping[str, float]

    @property
    def same(self) -> list[str]:
        """The effects that this record cannot tell from the true one."""
        return sorted(name for name, rest in self.with_other.items() if rest < LIMIT)


def column(shown: Callable[[float], np.ndarray], base: np.ndarray, size: float) -> np.ndarray:
    """A direction in which outputs go with a number, from `size` on in steps that are neither lost nor bent."""
    low, high = LINEAR_SIZE
    moved = shown(size) - base
    for _ in range(4):
        length = float(np.linalg.norm(moved)) if np.all(np.isfinite(moved)) else 1e6
        if low <= length <= high:
            break
        size *= 2.0 / length if length > 0.0 else 1e3
        if size > 1.0:
            size = 1.0
        moved = shown(size) - base
        if size == 1.0:
            break
    return moved if np.all(np.isfinite(moved)) else np.zeros(base.size)


def own_columns(made: Record, machine: Machine, base: np.ndarray) -> list[np.ndarray]:
    """Directions of the free parameters and of the initial state."""
    rig = made.rig

    def moved(name: str) -> Callable[[float], np.ndarray]:
        return lambda s: outputs(made, machine._replace(**{name: getattr(machine, name) * (1.0 + s)}))

    columns = [column(moved(name), base, 1e-4) for name in free_parameters(rig)]
    sizes = {X: rig.travel, Z: rig.presliding}
    if rig.is_fluid:
        sizes |= dict.fromkeys((P1, P2), machine.supply_pressure) | {SPOOL: machine.spool_limit}

    def started(place: int, size: float) -> Callable[[float], np.ndarray]:
        def shown(s: float) -> np.ndarray:
            start = resting(rig.machine)
            start[place] += s * size
            start[SHOWN] = start[X]
            return outputs(made, machine, start)

        return shown

    return [*columns, *(column(started(place, size), base, 1e-5) for place, size in sizes.items())]


def effect_columns(
    made: Record, machine: Machine, base: np.ndarray, form: Form, strength: float = 0.0
) -> list[np.ndarray]:
    """Directions of all parameters of an effect in a form; of one that `machine` has already, about its strength."""

    def moved(name: str, one: Column) -> Callable[[float], np.ndarray]:
        there = strength * form.weights.get(name, 0.0)
        return lambda s: outputs(made, machine._replace(**one(there + s)))

    return [column(moved(name, one), base, 1e-4) for name, one in form.columns.items()]


def left(apart: np.ndarray, columns: list[np.ndarray]) -> float:
    """Length of a difference after the best of columns is taken off."""
    used = [one / np.linalg.norm(one) for one in columns if np.linalg.norm(one) > 0.0]
    if not used:
        return float(np.linalg.norm(apart))
    matrix = np.column_stack(used)
    weights, *_ = np.linalg.lstsq(matrix, apart, rcond=1e-8)
    return float(np.linalg.norm(apart - matrix @ weights))


def distances(rig: Rig, true: Mapping[str, Acting], name: str, candidates: Sequence[str]) -> Distances:
    """Distances of a machine with its `true` effects from one that lacks `name` of them, on the fit record, to first
    order.

    What else is true is fitted with the plant's parameters. `candidates` are those that may stand in for it; where the
    plant's parameters alone leave less than the limit, so do they with any of these, and it is not computed how little.
    """
    rest = {other: acting for other, acting in true.items() if other != name}
    without = with_all(rig.machine, rest.values())
    made = record(rig, with_all(rig.machine, true.values()), FIT)
    made = replace(made, rig=coarse(rig))
    base = outputs(made, without)
    apart = outputs(made, made.machine) - base
    own = own_columns(made, without, base)
    for acting in rest.values():
        own += effect_columns(made, without, base, *acting)
    profiled = left(apart, own)
    others = {other: profiled for other in candidates if other not in true}
    if profiled >= LIMIT:
        for other in others:
            others[other] = left(apart, [*own, *effect_columns(made, without, base, drawn_form(rig, other))])
    return Distances(float(np.linalg.norm(apart)), profiled, others)
