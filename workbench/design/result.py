"""What a design is: the motion, what each hypothesis shows in it, and how surely it tells them apart; in SI."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plants.effects.registry import effects
from workbench.design.hypotheses import NOTHING, Hypothesis
from workbench.design.pieces import Condition, Piece, shaped
from workbench.design.power import Told
from workbench.design.refit import Leg
from workbench.design.rig import Rig
from workbench.publish.words import listed, plain_name
from workbench.records.experiment import Experiment
from workbench.simulation.run import Run

SURE, HARDLY = 0.9, 0.5
"""Shares of records that tell a pair apart, from which they do so surely, and below which hardly."""

BETTER = 0.8
"""Times its deviation before, below which a parameter is known better."""

NOTHING_ELSE = "nothing else"
"""What a hypothesis lacks that has no effect but those that all have."""


@dataclass(frozen=True)
class Known:
    """A parameter that a motion was to show: its value and its standard deviation (SI) before and after the motion."""

    name: str
    value: float
    before: float
    after: float


@dataclass(frozen=True, eq=False)
class Design:
    """A motion of `pieces`, in `legs` that are run in one go, with what each hypothesis does in them (`runs`), how
    pairs are `told` apart, and which parameters become `known`. `source` is the folder of a diagnosis, or the
    experiment's file.
    """

    experiment: Experiment
    source: str
    rig: Rig
    hypotheses: Sequence[Hypothesis]
    pieces: Sequence[Piece]
    legs: Sequence[Leg]
    runs: Sequence[Sequence[Run]]
    told: Sequence[Told]
    known: Sequence[Known]

    @property
    def duration(self) -> float:
        """s."""
        return sum(piece.duration for piece in self.pieces)

    @property
    def common(self) -> tuple[str, ...]:
        """The effects that all hypotheses have."""
        first = self.hypotheses[0].effects
        return tuple(name for name in first if all(name in one.effects for one in self.hypotheses))

    def name_of(self, number: int) -> str:
        """What a hypothesis has beside what all have."""
        own = [plain_name(name) for name in self.hypotheses[number].effects if name not in self.common]
        if own or len(self.hypotheses) == 1:
            return listed(own) or self.hypotheses[number].name
        return NOTHING_ELSE if self.common else NOTHING

    @property
    def tells(self) -> bool:
        """Whether it tells any pair at least now and then, or shows any parameter better than it is known."""
        better = any(one.after < BETTER * one.before for one in self.known)
        return better or any(one.power >= HARDLY for one in self.claimed)

    @property
    def claimed(self) -> list[Told]:
        """The pairs in which the rival cannot do all that the true one does."""
        return [one for one in self.told if not self.is_nested(one)]

    def is_nested(self, one: Told) -> bool:
        """Whether a rival can do all that the true one does: then it counts that it is not claimed."""
        return self.hypotheses[one.true].is_part_of(self.hypotheses[one.rival])

    @property
    def undecided(self) -> list[Told]:
        """The pairs that it hardly tells apart."""
        return [one for one in self.told if one.power < HARDLY]

    def shapes_of(self, hypothesis: Hypothesis) -> list[Mapping[str, float]]:
        """Of a hypothesis that counts in several shapes what shapes its effects (SI), its own first."""
        known = effects(self.rig.axis)
        shaping = [name for effect in hypothesis.effects for name, one in known[effect].numbers.items() if one.shapes]
        shapes = [hypothesis, *hypothesis.others] if hypothesis.others else []
        return [{name: shape.values[name] for name in shaping} for shape in shapes]

    def taken_up_by(self, one: Told) -> list[str]:
        """The parameters of a rival that move most to make up for the difference."""
        rival = self.hypotheses[one.rival]
        order = np.argsort(-np.abs(one.moved))
        return [rival.unknowns[int(k)].name for k in order[:2] if abs(one.moved[int(k)]) > 0.0]

    def to_json(self) -> dict[str, object]:
        """The content of design.json."""
        names = [one.name for one in self.hypotheses]
        return {
            "title": self.experiment.title,
            "source": self.source,
            "duration_s": self.duration,
            "sample_time_s": self.rig.sample_time,
            "loop": "open" if self.rig.steering is None else "closed",
            "controller": None if self.rig.steering is None else dict(self.rig.steering.table),
            "hypotheses": [
                {
                    "name": one.name,
                    "effects": list(one.effects),
                    "parameters": {u.name: one.values[u.name] for u in one.unknowns},
                    "shapes": [dict(shape) for shape in self.shapes_of(one)],
                }
                for one in self.hypotheses
            ],
            "pieces": [self._piece(piece) for piece in self.pieces],
            "told_apart": [
                {
                    "true": names[one.true],
                    "rival": names[one.rival],
                    "distance": None if math.isinf(one.distance) else math.sqrt(one.distance),
                    "power": one.power,
                    "low": one.low,
                    "high": one.high,
                    "taken_up_by": self.taken_up_by(one),
                }
                for one in self.told
            ],
            "parameters": [
                {
                    "name": one.name,
                    "value": one.value,
                    "std_before": _finite(one.before),
                    "std_after": _finite(one.after),
                }
                for one in self.known
            ],
        }

    def _piece(self, piece: Piece) -> Mapping[str, object]:
        of = shaped(piece, self.rig.reach)
        return {
            "kind": piece.kind,
            "duration_s": piece.duration,
            **_condition(piece.condition),
            "place": of.place,
            **of.numbers,
        }


def _condition(condition: Condition) -> dict[str, float]:
    return {"rpm": condition.rotation * 30.0 / math.pi, "load": condition.load}


def _finite(number: float) -> float | None:
    return number if math.isfinite(number) else None
