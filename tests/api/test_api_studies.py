"""Studies and questions from Python: results as objects, and the mistakes of a file."""

import json
from pathlib import Path

import pandas as pd
import pytest
from command import STUDIES, STUDY, workbench, write
from short_loop import small

import workbench as wb
from workbench import api

pytestmark = pytest.mark.usefixtures("png_alone")

FIGURES = """
[[tables]]
name = "lag"
title = "Phase lag"
index = "rpm"
columns = [{ result = "phase_lag_deg", label = "lag", unit = "deg" }]
[[figures]]
name = "friction"
title = "Friction"
[[figures.panels]]
x = "velocity"
x_label = "velocity"
y_label = "friction"
curves = [{ y = "axial_friction", where = { rpm = 460 } }]
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> api.StudyResults:
    """Of the tests' small study, with a table and a figure."""
    folder = tmp_path_factory.mktemp("api")
    return wb.Study(write(folder, STUDY + FIGURES)).run(folder / "out", jobs=2)


def test_tables_figures_and_columns_by_name(results: api.StudyResults) -> None:
    assert (results.tables, results.figures) == (["lag"], ["friction"])
    assert list(results.table("lag").columns) == ["rpm", "lag (deg)"]
    numbers = results.table("phase_lag")
    assert numbers["phase_lag_deg"].tolist() == results.frame["phase_lag_deg"].tolist()
    figure = results.figure("friction")
    assert figure.axes[0].get_title() == ""
    assert figure._repr_png_().startswith(b"\x89PNG")  # which a notebook shows
    with pytest.raises(wb.UserError, match='no table and no column "phase_lg"; did you mean "phase_lag"'):
        results.table("phase_lg")
    with pytest.raises(wb.UserError, match='no figure "frction"; did you mean "friction"'):
        results.figure("frction")


def test_signals_of_a_case_where_they_were_kept(results: api.StudyResults) -> None:
    case = results.case(rpm=460)
    assert case.kept
    assert case.frame().attrs["units"]["velocity"] == "m/s"
    assert case.plot("axial_friction", against="velocity").axes[0].get_xlabel() == "velocity (m/s)"
    with pytest.raises(wb.UserError, match="the signals of rpm 0 were not kept; run with keep_trajectories=True"):
        results.case(rpm=0).frame()
    with pytest.raises(wb.UserError, match="2 cases for no condition, expected one"):
        results.case()


def test_results_are_plain_data_and_can_be_read_again(results: api.StudyResults) -> None:
    data = json.loads(json.dumps(results.to_json()))
    assert data["units"]["phase_lag_deg"] == "deg"
    assert data["rows"][0]["settling_time_s"] is None
    assert data["rows"][1]["phase_lag_deg"] == pytest.approx(results.case(rpm=460).row["phase_lag_deg"], rel=1e-12)
    assert api.StudyResults.read(results.folder).to_json() == results.to_json()


def test_a_dictionary_is_the_same_study_as_its_file(results: api.StudyResults, tmp_path: Path) -> None:
    study = wb.Study(
        {
            "title": "a study for tests",
            "plant": {"model": "by_rpm", "parameters": "owen2001_simulation"},
            "axes": {"rpm": [0, 460]},
            "controllers": {"p": wb.pid(kp="500 V/m")},
            "references": {"sine": wb.sine("5 mm", "2 Hz")},
            "simulation": {"duration": "1 s", "transient": "0.4 s"},
        }
    )
    here = study.run(tmp_path / "out", keep_trajectories=True)
    pd.testing.assert_frame_equal(here.frame, results.frame)
    assert workbench("check", tmp_path / "out" / "study.toml").code == 0
    with pytest.raises(wb.UserError, match="holds results already"):
        study.run(tmp_path / "out")
    assert study.run(tmp_path / "out", resume=True).frame.equals(here.frame)
    with pytest.raises(wb.UserError, match="draws needs a table"):
        study.run(tmp_path / "other", draws=2)


def test_which_case_is_meant(results: api.StudyResults) -> None:
    study = wb.Study(results.folder / "study.toml")
    assert study.cases["rpm"].tolist() == [0, 460]
    with pytest.raises(wb.UserError, match="2 cases with no condition, expected one; the axes are rpm"):
        study.setup()
    with pytest.raises(wb.UserError, match="no cases with rpm 50"):
        study.setup(rpm=50)
    with pytest.raises(wb.UserError, match="no axis rmp"):
        study.setup(rmp=460)
    with pytest.raises(wb.UserError, match=r"has \[tune\] and no \[references\]; use wb.tune"):
        _ = wb.Study({"title": "t", "tune": {"objective": {"rms_error": 1}}}).plan
    assert wb.Study(STUDIES / "thesis_chapter3.toml").setup(rpm=460).reference is not None


# --- faces ---


def test_faces_are_small_and_stand_alone(results: api.StudyResults) -> None:
    for shown in (wb.simulate(small()), results):
        html = shown._repr_html_()
        assert "<table" in html
        assert "data:image/png;base64," in html
        assert "http" not in html
        assert len(html) < 200_000
    assert "rpm" in wb.Study(results.folder / "study.toml")._repr_html_()


# --- questions ---


def test_a_tuning_of_a_dictionary_leaves_a_study_and_gains(tmp_path: Path) -> None:
    content = {
        "title": "a dictionary that is tuned",
        "plant": {"model": "non_rotating", "parameters": "owen2001_simulation"},
        "controllers": {"p": wb.pid(kp=500)},
        "references": {"sine": wb.sine("5 mm", "2 Hz")},
        "simulation": {"duration": "1 s"},
        "tune": {"seeds": 1, "trials": 3, "objective": {"rms_error": 1}},
    }
    tuning = wb.tune(content, tmp_path / "out", controllers=["p"])
    (result,) = tuning.tuned
    gains = tmp_path / "out" / "tuned" / "p.toml"
    assert workbench("check", tmp_path / "out" / "study.toml").code == 0
    loop = wb.setup("non_rotating", "owen2001_simulation", controller=wb.pid(gains=str(gains)))
    assert loop.gains.proportional == pytest.approx(result.best["kp"])
    assert repr(tuning).startswith("a dictionary that is tuned\np reaches an objective of ")
    with pytest.raises(wb.UserError, match="holds trials already"):
        wb.tune(content, tmp_path / "out", controllers=["p"])
    with pytest.raises(wb.UserError, match="trials: got 0, expected 1 or more"):
        wb.tune(content, controllers=["p"], trials=0)


def test_questions_say_what_is_wrong(tmp_path: Path) -> None:
    with pytest.raises(wb.UserError, match="no such file"):
        wb.diagnose(tmp_path / "experiment.toml")
    with pytest.raises(wb.UserError, match='method "simulated": did you mean "simulation"'):
        wb.identify(tmp_path / "experiment.toml", method="simulated")
    with pytest.raises(wb.UserError, match="decide"):
        wb.decide({"title": "no question", "controllers": {"p": wb.pid(kp=500)}})
