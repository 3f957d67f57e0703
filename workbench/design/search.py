"""Which pieces a motion is made of: greedily, from pieces that fill the space of all, each moved on by an optimiser.

What pieces show adds up. So every piece that was ever simulated competes for every place in the motion, and costs
nothing then. Points that fill a space evenly: Sobol 1967; the descent: COBYQA (Ragonneau 2022).

It adds up to first order, and as if each piece were the first. So several motions are found that do much by that, from
all pieces and from those of one kind, for the whole of each to be looked at.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from cobyqa import minimize
from scipy.special import log_ndtr, logsumexp
from scipy.stats import qmc

from workbench.design.contrast import Contrast, Pair, Tried, pairs_of, tried
from workbench.design.hypotheses import Hypothesis, truths_of
from workbench.design.pieces import KINDS, Piece
from workbench.design.rig import Rig
from workbench.errors import UserError
from workbench.fitting.covariance import inverse
from workbench.progress import Progress

ODDS = 6.0
"""Twice the logarithm of the odds, of 20 to 1, by which a hypothesis has to be likelier to be told from another."""

PIECES = 8
"""Of a motion, if they are neither too long nor too short."""

PIECE = (2.0, 10.0)
"""s, of a piece."""

STEPS = 1.6e7
"""Of the solver, that a search may take: some ten seconds on each of two cores."""

TRIALS = (24, 200)
"""Pieces that are simulated, at least and at most."""

EXTREMES = ((1.0, 1.0, 0.5), (1.0, 0.0, 0.5))
"""Shares of pieces of each kind that are tried first: as large as the rig allows, and as fast, or as slow. Points that
fill a space come near no end of it, and there often is the most that a motion can show.
"""

COARSER = 100.0
"""Times the solver's tolerance with which the rig is simulated otherwise: what two hypotheses show is off by nearly the
same then, and a motion as a whole is simulated as exactly as ever.
"""

DESCENT, DESCENTS = 0.4, 3
"""Share of them that an optimiser moves on, and from how many."""

RADIUS, LAST_RADIUS = 0.15, 0.01
"""Of the descent, in shares."""

MOTIONS = 6
"""That are found, at most."""

LEAST, MOST = 0.1, 1e6
"""T below which a pair is so far from being told apart that no piece matters more than another, and beyond which it
does not count how surely it is.
"""
BESIDE = 1e-3
"""Of the logarithm of T beside that of the power: what tells apart surely may do so more surely still."""

SMALLER, TIMES = 0.25, 4
"""Share of its size that is taken off a piece that exceeds a limit, and how often."""


@dataclass(frozen=True)
class Wanted:
    """What a motion is for: to tell hypotheses apart, and to show parameters of the first of them (their places)."""

    hypotheses: Sequence[Hypothesis]
    parameters: Sequence[int] = ()

    def score(self, chosen: Sequence[Tried]) -> float:
        """Logarithm of the power to tell every pair apart, which of an effect of several shapes is the mean over these,
        and half that of the determinant of the parameters' precision (D-optimal: Kiefer and Wolfowitz 1960).
        """
        return self.score_of(self.left(chosen), chosen)

    def left(self, chosen: Sequence[Tried]) -> dict[Pair, float]:
        """T of every pair, to first order; of no piece it is 0."""
        nothing = dict.fromkeys(pairs_of(self.hypotheses), 0.0)
        return nothing | {pair: one.refitted(self.hypotheses[pair[1]])[0] for pair, one in summed(chosen).items()}

    def score_of(self, left: Mapping[Pair, float], chosen: Sequence[Tried]) -> float:
        """The same of pieces whose motion leaves that much of each pair, T."""
        total, truths = 0.0, truths_of(self.hypotheses)
        asked = dict[tuple[tuple[str, ...], int], list[float]]()
        for (true, rival), one in left.items():
            asked.setdefault((truths[true].effects, rival), []).append(one)
        for each in asked.values():
            distances = np.clip(each, LEAST, MOST)
            powers = log_ndtr((distances - ODDS) / (2.0 * np.sqrt(distances)))
            total += float(logsumexp(powers)) - np.log(len(each))
            total += BESIDE * float(np.mean(np.log1p(np.minimum(each, MOST))))
        if self.parameters:
            block = known_by(self.hypotheses[0], chosen)[np.ix_(self.parameters, self.parameters)]
            total -= 0.5 * float(np.linalg.slogdet(block)[1])
        return total


def known_by(first: Hypothesis, chosen: Sequence[Tried]) -> np.ndarray:
    """The covariance of the first hypothesis's unknowns after these pieces, and behind them of where it starts."""
    if not chosen:
        return first.covariance
    information = sum(one.information for one in chosen[1:]) + chosen[0].information
    return inverse(first.precision_with(len(information) - len(first.unknowns)) + information)


def summed(chosen: Sequence[Tried]) -> dict[Pair, Contrast]:
    """The contrasts of pieces that follow each other."""
    total = dict[Pair, Contrast]()
    for one in chosen:
        for pair, contrast in one.contrasts.items():
            total[pair] = total[pair] + contrast if pair in total else contrast
    return total


@dataclass
class Search:
    """Pieces that were tried on a rig, and how many more may be."""

    rig: Rig
    wanted: Wanted
    length: float
    progress: Progress
    most: int = TRIALS[0]
    known: list[Tried] = field(default_factory=list)
    refused: list[Tried] = field(default_factory=list)

    def at(self, piece: Piece) -> Tried:
        """A piece, simulated; one that exceeds a limit is made smaller until it does not, a few times."""
        for _ in range(TIMES):
            found = tried(self.rig, self.wanted.hypotheses, piece, informs=bool(self.wanted.parameters))
            if not found.beyond:
                self.known.append(found)
                break
            self.refused.append(found)
            size, pace, place = piece.shares
            piece = replace(piece, shares=(max(size - SMALLER, 0.0), pace, 0.5 + 0.5 * (place - 0.5)))
        count = len(self.known) + len(self.refused)
        self.progress("trying pieces of a motion", min(count / self.most, 1.0))
        return found

    def fill(self) -> None:
        """Try pieces of every kind and condition, evenly spread."""
        kinds, conditions = list(KINDS), self.rig.conditions
        extremes = np.repeat(EXTREMES, len(kinds), axis=0)
        points = np.concatenate([extremes, qmc.Sobol(3, scramble=True, seed=1).random_base2(7)])
        at, count = 0, 1
        while len(self.known) + len(self.refused) < (1.0 - DESCENT) * self.most and at < points.shape[0]:
            kind, condition = kinds[at % len(kinds)], conditions[(at // len(kinds)) % len(conditions)]
            size, pace, place = points[at].tolist()
            found = self.at(Piece(kind, (size, pace, place), self.length, condition))
            if at == 0:
                count = max(found.steps, 1)
                self.most = int(np.clip(STEPS / count, *TRIALS))
            at += 1

    def best(self, chosen: Sequence[Tried], kind: str = "") -> Tried:
        """Of all that are known, or of one kind, the piece that does most beside those that are chosen."""
        known = [one for one in self.known if kind in ("", one.piece.kind)]
        return max(known, key=lambda one: self.wanted.score([*chosen, one]))

    def greedily(self, places: int, kind: str = "") -> list[Tried]:
        """A motion of so many pieces, each the best beside those before."""
        chosen = list[Tried]()
        for _ in range(places):
            chosen.append(self.best(chosen, kind))
        return chosen

    def descended(self, chosen: Sequence[Tried], start: Tried, count: int) -> None:
        """Move a piece to where it does more, with so many simulations."""

        def cost(shares: np.ndarray) -> float:
            found = self.at(start.piece.with_shares(shares))
            return -self.wanted.score(chosen if found.beyond else [*chosen, found])

        minimize(
            cost,
            np.array(start.piece.shares),
            bounds=[(0.0, 1.0)] * 3,
            options={"radius_init": RADIUS, "radius_final": LAST_RADIUS, "maxfev": count},
        )


def search(rig: Rig, wanted: Wanted, duration: float, progress: Progress) -> list[list[Tried]]:
    """Motions of a `duration` (s) on a rig, each as its pieces in the order of their conditions and kinds, the best to
    first order first.

    Raises:
        UserError: every piece exceeds a limit, or none tells any two hypotheses apart.
    """
    length = float(np.clip(duration / PIECES, *PIECE))
    places = max(int(duration / length + 1e-9), 1)
    tried_on = replace(rig, tolerance=COARSER * rig.tolerance)
    found = Search(tried_on, wanted, duration / places, progress)
    found.fill()
    if not found.known:
        reasons = [one.beyond for one in found.refused]
        most = max(sorted(set(reasons)), key=reasons.count)
        raise UserError(f"no piece of a motion keeps the rig's limits: most exceed {most}; widen [design.limits]")
    chosen = list[Tried]()
    for place in range(places):
        best = found.best(chosen)
        left = found.most - len(found.known) - len(found.refused)
        if place < DESCENTS and left > 0:
            found.descended(chosen, best, max(left // (min(places, DESCENTS) - place), 4))
            best = found.best(chosen)
        chosen.append(best)
    _check_tells(wanted, found.known)
    kinds = [kind for kind in KINDS if any(kind == one.piece.kind for one in found.known)]
    motions = [chosen, found.greedily(places), *(found.greedily(places, kind) for kind in kinds)]
    motions.sort(key=wanted.score, reverse=True)
    ordered = [
        sorted(each, key=lambda one: (rig.conditions.index(one.piece.condition), kinds.index(one.piece.kind)))
        for each in motions
    ]
    return [one for i, one in enumerate(ordered) if one not in ordered[:i]][:MOTIONS]


def _check_tells(wanted: Wanted, known: Sequence[Tried]) -> None:
    """That of some pair at least one piece, repeated for ever, tells something."""
    pairs = pairs_of(wanted.hypotheses)
    if not pairs or wanted.parameters:
        return
    most = max(one.contrasts[pair].refitted(wanted.hypotheses[pair[1]])[0] for one in known for pair in pairs)
    if most < LEAST / len(known):
        names = " and ".join(one.name for one in wanted.hypotheses)
        raise UserError(
            f"no motion within the rig's limits tells {names} apart: after its refit no rival is off by more than "
            f"{np.sqrt(most):.1g} standard deviations of noise in any of {len(known)} pieces"
        )
