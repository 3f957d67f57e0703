"""All that should be seen of the program's speed: peers, cases, jobs, memory, stiffness, records, start-up.

    python benchmarks/all.py [--full] [--only PART ...] [--folder docs]

Writes docs/benchmarks.md with its figures, and docs/benchmarks/ratios.json, and prints which ratios are others than
those that are stored there. With --only nothing is stored. README.md says how to read it.
"""

import argparse
import tempfile
import time
from collections.abc import Callable, Sequence
from pathlib import Path

from suite.cases import cases
from suite.loops import seconds, stiffness, together
from suite.page import write_page
from suite.part import FULL, QUICK, Part, Size
from suite.peers import peers
from suite.ratios import changes, store, stored
from suite.records import records
from suite.startup import startup

PARTS: dict[str, Callable[[Size, Path], Part | list[Part]]] = {
    "startup": startup,
    "peers": peers,
    "seconds": seconds,
    "stiffness": stiffness,
    "together": together,
    "cases": cases,
    "records": records,
}
"""By name, in the order of the page."""

DOCS = Path(__file__).parents[1] / "docs"


def measured(names: Sequence[str], size: Size) -> list[Part]:
    """The parts of these names, one after another; says how long each took."""
    parts: list[Part] = []
    for name in names:
        begin = time.monotonic()
        with tempfile.TemporaryDirectory() as folder:
            made = PARTS[name](size, Path(folder))
        parts += made if isinstance(made, list) else [made]
        print(f"{name}: measured in {time.monotonic() - begin:.0f} s", flush=True)
    return parts


def report(parts: Sequence[Part], folder: Path, *, full: bool, keep: bool) -> None:
    """Write the page into `folder`, say which ratios have moved since those stored there, and `keep` these."""
    (folder / "benchmarks").mkdir(parents=True, exist_ok=True)
    path = folder / "benchmarks" / "ratios.json"
    before, now = stored(path), {name: ratio for part in parts for name, ratio in part.ratios.items()}
    print(f"wrote {write_page(parts, before, folder, full=full)}")
    same = "no ratio has moved by more than its spread" if before else "no ratios are stored to compare with"
    for line in changes(before, now) or [same]:
        print(line)
    if keep:
        store(path, now)


def main() -> None:
    """Measure, write, compare."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--full", action="store_true", help="longer, up to 100 000 cases")
    parser.add_argument("--only", nargs="+", choices=PARTS, metavar="PART", help=f"of {', '.join(PARTS)}")
    parser.add_argument("--folder", type=Path, default=DOCS, help="where the page goes")
    options = parser.parse_args()
    size = FULL if options.full else QUICK
    parts = measured(options.only or list(PARTS), size)
    report(parts, options.folder, full=options.full, keep=options.only is None)


if __name__ == "__main__":
    main()
