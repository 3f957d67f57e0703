"""The example of docs/plugin_example: a controller that its entry point alone brings in."""

import os
import subprocess
import sys
from collections.abc import Iterator, Sequence
from concurrent.futures import ProcessPoolExecutor
from importlib.util import find_spec
from multiprocessing import get_context
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest
from command import DRIVE, PROCESS, Answer, changed, fails, workbench, write
from plugin_site import EXAMPLE, brings, site, visible

from controllers.interface import Reference
from controllers.pid import PID
from controllers.registry import CONTROLLERS, controllers
from plants.interface import Measurement
from workbench.errors import UserError

STUDY = EXAMPLE / "study.toml"


def in_a_process(folder: Path, *arguments: str | Path) -> subprocess.CompletedProcess[str]:
    """The command in a process of its own, as a user runs it, with the packages of `folder`."""
    packages = [str(folder), os.environ.get("PYTHONPATH", "")]
    environment = {**os.environ, "PYTHONPATH": os.pathsep.join(filter(None, packages))}
    command = [*PROCESS, *map(str, arguments)]
    return subprocess.run(command, capture_output=True, text=True, check=False, env=environment)


def in_a_fork(folder: Path, *arguments: str | Path) -> Answer:
    """The command in a process that begins as this one, where nothing of the packages of `folder` is imported yet."""
    with ProcessPoolExecutor(1, get_context("fork")) as executor:
        return executor.submit(_with_packages, folder, arguments).result()


def _with_packages(folder: Path, arguments: Sequence[str | Path]) -> Answer:
    sys.path.insert(0, str(folder))
    return workbench(*arguments)


@pytest.fixture
def installed(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    """The example, installed."""
    visible(site(tmp_path), monkeypatch)
    yield
    sys.modules.pop("deadband_p", None)


def test_the_module_alone_is_not_found(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Nothing but an entry point names one: Python could import this one, and a study still cannot name it."""
    write(tmp_path, (EXAMPLE / "deadband_p.py").read_text(encoding="utf-8"), "left_out.py")
    visible(tmp_path, monkeypatch)
    assert find_spec("left_out") is not None
    study = write(tmp_path, changed('"deadband_p"', '"left_out"', STUDY.read_text(encoding="utf-8")))
    fails(workbench("check", study), 'controllers.mine.type: unknown controller "left_out"; expected one of pid, ')


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
    fails(workbench("check", write(tmp_path, changed(old, new, STUDY.read_text(encoding="utf-8")))), said)


def test_the_study_ends_at_the_deadband(tmp_path: Path) -> None:
    """The cylinder integrates: without overshoot it stops where the command becomes 0, at |e| = D."""
    out = tmp_path / "out"
    done = in_a_process(site(tmp_path), "run", STUDY, "--out", out)
    assert done.returncode == 0, done.stderr
    results = pd.read_parquet(out / "results.parquet")
    assert list(results["outcome"]) == ["completed"] * 3
    np.testing.assert_allclose(results["steady_state_error_m"], [0.0, 0.5e-3, 1.0e-3], rtol=0.0, atol=1e-8)


def test_an_edited_plugin_cannot_be_resumed(tmp_path: Path) -> None:
    """Its file lies outside the program's; a study that does not name it is resumed all the same."""
    module, out, plain = site(tmp_path) / "deadband_p.py", tmp_path / "out", tmp_path / "plain"
    text = STUDY.read_text(encoding="utf-8")
    short = write(tmp_path, changed('duration = "2 s"', 'duration = "0.01 s"', text))
    ours = write(tmp_path, DRIVE, "drive.toml")
    assert in_a_fork(tmp_path, "run", short, "--out", out).code == 0
    assert workbench("run", ours, "--out", plain).code == 0
    assert in_a_fork(tmp_path, "run", short, "--out", out, "--resume").code == 0
    law = module.read_text(encoding="utf-8")
    module.write_text(changed("np.abs(error) - gains.deadband", "np.abs(error) - 2 * gains.deadband", law))
    refused = in_a_fork(tmp_path, "run", short, "--out", out, "--resume")
    assert (refused.code, refused.err) == (
        2,
        f"error: {out}: its results are of another version of the plug-ins; start anew with --overwrite, or choose "
        "another --out\n",
    )
    assert workbench("run", ours, "--out", plain, "--resume").code == 0


def test_the_whole_package_of_a_plugin_counts(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A law may stand in another file than the one that the entry point names."""
    package = tmp_path / "whole_package"
    package.mkdir()
    for name in ("__init__", "mine", "law"):
        write(package, "", f"{name}.py")
    write(package, "from whole_package import law\nfrom controllers.pid import PID as MINE\n", "mine.py")
    brings(tmp_path, "friction_workbench.controllers", "mine = whole_package.mine:MINE")
    visible(tmp_path, monkeypatch)
    before = CONTROLLERS.source("mine")
    assert before == CONTROLLERS.source("mine") != ""
    write(package, "changed = 1\n", "law.py")
    assert CONTROLLERS.source("mine") != before
    assert CONTROLLERS.source("pid") == CONTROLLERS.source("none") == ""


def test_compiled_code_follows_every_file_of_a_plugin(tmp_path: Path) -> None:
    """Half the gain, in a file that the entry point does not name, leaves a larger error. Nobody edits a file twice in
    a second, in which Python would not see it where the size stays.
    """
    package = tmp_path / "apart"
    package.mkdir()
    write(package, "", "__init__.py")
    law = "from plants.equation import equation\n@equation\ndef gain(kp):\n    return 1.0 * kp\n"
    module = changed("command = gains.kp *", "command = gain(gains.kp) *", (EXAMPLE / "deadband_p.py").read_text())
    write(package, "from apart.law import gain\n" + module, "deadband.py")
    brings(tmp_path, "friction_workbench.controllers", "apart = apart.deadband:DEADBAND_P")
    text = changed('"deadband_p"', '"apart"', STUDY.read_text(encoding="utf-8")).replace('"2 s"', '"0.02 s"')
    errors = []
    for number, code in enumerate((law, changed("1.0", "0.5", law))):
        os.utime(write(package, code, "law.py"), (number, number))
        out = tmp_path / str(number)
        assert in_a_fork(tmp_path, "run", write(tmp_path, text), "--out", out).code == 0
        errors.append(pd.read_parquet(out / "results.parquet")["rms_error_m"][0])
    assert errors[1] > errors[0]


TYPO = """\
from dataclasses import replace
from controllers.pid import PID
import numpy as np
from plants.equation import equation
@equation
def step(reference, measurement, state, gains, sample_time):
    return {wrong}, state
IT = replace(PID, name="mine", step=step)
"""


@pytest.mark.parametrize(
    ("wrong", "reason"),
    [
        ("np.tnh(reference.position)", "module 'numpy' has no attribute 'tnh'"),
        ("tanh(reference.position)", "name 'tanh' is not defined"),
        ("reference.positon", "'Reference' object has no attribute 'positon'"),
        (
            "1.0 if reference.position > 0.0 else 0.0",
            'branches on a value; in place of a condition ("if", "and", "max") use select(condition, a, b)',
        ),
    ],
)
def test_a_step_that_cannot_be_compiled_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, wrong: str, reason: str
) -> None:
    brings(tmp_path, "friction_workbench.controllers", "mine = typo:IT")
    visible(tmp_path, monkeypatch)
    monkeypatch.delitem(sys.modules, "typo", raising=False)
    write(tmp_path, TYPO.format(wrong=wrong), "typo.py")
    study = write(tmp_path, changed('"pid"', '"mine"', DRIVE))
    done = workbench("run", study, "--out", tmp_path / "out")
    assert (done.code, done.err) == (
        2,
        f'error: controller "mine" cannot be compiled: "step" (typo.py, line 7) {reason} (--debug shows all of it)\n',
    )
    with pytest.raises(UserError) as raised:  # for the interpreter to show, with the cause
        workbench("--debug", "run", study, "--out", tmp_path / "again")
    assert raised.value.__cause__ is not None


UNDECLARED = """\
from dataclasses import replace
from typing import NamedTuple
from controllers.pid import PID
from plants.registry import DRIVE_FORCE
class Bare(NamedTuple):
    kp: float
IT = replace(DRIVE_FORCE, Parameters=Bare) if {is_plant} else replace(PID, Settings=Bare)
"""


@pytest.mark.parametrize("kind", ["controllers", "plants"])
@pytest.mark.parametrize(
    ("code", "wrong"),
    [
        ("import no_such_module", "(ModuleNotFoundError: No module named 'no_such_module')"),
        ("raise ValueError('first\\nsecond')", "(ValueError: first second)"),
        ("", "(AttributeError: module 'broken_{kind}' has no attribute 'IT')"),
        (UNDECLARED, "(TypeError: {undeclared})"),
        ("IT = 3", "(TypeError: got int, expected {type})"),
    ],
    ids=["import", "raises", "no object", "no units", "wrong object"],
)
def test_a_broken_plugin_is_told_where_it_is_named(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, code: str, wrong: str
) -> None:
    """In one line, with the package; the list shows it, and what does not name it runs."""
    module = f"broken_{kind}"
    brings(tmp_path, f"friction_workbench.{kind}", f"mine = {module}:IT")
    visible(tmp_path, monkeypatch)
    monkeypatch.delitem(sys.modules, module, raising=False)
    names = {
        "controllers": ("Controller", "Settings.kp: expected Annotated[float, unit] or Annotated[str, choice, ...]"),
        "plants": ("Plant", "Bare: expected a NamedTuple of Annotated[float, unit]"),
    }
    wrong = wrong.format(kind=kind, type=names[kind][0], undeclared=names[kind][1])
    write(tmp_path, code.replace("{is_plant}", str(kind == "plants")), f"{module}.py")
    said = f'{module}:IT of the package "other" cannot be used {wrong}; mend or uninstall the package\n'
    assert workbench("check", write(tmp_path, DRIVE)).code == 0
    listed = workbench("list", kind)
    assert (listed.code, listed.err) == (0, "")
    assert f"  {'mine':22} {said}" in listed.out
    key, old = ("controllers.p.type", '"pid"') if kind == "controllers" else ("plant.model", '"drive"')
    refused = workbench("check", write(tmp_path, changed(old, '"mine"', DRIVE)))
    assert (refused.code, refused.out) == (2, "")
    assert refused.err.partition(".toml:")[2].partition(": ")[2] == f"{key}: {said}"


def test_an_entry_point_that_is_none_is_told_where_it_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    brings(tmp_path, "friction_workbench.controllers", 'mine = "module:IT"')
    visible(tmp_path, monkeypatch)
    assert workbench("check", write(tmp_path, DRIVE)).code == 0
    refused = workbench("check", write(tmp_path, changed('"pid"', '"mine"', DRIVE)))
    assert (refused.code, refused.out) == (2, "")
    assert "cannot be used (ValueError: an entry point is written MODULE:OBJECT)" in refused.err


FRICTIONLESS = """\
from dataclasses import replace
from typing import Annotated, NamedTuple
import numpy as np
from plants.registry import DRIVE_FORCE
from plants.hydraulics import Mass
from plants.sources import ForceLimits
class Parameters(NamedTuple):
    body: Mass
    source: ForceLimits
    stroke: Annotated[float, "m"] = np.inf
IT = replace(DRIVE_FORCE, name="slider", Parameters=Parameters)
"""


@pytest.mark.parametrize(
    "name", ["lugre", "lugre_adaptive", "tafazoli", "friedland_park", "static_map", "uncompensated"]
)
def test_a_compensator_says_what_the_plant_of_a_plugin_lacks(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str
) -> None:
    """In one line: a mass without friction has nothing to believe in."""
    module = f"frictionless_{name}"
    brings(tmp_path, "friction_workbench.plants", f"slider = {module}:IT")
    visible(tmp_path, monkeypatch)
    monkeypatch.delitem(sys.modules, module, raising=False)
    write(tmp_path, FRICTIONLESS, f"{module}.py")
    study = changed('"drive"', '"slider"', changed('type = "pid"\nkp = "3 N/m"', f'type = "{name}"', DRIVE))
    said = (
        f'controllers.p: type "{name}" needs "friction" among the parameters of its plant, and slider has body, '
        "source, stroke"
    )
    fails(workbench("check", write(tmp_path, study)), said)
    fails(workbench("run", write(tmp_path, study), "--out", tmp_path / "out"), said)


SLIP = """\
from dataclasses import replace
from controllers.pid import PID
def design(settings, belief, sample_time):
    return settings.gain
IT = replace(PID, name="mine", design=design)
"""


def test_a_slip_in_the_code_of_a_plugin_is_one_line_and_not_blamed_on_the_study(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    brings(tmp_path, "friction_workbench.controllers", "mine = slip:IT")
    visible(tmp_path, monkeypatch)
    monkeypatch.delitem(sys.modules, "slip", raising=False)
    write(tmp_path, SLIP, "slip.py")
    study = write(tmp_path, changed('"pid"', '"mine"', DRIVE))
    said = (
        "package \"other\": AttributeError: 'Settings' object has no attribute 'gain', in \"design\" (slip.py, line 4)"
    )
    done = workbench("check", study)
    assert (done.code, done.err) == (2, f"error: {said} (--debug shows all of it)\n")
    with pytest.raises(AttributeError, match="gain"):
        workbench("--debug", "check", study)


def test_a_list_shows_the_name_that_studies_use(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The entry point's, whatever the object calls itself; and none of ours can be taken."""
    write(tmp_path, "from controllers.dither import DITHER\n", "renamed.py")
    brings(tmp_path, "friction_workbench.controllers", "shaken = renamed:DITHER\npid = renamed:DITHER")
    visible(tmp_path, monkeypatch)
    names = [line.split()[0] for line in workbench("list", "controllers").out.splitlines() if line[2:3] != " "]
    assert names.count("shaken") == names.count("dither") == names.count("pid") == 1
    assert controllers()["shaken"].name == "dither"
    assert controllers()["pid"] is PID


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
