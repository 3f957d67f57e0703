"""Running a page's blocks in order, in a folder of its own."""

import contextlib
import io
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

from command import workbench

from snippets.blocks import Block, blocks
from snippets.commands import workbench_lines
from snippets.folders import missing_lines, written
from snippets.given import given


class BlockError(Exception):
    """A block that did not do what its page says; where it stands, and what it did."""

    def __init__(self, block: Block, said: str) -> None:
        super().__init__(f"{block.place}: {said.strip()}")


def run_quick(page: Path, folder: Path) -> list[str]:
    """Check the TOML of a page, and run what is marked as quick, in this process; the places of what was done.

    Raises:
        BlockError: a block that fails, or prints something else.
    """
    done, printed = [], ""
    given(page, folder)
    with contextlib.chdir(folder):
        for block in blocks(page):
            if path := written(block, folder):
                if path.suffix == ".toml":
                    _checked(block, path.relative_to(folder))
                    done.append(block.place)
            elif block.kind == "quick":
                printed = _quick(block)
                done.append(block.place)
            elif block.kind == "output" and printed:
                _as_printed(block, printed)
                done.append(block.place)
            else:
                printed = ""
    return done


def run_all(page: Path, folder: Path) -> Iterator[str]:
    """Run all that is run of a page, as a reader would; the place of each block, once it has done what it should.

    Raises:
        BlockError: a block that fails, or prints something else.
    """
    printed = ""
    given(page, folder)
    names: dict[str, object] = {"__name__": "__main__"}
    for block in blocks(page):
        if block.kind == "illustration":
            continue
        if block.kind == "output":
            _as_printed(block, printed)
        elif (path := written(block, folder)) is None:
            printed = _in_shell(block, folder) if block.language == "sh" else _python(block, folder, names)
        elif path.suffix == ".toml":
            with contextlib.chdir(folder):
                _checked(block, path.relative_to(folder))
        yield block.place


def _checked(block: Block, path: Path) -> None:
    answer = workbench("check", path)
    if answer.code:
        raise BlockError(block, answer.err)


def _quick(block: Block) -> str:
    if block.language == "python":
        return _executed(block, {"__name__": "__main__"})
    answers = [workbench(*words) for words in workbench_lines(block)]
    for answer in answers:
        if answer.code:
            raise BlockError(block, answer.err)
    return "\n".join(answer.out for answer in answers)


def _executed(block: Block, names: dict[str, object]) -> str:
    out = io.StringIO()
    with contextlib.redirect_stdout(out):
        exec(compile(block.text, block.place, "exec"), names)
    return out.getvalue()


def _python(block: Block, folder: Path, names: dict[str, object]) -> str:
    with contextlib.chdir(folder):
        try:
            return _executed(block, names)
        except Exception as error:
            raise BlockError(block, f"{type(error).__name__}: {error}") from error


def _in_shell(block: Block, folder: Path) -> str:
    """What a block prints where `workbench`, `python` and `.venv/bin` are those of this environment."""
    programs = Path(sys.executable).parent
    link = folder / ".venv"
    if not link.exists():
        link.symlink_to(programs.parent)
    environment = {**os.environ, "PATH": f"{programs}{os.pathsep}{os.environ['PATH']}"}
    ran = subprocess.run(
        ["bash", "-e", "-c", block.text], cwd=folder, env=environment, capture_output=True, text=True, check=False
    )
    if ran.returncode:
        raise BlockError(block, f"exit code {ran.returncode}\n{ran.stdout[-1000:]}{ran.stderr[-2000:]}")
    return ran.stdout


def _as_printed(block: Block, printed: str) -> None:
    if missing := missing_lines(block.text, printed):
        raise BlockError(block, "not printed:\n" + "\n".join(missing))
