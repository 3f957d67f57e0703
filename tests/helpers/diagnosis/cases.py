"""Which experiments the suite makes."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from zlib import crc32

from .effects import EFFECTS, UNLISTED

SETS = ("tuning", "reported")
"""`tuning` is for working on diagnosis; `reported` has other seeds and is looked at once, for the figures."""

STRENGTHS = (1.0, 0.5, 0.2)
REPETITIONS = 2
SILENT = 12
"""How many records without effect."""

PAIRS = (
    ("valve_deadband", "direction_asymmetry"),
    ("internal_leakage", "position_dependent_friction"),
    ("unequal_areas", "quadratic_drag"),
    ("command_delay", "pressure_dependent_friction"),
    ("entrained_air", "spring_load"),
    ("constant_load", "viscous_drift"),
)
PAIR_STRENGTH = 0.7
UNLISTED_STRENGTH = 1.0

KINDS = ("effect", "pair", "none", "unlisted")


@dataclass(frozen=True)
class Case:
    """One experiment: what is in it, by name and strength, and the seed of everything else."""

    name: str
    kind: str
    truth: str
    seed: int
    effects: dict[str, float] = field(default_factory=dict)
    unlisted: dict[str, float] = field(default_factory=dict)

    @property
    def strength(self) -> float:
        """The one strength of all effects; 0 without any."""
        return max([*self.effects.values(), *self.unlisted.values()], default=0.0)


def _case(chosen: str, kind: str, names: Sequence[str], strength: float, repetition: int) -> Case:
    truth = "+".join(names) or "none"
    name = f"{truth}_{strength:g}_{repetition}" if names else f"none_{repetition}"
    strengths = dict.fromkeys(names, strength)
    inside = {"unlisted": strengths} if kind == "unlisted" else {"effects": strengths}
    return Case(name, kind, truth, crc32(f"{chosen} {name}".encode()), **inside)


def make_cases(chosen: str, only: Sequence[str] = (), strengths: Sequence[float] = ()) -> list[Case]:
    """The cases of a set, in a fixed order; a case has the same seed whatever else is chosen.

    Args:
        chosen: one of `SETS`.
        only: names of effects, of unlisted ones, or kinds of `KINDS`; nothing for all.
        strengths: of single effects, in place of `STRENGTHS`.

    Raises:
        ValueError: a name that is none of these.
    """
    for name in only:
        if name not in (*EFFECTS, *UNLISTED, *KINDS):
            raise ValueError(f'"{name}" is no effect; expected one of {", ".join([*EFFECTS, *UNLISTED, *KINDS])}')
    seeds = range(REPETITIONS)
    cases = [
        *(_case(chosen, "effect", [name], s, k) for name in EFFECTS for s in strengths or STRENGTHS for k in seeds),
        *(_case(chosen, "pair", pair, PAIR_STRENGTH, k) for pair in PAIRS for k in seeds),
        *(_case(chosen, "none", [], 0.0, k) for k in range(SILENT)),
        *(_case(chosen, "unlisted", [name], UNLISTED_STRENGTH, k) for name in UNLISTED for k in seeds),
    ]
    return [case for case in cases if not only or case.kind in only or case.truth in only]
