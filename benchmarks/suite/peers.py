"""The same closed loop by this program, by general tools and in C: `closed_loop.py`, run as a user runs it."""

import math
import re
import subprocess
import sys
from dataclasses import dataclass
from pathlib import Path

from matplotlib.axes import Axes

from suite.part import Part, Ratio, Size, shown
from workbench.publish.style import plain_numbers

SCRIPT = Path(__file__).parents[1] / "closed_loop.py"

ROW = re.compile(r"^(?P<name>\S.*?)\s+(?P<ms>\d+\.\d+)(?P<scaled>[* ])\s*(?P<error>nan|\d\.\d+e[-+]\d+)\s+\d+\.\d+$")

COMPARED = ("in C, gcc -O2", "CVODES", "python-control, restarted")
"""Parts of the names of the peers that ours is held against in the ratios: ours over C, the others over ours."""


@dataclass(frozen=True)
class Time:
    """Of one row of the printed table: milliseconds, and the position error (m)."""

    name: str
    milliseconds: float
    error: float


def times_in(printed: str) -> list[Time]:
    """The rows of what `closed_loop.py` prints.

    Raises:
        ValueError: there are none, because its table has another form.
    """
    found = [ROW.match(line) for line in printed.splitlines()]
    times = [Time(row["name"], float(row["ms"]), float(row["error"])) for row in found if row]
    if not times:
        raise ValueError(f"no row of a table in what {SCRIPT.name} prints:\n{printed}")
    return times


def measured(turns: int) -> list[Time]:
    """The table, once."""
    command = [sys.executable, SCRIPT, "--rounds", str(turns)]
    return times_in(subprocess.run(command, check=True, capture_output=True, text=True).stdout)


def peers(size: Size, folder: Path) -> Part:
    """All peers in turn, `size.rounds` times over."""
    rounds = [measured(size.turns) for _ in range(size.rounds)]
    best = [
        min((time for times in rounds for time in times if time.name == name), key=lambda time: time.milliseconds)
        for name in dict.fromkeys(time.name for times in rounds for time in times)
    ]
    ours = best[0]

    def draw(axes: Axes) -> None:
        names = [time.name for time in best][::-1]
        values = [time.milliseconds for time in best][::-1]
        bars = axes.barh(names, values, color=["#0072B2" if name.startswith("ours") else "#bbbbbb" for name in names])
        axes.bar_label(bars, [f" {shown(value)}" for value in values], fontsize="small")
        axes.set_xscale("log")
        plain_numbers(axes.xaxis)
        axes.margins(x=0.15)
        axes.set_xlabel("ms for 3 s of closed loop (logarithmic)")
        axes.grid(axis="y", visible=False)

    return Part(
        "peers",
        "The same closed loop by other tools",
        "3 s of one closed loop at 1 kHz, in one run on one core; blue is this program. What each row is, and why the "
        "errors are alike, is said in benchmarks/README.md.",
        ("", "ms", "position error, m", "over ours"),
        [
            (time.name, shown(time.milliseconds), f"{time.error:.1e}", shown(time.milliseconds / ours.milliseconds))
            for time in best
        ],
        draw,
        height=0.3 * len(best) + 1.0,
        ratios=dict(item for name in COMPARED for item in _ratio(rounds, name)),
    )


def _ratio(rounds: list[list[Time]], part: str) -> list[tuple[str, Ratio]]:
    """Of the first row, ours, and the first whose name holds `part`; nothing where there is none, as without gcc.

    A peer whose error is no number solved something else, and is not compared.
    """
    pairs = [(times[0], next((time for time in times if part in time.name), None)) for times in rounds]
    found = [
        (ours.milliseconds, peer.milliseconds, peer.name)
        for ours, peer in pairs
        if peer is not None and math.isfinite(peer.error)
    ]
    if not found:
        return []
    if part.startswith("in C"):
        return [("ours over the same scheme in C", Ratio(tuple(ours / peer for ours, peer, _ in found)))]
    return [(f"{found[0][2]} over ours", Ratio(tuple(peer / ours for ours, peer, _ in found)))]
