"""The command: mutants until the time or the count is up, several processes, a line a finding and how to repeat it."""

import argparse
import os
import sys
import tempfile
import time
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path

from fuzz.processes import tried
from fuzz.sandbox import Sandbox
from fuzz.trials import KINDS, trial

EVERY = 60.0
"""Seconds after which it is said again how far it is."""

LIKE = 2
"""Findings of one kind and place that are shown; of further ones their number."""


@dataclass
class Tally:
    """What has been seen so far."""

    trials: Counter[str] = field(default_factory=Counter)
    kinds: Counter[str] = field(default_factory=Counter)
    alike: Counter[tuple[str, str]] = field(default_factory=Counter)

    def add(self, kind: str, seed: int, number: int, done: str, findings: list[tuple[str, str]]) -> None:
        """One trial; its findings are shown unless there were many like them."""
        self.trials[done] += 1
        for what, words in findings:
            self.kinds[what] += 1
            like = what, words.split(": ")[0] if what == "traceback" else words[:60]
            self.alike[like] += 1
            if self.alike[like] <= LIKE:
                print(f"{what}: {words}\n    python -m fuzz {kind} --seed {seed} --only {number}", flush=True)

    def said(self) -> str:
        """All of it in a line."""
        trials = ", ".join(f"{count} {name}" for name, count in sorted(self.trials.items())) or "none"
        found = ", ".join(f"{count} {name}" for name, count in sorted(self.kinds.items())) or "nothing found"
        return f"{sum(self.trials.values())} mutants ({trials}): {found}"


def main() -> int:
    """Run what the arguments ask for; 1 where anything was found."""
    parser = argparse.ArgumentParser(prog="python -m fuzz", description="Mutated files, in search of tracebacks.")
    parser.add_argument("kind", nargs="?", choices=KINDS, help="default: all three, each a share of the time")
    parser.add_argument("--seconds", type=float, default=600.0)
    parser.add_argument("--count", type=int, help="mutants at most")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--first", type=int, default=0, help="number of the first mutant")
    parser.add_argument("--only", type=int, help="one mutant alone, with what it holds")
    parser.add_argument("--jobs", type=int, default=os.cpu_count() or 1)
    asked = parser.parse_args()
    if asked.only is not None:
        return _one(asked.kind or KINDS[0], asked.seed, asked.only)
    found = False
    numbers = range(asked.first, asked.first + (sys.maxsize // 2 if asked.count is None else asked.count))
    kinds = (asked.kind,) if asked.kind else KINDS
    for kind in kinds:
        print(f"{kind}, seed {asked.seed}", flush=True)
        tally, began = Tally(), time.monotonic()
        told = began
        for number, done, findings in tried(kind, asked.seed, numbers, asked.seconds / len(kinds), asked.jobs):
            tally.add(kind, asked.seed, number, done, findings)
            if time.monotonic() - told > EVERY:
                told = time.monotonic()
                print(f"    {tally.said()}", flush=True)
        for (what, words), count in tally.alike.most_common():
            print(f"  {count} times {what}: {words}")
        print(f"{kind}, seed {asked.seed}: {tally.said()}; {time.monotonic() - began:.0f} s", flush=True)
        found = found or bool(tally.kinds)
    return int(found)


class Shown(Sandbox):
    """A sandbox that prints the files that are put into it."""

    def put(self, name: str, content: bytes) -> Path:
        print(f"--- {name}\n{content.decode(errors='backslashreplace')[:20000]}")
        return super().put(name, content)


def _one(kind: str, seed: int, number: int) -> int:
    """One mutant: its files as they are put down, and what is found."""
    with tempfile.TemporaryDirectory() as folder:
        one = trial(Shown(Path(folder)), kind, seed, number)
    print(f"--- {one.done}")
    for finding in one.findings:
        print(f"{finding.kind}: {finding.what}")
    return int(bool(one.findings))


if __name__ == "__main__":
    sys.exit(main())
