"""Measured friction-velocity curves against the bristle laws: what is predicted, what is found to be missing."""

import functools
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import STUDIES

from plants.anisotropic import Guide
from workbench.errors import UserError
from workbench.friction_curves.comparison import Comparison, compare
from workbench.friction_curves.figures import curves_data, draw_curves, draw_reductions, static_data
from workbench.friction_curves.folder import TABLES
from workbench.friction_curves.measured import Curve, read_curves, without_rotation
from workbench.friction_curves.power import power_table
from workbench.friction_curves.predicted import (
    CANDIDATES,
    FILM,
    GUIDE,
    Prediction,
    affordable,
    fit,
    laws,
    rms,
    supported,
)
from workbench.friction_curves.schema import FrictionCurvesTable
from workbench.friction_curves.tables import effect_table, error_table, slope_table, verdict
from workbench.parameters.sets import named_sets, read_parameters
from workbench.study.reading import read_study
from workbench.study.report.break_even import BreakEvenTable
from workbench.study.report.break_even_table import break_even_table

MEASURED = STUDIES / "measured" / "owen2001_friction.toml"
VALUES = read_parameters(named_sets()["owen2001_experiment"])
HELICAL, ISOTROPIC, ANISOTROPIC = laws(VALUES)
FIT_RPM, CHECK_RPM = (25.0, 75.0, 125.0), (50.0, 100.0)


def at(rpm: tuple[float, ...]) -> list[Curve]:
    return [curve for curve in read_curves(MEASURED) if curve.rpm in rpm]


def as_measured(law: Prediction, rpm: tuple[float, ...], noise: float = 0.0) -> list[Curve]:
    """What a rig that follows the law would have given, each curve with a smooth error of its own (N)."""
    rng = np.random.default_rng(3)
    curves = [law.curve(speed, direction) for speed in rpm for direction in ("forward", "backward")]
    wave = [np.cos(k * np.pi * np.linspace(0.0, 1.0, curves[0].speed.size)) for k in range(4)]
    return [replace(c, friction=c.friction + noise * (rng.standard_normal(4) @ np.array(wave))) for c in curves]


def test_measured_curves_are_those_of_the_tables() -> None:
    """Table 5.4 at 25 rpm forward: 50 exp(-(v/0.003)^2) + 34800 v; at 0 rpm table 5.2."""
    (curve,) = (one for one in at((25.0,)) if one.direction == "forward")
    assert curve.at(3e-3) == pytest.approx(50.0 * np.exp(-1.0) + 34800.0 * 3e-3, rel=1e-3)
    forward, _ = without_rotation(VALUES)
    assert forward.static == 480.0
    assert forward.at(11.4e-3) == pytest.approx(330.0 + 22800.0 * 11.4e-3, rel=1e-3)


@pytest.mark.parametrize(
    ("rpm", "at_rest", "regression"), [(75.0, 12550.0, 11600.0), (100.0, 9510.0, 9075.0), (125.0, 7470.0, 7256.0)]
)
def test_added_slope(rpm: float, at_rest: float, regression: float) -> None:
    assert ANISOTROPIC.added_slope(rpm) == pytest.approx((at_rest, regression), rel=0.03)
    surface = rpm * 2.0 * np.pi / 60.0 * 31.75e-3
    level = 330.0 / surface  # one level: g / v_h, the Stribeck parts long gone
    assert HELICAL.added_slope(rpm)[0] == pytest.approx(level, rel=1e-3)
    assert ISOTROPIC.added_slope(rpm) == HELICAL.added_slope(rpm)


def test_film_and_guide_are_supported_by_the_measured_curves() -> None:
    """The error on speeds that the fit never saw is at most half of the best bare law's."""
    added, _ = supported(ANISOTROPIC, at(FIT_RPM))
    assert added.effect is not None
    assert added.effect.name == "film and guide"
    best = min(rms(law, at(CHECK_RPM)) for law in (HELICAL, ISOTROPIC, ANISOTROPIC))
    assert rms(added.prediction, at(CHECK_RPM)) < 0.5 * best
    for name, (value, std) in added.numbers.items():
        assert std < 0.15 * value, name


def test_what_is_there_is_found_and_nothing_else() -> None:
    p = ANISOTROPIC.parameters
    true = replace(ANISOTROPIC, parameters=p._replace(film=p.film._replace(film_share=0.7), guide=Guide(25.0)))
    found, _ = supported(ANISOTROPIC, as_measured(true, FIT_RPM, noise=1.0))
    assert found.effect is not None
    assert found.effect.name == "film and guide"
    for name, value in {"film_share": 0.7, "guide_coulomb": 25.0}.items():
        assert abs(found.numbers[name][0] - value) < 3.0 * found.numbers[name][1]
    silent, fitted = supported(ANISOTROPIC, as_measured(ANISOTROPIC, FIT_RPM, noise=1.0))
    assert silent.effect is None
    assert len(fitted) == len(CANDIDATES)


def test_a_number_that_nothing_depends_on_has_no_finite_deviation() -> None:
    """A resonance without any dip has a width that no curve tells."""
    flat = next(one for one in CANDIDATES if one.name == "film and resonance")
    _, width = fit(ANISOTROPIC, flat, at(FIT_RPM)).numbers["width"]
    assert np.isinf(width)


def test_the_study_simulates_the_numbers_that_it_fits() -> None:
    found = compared()
    numbers, declared = found.added.numbers, found.study.file.cases["corrected"]["plant"]["set"]
    assert declared["film_share"] == pytest.approx(numbers["film_share"][0], abs=5e-4)
    assert declared["guide_coulomb"] == f"{numbers['guide_coulomb'][0]:.1f} N"


def test_tables_say_what_was_found() -> None:
    comparison = compared()
    tables = {name: make(comparison).cells for name, make in TABLES.items()}
    errors = tables["friction_curve_error"].set_index("law")["check / best bare law"]
    assert float(errors["anisotropic, film and guide"]) <= 0.5
    static = tables["static_friction"].set_index("rpm")
    assert (static["anisotropic (%)"] == "100.0").all()
    assert all(float(fall) == pytest.approx(90.0, abs=3.0) for fall in static["measured (%)"].iloc[1:])
    remark = tables["friction_curve_effects"].set_index(["law", "parameter"])["remark"]
    assert remark["anisotropic, resonance", "dip"] == "not identified"
    assert remark["anisotropic, film", "film_share"] == ""


@functools.cache
def compared(*fit_rpm: float) -> Comparison:
    """The study of chapter 5, fitted to the curves at other speeds of rotation where any are given."""
    study = read_study(STUDIES / "thesis_chapter5.toml")
    spec = study.section(FrictionCurvesTable)
    assert spec is not None
    return compare(study, spec.model_copy(update={"fit_rpm": list(fit_rpm)} if fit_rpm else {}))


def test_one_speed_of_rotation_supports_no_more_than_it_tells() -> None:
    """Eight independent numbers: no effect of four is chosen, none that is not identified, and a doubt is told."""
    found = compared(25.0)
    numbers = found.added.numbers
    assert len(numbers) < 4
    assert all(std < abs(value) for value, std in numbers.values())
    (alone,) = (one for one in found.fitted if one.effect is not None and one.effect.name == "resonance")
    assert all(np.isinf(std) for _, std in alone.numbers.values()), "dip and width stand in for each other"
    said, check = verdict(found), found.curves([50.0, 100.0])
    fewer = [one.prediction for one in found.fitted if len(one.numbers) < len(numbers)]
    better = min([*found.laws, *fewer], key=lambda law: rms(law, check))
    doubtful = rms(better, check) < rms(found.added.prediction, check)
    assert (f"With fewer numbers {better.name} does better on the check speeds" in said) == doubtful
    assert "resonance" in said.split("Not supported: ")[1].split(": their numbers are not all identified")[0]


def test_a_choice_that_a_cheaper_one_beats_is_doubtful() -> None:
    """Were the resonance chosen, film alone would be better with one number less; four of eight are too many."""
    found = compared()
    (resonance,) = (one for one in found.fitted if one.effect is not None and one.effect.name == "resonance")
    said = verdict(replace(found, added=resonance))
    assert "the error rises from 37.3 N, that of the best bare law, to 43.5 N" in said
    assert "With fewer numbers anisotropic, film does better on the check speeds, 18.8 N" in said
    largest = max(found.fitted, key=lambda one: len(one.numbers))
    assert affordable(largest, at(FIT_RPM))
    assert not affordable(largest, at((25.0,)))


def test_the_measured_account_says_where_the_law_comes_to_another_answer() -> None:
    """At 10 rpm the law's hydraulic power is an eighth too high, and rotation does not pay by it."""
    *_, own = power_table(compared()).notes
    assert "film and guide, it pays at none of these speeds" in own
    assert "differ at 10 rpm: there predicted hydraulic power is 12 % above measured" in own
    assert "rotating_pays_constant_speed_corrected" in own


def test_a_fit_that_the_study_does_not_simulate_is_told() -> None:
    assert not any("The study simulates" in note for note in effect_table(compared()).notes)
    notes = effect_table(compared(75.0, 125.0)).notes
    (share,) = (note for note in notes if "film_share" in note and "The study simulates" in note)
    assert share.startswith("The study simulates film_share 0.502 in corrected, constant_speed_corrected")
    assert "the fit gives 0." in share


def test_cells_and_headings_are_explained() -> None:
    slopes = slope_table(compared())
    assert (TABLES["added_slope"], slopes.title) == (slope_table, "Slope that rotation adds to axial friction (N s/m)")
    assert (slopes.cells == "a level").any(axis=None)
    assert any(note.startswith("A level: ") for note in slopes.notes)
    assert any(note.startswith("Reference: ") for note in slopes.notes)
    effects = effect_table(compared()).cells.set_index(["law", "parameter"])
    width = effects.loc[("anisotropic, film and resonance", "width")]
    assert (width["value"], width["std"], width["remark"]) == ("", "", "not identified, at its bound")
    assert any("Check / best bare law: error" in note for note in error_table(compared()).notes)


def test_reductions_are_drawn_from_nought() -> None:
    reductions = static_data(compared())
    before = sum(curve.static for curve in compared().at_rest)
    left = [sum(curve.static for curve in compared().curves([rpm])) / before for rpm in reductions.rpm]
    assert next(iter(reductions.lines)) == "measured"
    assert reductions.lines["measured"] == pytest.approx([100.0 - 100.0 * share for share in left])
    assert draw_reductions(reductions).axes[0].get_ylim()[0] == 0.0
    titles = [axes.get_title() for axes in draw_curves(curves_data(compared(), "forward"), "forward").axes]
    assert titles[0] == "10 rpm (not used)"


def test_the_fit_of_a_bare_law_is_neutral() -> None:
    found = fit(ANISOTROPIC, FILM + GUIDE, as_measured(ANISOTROPIC, FIT_RPM))
    assert found.numbers["film_share"][0] == pytest.approx(1.0, abs=1e-4)
    assert found.numbers["guide_coulomb"][0] == pytest.approx(0.0, abs=0.1)


def test_lists_of_different_length_are_a_mistake(tmp_path: Path) -> None:
    path = tmp_path / "curves.toml"
    path.write_text(MEASURED.read_text().replace("coulomb = [50, 0,", "coulomb = [50,"), encoding="utf-8")
    with pytest.raises(UserError, match=r"forward.coulomb: holds 5 values, expected one for each of the 6 rpm"):
        read_curves(path)


def test_break_even_counts_each_account() -> None:
    frame = pd.DataFrame(
        {
            "rpm": [0, 5, 10],
            "outcome": ["completed"] * 3,
            "hydraulic_power_W": [4.0, 3.0, 2.0],
            "rotation_power_W": [None, 0.5, 2.5],
            "supply_power_W": [100.0, 100.05, 99.95],
        }
    )
    spec = BreakEvenTable.model_validate(
        {
            "name": "t",
            "title": "t",
            "accounts": [
                {"label": "both", "columns": ["hydraulic_power_W", "rotation_power_W"]},
                {"label": "pump", "columns": ["supply_power_W"]},
            ],
        }
    )
    found = break_even_table(spec, frame).set_index("account")
    assert found.loc["both", "less at rpm"] == "5"
    assert found.loc["both", "change (%)"] == "-12.5"
    assert found.loc["pump", "less at rpm"] == "none"
