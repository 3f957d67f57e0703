"""The page: machine and date, then a figure and a table for each part, and the ratios beside those of the last time."""

import os
import platform
import time
from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from suite.part import Part, Ratio, shown
from workbench.publish.pictures import save
from workbench.publish.style import WIDTH, figure_style

PACKAGES = ("numpy", "numba", "scipy", "casadi", "control")

HEAD = """\
# Benchmarks

Written by `make benchmark{full}`; `benchmarks/README.md` says how each figure is measured
and read. Times are of this machine alone; the ratios at the end are what other machines can be compared by.

{machine}
"""


def machine() -> str:
    """Date, processor, cores and versions, in a sentence."""
    versions = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    return (
        f"{time.strftime('%d %B %Y', time.gmtime())}; {processor()}, {os.cpu_count()} cores, {platform.system()}; "
        f"Python {platform.python_version()}, {versions}."
    )


def processor() -> str:
    """What the processor is called."""
    told = Path("/proc/cpuinfo")
    lines = told.read_text(encoding="utf-8").splitlines() if told.exists() else []
    names = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return names[0] if names else platform.processor() or platform.machine()


def table(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """In Markdown."""
    lines = [columns, ["---"] * len(columns), *rows]
    return "\n".join(f"| {' | '.join(line)} |" for line in lines)


def picture(part: Part, folder: Path) -> Path:
    """Draw and save a part's figure; returns its path."""
    with figure_style():
        figure = Figure(figsize=(WIDTH, part.height))
        FigureCanvasAgg(figure)
        part.draw(figure.subplots())
        figure.suptitle(part.title)
    (path,) = save(figure, part.name, folder, ("svg",), caption=part.words)
    return path


def ratio_rows(before: Mapping[str, Ratio], now: Mapping[str, Ratio]) -> list[tuple[str, str, str, str]]:
    """Each ratio with its rounds' range, and the last time's."""
    return [
        (
            name,
            shown(ratio.middle),
            f"{shown(min(ratio.values))} to {shown(max(ratio.values))}" if len(ratio.values) > 1 else "",
            shown(before[name].middle) if name in before else "",
        )
        for name, ratio in now.items()
    ]


def write_page(parts: Sequence[Part], before: Mapping[str, Ratio], folder: Path, *, full: bool) -> Path:
    """Write benchmarks.md, and a figure for each part into benchmarks/, in `folder`; returns the page."""
    pieces = [HEAD.format(full=" FULL=1" if full else "", machine=machine())]
    for part in parts:
        path = picture(part, folder / "benchmarks")
        pieces += [
            f"## {part.title}",
            part.words,
            f"![{part.title}](benchmarks/{path.name})",
            table(part.columns, part.rows),
        ]
    now = {name: ratio for part in parts for name, ratio in part.ratios.items()}
    pieces += [
        "## Ratios",
        "The median of the rounds, their range, and the median of the time before.",
        table(("ratio", "now", "range", "before"), ratio_rows(before, now)),
    ]
    page = folder / "benchmarks.md"
    page.write_text("\n\n".join(piece.strip() for piece in pieces) + "\n", encoding="utf-8")
    return page
