"""What a part of the benchmarks hands to the page, and how much of it is measured."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

from matplotlib.axes import Axes


def shown(value: float) -> str:
    """Three digits, without a power of ten where the number is large."""
    return f"{value:.0f}" if value >= 100.0 else f"{value:.3g}"


@dataclass(frozen=True)
class Ratio:
    """A ratio of two times, or of two sizes, that were measured side by side, once in each round."""

    values: tuple[float, ...]

    @property
    def middle(self) -> float:
        """The median."""
        ordered = sorted(self.values)
        half = len(ordered) // 2
        return ordered[half] if len(ordered) % 2 else 0.5 * (ordered[half - 1] + ordered[half])


@dataclass(frozen=True)
class Part:
    """One figure of the page with its table; `draw` draws it, `ratios` are what another machine can be compared by."""

    name: str
    title: str
    words: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    draw: Callable[[Axes], None]
    height: float = 3.2
    ratios: dict[str, Ratio] = field(default_factory=dict)


@dataclass(frozen=True)
class Size:
    """How much is measured.

    `cases` are the numbers of cases of a study, `both_jobs` the one that one and two jobs take turns at; `seconds` are
    durations of a run (s), `damping` values of the bristle damping (N s/m), `records` lengths of a record (s). Ratios
    are measured `rounds` times; of `turns` turns the best time of a peer counts, and of `starts` starts the least.
    """

    rounds: int
    turns: int
    starts: int
    cases: Sequence[int]
    both_jobs: int
    seconds: Sequence[float]
    damping: Sequence[float]
    records: Sequence[float]


QUICK = Size(3, 4, 7, (1, 10, 100, 1000, 10_000), 1000, (1, 3, 10, 30, 100), (1e3, 1e4, 1e5, 1e6), (10, 30))
FULL = Size(
    7,
    20,
    15,
    (1, 10, 100, 1000, 10_000, 100_000),
    5000,
    (1, 3, 10, 30, 100, 300, 1000),
    (1e2, 1e3, 1e4, 1e5, 1e6),
    (10, 20, 50, 100),
)
