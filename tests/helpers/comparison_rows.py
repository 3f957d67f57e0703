"""What the rows of a comparison say, found by other means than the program's: pandas and SciPy on the results."""

import functools
import math
from collections.abc import Callable, Iterator
from itertools import combinations
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
from scipy import stats

CANDIDATE = r"([a-z0-9 ]+?) (?:at rest|at ([\d.]+) rpm(?: \(really ([\d.]+)\))?)"
NUMBER = r"(-?[\d.e-]+|< 0.0001)"
RANGE = r"(?: \((-?[\d.e-]+) to (-?[\d.e-]+)\))?"
SIZED = rf"{CANDIDATE}, {NUMBER} mm{RANGE}"
WORD = r"(beats|loses to|is level with|cannot be told from)"
MARGIN = rf"ratio {NUMBER}{RANGE}, difference {NUMBER} mm{RANGE}(; \d+ draws do not tell, .*)?"

CLASSES = ("nothing", "compensate", "avoid", "both")
PLAIN, PRESSURE, STEPS, NEGLIGIBLE = ("p", "pi"), ("load_pressure",), ("steps",), 1e-6
PAIRS = 6


class Key(NamedTuple):
    """One cell."""

    machine: str
    scenario: str
    reference: str


def kept(method: Callable[..., Any]) -> Callable[..., Any]:
    """A method of `Rows` that answers once what it is asked: of a cell, and of one of its two frames."""

    @functools.wraps(method)
    def answer(self: "Rows", *asked: Any) -> Any:
        frames = {id(self.search): "search", id(self.fresh): "fresh"}
        key = (method.__name__, *(frames.get(id(each), each) for each in asked))
        if key not in self.answers:
            self.answers[key] = method(self, *asked)
        return self.answers[key]

    return answer


class Rows:
    """Search and fresh results of a comparison, asked by cell and candidate."""

    def __init__(self, search: pd.DataFrame, fresh: pd.DataFrame) -> None:
        self.search, self.fresh = search, fresh
        self.answers: dict[tuple[Any, ...], Any] = {}

    def cells(self) -> Iterator[Key]:
        for key in self.search[["machine", "scenario", "reference"]].drop_duplicates().itertuples(index=False):
            yield Key(*key)

    @kept
    def of(self, frame: pd.DataFrame, cell: Key, controller: str, rpm: float) -> pd.DataFrame:
        """The rows of a candidate, by draw."""
        rows = frame[(frame["machine"] == cell.machine) & (frame["scenario"] == cell.scenario)]
        rows = rows[rows["reference"] == cell.reference]
        return rows[(rows["controller"] == controller) & (rows["rpm"] == rpm)].sort_values("draw")

    def errors(self, frame: pd.DataFrame, cell: Key, controller: str, rpm: float) -> np.ndarray:
        """Its errors (m)."""
        column = "steady_state_max_error_m" if cell.reference in STEPS else "rms_error_m"
        return self.of(frame, cell, controller, rpm)[column].to_numpy(float)

    @kept
    def hunting(self, cell: Key, controller: str, rpm: float) -> tuple[int, int]:
        """On how many draws it swings, and of how many: of the fresh draws, where it was measured there."""
        for frame in (self.fresh, self.search):
            rows = frame[(frame["machine"] == cell.machine) & (frame["scenario"] == cell.scenario)]
            rows = rows[(rows["controller"] == controller) & (rows["rpm"] == rpm) & rows["limit_cycle"].notna()]
            if not rows.empty:
                swings = rows[rows["limit_cycle"].isin(["sustained", "too_short"])]
                return swings["draw"].nunique(), rows["draw"].nunique()
        raise AssertionError("nobody held still")

    @kept
    def rare(self, cell: Key) -> dict[str, tuple[str, float]]:
        """Of each class the best that may hunt on no more than 5 % of the machines, if it is in front of who stands."""
        rarely = {}
        for kind in CLASSES:
            for candidate in self.ranked(cell, kind):
                if candidate == self.stands(cell).get(kind):
                    break
                count, of = self.hunting(cell, *candidate)
                if stats.beta.ppf(0.025, count, of - count + 1) <= 0.05:
                    rarely.setdefault(kind, candidate)
        return rarely

    @kept
    def hunts(self, frame: pd.DataFrame, cell: Key, controller: str, rpm: float) -> bool:
        """Whether it swings in any draw of its machine and scenario."""
        rows = frame[(frame["machine"] == cell.machine) & (frame["scenario"] == cell.scenario)]
        rows = rows[(rows["controller"] == controller) & (rows["rpm"] == rpm)]
        return bool(rows["limit_cycle"].isin(["sustained", "too_short"]).any())

    @kept
    def ranked(self, cell: Key, kind: str) -> list[tuple[str, float]]:
        """The candidates of a class that hold in the search and were measured again, the best first."""
        part = self.search[(self.search["machine"] == cell.machine) & (self.search["scenario"] == cell.scenario)]
        part = part[part["reference"] == cell.reference]
        named = {(str(c), float(r)) for c, r in part[["controller", "rpm"]].drop_duplicates().itertuples(index=False)}
        own = [
            candidate
            for candidate in named
            if class_of(*candidate) == kind and not self.hunts(self.search, cell, *candidate)
        ]
        own = [candidate for candidate in own if not self.of(self.fresh, cell, *candidate).empty]
        return sorted(own, key=lambda candidate: stats.gmean(self.errors(self.search, cell, *candidate)))

    @kept
    def stands(self, cell: Key) -> dict[str, tuple[str, float]]:
        """Who stands for each class."""
        ranked = {kind: self.ranked(cell, kind) for kind in CLASSES}
        sound = {
            kind: [candidate for candidate in of if not self.hunts(self.fresh, cell, *candidate)]
            for kind, of in ranked.items()
        }
        return {kind: of[0] for kind, of in sound.items() if of}

    @kept
    def word(self, cell: Key, first: tuple[str, float], second: tuple[str, float], pairs: int = PAIRS) -> str:
        """How one candidate does against another on the fresh draws."""
        a, b = (self.errors(self.fresh, cell, *who) for who in (first, second))
        floor, bound = NEGLIGIBLE / 0.05, -math.log(0.95)
        low, high = interval(np.log(b + floor) - np.log(a + floor), pairs)
        if low > bound:
            return "beats"
        if high < -bound:
            return "loses to"
        return "is level with" if low >= -bound and high <= bound else "cannot be told from"

    def kind(self, cell: Key) -> str:
        """The verdict, by its definition on the page."""
        strictly, otherwise = self.both_ways(cell)
        return strictly if strictly == otherwise else "cannot be told"

    def both_ways(self, cell: Key) -> tuple[str, str]:
        """The verdict if nothing holds that hunts, and the one if what does so rarely holds."""
        held = self.stands(cell)
        return self.kind_among(cell, held), self.kind_among(cell, held | self.rare(cell))

    def kind_among(self, cell: Key, held: dict[str, tuple[str, float]]) -> str:
        """The verdict if these stand for the classes."""
        words = {
            (a, b): self.word(cell, held[a], held[b]) for pair in combinations(held, 2) for a, b in (pair, pair[::-1])
        }

        def wins(side: str, *others: str) -> bool:
            return side in held and all(words.get((side, other), "beats") == "beats" for other in others)

        if "nothing" in held:
            beaten = [words["nothing", kind] for kind in held if kind != "nothing"]
            if set(beaten) <= {"beats", "is level with"}:
                return "nothing needed"
        for kind, others in (
            ("both", ("compensate", "avoid", "nothing")),
            ("compensate", ("avoid", "nothing")),
            ("avoid", ("compensate", "nothing")),
        ):
            if wins(kind, *others):
                return kind
        level = words.get(("compensate", "avoid")) == "is level with"
        if level and (wins("compensate", "nothing") or wins("avoid", "nothing")):
            return "level"
        return "cannot be told" if "cannot be told from" in words.values() else "level"


def class_of(controller: str, rpm: float) -> str:
    """The class of a candidate."""
    return CLASSES[2 * (rpm > 0) + (controller not in PLAIN)]


def interval(values: np.ndarray, pairs: int = 1) -> tuple[float, float]:
    """Student's interval of a mean, by SciPy's test."""
    ends = stats.ttest_1samp(values, 0.0).confidence_interval(1.0 - 0.05 / pairs)
    return float(ends.low), float(ends.high)


def same(text: str, value: float, digits: int = 3) -> bool:
    """Whether a number on the page is this one to the digits that it is told with."""
    if text.startswith("<"):
        return abs(value) < 1e-4
    return math.isclose(float(text), value, rel_tol=0.51 * 10.0 ** (1 - digits), abs_tol=1e-9)
