"""Commands that are stopped at any moment of their lives, and go on: nothing is lost, and the bytes are the same.

    PYTHONPATH=tests/helpers python -m kills --command decide --rounds 100 --seed 1 --jobs 2 [--signal SIGKILL ...]

A first undisturbed run says what the results are and how long they take. In each round the command gets a signal at a
random moment, from the first line of its code on, imports included, and is repeated, now and then stopped again, until
it ends by itself. Wrong is a traceback, an exit code that is none of the signal's, finished work that is not there
afterwards, a file that differs, and anything left behind.
"""

import argparse
import json
import random
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from contextlib import closing
from dataclasses import dataclass, field
from pathlib import Path

from kill_studies import COMMANDS, Command

AT_STAKE = 0.5
"""Seconds of work that may be lost."""

AGAIN = 0.3
"""How often a repeated command is stopped too."""

BEGUN = "begun\n"
BEGIN = f"import sys; print({BEGUN.strip()!r}, file=sys.stderr, flush=True)\n"
"""What a process says first: before, it is Python that starts, and a signal to it is not the command's to answer."""

LONG = 1.0
"""Seconds to stop from which on it is told when."""

CODES = {signal.SIGKILL: -signal.SIGKILL, signal.SIGINT: 130, signal.SIGTERM: 143}
"""Exit codes by signal. A shell shows the same where all is written and Python itself, which is ending, is stopped."""

TIMES = {"wall_seconds", "started", "jobs"}
"""What files of results say of how they came about, not of what they are."""


@dataclass
class Life:
    """What a process left: its exit code, what it complained of, when each piece of work was finished, and how long it
    took to end from the signal on, 0 where it ended by itself (s)."""

    code: int
    complaints: str
    finished: list[float]
    signalled: float
    seconds: float

    @property
    def surely_kept(self) -> int:
        """Pieces of work that were finished well before the signal."""
        return sum(moment < self.signalled - AT_STAKE for moment in self.finished)


@dataclass
class Tally:
    """What rounds have shown."""

    signals: Counter[str] = field(default_factory=Counter)
    ended_before: int = 0
    repeats: int = 0
    longest_stop: float = 0.0
    wrong: list[str] = field(default_factory=list)


def live(command: Command, arguments: list[str], stop: signal.Signals | None = None, moment: float = 0.0) -> Life:
    """Run a command in a process of its own, which tells of all that it does; `stop` it at that moment (s)."""
    said, moments = list[str](), list[float]()
    signalled = ended = 0.0
    line = [sys.executable, "-c", BEGIN + command.code, *arguments]
    with subprocess.Popen(line, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE, text=True) as process:
        assert process.stderr is not None
        errors = process.stderr

        assert errors.readline() == BEGUN

        def listen() -> None:
            for line in errors:
                said.append(line)
                if re.match(command.finished, line):
                    moments.append(time.monotonic())

        listener = threading.Thread(target=listen)
        listener.start()
        try:
            process.wait(moment if stop else None)
        except subprocess.TimeoutExpired:
            signalled = time.monotonic()
            process.send_signal(stop or signal.SIGKILL)
            process.wait()
            ended = time.monotonic()
        listener.join()
    complaints = "".join(line for line in said if not re.match(command.finished, line))
    return Life(process.returncode, complaints, moments, signalled, ended - signalled)


def rows(command: Command, out: Path) -> int:
    """Pieces of work that are kept in a folder."""
    database = out / command.database
    if not command.database or not database.exists():
        return 0
    with closing(sqlite3.connect(database)) as connection:  # not read-only: a commit that was cut off is taken back
        if not connection.execute("SELECT 1 FROM sqlite_master WHERE name = ?", (command.table,)).fetchone():
            return 0
        return int(connection.execute(f"SELECT COUNT(*) FROM {command.table}").fetchone()[0])


def contents(out: Path) -> dict[str, bytes]:
    """The files of a folder of results, but for databases and the times in what says how they were made."""
    paths = sorted(path for path in out.rglob("*") if path.is_file() and path.suffix != ".sqlite")
    return {str(path.relative_to(out)): _timeless(path) for path in paths}


def _timeless(path: Path) -> bytes:
    if path.suffix != ".json":
        return path.read_bytes()
    return json.dumps(_without_times(json.loads(path.read_text(encoding="utf-8")))).encode()


def _without_times(content: object) -> object:
    if isinstance(content, dict):
        return {key: _without_times(value) for key, value in content.items() if key not in TIMES}
    return [_without_times(value) for value in content] if isinstance(content, list) else content


def play(
    command: Command, home: Path, stop: signal.Signals, moments: list[float], expected: dict[str, bytes], jobs: int
) -> Tally:
    """A round: the command stopped at these moments of its lives, then left to end; what that shows."""
    out, tally = home / "out", Tally()
    fresh = [*command.arguments(home, jobs), "--out", str(out)]
    for number, moment in enumerate([*moments, None]):
        place = f"{stop.name} at {', '.join(f'{each:.3f}' for each in moments[: number + 1])} s"
        before = rows(command, out)
        options = command.again if number else []
        life = live(command, [*fresh, *options], stop if moment is not None else None, moment or 0.0)
        if "Traceback" in life.complaints:
            tally.wrong.append(f"{place}: traceback: {life.complaints[-2000:]}")
        if not life.signalled:
            tally.ended_before += moment is not None
            if life.code:
                tally.wrong.append(f"{place}: exit code {life.code}: {life.complaints}")
            break
        tally.signals[stop.name] += 1
        tally.repeats += number > 0
        if life.code not in (CODES[stop], 0) and not (life.code == -stop and contents(out) == expected):
            tally.wrong.append(f"{place}: exit code {life.code}, expected {CODES[stop]}: {life.complaints}")
        if stop is not signal.SIGKILL:
            tally.longest_stop = max(tally.longest_stop, life.seconds)
            if life.seconds > LONG:
                print(f"  {place}: took {life.seconds:.2f} s to stop", flush=True)
        kept = rows(command, out)
        least = max(before, life.surely_kept if command.database and not number else 0)
        if kept < least:
            tally.wrong.append(f"{place}: {kept} pieces of work are kept, {least} were finished {AT_STAKE} s before")
    found = contents(out) if out.exists() else {}
    for name in sorted(expected.keys() | found.keys()):
        if expected.get(name) != found.get(name):
            what = "is missing" if name not in found else "differs" if name in expected else "is left behind"
            tally.wrong.append(f"{place}: {name} {what}")
    tally.wrong += [f"{place}: {path.name} is left beside" for path in home.glob(".*")]
    shutil.rmtree(out, ignore_errors=True)
    return tally


def rounds(name: str, count: int, seed: int, jobs: int, signals: list[signal.Signals]) -> list[Tally]:
    """So many rounds of a command; what each has shown, and a line of each that went wrong."""
    command, generator = COMMANDS[name], random.Random(seed)
    with tempfile.TemporaryDirectory() as folder:
        home = Path(folder)
        command.make(home)
        began = time.monotonic()
        whole = live(command, [*command.arguments(home, jobs), "--out", str(home / "out")])
        assert whole.code == 0, whole.complaints
        lifetime, expected = time.monotonic() - began, contents(home / "out")
        shutil.rmtree(home / "out")
        print(f"{name}, {jobs} jobs: {len(whole.finished)} pieces of work, {lifetime:.1f} s undisturbed", flush=True)
        tallies = []
        for number in range(count):
            moments = [generator.uniform(0.0, lifetime)]
            while generator.random() < AGAIN:
                moments.append(generator.uniform(0.0, lifetime))
            tallies.append(play(command, home, signals[number % len(signals)], moments, expected, jobs))
            for line in tallies[-1].wrong:
                print(f"  round {number}: {line}", flush=True)
    return tallies


def main() -> int:
    """Play the rounds that are asked for; print what they have shown."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--command", choices=COMMANDS, required=True)
    parser.add_argument("--rounds", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--signal", nargs="+", default=[each.name for each in CODES], choices=[s.name for s in CODES])
    given = parser.parse_args()
    signals = [signal.Signals[name] for name in given.signal]
    signal.signal(signal.SIGINT, signal.default_int_handler)  # a shell's background jobs ignore it, and theirs too
    tallies = rounds(given.command, given.rounds, given.seed, given.jobs, signals)
    counts = sum((tally.signals for tally in tallies), Counter[str]())
    wrong = sum(bool(tally.wrong) for tally in tallies)
    print(
        f"{len(tallies)} rounds: {', '.join(f'{number} {name}' for name, number in counts.items()) or 'no signal'}, "
        f"{sum(tally.repeats for tally in tallies)} of them to a repeated command; "
        f"{sum(tally.ended_before for tally in tallies)} ended before theirs; "
        f"longest stop {max(tally.longest_stop for tally in tallies):.2f} s; {wrong} rounds went wrong"
    )
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
