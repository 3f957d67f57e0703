"""The page that compares compensation with rotation: its words follow from the numbers, whatever they are."""

from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from workbench.report.comparison import pivots, sentences
from workbench.report.comparison_figures import non_dominated
from workbench.report.comparison_page import write_comparison
from workbench.study.schema import ComparisonTable, StudyFile

SPEC = ComparisonTable(plain=["p"], steps=["steps"], negligible=1e-6)


def frame(plain: dict[float, float], compensated: dict[float, float], verdict: str = "none") -> pd.DataFrame:
    """Results of controllers p and lugre with these rms errors (m) by rpm, and steps with one verdict."""
    rows = []
    for controller, errors in (("p", plain), ("lugre", compensated)):
        for rpm, error in errors.items():
            for reference in ("sine", "steps"):
                moving = reference == "sine"
                rows.append(
                    {
                        "case": reference,
                        "scenario": "nominal",
                        "reference": reference,
                        "rpm": rpm,
                        "controller": controller,
                        "outcome": "completed",
                        "phase_lag_deg": 1.0 if moving else None,
                        "rms_error_m": error,
                        "max_error_m": 2.0 * error,
                        "steady_state_error_m": None if moving else 1e-9,
                        "limit_cycle": None if moving else verdict,
                        "limit_cycle_amplitude_m": None if moving or verdict == "none" else 1.5e-3,
                        "total_power_W": 10.0 + rpm,
                        "supply_power_W": 20.0,
                        "rotation_power_W": rpm if rpm else None,
                        "motor_electric_power_W": 4.0 * rpm if rpm else None,
                    }
                )
    return pd.DataFrame(rows)


@pytest.mark.parametrize(
    ("plain", "compensated", "said"),
    [
        (
            {0: 9e-4, 10: 3e-4, 100: 1e-4},
            {0: 5e-4, 100: 5e-4},
            "rotation beats compensation, lugre without rotation (0.5 mm): from p at 10 rpm (0.3 mm) on, "
            "at 10 W at the rod, 40 W at the motor's terminals; it does best with p at 100 rpm (0.1 mm), at 100 W",
        ),
        ({0: 9e-4, 100: 8e-4}, {0: 5e-4, 100: 5e-4}, "compensation beats rotation, lugre without rotation (0.5 mm)"),
        ({0: 9e-4, 100: 5.1e-4}, {0: 5e-4, 100: 5e-4}, "the two are level"),
        ({0: 9e-4, 100: 8e-4}, {0: 5e-4, 100: 2e-4}, "Both together do best: lugre at 100 rpm (0.2 mm)."),
        ({0: 9e-4, 100: 5e-7}, {0: 4e-7, 100: 1e-7}, "both exact to 0.001 mm"),
        ({0: 9e-4, 100: 5e-4}, {0: 4e-7, 100: 1e-7}, "compensation is exact to 0.001 mm"),
    ],
)
def test_the_verdict_follows_from_the_errors(
    plain: dict[float, float], compensated: dict[float, float], said: str
) -> None:
    assert said in sentences(SPEC, frame(plain, compensated))["nominal"][0]


def test_limit_cycles_are_told_by_controller_and_rpm() -> None:
    quiet = sentences(SPEC, frame({0: 1e-3, 10: 1e-3}, {0: 1e-3}))["nominal"][-1]
    assert quiet == "No limit cycle in any of 3 cases with steps."
    loud = sentences(SPEC, frame({0: 1e-3, 10: 1e-3}, {0: 1e-3}, "sustained"))["nominal"][-1]
    assert "p at 0, 10 rpm (up to 1.5 mm peak to peak)" in loud


def test_the_non_dominated_set() -> None:
    cost, error = np.array([1.0, 2.0, 3.0, 2.5, 1.0]), np.array([5.0, 3.0, 3.0, 1.0, 6.0])
    assert non_dominated(cost, error).tolist() == [True, True, False, True, False]


def test_a_pivot_has_a_row_an_rpm_and_a_column_a_controller() -> None:
    made = {pivot.name: pivot.cells for pivot in pivots(SPEC, frame({0: 1e-3, 10: 2e-3}, {0: 3e-3}))}
    cells = made["nominal_sine_rms_error_m"]
    assert list(cells.columns) == ["rotation (rpm)", "p", "lugre"]
    assert cells["p"].tolist() == ["1", "2"]
    assert cells["lugre"].tolist() == ["3", ""]


def test_the_page_is_written_with_its_figures_and_the_same_bytes_twice(tmp_path: Path) -> None:
    results = frame({0: 9e-4, 10: 3e-4, 100: 1e-4}, {0: 5e-4, 10: 4e-4, 100: 5e-4}, "sustained")
    file = StudyFile(title="A < B", question="which?", comparison=SPEC)
    texts = []
    for name in ("one", "two"):
        markdown, html = write_comparison(file, results, tmp_path / name)
        texts.append((markdown.read_bytes(), html.read_bytes()))
        pictures = list((tmp_path / name / "figures").glob("*.png"))
        assert {picture.stem for picture in pictures} == {
            "error_against_rpm_nominal",
            "error_against_power_nominal",
            "limit_cycle_map",
        }
    assert texts[0] == texts[1]
    assert b"A &lt; B" in texts[0][1]
    assert b"6 cases" in texts[0][0] or b"12 cases" in texts[0][0]
