"""What commands do without: libraries that take longer to import than the command has to do."""

import os
import subprocess
import sys
from pathlib import Path

import pytest
from command import ROOT

SLOW = (
    "numba",
    "llvmlite",
    "scipy",
    "pandas",
    "pyarrow",
    "matplotlib",
    "pint",
    "casadi",
    "control",
    "optuna",
    "cobyqa",
    "filterpy",
    "jinja2",
    "distributed",
    "bokeh",
)
"""Each takes a tenth of a second at least, numba half a second, scipy's statistics one."""

RUNS = ("numba", "llvmlite", "pandas", "pyarrow", "matplotlib", "pint", "jinja2")
"""What a run with a table and a figure takes."""

SCRIPT = """\
import sys
from workbench.cli import main
sys.argv = ["workbench", *sys.argv[1:]]
try:
    main()
finally:
    print(*sys.modules, file=sys.stderr)
"""


def imported(*arguments: str, cache: Path | None = None) -> tuple[str, set[str]]:
    """What the command prints, in a process of its own, and the modules that it has imported by its end.

    With a `cache` of its own the units that it has met before are not known.
    """
    environment = os.environ if cache is None else {**os.environ, "XDG_CACHE_HOME": str(cache)}
    done = subprocess.run(
        [sys.executable, "-c", SCRIPT, *arguments],
        capture_output=True,
        text=True,
        check=True,
        cwd=ROOT,
        env=environment,
    )
    return done.stdout, set(done.stderr.split())


def test_help_imports_neither_a_slow_library_nor_the_program(tmp_path: Path) -> None:
    shown, modules = imported("--help", cache=tmp_path)
    assert modules.isdisjoint({*SLOW, "numpy", "pydantic", "plants", "controllers", "workbench.study"})
    assert "typer" in modules
    for command in ("run", "check", "list", "table", "plot"):
        assert f"  {command} " in shown
    assert "..." not in shown.partition("Commands:")[2], "what each command does fits on its line"


@pytest.mark.parametrize("arguments", [("list",), ("list", "plants")])
def test_a_list_imports_no_slow_library(arguments: tuple[str, ...], tmp_path: Path) -> None:
    shown, modules = imported(*arguments, cache=tmp_path)
    assert shown.startswith("plants\n")
    assert modules.isdisjoint(SLOW)
    assert modules.isdisjoint({"workbench.study.schema", "workbench.study.resolve"}), "it reads no study"


@pytest.mark.parametrize("file", ["studies/thesis_chapter3.toml", "plants/parameters/owen2001_simulation.toml"])
def test_a_check_imports_no_slow_library_once_its_units_are_known(file: str, tmp_path: Path) -> None:
    first, modules = imported("check", file, cache=tmp_path)
    assert modules.isdisjoint(set(SLOW) - {"pint", "scipy"}), "pint looks for what else it could convert"
    again, modules = imported("check", file, cache=tmp_path)
    assert modules.isdisjoint(SLOW)
    assert again == first


SMALL = """\
title = "One case"
plant = { model = "non_rotating", parameters = "owen2001_simulation" }
controllers = { p = { type = "pid", kp = "500 V/m" } }
references = { sine = { kind = "sine", amplitude = "25 mm", frequency = "0.9 Hz" } }
simulation = { duration = "2 s" }

[[tables]]
name = "errors"
title = "Errors"
rows = [{ result = "rms_error_m", label = "rms error", unit = "mm" }]

[[figures]]
name = "position"
title = "Position"

[[figures.panels]]
x_label = "time"
x_unit = "s"
y_label = "position"
y_unit = "mm"
curves = [{ y = "position", label = "run" }]
"""


def test_a_run_imports_what_runs_draws_and_writes_alone(tmp_path: Path) -> None:
    study, out = tmp_path / "small.toml", tmp_path / "out"
    study.write_text(SMALL, encoding="utf-8")
    _, modules = imported("run", str(study), "--out", str(out), "--jobs", "1")
    assert (out / "figures" / "position.pdf").stat().st_size > 0
    assert {"numba", "pandas", "matplotlib"} <= modules
    others = {*SLOW, "scipy.stats", "scipy.signal", "scipy.ndimage"} - {*RUNS, "scipy"}  # scipy.linalg is numba's
    assert modules.isdisjoint(others), "no linearisation, no statistics, no optimiser"
    again, modules = imported("run", str(study), "--out", str(out), "--jobs", "1", "--resume")
    assert "rms error" in again
    assert modules.isdisjoint(SLOW), "all stands: nothing is run or drawn"


def test_a_diagnosis_imports_neither_symbols_nor_linear_analysis() -> None:
    script = "import sys, workbench.diagnose.diagnose, workbench.diagnose.report.folder; print(*sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, cwd=ROOT)
    assert {"casadi", "control", "matplotlib.pyplot", "optuna", "cobyqa"}.isdisjoint(done.stdout.split())


def test_a_spoilt_file_of_kept_factors_is_made_anew(tmp_path: Path) -> None:
    file = "plants/parameters/owen2001_simulation.toml"
    first, _ = imported("check", file, cache=tmp_path)
    (kept,) = (tmp_path / "friction-workbench").glob("pint_*_si_factor.json")
    whole = kept.read_text(encoding="utf-8")
    for spoilt in (whole[: len(whole) // 2], "[]"):
        kept.write_text(spoilt, encoding="utf-8")
        assert imported("check", file, cache=tmp_path)[0] == first
        assert kept.read_text(encoding="utf-8") == whole


@pytest.mark.parametrize(("said", "taken"), [(None, "1"), ("3", "3")])
def test_whoever_imports_the_program_has_linear_algebra_in_one_thread(said: str | None, taken: str) -> None:
    environment = {name: value for name, value in os.environ.items() if name != "OPENBLAS_NUM_THREADS"}
    if said is not None:
        environment["OPENBLAS_NUM_THREADS"] = said
    script = "import os, sys, workbench; print(os.environ['OPENBLAS_NUM_THREADS'], 'numpy' in sys.modules)"
    done = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True, env=environment)
    assert done.stdout == f"{taken} False\n"
