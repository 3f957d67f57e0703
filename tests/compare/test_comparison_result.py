"""The result of a comparison as an object: its page, the numbers of its figures, its JSON and its face."""

import json
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from browsing import from_disk
from made_up_comparison import SPEC, STEPS, cell, compared, made_up_study, whole

from workbench.api import StudyResults
from workbench.compare.comparison import compare
from workbench.compare.report.hunting_figure import hunting_map
from workbench.compare.report.page import write_comparison
from workbench.compare.report.panels import candidates_of
from workbench.compare.report.power_figure import power_panel
from workbench.compare.report.speed_figure import speed_panel
from workbench.compare.report.tables import pivots
from workbench.compare.result import Comparison
from workbench.errors import UserError

if TYPE_CHECKING:
    from playwright.sync_api import Browser


pytestmark = pytest.mark.usefixtures("png_alone")


@pytest.fixture(scope="module")
def whole_comparison() -> Comparison:
    """Of two machines, two scenarios, a sine and steps."""
    return compare(made_up_study("A < B", "which?"), SPEC, whole(draws=range(1, 4)))


@pytest.fixture(scope="module")
def page(whole_comparison: Comparison, tmp_path_factory: pytest.TempPathFactory, png_alone: None) -> list[Path]:
    """Its page, as Markdown and as HTML."""
    return write_comparison(whole_comparison, tmp_path_factory.mktemp("one"))


def test_the_page_is_written_with_its_figures_and_the_same_bytes_twice(
    whole_comparison: Comparison, page: list[Path], tmp_path: Path
) -> None:
    texts = []
    for markdown, html in (page, write_comparison(whole_comparison, tmp_path)):
        texts.append((markdown.read_bytes(), html.read_bytes()))
        pictures = {picture.stem for picture in (html.parent / "figures").glob("*.png")}
        assert pictures == {
            "error_against_rpm_nominal",
            "error_against_rpm_soft",
            "error_against_power_nominal",
            "error_against_power_soft",
            "hunting_map",
        }
    assert texts[0] == texts[1]
    html = texts[0][1].decode()
    assert "A &lt; B" in html
    assert html.index("matrices") < html.index("In words") < html.index("Left out") < html.index("<h2>Nominal")
    assert "360 cases: 2 machines, 5 controllers" in html


def test_a_click_on_a_field_of_the_matrix_shows_its_cases(browser: "Browser", page: list[Path]) -> None:
    with from_disk(browser, page[1]) as opened:
        rows = opened.locator(".cases tbody tr:not([hidden])")
        assert rows.count() == 120  # three draws in a line
        table = opened.locator(".matrices table").nth(1)
        place = {"machine": table.locator("caption").inner_text(), "scenario": "soft", "reference": "steps"}
        heads = table.locator("tr").first.locator("th").all_inner_texts()
        row = next(row for row in table.locator("tr").all() if row.locator("th").first.inner_text() == "soft")
        row.locator("td").nth(heads.index("steps") - 1).click()
        shown = [text.split("\t") for text in rows.all_inner_texts()]
        assert 0 < len(shown) < 120
        for name, value in place.items():
            column = opened.locator(".cases thead th").all_inner_texts().index(name)
            assert {cells[column].strip() for cells in shown} == {value}


def test_a_comparison_of_steps_alone_makes_its_page(tmp_path: Path) -> None:
    frame = cell({("p", 0.0): 9e-4, ("lugre", 0.0): 5e-4, ("p", 10.0): 3e-4}, place=STEPS)
    assert len(write_comparison(compared(frame), tmp_path)) == 2


def test_results_of_a_study_have_the_comparison_as_an_object(tmp_path: Path) -> None:
    search, fresh = whole(draws=range(1, 4)), whole(2, range(11, 17))
    (tmp_path / "fresh").mkdir()
    fresh.to_parquet(tmp_path / "fresh" / "results.parquet")
    results = StudyResults(made_up_study().with_section("comparison", SPEC), tmp_path, search)
    comparison = results.comparison
    verdict = comparison.at("nominal", "sine", machine="rig")
    assert verdict.fresh
    assert verdict.kind == compared(search, fresh=fresh).at("nominal", "sine", machine="rig").kind
    data = json.loads(json.dumps(comparison.to_json()))
    assert [(cell["machine"], cell["scenario"], cell["reference"], cell["verdict"]) for cell in data["cells"]] == [
        (*cell, verdict.kind) for cell, verdict in comparison.verdicts.items()
    ]
    best = verdict.best["compensate"]
    told = next(cell for cell in data["cells"] if (cell["machine"], cell["reference"]) == ("rig", "sine"))
    assert told["best"]["compensate"]["controller"] == best.controller
    assert told["best"]["compensate"]["error_m"]["mean"] == pytest.approx(best.errors.mean())
    html = comparison._repr_html_()
    assert "data:image/png;base64," in html
    assert "stands for its class" in html
    with pytest.raises(UserError, match=r"its study has no \[comparison\]"):
        _ = StudyResults(made_up_study(), tmp_path, search).comparison


def test_numbers_of_figures_stand_apart_from_their_drawing() -> None:
    errors = {("p", 0.0): 9e-4, ("p", 10.0): 3e-4, ("pi", 10.0): 4e-4, ("lugre", 0.0): 2e-7}
    comparison = compared(cell(errors, [1], noise=0.0))
    ((place, candidates),) = candidates_of(comparison).items()
    panel = speed_panel(SPEC, place, candidates)
    assert {line.controller: line.best for line in panel.lines} == {"p": True, "pi": False, "lugre": True}
    shared = comparison.at("nominal", "sine", machine="rig").best["nothing"].errors[0] / 9e-4
    line = next(line for line in panel.lines if line.controller == "p")
    assert [point.real_rpm for point in line.points] == [0.0, 10.0]
    assert [point.error for point in line.points] == pytest.approx([0.9 * shared, 0.3 * shared])
    tiny = next(line for line in panel.lines if line.controller == "lugre")
    assert tiny.points[0].error == pytest.approx(0.5e-3), "the middle of the band of what is not told apart"
    standing = power_panel(SPEC, place, candidates, comparison.verdicts[place]).standing
    assert [(each.kind, each.bar.place) for each in standing] == [("nothing", 200), ("compensate", 200), ("avoid", 240)]
    frame = cell(errors, [1, 2], place=STEPS)
    frame.loc[(frame["controller"] == "p") & (frame["draw"] == 2), "limit_cycle"] = "sustained"
    drawn = hunting_map(frame.assign(limit_cycle_amplitude_m=1e-3))
    assert drawn is not None
    assert drawn.rows[0][0].share[drawn.controllers.index("p")].tolist() == [0.5, 0.5]
    assert [(swing.share, swing.amplitude) for swing in drawn.rows[0][0].swings] == [(0.5, 1e-3)] * 2


def test_pivots_rank_nothing_and_show_small_numbers_as_such() -> None:
    frame = cell({("p", 0.0): 1e-17, ("lugre", 0.0): 5e-4, ("p", 10.0): 3e-4}, [1])
    made = {pivot.name: pivot.cells for pivot in pivots(compared(frame))}
    assert made["rig_nominal_sine_rms_error_m"]["p"].iloc[0] == "< 0.0001"
    assert made["rig_nominal_sine_phase_lag_deg"]["p"].tolist() == ["1", "1"]
