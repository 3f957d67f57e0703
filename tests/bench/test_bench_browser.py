"""The bench in a real browser: a slider that moves numbers and curves, a sweep that is clicked, a saved study."""

import contextlib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import TYPE_CHECKING

import pytest
from benches import short
from browsing import opened_page

import workbench as wb
from workbench.bench.link import encoded
from workbench.bench.opened import opened
from workbench.bench.outcome import outcome_of
from workbench.bench.serving import bench_server

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("bench")


@pytest.fixture(scope="module")
def address(folder: Path) -> Iterator[str]:
    server = bench_server(short(rpm=120), folder)
    server.start_beside()
    yield server.url
    server.stop()


@contextlib.contextmanager
def opened_bench(browser: "Browser", address: str, width: int = 1300) -> Iterator["Page"]:
    """The bench, once it shows its scopes."""
    with opened_page(browser, address, width) as page:
        page.wait_for_selector("canvas")
        yield page


@pytest.fixture(scope="module")
def bench(browser: "Browser", address: str) -> Iterator["Page"]:
    """The bench for tests that take it as they find it."""
    with opened_bench(browser, address) as page:
        yield page


WIDTH = "document.documentElement.scrollWidth"
"""Of all that is on a page."""


def handle(page: "Page", label: str) -> None:
    """Put the keyboard on the slider below the field of that label."""
    field = page.get_by_label(label, exact=True)
    box = field.bounding_box()
    assert box is not None
    for one in page.locator(".noUi-handle").all():
        place = one.bounding_box()
        if place is not None and 0.0 < place["y"] - box["y"] < 60.0:
            one.focus()
            return
    raise AssertionError(f"no slider below {label}")


def shown(page: "Page", row: str, figure: str) -> str:
    """A cell of the table of figures."""
    heads = page.locator("th[scope=col]").all_inner_texts()
    cells = page.locator(f"tr:has(th:text-is('{row}')) td").all_inner_texts()
    return cells[heads.index(figure)]


def lag(page: "Page") -> float:
    """The phase lag (deg) in that table of the loop at hand."""
    return float(shown(page, "here", "phase lag").removesuffix(" deg"))


def once(page: "Page", holds: Callable[[], bool], seconds: float = 30.0) -> None:
    """Wait until something holds of the page, however slow the machine; what never does fails."""
    for _ in range(int(seconds / 0.05)):
        if holds():
            return
        page.wait_for_timeout(50)
    raise AssertionError("it does not hold")


def test_a_slider_moves_numbers_and_curves(browser: "Browser", bench: "Page") -> None:
    before = shown(bench, "here", "rms error")
    bench.get_by_role("button", name="Pin", exact=True).click()
    bench.wait_for_selector("th:text-is('pinned')")
    handle(bench, "kp")
    field, text = bench.get_by_label("kp", exact=True), ""
    for _ in range(5):
        text = field.input_value()
        bench.keyboard.press("ArrowRight")
        once(bench, lambda text=text: field.input_value() != text)
    text = field.input_value()
    gain = float(text.removesuffix(" V/m"))
    assert gain > 500.0
    loop = short(rpm=120).changed({"controllers.p.kp": gain})
    expected = outcome_of(loop).figures["rms_error_m"]
    assert isinstance(expected, float)
    wanted = pytest.approx(1e3 * expected, rel=1e-3)
    once(bench, lambda: float(shown(bench, "here", "rms error").removesuffix(" mm")) == wanted)
    assert shown(bench, "pinned", "rms error") == before
    once(bench, lambda: bench.url.endswith(f"?state={encoded(loop, short(rpm=120))}"))
    with opened_bench(browser, bench.url) as again:
        assert again.get_by_label("kp", exact=True).input_value() == text


def test_what_is_typed_wrongly_is_told(bench: "Page") -> None:
    field = bench.get_by_label("kp", exact=True)
    before = field.input_value()
    field.fill("3 apples")
    field.press("Enter")
    bench.wait_for_selector("text=kp: got")
    field.fill("-3 V/m")
    field.press("Enter")
    bench.wait_for_selector("text=expected a value that is not negative")
    assert field.input_value() == before  # what is refused does not stay
    field.fill("0.7 V/mm")
    field.press("Enter")
    bench.wait_for_selector("text=expected a value", state="hidden")
    once(bench, lambda: field.input_value() == "700 V/m")


def test_a_saved_study_is_run_to_the_same_figures(bench: "Page", folder: Path) -> None:
    field = bench.get_by_label("kp", exact=True)
    field.fill("640")
    field.press("Enter")
    wanted = outcome_of(short(rpm=120).changed({"controllers.p.kp": 640.0})).figures["phase_lag_deg"]
    once(bench, lambda: lag(bench) == pytest.approx(wanted, rel=1e-3))
    bench.get_by_placeholder("my_study.toml").fill("found.toml")
    bench.get_by_placeholder("my_study.toml").press("Enter")
    bench.get_by_role("button", name="Save as study").click()
    bench.wait_for_selector("text=workbench run found.toml")
    row = wb.Study(folder / "found.toml").run(folder / "results").frame.iloc[0]
    figures = outcome_of(opened(folder / "found.toml")).figures
    assert row["phase_lag_deg"] == figures["phase_lag_deg"]
    assert lag(bench) == pytest.approx(row["phase_lag_deg"], rel=1e-3)
    bench.get_by_role("button", name="Save as study").click()
    bench.wait_for_selector("text=there is a file of this name")


def test_a_click_in_a_sweep_takes_the_bench_there(bench: "Page") -> None:
    bench.get_by_label("points", exact=True).fill("12")
    bench.get_by_label("points", exact=True).press("Enter")
    bench.get_by_role("button", name="Sweep", exact=True).click()
    bench.wait_for_selector("text=/^1[0-9] points$/")
    field = bench.get_by_label("kp", exact=True)
    before = field.input_value()
    bench.mouse.click(*at_rest(bench))
    bench.wait_for_function("([field, before]) => field.value !== before", arg=[field.element_handle(), before])
    assert float(field.input_value().removesuffix(" V/m")) == pytest.approx(bench.evaluate(VALUE), rel=1e-5)


def at_rest(page: "Page") -> tuple[float, float]:
    """Where the ninth point of the sweep is on the screen, once the page has stopped moving and drawing."""
    places: list[tuple[float, float]] = []
    while len(places) < 3 or not places[-1] == places[-2] == places[-3]:
        page.wait_for_timeout(200)
        places.append(page.evaluate(POINT))
    return places[-1]


_SWEEP = """
const plot = [...Bokeh.documents[0]._all_models.values()].find(m => m.name === "sweep log")
const {x, y} = plot.renderers[0].data_source.data
const view = Bokeh.index.get_one(plot)
"""

POINT = f"""() => {{
{_SWEEP}
view.el.scrollIntoView()
const corner = view.el.getBoundingClientRect()
return [corner.left + view.frame.x_scale.compute(x[8]), corner.top + view.frame.y_scale.compute(y[8])]
}}"""
"""Where the ninth point of the sweep is on the screen."""

VALUE = f"() => {{ {_SWEEP} return x[8] }}"


def test_nothing_is_wider_than_the_screen(bench: "Page") -> None:
    assert bench.evaluate(WIDTH) <= 1300


def test_curves_can_be_taken_along(bench: "Page", tmp_path: Path) -> None:
    bench.locator(".bk-Figure").first.hover(force=True)
    for title, ending in (("Save the curves as CSV", "csv"), ("Save as SVG", "svg")):
        with bench.expect_download() as download:
            bench.locator(f'[title="{title}"]').first.click()
        path = tmp_path / download.value.suggested_filename
        download.value.save_as(path)
        assert path.name == f"position.{ending}"
    lines = (tmp_path / "position.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == '"curve","time (s)","position (mm)"'
    assert lines[1].startswith('"reference position",0,')
    assert (tmp_path / "position.svg").read_text(encoding="utf-8").startswith("<svg")


def test_on_a_narrow_screen_nothing_is_wider_and_the_page_says_how_soon_it_follows(
    browser: "Browser", address: str
) -> None:
    with opened_bench(browser, address, 390) as page:
        assert page.evaluate(WIDTH) <= 390
        assert page.locator("text=/drawn [0-9]+ ms after the hand moved/").count() == 0
        handle(page, "kp")
        page.keyboard.press("ArrowRight")
        page.wait_for_selector("text=/drawn [0-9]+ ms after the hand moved/")
