"""Results of the repository's own studies, run by the command, once for all tests and test processes."""

import fcntl
import os
from pathlib import Path

import pytest
from command import STUDIES, workbench


def shared_folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder for the results of all studies, shared by parallel test processes."""
    base = tmp_path_factory.getbasetemp()
    folder = (base.parent if "PYTEST_XDIST_WORKER" in os.environ else base) / "published"
    folder.mkdir(exist_ok=True)
    return folder


def outcome(results: Path, name: str) -> Path:
    """The results of a study, which the first that asks for them runs; what the command said is in `said`."""
    folder = results / name
    with (results / f"{name}.lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        done = _printed(folder)
        if not done.exists():
            answer = workbench("run", STUDIES / f"{name}.toml", "--out", folder)
            assert (answer.code, answer.err) == (0, "")
            done.write_text(answer.out, encoding="utf-8")
    return folder


def said(folder: Path) -> str:
    """What the command printed that made these results."""
    return _printed(folder).read_text(encoding="utf-8")


def _printed(folder: Path) -> Path:
    return folder.with_name(f"{folder.name}.txt")
