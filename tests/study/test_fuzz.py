"""A few of the mutants of `make fuzz`: none brings about a traceback, a long answer, or a file outside the folder."""

from pathlib import Path

import pytest
from fuzz.sandbox import Sandbox
from fuzz.trials import random_of, trial
from fuzz.watch import warmed, watched

COUNTS = {"check": 60, "run": 6, "records": 40}


@pytest.mark.parametrize("kind", COUNTS)
def test_mutants(tmp_path: Path, kind: str) -> None:
    sandbox, done = warmed(Sandbox(tmp_path), kind), set[str]()
    for number in range(COUNTS[kind]):
        tried = trial(sandbox, kind, 1, number)
        assert not tried.findings, f"python -m fuzz {kind} --seed 1 --only {number}"
        done.add(tried.done)
    assert done == {"run"} if kind == "run" else done == {"refused", "in order"}


def test_a_mutant_is_told_by_its_seed_and_number(tmp_path: Path) -> None:
    assert random_of("check", 1, 7).random() == random_of("check", 1, 7).random() != random_of("check", 2, 7).random()


def test_what_is_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The watch sees a traceback, a file outside, a long answer, what steers a terminal, and a warning."""
    sandbox = Sandbox(tmp_path)
    path = sandbox.put("mutant.toml", b"title = 1")

    def found(does: str) -> list[str]:
        monkeypatch.setattr("workbench.cli.check.command", lambda file: exec(does))
        return [finding.kind for finding in watched(sandbox, "check", path)[1]]

    assert found("raise TypeError('x')") == ["traceback"]
    assert found("file.with_name('evil').touch()") == ["outside"]
    assert not path.with_name("evil").exists()
    assert found("import sys; print('error: a\\nb\\nc\\nd', file=sys.stderr); sys.exit(2)") == ["long"]
    assert found("import sys; print('error: a ' + 'b ' * 300, file=sys.stderr); sys.exit(2)") == ["long"]
    assert found("print('\\x1b[2J')") == ["control"]
    assert found("import warnings; warnings.warn('x')") == ["warning"]
    assert found("import sys; sys.exit(2)") == ["silent"]
    assert found("print('in order')") == []
