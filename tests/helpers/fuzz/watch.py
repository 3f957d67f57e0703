"""A command watched while it meets a mutant: what it must not do, as findings."""

import contextlib
import io
import re
import signal
import sys
import time
import traceback
import warnings
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from command import DRIVE, STUDY, Answer

from fuzz.sandbox import Sandbox
from workbench.cli import check
from workbench.cli.app import app, mistakes_told

LONGEST_SECONDS = 10
"""Of processor time: a busy machine is no hang."""

MOST_LINES, MOST_CHARACTERS = 3, 400
"""Of a refusal, and of each of its lines without its place."""


COMPILED = 60
"""Seconds within which a command that has to compile is through, the first time; the second time it need not."""


class HangError(BaseException):
    """A command that has taken too long; no handler of the program takes it for a mistake of the user."""


@dataclass(frozen=True)
class Finding:
    """What a mutant brought about: of which kind, and where or what in words."""

    kind: str
    what: str


@contextmanager
def _alarm(seconds: float) -> Iterator[None]:
    def rings(*_: object) -> None:
        raise HangError

    before = signal.signal(signal.SIGPROF, rings)
    signal.setitimer(signal.ITIMER_PROF, seconds)
    try:
        yield
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0.0)
        signal.signal(signal.SIGPROF, before)


def watched(sandbox: Sandbox, *arguments: str | Path) -> tuple[Answer | None, list[Finding]]:
    """What a command answers, None where it ends by a traceback or not at all, and what was found."""
    before = sandbox.listing()
    began = time.process_time()
    answer, found = _run(arguments, COMPILED)
    if time.process_time() - began > LONGEST_SECONDS:
        answer, found = _run(arguments, LONGEST_SECONDS)
    outside = sorted(sandbox.listing() - before)
    found += [Finding("outside", _without(sandbox, path)) for path in outside[:1]]
    for path in outside:
        if Path(path).is_file() or Path(path).is_symlink():
            Path(path).unlink()
    return answer, found + ([] if answer is None else _said(sandbox, answer))


def _run(arguments: Sequence[str | Path], seconds: float) -> tuple[Answer | None, list[Finding]]:
    try:
        with _alarm(seconds), warnings.catch_warnings():
            warnings.simplefilter("always")
            warnings.showwarning = _shown  # as without a test around, which collects them
            for quiet in (DeprecationWarning, PendingDeprecationWarning, ImportWarning, ResourceWarning):
                warnings.simplefilter("ignore", quiet)
            return _answer(arguments), []
    except HangError as error:
        return None, [Finding("hang", _place(error))]
    except Exception as error:  # noqa: BLE001 - any at all is a finding
        return None, [Finding("traceback", f"{type(error).__name__} at {_place(error)}: {str(error)[:120]!r}")]


def warmed(sandbox: Sandbox, kind: str) -> Sandbox:
    """The sandbox, when what is compiled once is compiled: it is no hang of the first mutant."""
    for name in ("hunting.toml", "observers.toml", "thesis_chapter3.toml"):
        _answer(("check", sandbox.studies / name))
    for text in (STUDY, DRIVE) if kind == "run" else ():
        path = sandbox.put("mutant.toml", text.encode())
        _answer(("run", path, "--out", sandbox.out, "--jobs", "1"))
        sandbox.empty()
    return sandbox


def _answer(arguments: Sequence[str | Path]) -> Answer:
    """What the command says; `check` goes without the reading of arguments, which takes longer than most files."""
    out, err, code = io.StringIO(), io.StringIO(), 0
    with contextlib.redirect_stdout(out), contextlib.redirect_stderr(err):
        try:
            with mistakes_told():
                if arguments[0] == "check":
                    check.command(Path(arguments[1]))
                else:
                    app([str(argument) for argument in arguments])
        except SystemExit as ended:
            code = int(ended.code or 0)
    return Answer(code, out.getvalue(), err.getvalue())


def _shown(message: Warning | str, category: type[Warning], filename: str, lineno: int, *_: object) -> None:
    sys.stderr.write(warnings.formatwarning(message, category, filename, lineno))


def _place(error: BaseException) -> str:
    """Where in our own code an error arose."""
    frames = traceback.extract_tb(error.__traceback__)
    ours = [frame for frame in frames if re.search(r"/(workbench|plants|controllers)/", frame.filename)]
    frame = (ours or frames)[-1]
    return f"{'/'.join(Path(frame.filename).parts[-3:])}:{frame.lineno} {frame.name}"


def _said(sandbox: Sandbox, answer: Answer) -> list[Finding]:
    lines = _without(sandbox, answer.err).rstrip("\n").split("\n") if answer.err else []
    found = []
    refused = answer.code not in (0, 1)
    if refused and len(lines) > MOST_LINES:
        found.append(Finding("long", f"{len(lines)} lines: {lines[0][:160]}"))
    longest = max(map(_behind_place, lines), key=len, default="")
    if len(longest) > MOST_CHARACTERS:
        found.append(Finding("long", f"{len(longest)} characters: {longest[:160]}"))
    if refused and (not lines or not lines[0].startswith("error: ")):
        found.append(Finding("silent", f"exit code {answer.code}: {answer.err[:160]!r}"))
    strange = [line for line in lines if not line.startswith(("error: ", "warning: "))]
    if not refused and strange:
        found.append(Finding("warning", strange[0][:200]))
    if control := re.search(r"[\x00-\x08\x0b-\x1f\x7f-\x9f\u202a-\u202e\u2066-\u2069]", answer.err + answer.out):
        found.append(Finding("control", f"{control[0]!r} on the terminal: {(answer.err or answer.out)[:160]!r}"))
    return found


def _behind_place(line: str) -> str:
    """What a line says, without the file, the line and the key that it says it of."""
    return re.sub(r"^((error|warning|@[^ ]*|[^ ]{1,300}): )+", "", line)


def _without(sandbox: Sandbox, text: str) -> str:
    return text.replace(str(sandbox.home), "@").replace(str(sandbox.root), "@@")
