"""Which experiments the suite makes: kinds of cases, spread evenly over machines, noises and motions."""

from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from zlib import crc32

import numpy as np

from . import noise
from .effects import EFFECTS
from .machines import KINDS, MOTIONS, between, stream
from .unlisted import UNLISTED

SETS = ("tuning", "reported")
"""`tuning` is for working on diagnosis; `reported` has other seeds, for the figures: no constant is chosen by it."""

NONE, THREE, LIMIT, STRONG, SEVERAL, OTHER = CASES = ("none", "three", "limit", "strong", "several", "unlisted")
"""Without effect; one at 3 limits, at 1 limit, and strong; two or three; one that no list has."""

SILENT = 60
REPETITIONS, MORE = 4, 10
"""Of each effect at 3 limits, and how many effects have one more."""

AT_LIMIT = STRONGS = 60
PAIRS, TRIPLES = 26, 14
OTHERS = 30

STRONG_RANGE, SEVERAL_RANGE, OTHER_RANGE = (10.0, 1000.0), (3.0, 30.0), (10.0, 100.0)
"""Multiples of the limit, log-uniform."""


@dataclass(frozen=True)
class Case:
    """One experiment: its machine, how it is moved and what noise it has, which effects at which multiples of their
    limits, and the seed of everything else.
    """

    name: str
    kind: str
    machine: str
    motion: str
    noise: str
    seed: int
    effects: tuple[str, ...] = ()
    multiples: tuple[float, ...] = ()

    @property
    def truth(self) -> str:
        """The effects in one word."""
        return "+".join(self.effects) or "none"


class _Spread:
    """Gives in turn what was given least: machines, on each machine noises, and motions on each machine."""

    def __init__(self) -> None:
        self.given: Counter[tuple[str, ...]] = Counter()

    def next(self, fits: Iterable[tuple[str, str]], turn: int) -> tuple[str, str, str]:
        """A machine, a motion and a noise among the machines and motions that fit; ties go by `turn`."""
        allowed = list(fits)
        machine = self._least([(m,) for m in KINDS if any(one == m for one, _ in allowed)], turn)[0]
        motion = self._least([(machine, "m", m) for one, m in allowed if one == machine], turn)[2]
        kind = self._least([(machine, "n", n) for n in noise.KINDS], turn)[2]
        return machine, motion, kind

    def _least(self, keys: Sequence[tuple[str, ...]], turn: int) -> tuple[str, ...]:
        turned = [keys[(turn + i) % len(keys)] for i in range(len(keys))]
        chosen = min(turned, key=lambda key: self.given[key])
        self.given[chosen] += 1
        return chosen


def _fitting(names: Sequence[str]) -> list[tuple[str, str]]:
    """Machines and motions that may have all of these effects."""
    known = [EFFECTS[name] if name in EFFECTS else UNLISTED[name] for name in names]
    return [(k, m) for k in KINDS for m in MOTIONS[k] if all(one.may_be(k, m) for one in known)]


def _together(count: int, taken: Counter[str], turn: int) -> tuple[str, ...]:
    """Effects that one machine may have together: those that were taken least."""
    names = list(EFFECTS)
    order = [names[(7 * turn + 5 * i) % len(names)] for i in range(len(names))]
    chosen: list[str] = []
    for name in sorted(order, key=lambda item: taken[item]):
        if _fitting([*chosen, name]):
            chosen.append(name)
        if len(chosen) == count:
            break
    taken.update(chosen)
    return tuple(chosen)


def _case(chosen: str, kind: str, number: int, effects: Sequence[str], spread: _Spread) -> Case:
    name = f"{kind}_{number:03d}" + "".join(f"_{effect}" for effect in effects)
    seed = crc32(f"{chosen} {name}".encode())
    ranges = {STRONG: STRONG_RANGE, SEVERAL: SEVERAL_RANGE, OTHER: OTHER_RANGE}
    draw = stream(seed, "multiples")
    fixed = {THREE: 3.0, LIMIT: 1.0}
    multiples = tuple(fixed[kind] if kind in fixed else between(draw, *ranges[kind]) for _ in effects)
    fits = _fitting(effects) if effects else [(k, m) for k in KINDS for m in MOTIONS[k]]
    machine, motion, noisy = spread.next(fits, number)
    return Case(name, kind, machine, motion, noisy, seed, tuple(effects), multiples)


def make_cases(chosen: str, only: Sequence[str] = (), first: int | None = None) -> list[Case]:
    """The cases of a set, in a fixed order; a case is the same whatever else is chosen.

    Args:
        chosen: one of `SETS`.
        only: names of effects, of unlisted ones, or kinds of `CASES`; nothing for all.
        first: so many of each kind.

    Raises:
        ValueError: a name that is none of these.
    """
    for name in only:
        if name not in (*EFFECTS, *UNLISTED, *CASES):
            raise ValueError(f'"{name}" is no effect; expected one of {", ".join([*CASES, *EFFECTS, *UNLISTED])}')
    names, others = list(EFFECTS), list(UNLISTED)
    turned = np.random.default_rng(crc32(b"order")).permutation(names).tolist()
    taken: Counter[str] = Counter()
    groups: dict[str, list[tuple[str, ...]]] = {
        NONE: [()] * SILENT,
        THREE: [*((name,) for _ in range(REPETITIONS) for name in turned), *((name,) for name in turned[:MORE])],
        LIMIT: [(turned[i % len(names)],) for i in range(AT_LIMIT)],
        STRONG: [(turned[(i + 17) % len(names)],) for i in range(STRONGS)],
        SEVERAL: [_together(2 if i < PAIRS else 3, taken, i) for i in range(PAIRS + TRIPLES)],
        OTHER: [(others[i % len(others)],) for i in range(OTHERS)],
    }
    cases = []
    for kind, sets in groups.items():
        spread = _Spread()
        made = [_case(chosen, kind, i, effects, spread) for i, effects in enumerate(sets)]
        made = [case for case in made if _wanted(case, only)]
        cases += made[:first]
    return cases


def _wanted(case: Case, only: Sequence[str]) -> bool:
    """Kinds and effects that are named narrow the choice, each on its own."""
    kinds, effects = {*only} & {*CASES}, {*only} - {*CASES}
    return (not kinds or case.kind in kinds) and (not effects or bool(effects & {*case.effects}))
