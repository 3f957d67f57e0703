"""How large the page of a comparison of 2000 cases is, and how soon it can be read and used, opened from disk.

    .venv/bin/python benchmarks/pages.py [--cases 2000]

A study of so many cases with all that a page has of each (a line of figures, a sketch of its motion) is run, and its
page is opened in Chromium with the network off; beside it the same page without scripts and sketches: the text.
"""

import argparse
import re
import statistics
import sys
import tempfile
import time
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / "tests" / "helpers"))

from browsing import CHROMIUM, FLAGS
from playwright.sync_api import Browser, sync_playwright

import workbench as wb

STUDY = """
title = "Every gain at every speed"
question = "How long does a page take?"
[plant]
model = "rotating"
parameters = "owen2001_simulation"
[controllers.p]
type = "pid"
kp = "500 V/m"
[references.sine]
kind = "sine"
amplitude = "5 mm"
frequency = "0.9 Hz"
[axes]
rpm = [{speeds}]
"controllers.p.kp" = [{gains}]
[simulation]
duration = "2 s"
transient = "0 s"
"""

SPEEDS = 40

RUNS = 7


def made(cases: int, folder: Path) -> Path:
    """The page of a study of so many cases."""
    speeds = ", ".join(str(3 * i + 1) for i in range(SPEEDS))
    gains = ", ".join(f'"{300 + 5 * i} V/m"' for i in range(-(-cases // SPEEDS)))
    (folder / "study.toml").write_text(STUDY.format(speeds=speeds, gains=gains), encoding="utf-8")
    return wb.Study(folder / "study.toml").run(folder / "results").folder / "results.html"


def without_scripts(page: Path) -> Path:
    """The same page with its text alone."""
    text = re.sub(r"<script.*?</script>", "", page.read_text(encoding="utf-8"), flags=re.DOTALL)
    path = page.with_name("text.html")
    path.write_text(text, encoding="utf-8")
    return path


def seconds_to_open(browser: Browser, page: Path, ready: str) -> float:
    """From the address to where `ready` is there and two frames were drawn."""
    context = browser.new_context(offline=True, viewport={"width": 1300, "height": 1000})
    tab = context.new_page()
    began = time.perf_counter()
    tab.goto(page.as_uri())
    tab.wait_for_selector(ready, state="attached")
    tab.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    took = time.perf_counter() - began
    context.close()
    return took


def seconds_to_click(browser: Browser, page: Path) -> float:
    """From a click on a line far down to its motion being drawn."""
    context = browser.new_context(offline=True, viewport={"width": 1300, "height": 1000})
    tab = context.new_page()
    tab.goto(page.as_uri())
    tab.locator("#cases").scroll_into_view_if_needed()
    tab.wait_for_selector(".trajectory canvas", state="attached")
    row = tab.locator(".cases tbody tr").nth(777)
    row.scroll_into_view_if_needed()
    before = tab.locator(".trajectory-title").inner_text()
    began = time.perf_counter()
    row.click()
    tab.wait_for_function("before => document.querySelector('.trajectory-title').innerText !== before", arg=before)
    tab.evaluate("new Promise(done => requestAnimationFrame(() => requestAnimationFrame(done)))")
    took = time.perf_counter() - began
    context.close()
    return took


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--cases", type=int, default=2000)
    cases = parser.parse_args().cases
    with tempfile.TemporaryDirectory() as folder, sync_playwright() as playwright:
        page = made(cases, Path(folder))
        text = without_scripts(page)
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=FLAGS)
        opened = [seconds_to_open(browser, page, ".filter") for _ in range(RUNS)]
        bare = [seconds_to_open(browser, text, "table") for _ in range(RUNS)]
        clicked = [seconds_to_click(browser, page) for _ in range(3)]
        browser.close()
        sizes = [path.stat().st_size / 1e6 for path in (page, text)]
        print(f"{cases} cases: {sizes[0]:.1f} MB (text alone {sizes[1]:.1f} MB)")
        middle = statistics.median(opened)
        ratio = middle / statistics.median(bare)
        print(f"opened: median {middle:.2f} s, longest {max(opened):.2f} s; {ratio:.1f} times the text alone")
        print(f"a line clicked to its motion drawn: median {statistics.median(clicked):.2f} s")


if __name__ == "__main__":
    main()
