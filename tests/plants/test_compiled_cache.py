"""Compiled code that is kept on disk: closures of one name, made by processes of their own, stay themselves."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command import ROOT

MODULE = """\
from numba import types
from plants.compiled import compiled
from plants.equation import equation

@equation
def double(x):
    return 2.0 * x

@equation
def triple(x):
    return 3.0 * x

def made(law):
    @compiled(types.float64(types.float64))
    def entry(x):
        return law(x)
    return entry
"""

PROGRAM = """\
import sys
import closures
for one in [closures.made(getattr(closures, name)) for name in sys.argv[1:]]:
    print(one.native_name, one.ctypes(1.0), one.cache_hits)
"""


@pytest.mark.parametrize("order", [("double", "triple"), ("triple", "double")])
def test_closures_that_two_processes_kept_are_told_apart_by_a_third(tmp_path: Path, order: tuple[str, str]) -> None:
    """Their symbols differ: of two alike, the linker may take either, as it did where a closure is long."""
    (tmp_path / "closures.py").write_text(MODULE, encoding="utf-8")
    paths = os.pathsep.join((str(ROOT), str(tmp_path)))
    environment = {**os.environ, "NUMBA_CACHE_DIR": str(tmp_path / "cache"), "PYTHONPATH": paths}

    def ran(*names: str) -> list[list[str]]:
        command = [sys.executable, "-c", PROGRAM, *names]
        done = subprocess.run(command, capture_output=True, text=True, check=True, env=environment)
        return [line.split() for line in done.stdout.splitlines()]

    alone = {name: ran(name)[0] for name in ("double", "triple")}
    assert [line[1:] for line in alone.values()] == [["2.0", "0"], ["3.0", "0"]]
    assert alone["double"][0] != alone["triple"][0]
    assert [line[1:] for line in ran(*order)] == [[alone[name][1], "1"] for name in order]
