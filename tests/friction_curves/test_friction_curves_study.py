"""Measured friction-velocity curves in a study: what it writes, and what is said of a mistake in what it asks."""

from pathlib import Path

import pandas as pd
import pytest
from command import STUDIES, STUDY, changed, fails, ran, workbench, write

pytestmark = pytest.mark.usefixtures("png_alone")

MEASURED = STUDIES / "measured" / "owen2001_friction.toml"

ASKED = """
[friction_curves]
measured = "curves.toml"
parameters = "owen2001_experiment"
fit_rpm = [25, 75, 125]
check_rpm = [50, 100]
speed = "8 mm/s"
"""

PANEL = """
[[figures]]
name = "f"
title = "f"
[[figures.panels]]
x = "velocity"
x_label = "v"
x_unit = "mm/s"
y_label = "F"
y_unit = "N"
measured_rpm = 10
curves = [{ y = "axial_friction", where = { rpm = 0 }, label = "simulated" }]
"""

SPEC = ASKED + "reference_slope = { 75 = [12550, 11600] }\n" + PANEL


def test_measured_friction_in_a_panel_needs_a_file_of_it(tmp_path: Path) -> None:
    answer = workbench("check", write(tmp_path, STUDY + PANEL))
    assert answer.code == 2
    assert "measured_rpm: there is no [friction_curves]" in answer.err


def test_a_study_writes_its_comparison_with_measured_curves(tmp_path: Path) -> None:
    """Tables, figures, the validation of a drawn run, and all of it again from the folder of results alone."""
    study = changed('"owen2001_simulation"', '"owen2001_experiment"\nbristle = "anisotropic"')
    asked = changed("curves.toml", str(MEASURED), ASKED)
    out = ran(tmp_path, study + asked + changed("measured_rpm = 10", "measured_rpm = 0", PANEL))
    validation = pd.read_csv(out / "tables" / "validation.csv")
    assert set(validation["direction"]) == {"forward", "backward"}
    assert (validation["error (N)"] > 0.0).all()
    for name in ("curves_forward", "curves_backward", "figure_5_10", "figure_5_21"):
        assert (out / "figures" / f"{name}.png").stat().st_size > 10_000
    before = (out / "tables" / "friction_curve_error.md").read_bytes()
    (out / "tables" / "friction_curve_error.md").unlink()
    assert workbench("table", out).code == 0
    assert (out / "tables" / "friction_curve_error.md").read_bytes() == before


RPM = "rpm in curves.toml; there are"
WRONG_ASKED = {
    "no such file": ("curves.toml", "curve.toml", 'measured: got "curve.toml", no such file beside the study'),
    "no such set": ("owen2001_experiment", "owen2001_exp", 'parameters: unknown parameter set "owen2001_exp"; did you'),
    "fit": ("[25, 75, 125]", "[30]", f"fit_rpm: no 30 {RPM} 10, 25, 50, 75, 100, 125"),
    "check": ("[50, 100]", "[0]", f"check_rpm: no 0 {RPM} 10, 25"),
    "twice": ("[50, 100]", "[50, 50]", "check_rpm: holds 50 rpm twice: expected each once"),
    "in both": ("[50, 100]", "[50, 75]", "check_rpm: 75 rpm is in fit_rpm too: expected speeds that the fit does not"),
    "slope": ("{ 75 =", "{ 30 =", f"reference_slope: no 30 {RPM} 10, 25"),
    "slope of a word": ("{ 75 =", "{ fast =", 'reference_slope: got "fast", expected a speed of rotation in rpm'),
    "speed": ("8 mm/s", "8 m/s", "speed: got 8 m/s, expected one that was measured: 0.0006 to 0.0114 m/s"),
    "panel": ("measured_rpm = 10", "measured_rpm = 30", f"measured_rpm: no 30 {RPM} 0, 10, 25, 50, 75, 100, 125"),
}
WRONG_MEASURED = {
    "key": ("coulomb = [50", "coulom = [50", 'forward.coulom: unknown key; did you mean "coulomb"?'),
    "length": ("viscous = [37200, ", "viscous = [", "forward.viscous: holds 5 values, expected one for each of the 6"),
    "mm/s": ("[0.0017,", "[1.7,", "got 1.7 at 10 rpm, expected m/s, above 0 and at most 0.1 (1.7 mm/s is 0.0017)"),
    "no Stribeck velocity": ("[0.0017,", "[0,", "got 0 at 10 rpm, expected m/s, above 0 and at most 0.1"),
    "negative": ("[37200,", "[-37200,", "forward.viscous: got -37200 at 10 rpm, expected a value that is not negative"),
    "static": ("[90,", "[40,", "forward.static: got 40 N at 10 rpm, below coulomb of 50 N: expected at least that"),
    "order": ("[10, 25, 50,", "[10, 50, 25,", "rpm: got 25 behind 50: expected each once, ascending"),
    "duplicate": ("[10, 25, 50,", "[10, 25, 25,", "rpm: got 25 behind 25: expected each once, ascending"),
    "without rotation": ("[10, 25, 50,", "[0, 25, 50,", "rpm: got 0, what is measured without rotation is in the"),
}


@pytest.mark.parametrize("mistake", [*WRONG_ASKED, *WRONG_MEASURED])
def test_a_mistake_is_told_before_anything_runs(mistake: str, tmp_path: Path) -> None:
    """By `check`, by `run --dry-run` and by `run` alike, in one line with the place."""
    spec, curves = SPEC, MEASURED.read_text(encoding="utf-8")
    if mistake in WRONG_ASKED:
        old, new, expected = WRONG_ASKED[mistake]
        assert old in spec
        spec = spec.replace(old, new)
    else:
        old, new, expected = WRONG_MEASURED[mistake]
        assert old in curves
        curves = curves.replace(old, new, 1)
    study, out = write(tmp_path, STUDY + spec), tmp_path / "out"
    write(tmp_path, curves, "curves.toml")
    for command in (("check", study), ("run", study, "--out", out, "--dry-run"), ("run", study, "--out", out)):
        fails(workbench(*command), expected, ".toml:")
    assert not out.exists()


def test_what_is_asked_rightly_passes(tmp_path: Path) -> None:
    (tmp_path / "curves.toml").write_bytes(MEASURED.read_bytes())
    assert workbench("check", write(tmp_path, STUDY + SPEC)).code == 0
