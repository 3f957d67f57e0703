"""The page that compares compensation with rotation: its words follow from the numbers, whatever they are."""

from pathlib import Path

import pandas as pd
import pytest
from command import fails, workbench, write

from workbench.report.comparison import best, cases_of, cheapest, exactness, pivots, rule, sentences
from workbench.report.comparison_figures import non_dominated
from workbench.report.comparison_page import write_comparison
from workbench.report.comparison_tuned import changes, of_tuned
from workbench.study.document import Study
from workbench.study.report_schema import ComparisonTable
from workbench.study.schema import StudyFile

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
                        "solver_error_m": 1e-12,
                    }
                )
    return pd.DataFrame(rows)


@pytest.mark.parametrize(
    ("plain", "compensated", "said"),
    [
        (
            {0: 9e-4, 10: 3e-4, 100: 1e-4},
            {0: 5e-4, 100: 5e-4},
            "Sine: with neither, p leaves 0.9 mm. Rotation beats compensation, lugre without rotation (0.5 mm): "
            "cheapest with p at 10 rpm (0.3 mm), 10 W at the rod, 40 W at the motor's terminals; best with p at "
            "100 rpm (0.1 mm), 100 W at the rod, 400 W at the motor's terminals.",
        ),
        (
            {0: 9e-4, 10: 3e-4, 100: 2.9e-4},
            {0: 5e-4},
            "Sine: with neither, p leaves 0.9 mm. Rotation beats compensation, lugre without rotation (0.5 mm): "
            "cheapest with p at 10 rpm (0.3 mm), 10 W at the rod, 40 W at the motor's terminals.",
        ),
        (
            {0: 9e-4, 10: 8.1e-4, 100: 8e-4},
            {0: 5e-4, 100: 5e-4},
            "Sine: with neither, p leaves 0.9 mm. Compensation, lugre without rotation (0.5 mm), beats rotation, "
            "p at 10 rpm (0.81 mm), which would have cost 10 W at the rod, 40 W at the motor's terminals.",
        ),
        (
            {0: 9e-4, 10: 5.1e-4, 100: 4.9e-4},
            {0: 5e-4, 100: 5e-4},
            "Sine: with neither, p leaves 0.9 mm. Compensation, lugre without rotation (0.5 mm), and rotation, p "
            "at 10 rpm (0.51 mm), are level; rotation costs 10 W at the rod, 40 W at the motor's terminals.",
        ),
        (
            {0: 9e-4, 100: 2e-4},
            {0: 1e-3},
            "Sine: with neither, p leaves 0.9 mm. Rotation beats compensation, lugre without rotation (1 mm), by "
            "this rule no better than neither: cheapest with p at 100 rpm (0.2 mm), 100 W at the rod, 400 W at "
            "the motor's terminals.",
        ),
        (
            {0: 9e-4, 100: 8e-4},
            {0: 5e-4, 10: 3e-4, 100: 2e-4},
            "Sine: with neither, p leaves 0.9 mm. Compensation, lugre without rotation (0.5 mm), beats rotation, p at "
            "100 rpm (0.8 mm), which would have cost 100 W at the rod, 400 W at the motor's terminals. Both "
            "together beat either alone: cheapest with lugre at 10 rpm (0.3 mm), 10 W at the rod, 40 W at the "
            "motor's terminals; best with lugre at 100 rpm (0.2 mm), 100 W at the rod, 400 W at the motor's terminals.",
        ),
        (
            {0: 9e-7, 100: 1e-9},
            {0: 4e-7, 100: 1e-9},
            "Sine: nothing is needed: p without rotation (0.0009 mm) is within 0.001 mm.",
        ),
        (
            {0: 5e-4, 100: 4.9e-4},
            {0: 5e-4, 100: 4.8e-4},
            "Sine: nothing is needed: p without rotation (0.5 mm) is level with the best of all, lugre at 100 "
            "rpm (0.48 mm).",
        ),
        ({0: 9e-4}, {0: 5e-4}, "Sine: no comparison, since no case of one side has an error."),
    ],
)
def test_the_verdict_follows_from_the_errors(
    plain: dict[float, float], compensated: dict[float, float], said: str
) -> None:
    assert sentences(SPEC, frame(plain, compensated))["nominal"][0] == said


def test_a_difference_within_the_solver_error_does_not_count() -> None:
    results = frame({0: 9e-4, 100: 2e-4}, {0: 5e-4}).assign(solver_error_m=4e-4)
    assert "nothing is needed" in sentences(SPEC, results)["nominal"][0]
    assert "more than 5 % of the larger, by more than 0.001 mm, and by more than their solver errors" in rule(SPEC)
    assert exactness(SPEC, results) == (
        "6 of 6 cases have a solver error above 10 % of their error; in 3 of these the error is above 0.001 mm."
    )


def test_the_cheapest_is_that_of_the_least_power_with_the_least_error() -> None:
    """The slowest need not be the cheapest: friction falls with speed."""
    results = frame({10: 1e-4, 25: 3e-4}, {25: 2e-4})
    results["motor_electric_power_W"] = results["rpm"].map({10: 300.0, 25: 270.0}) + results["controller"].eq("lugre")
    cases = cases_of(results, "rms_error_m")
    assert (cheapest(cases).controller, cheapest(cases).rpm) == ("lugre", 25)
    assert (best(cases).controller, best(cases).rpm) == ("p", 10)


def test_limit_cycles_are_told_by_controller_and_rpm() -> None:
    quiet = sentences(SPEC, frame({0: 1e-3, 10: 1e-3}, {0: 1e-3}))["nominal"][-1]
    assert quiet == "No sustained limit cycle in any of 3 cases with steps."
    loud = sentences(SPEC, frame({0: 1e-3, 10: 1e-3}, {0: 1e-3}, "sustained"))["nominal"][-1]
    assert "p at 0, 10 rpm (up to 1.5 mm peak to peak)" in loud


def test_the_non_dominated_set() -> None:
    """A case that takes a little less power, or errs a little less, does not count."""
    results = frame({1: 6e-4, 2: 5e-4, 3: 3e-4, 4: 2.9e-4, 5: 1e-4, 6: 4e-4}, {})
    results["total_power_W"] = results["rpm"].map({1: 1.0, 2: 1.05, 3: 2.0, 4: 2.5, 5: 3.0, 6: 4.0})
    chosen = non_dominated(SPEC, cases_of(results[results["reference"] == "sine"], "rms_error_m"))
    assert [case.rpm for case in chosen] == [2, 3, 5]


def test_a_pivot_has_a_row_an_rpm_and_a_column_a_controller() -> None:
    made = {pivot.name: pivot.cells for pivot in pivots(SPEC, frame({0: 1e-3, 10: 2e-3}, {0: 3e-3}))}
    cells = made["nominal_sine_rms_error_m"]
    assert list(cells.columns) == ["rotation (rpm)", "p", "lugre"]
    assert cells["p"].tolist() == ["1", "2"]
    assert cells["lugre"].tolist() == ["3", ""]
    assert made["nominal_steps_steady_state_error_m"]["p"].tolist() == ["< 0.0001", "< 0.0001"]
    assert not any("limit_cycle" in name for name in made), "tables without any limit cycle are left out"


def test_the_page_is_written_with_its_figures_and_the_same_bytes_twice(tmp_path: Path) -> None:
    results = frame({0: 9e-4, 10: 3e-4, 100: 1e-4}, {0: 5e-4, 10: 4e-4, 100: 5e-4}, "sustained")
    study = Study(tmp_path / "a.toml", "", StudyFile(title="A < B", question="which?", comparison=SPEC))
    texts = []
    for name in ("one", "two"):
        markdown, html = write_comparison(study, results, tmp_path / name)
        texts.append((markdown.read_bytes(), html.read_bytes()))
        pictures = list((tmp_path / name / "figures").glob("*.png"))
        assert {picture.stem for picture in pictures} == {
            "error_against_rpm_nominal",
            "error_against_power_nominal",
            "limit_cycle_map",
        }
    assert texts[0] == texts[1]
    write_comparison(study, results.assign(limit_cycle="none"), tmp_path / "quiet")
    assert not (tmp_path / "quiet" / "figures" / "limit_cycle_map.png").exists()
    assert b"A &lt; B" in texts[0][1]
    assert b"6 cases" in texts[0][0] or b"12 cases" in texts[0][0]


def test_what_tuning_changes_is_told() -> None:
    """Compensation beats rotation with the gains before; tuned, rotation wins; steps stay as they are."""
    spec = SPEC.model_copy(update={"before": {"p": "p_before", "lugre": "lugre_before"}})
    tuned = frame({0: 9e-4, 10: 3e-4}, {0: 5e-4})
    old = frame({0: 9e-4, 10: 6e-4}, {0: 5e-4})
    old["controller"] += "_before"
    both = pd.concat([tuned, old], ignore_index=True)
    first, *others = changes(spec, both)
    assert first == "1 of 2 conclusions are others with tuned gains than with those before."
    assert others == [
        "Nominal, sine. Before: with neither, p leaves 0.9 mm. Compensation, lugre without rotation (0.5 mm), beats "
        "rotation, p at 10 rpm (0.6 mm), which would have cost 10 W at the rod, 40 W at the motor's terminals. Tuned: "
        "with neither, p leaves 0.9 mm. Rotation beats compensation, lugre without rotation (0.5 mm): cheapest with p "
        "at 10 rpm (0.3 mm), 10 W at the rod, 40 W at the motor's terminals."
    ]
    assert set(of_tuned(spec, both)["controller"]) == {"p", "lugre"}
    same = pd.concat([old, old.assign(controller=old["controller"].str.removesuffix("_before"))], ignore_index=True)
    assert changes(spec, same) == ["No conclusion changes: 2 of 2 are the same."]
    assert changes(SPEC, tuned) == []


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('plain = ["p"]', 'plain = ["q"]', 'comparison.plain.0: unknown controller "q"'),
        ('steps = ["hold"]', 'steps = ["step"]', 'comparison.steps.0: unknown reference "step"; did you mean "steps"?'),
        ('before = { p = "old" }', 'before = { p = "older" }', 'comparison.before.p: unknown controller "older"'),
    ],
)
def test_names_of_a_comparison_are_checked(tmp_path: Path, old: str, new: str, said: str) -> None:
    text = """title = "t"
[plant]
model = "non_rotating"
parameters = "owen2001_simulation"
[controllers]
p = { type = "pid", kp = "500 V/m" }
old = { type = "pid", kp = "400 V/m" }
[references]
steps = { kind = "steps", levels = ["1 mm"], dwell = "1 s" }
[simulation]
duration = "1 s"
[axes]
controller = ["p", "old"]
scenario = ["nominal"]
[comparison]
plain = ["p"]
steps = ["steps"]
before = { p = "old" }
"""
    assert workbench("check", write(tmp_path, text)).code == 0
    fails(workbench("check", write(tmp_path, text.replace(old.replace("hold", "steps"), new))), said)
