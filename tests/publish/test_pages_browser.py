"""Pages of results in a real browser, from disk and without a network."""

import contextlib
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from browsing import from_disk
from command import DRIVE, changed

import workbench as wb
from workbench.publish.page.index import write_index

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

pytestmark = pytest.mark.usefixtures("png_alone")

STUDY = """
title = "Two gains"
question = "Which gain tracks better?"
[plant]
model = "rotating_isotropic"
parameters = "owen2001_simulation"
[controllers.soft]
type = "pid"
kp = "300 V/m"
[controllers.stiff]
type = "pid"
kp = "600 V/m"
[references.sine]
kind = "sine"
amplitude = "10 mm"
frequency = "0.9 Hz"
[axes]
controller = ["soft", "stiff"]
rpm = [0, 10, 20, 30, 40, 60, 80, 120]
[simulation]
duration = "1.2 s"
transient = "0 s"
[[figures]]
name = "motion"
title = "Motion"
[[figures.panels]]
x = "time"
x_label = "time"
y_label = "position"
y_unit = "mm"
[[figures.panels.curves]]
y = "reference_position"
where = { controller = "soft", rpm = 0 }
label = "reference"
style = "reference"
[[figures.panels.curves]]
y = "position"
where = { controller = "soft", rpm = 0 }
label = "soft"
"""


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory, png_alone: None) -> wb.StudyResults:
    folder = tmp_path_factory.mktemp("pages")
    (folder / "study.toml").write_text(STUDY, encoding="utf-8")
    return wb.Study(folder / "study.toml").run(folder / "gains")


@contextlib.contextmanager
def opened(browser: "Browser", results: wb.StudyResults) -> Iterator["Page"]:
    """The page of results, once it shows its trajectories."""
    with from_disk(browser, results.folder / "results.html") as page:
        page.wait_for_selector(".cases canvas", state="attached")
        yield page


@pytest.fixture(scope="module")
def page(browser: "Browser", results: wb.StudyResults) -> Iterator["Page"]:
    """The page for tests that leave it as they find it."""
    with opened(browser, results) as page:
        yield page


def column(page: "Page", heading: str) -> list[str]:
    """The cells below a heading of the table of cases that are shown."""
    heads = [text.split(" ▲")[0].split(" ▼")[0] for text in page.locator(".cases thead th").all_inner_texts()]
    rows = page.locator(".cases tbody tr:not([hidden])")
    return [row.split("\t")[heads.index(heading)].strip() for row in rows.all_inner_texts()]


def test_the_answer_comes_first(page: "Page") -> None:
    assert page.title() == "Two gains"
    first = page.locator("body > *:visible").nth(2).inner_text()
    assert "Which gain" in first
    answer = page.locator(".answer").inner_text()
    assert "Phase lag from" in answer
    assert "Rms error from" in answer


def test_a_heading_sorts_up_and_down(browser: "Browser", results: wb.StudyResults) -> None:
    with opened(browser, results) as page:
        head = page.get_by_role("button", name="rms error (mm)")
        head.click()
        up = [float(text) for text in column(page, "rms error (mm)")]
        assert up == sorted(up)
        assert len(set(up)) > 8
        head.press("Enter")
        assert [float(text) for text in column(page, "rms error (mm)")] == sorted(up, reverse=True)
        assert page.locator("th[aria-sort=descending]").count() == 1


def test_words_bounds_and_choices_filter(page: "Page") -> None:
    field = page.locator(".filter input")
    field.fill("stiff rpm<=20")
    assert column(page, "controller") == ["stiff"] * 3
    assert column(page, "rpm") == ["0", "10", "20"]
    assert "3 of 16 rows" in page.locator(".filter").inner_text()
    field.fill("rpm=120")
    assert column(page, "rpm") == ["120", "120"]
    field.fill("rms error (mm) > 1 controller != soft")
    assert column(page, "controller") == ["stiff"] * 8
    field.fill("rms_error < 1.2 rpm = 120")
    assert column(page, "controller") == ["stiff"]
    field.fill("bla < 3 rpm >= 80")
    assert len(column(page, "rpm")) == 4
    assert 'no column "bla"' in page.locator(".filter").inner_text()
    page.get_by_role("button", name="all", exact=True).click()
    assert len(column(page, "rpm")) == 16
    page.get_by_label("controller", exact=True).select_option("soft")
    assert column(page, "controller") == ["soft"] * 8
    page.get_by_role("button", name="all", exact=True).click()
    assert len(column(page, "rpm")) == 16


_CURVE = """name => {
  for (const document of Bokeh.documents)
    for (const model of document._all_models.values())
      if (model.name === name && model.data_source.data.x.length)
        return [Array.from(model.data_source.data.x), Array.from(model.data_source.data.y)];
}"""


def test_a_click_draws_the_case_and_keeps_the_one_before(page: "Page", results: wb.StudyResults) -> None:
    page.locator(".cases tbody tr").nth(0).click()
    page.locator(".cases tbody tr").nth(9).click()
    title = page.locator(".trajectory-title").inner_text()
    assert title == f"{label(page, 9)} (in grey: {label(page, 0)})"
    controller, rpm = column(page, "controller")[9], float(column(page, "rpm")[9])
    case = results.frame[(results.frame["controller"] == controller) & (results.frame["rpm"] == rpm)].iloc[0]
    _, error = page.evaluate(_CURVE, "error")
    assert max(map(abs, error)) == pytest.approx(1e3 * case["max_error_m"], rel=1e-3)
    assert page.evaluate(_CURVE, "error, before")
    page.locator(".cases tbody tr").nth(9).press("ArrowDown")
    assert page.locator(".trajectory-title").inner_text().startswith(f"{label(page, 10)} (in grey: {label(page, 9)}")


def label(page: "Page", row: int) -> str:
    """What the page calls the case of a row."""
    return f"{column(page, 'controller')[row]}, rpm {column(page, 'rpm')[row]}"


def test_a_picture_comes_alive_and_its_keys_hide_curves(page: "Page") -> None:
    figure = page.locator("#figure-motion")
    figure.scroll_into_view_if_needed()
    page.wait_for_selector("#figure-motion.live-shown canvas", state="attached")
    assert not figure.locator("> img").is_visible()
    key = figure.get_by_role("button", name="soft")
    time, position = page.evaluate(_CURVE, "soft")
    assert (min(time), max(time)) == pytest.approx((0.0, 1.2), abs=0.01)
    assert 7.0 < max(position) < 10.5
    key.click()
    assert key.get_attribute("aria-pressed") == "false"
    models = "Bokeh.documents.flatMap(document => [...document._all_models.values()])"
    assert page.evaluate(f"{models}.some(model => model.name === 'soft' && model.visible === false)")
    key.click()
    assert key.get_attribute("aria-pressed") == "true"


def test_dark_and_light(page: "Page") -> None:
    def back() -> str:
        return str(page.evaluate("getComputedStyle(document.body).backgroundColor"))

    light = back()
    page.get_by_role("button", name="dark page").click()
    assert back() != light
    page.get_by_role("button", name="light page").click()
    assert back() == light


def test_on_paper_stand_the_pictures_themselves(page: "Page") -> None:
    page.locator("#figure-motion").scroll_into_view_if_needed()
    page.wait_for_selector("#figure-motion.live-shown", state="attached")
    page.emulate_media(media="print")
    assert page.locator("#figure-motion > img").is_visible()
    assert not page.locator(".trajectory").is_visible()
    assert not page.locator(".filter").first.is_visible()
    page.emulate_media(media="screen")


def test_without_a_script_all_is_there(browser: "Browser", results: wb.StudyResults) -> None:
    context = browser.new_context(java_script_enabled=False, offline=True)
    page = context.new_page()
    page.goto((results.folder / "results.html").as_uri())
    assert page.locator("#figure-motion > img").evaluate("image => image.naturalWidth") > 300
    assert page.locator(".cases tbody tr").count() == 16
    context.close()


@pytest.mark.parametrize("width", [1300, 390])
def test_no_page_is_wider_than_the_screen(browser: "Browser", results: wb.StudyResults, width: int) -> None:
    index, _ = write_index(results.folder.parent)
    for path in (results.folder / "results.html", index):
        with from_disk(browser, path, width) as page:
            assert page.evaluate("document.documentElement.scrollWidth") <= width


def test_the_index_leads_to_the_page(browser: "Browser", results: wb.StudyResults) -> None:
    index, count = write_index(results.folder.parent)
    assert count == 1
    with from_disk(browser, index) as page:
        assert "Phase lag from" in page.locator("tbody").inner_text()
        page.get_by_role("link", name="Two gains").click()
        assert page.title() == "Two gains"


def test_no_text_of_a_study_changes_its_page(browser: "Browser", tmp_path: Path) -> None:
    text = changed('y_label = "position"', "y_label = 'a <!-- <script b </script> {{ 7*7 }}'", STUDY)
    text = changed("rpm = [0, 10, 20, 30, 40, 60, 80, 120]", "rpm = [0, 120]", text)
    (tmp_path / "study.toml").write_text(text, encoding="utf-8")
    folder = wb.Study(tmp_path / "study.toml").run(tmp_path / "out").folder
    with from_disk(browser, folder / "results.html") as page:
        assert page.locator(".cases tbody tr").count() == 4
        page.locator("#figure-motion").scroll_into_view_if_needed()
        page.wait_for_selector("#figure-motion.live-shown canvas", state="attached")


def test_a_force_is_no_voltage(browser: "Browser", tmp_path: Path) -> None:
    (tmp_path / "study.toml").write_text(changed('"drive"', '"drive"\ncommand = "force"', DRIVE), encoding="utf-8")
    folder = wb.Study(tmp_path / "study.toml").run(tmp_path / "out").folder
    with from_disk(browser, folder / "results.html") as page:
        page.locator(".cases tbody tr").first.click()
        page.wait_for_selector(".trajectory canvas", state="attached")
        labels = page.evaluate("Bokeh.documents.map(each => each.roots()[0].left?.[0]?.axis_label)")
        assert "command (N)" in labels
