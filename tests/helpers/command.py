"""The `workbench` command as tests run it, and a small study that they change."""

import contextlib
import io
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple
from unittest import mock

from workbench.cli import main
from workbench.stopping import SIGNALS

ROOT = Path(__file__).parents[2]
STUDIES = ROOT / "studies"
PROCESS = (sys.executable, "-c", "from workbench.cli import main; main()")
"""The command in a process of its own."""

PIPED = """\
from workbench.cli import main, progress
progress.INTERVAL = {interval}
main()
"""
"""The same as code, which says how far it is every so many seconds."""

STUDY = """\
title = "a study for tests"
[plant]
model = "by_rpm"
parameters = "owen2001_simulation"

[axes]
rpm = [0, 460]

[controllers.p]
type = "pid"
kp = "500 V/m"

[references.sine]
kind = "sine"
amplitude = "5 mm"
frequency = "2 Hz"

[simulation]
duration = "1 s"
transient = "0.4 s"
"""

DRIVE = """\
title = "a drive, for tests"
[plant]
model = "drive"
parameters = "canudas1995"

[controllers.p]
type = "pid"
kp = "3 N/m"

[references.step]
kind = "steps"
levels = ["1 m"]
dwell = "1 s"

[simulation]
duration = "1 s"
"""

FIGURE = '[[figures]]\nname = "f"\ntitle = "f"\n[[figures.panels]]\nx_label = "x"\ny_label = "y"\n'
"""A figure of one panel, without its curves."""


class Answer(NamedTuple):
    """What a command left: its exit code and what it wrote."""

    code: int
    out: str
    err: str


def workbench(*arguments: str | Path) -> Answer:
    """Run the command in this process, which hears signals as before when it has ended."""
    out, err, code = io.StringIO(), io.StringIO(), 0
    handlers = {number: signal.getsignal(number) for number in SIGNALS}
    with (
        mock.patch.object(sys, "argv", ["workbench", *map(str, arguments)]),
        contextlib.redirect_stdout(out),
        contextlib.redirect_stderr(err),
    ):
        try:
            main()
        except SystemExit as ended:
            code = int(ended.code or 0)
        finally:
            for number, handler in handlers.items():
                signal.signal(number, handler)
    return Answer(code, out.getvalue(), err.getvalue())


def killed(enough: Callable[[], bool], *arguments: str | Path) -> bytes:
    """Run the command in a process of its own, kill it with SIGKILL once there is enough; what it complained of."""
    command = [*PROCESS, *map(str, arguments)]
    process = subprocess.Popen(command, stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)
    deadline = time.monotonic() + 120.0
    while not enough() and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    _, complaints = process.communicate(timeout=60.0)
    assert process.returncode == -signal.SIGKILL
    return complaints


def write(folder: Path, text: str, name: str = "study.toml") -> Path:
    """A file in `folder`."""
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def changed(old: str, new: str, study: str = STUDY) -> str:
    """The study with one place of it changed."""
    assert study.count(old) == 1, old
    return study.replace(old, new)


def fails(answer: Answer, *said: str) -> None:
    """One line of error that says this, and nothing else."""
    assert (answer.code, answer.out) == (2, ""), answer
    for part in said:
        assert part in answer.err
    assert answer.err.count("\n") == 1


def ran(folder: Path, text: str, *options: str) -> Path:
    """The folder of results of a study that runs without complaint."""
    out = folder / "results"
    answer = workbench("run", write(folder, text), "--out", out, *options)
    assert (answer.code, answer.err) == (0, "")
    return out
