"""The example of docs/plugin_example: a controller that its entry point alone brings in."""

import os
import shutil
import subprocess
import sys
import tomllib
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from command import PROCESS, ROOT, changed, workbench, write

from controllers.interface import Reference
from controllers.registry import controllers
from plants.interface import Measurement

EXAMPLE = ROOT / "docs" / "plugin_example"
STUDY = EXAMPLE / "study.toml"


def site(folder: Path, *, declared: bool) -> Path:
    """A folder of packages that holds the example as an installer leaves it, or its module alone."""
    description = tomllib.loads((EXAMPLE / "pyproject.toml").read_text(encoding="utf-8"))
    project = description["project"]
    for module in description["tool"]["setuptools"]["py-modules"]:
        shutil.copy(EXAMPLE / f"{module}.py", folder)
    if declared:
        information = folder / f"{project['name'].replace('-', '_')}-{project['version']}.dist-info"
        information.mkdir()
        metadata = f"Metadata-Version: 2.1\nName: {project['name']}\nVersion: {project['version']}\n"
        (information / "METADATA").write_text(metadata, encoding="utf-8")
        groups = project["entry-points"]
        lines = [f"[{group}]\n" + "".join(f"{k} = {v}\n" for k, v in groups[group].items()) for group in groups]
        (information / "entry_points.txt").write_text("\n".join(lines), encoding="utf-8")
    return folder


def visible(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Python finds packages in the folder too, until the test ends."""
    monkeypatch.setattr(sys, "path", [str(folder), *sys.path])
    monkeypatch.delitem(sys.modules, "deadband_p", raising=False)


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The example, installed."""
    visible(site(tmp_path, declared=True), monkeypatch)
    yield
    sys.modules.pop("deadband_p", None)


@pytest.mark.skipif("deadband_p" in controllers(), reason="the example is installed here")
def test_the_module_alone_is_not_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing but the entry point names it: Python could import it, and a study still cannot name it."""
    visible(site(tmp_path, declared=False), monkeypatch)
    assert find_spec("deadband_p") is not None
    answer = workbench("check", STUDY)
    assert (answer.code, answer.out) == (2, "")
    assert 'controllers.mine.type: unknown controller "deadband_p"; expected one of pid, ' in answer.err
    assert answer.err.count("\n") == 1


@pytest.mark.usefixtures("installed")
def test_the_entry_point_brings_it_in() -> None:
    listed = workbench("list", "controllers")
    assert (listed.code, listed.err) == (0, "")
    lines = [" ".join(line.split()) for line in listed.out.splitlines()]
    at = lines.index("deadband_p P with a deadband of the error")
    assert lines[at + 1 : at + 3] == ["kp command/m needed", "deadband m default 0.0"]
    checked = workbench("check", STUDY)
    assert (checked.code, checked.err) == (0, "")
    assert checked.out.endswith("  3 cases, 6 s of simulated time\n")


@pytest.mark.usefixtures("installed")
@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        (
            '"deadband_p"',
            '"deadband"',
            'controllers.mine.type: unknown controller "deadband"; did you mean "deadband_p"?',
        ),
        ('"0.5 mm"', '"-0.5 mm"', "controllers.mine: deadband is -0.0005 m, expected 0 or more"),
        ('"0.5 mm"', '"0.5 mV"', 'controllers.mine.deadband: got "0.5 mV", expected a quantity in m, such as "1 m"'),
    ],
)
def test_its_settings_are_checked_like_ours(tmp_path: Path, old: str, new: str, said: str) -> None:
    answer = workbench("check", write(tmp_path, changed(old, new, STUDY.read_text(encoding="utf-8"))))
    assert (answer.code, answer.out) == (2, "")
    assert said in answer.err
    assert answer.err.count("\n") == 1


def test_the_study_ends_at_the_deadband(tmp_path: Path) -> None:
    """The cylinder integrates: without overshoot it stops where the command becomes 0, at |e| = D.

    In a process of its own, as a user runs it.
    """
    packages = [str(site(tmp_path, declared=True)), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, packages))}
    out = tmp_path / "out"
    arguments = [*PROCESS, "run", str(STUDY), "--out", str(out)]
    done = subprocess.run(arguments, capture_output=True, text=True, check=False, env=environment)
    assert (done.returncode, done.stderr) == (0, "")
    results = pd.read_parquet(out / "results.parquet")
    assert list(results["outcome"]) == ["completed"] * 3
    np.testing.assert_allclose(results["steady_state_error_m"], [0.0, 0.5e-3, 1.0e-3], rtol=0.0, atol=1e-8)


@pytest.mark.usefixtures("installed")
def test_its_law() -> None:
    """u = K_p (|e| - D) sgn(e) outside the band and 0 in it, by hand; for floats and arrays alike."""
    law = controllers()["deadband_p"]
    gains = law.design(law.Settings(200.0, 1e-3), None, 1e-3)

    def command(error: Any) -> Any:
        measurement = Measurement(0.0, np.nan, np.nan, np.nan)
        return law.step(Reference(error, 0.0, 0.0), measurement, law.start(measurement, gains), gains, 1e-3)[0]

    errors, expected = [3e-3, 1e-3, 0.5e-3, 0.0, -0.9e-3, -6e-3], [0.4, 0.0, 0.0, 0.0, 0.0, -1.0]
    np.testing.assert_allclose(command(np.array(errors)), expected, atol=1e-15)
    np.testing.assert_allclose([float(command(error)) for error in errors], expected, atol=1e-15)
