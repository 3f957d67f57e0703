"""How soon the bench follows the hand, measured in a browser: slider moved to scopes redrawn, start, sweep, memory.

    python benchmarks/bench.py [--moves N] [--minutes M] [--picture FILE.png]

The loop: 5 s of the thesis's actuator at 120 rpm, sampled at 1 kHz, four scopes and the figures of the run. A move is a
key pressed on the slider of K_p; it has been drawn when the browser has presented the frame after the new curves have
come. With --minutes, the slider is dragged to and fro that long, and the memory of both sides is told at the beginning
and after each sixth of it. Needs Chromium, and the extra `bench`.
"""

import argparse
import resource
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from playwright.sync_api import sync_playwright

from workbench.bench.groups import controls_of
from workbench.bench.knobs import Knob
from workbench.bench.opened import opened
from workbench.bench.outcome import outcome_of
from workbench.bench.scopes import FIRST, SCOPES
from workbench.bench.sweep import places, swept

if TYPE_CHECKING:
    from playwright.sync_api import Page

FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--disable-component-update"]
SWEPT = {"simulation.duration": 2.0, "simulation.transient": 0.5}
SLIDER = ".noUi-handle"


def quantiles(milliseconds: Sequence[float]) -> str:
    """Median and 95 %."""
    return f"{np.median(milliseconds):.0f} ms (median), {np.quantile(milliseconds, 0.95):.0f} ms (95 %)"


def parts() -> list[str]:
    """Where the time of a run goes before it leaves for the browser, in milliseconds."""
    loop = opened(None)
    times: dict[str, list[float]] = {"study and plant": [], "simulation": [], "figures": [], "curves": []}
    for number in range(30):
        marks = [time.perf_counter()]
        turned = loop.changed({"controllers.p.kp": 500.0 + number})
        _ = turned.resolved
        marks.append(time.perf_counter())
        outcome = outcome_of(turned)
        marks.append(time.perf_counter())
        _ = outcome.figures, outcome.loop_gain
        marks.append(time.perf_counter())
        for name in FIRST:
            SCOPES[name].view(outcome)
        marks.append(time.perf_counter())
        for (_, found), begin, end in zip(times.items(), marks[:-1], marks[1:], strict=True):
            found.append(1e3 * (end - begin))
    return [f"{name} {np.median(found[5:]):.1f} ms" for name, found in times.items()]


def sweep_seconds() -> float:
    """Of 200 points of 2 s."""
    loop = opened(None).changed(SWEPT)
    knob = next(one for one in controls_of("controller", outcome_of(loop)) if isinstance(one, Knob))
    values = [knob.at(place) for place in places(200)]
    best = np.inf
    for _ in range(3):
        begin = time.perf_counter()
        assert len(list(swept(loop, knob, values, "rms_error_m", lambda: False))) == len(values)
        best = min(best, time.perf_counter() - begin)
    return best


def moved(page: "Page", moves: int) -> list[float]:
    """Milliseconds from a key on the slider to the frame that shows the run."""
    page.evaluate("window.bench_times = []")
    page.locator(SLIDER).first.focus()
    for number in range(moves):
        page.keyboard.press("ArrowRight" if number % 40 < 20 else "ArrowLeft")
        page.wait_for_timeout(200)
    page.wait_for_timeout(1000)
    times: list[float] = page.evaluate("window.bench_times")
    return times


SPANS = 6
"""Of the dragging, after each of which memory is read."""


def dragged(page: "Page", minutes: float) -> None:
    """Drag the slider to and fro."""
    box = page.locator(SLIDER).first.bounding_box()
    assert box is not None
    x, y = box["x"] + 0.5 * box["width"], box["y"] + 0.5 * box["height"]
    page.mouse.move(x, y)
    page.mouse.down()
    end = time.monotonic() + 60.0 * minutes
    while time.monotonic() < end:
        for step in (*range(60), *range(60, 0, -1)):
            page.mouse.move(x + step, y)
            page.wait_for_timeout(16)
    page.mouse.up()


def megabytes(process: int) -> float:
    """Resident memory of a process."""
    for line in Path(f"/proc/{process}/status").read_text(encoding="utf-8").splitlines():
        if line.startswith("VmRSS"):
            return float(line.split()[1]) / 1024.0
    return float("nan")


def heap(page: "Page") -> float:
    """Of the page, after a collection (MB)."""
    session = page.context.new_cdp_session(page)
    session.send("HeapProfiler.collectGarbage")
    used: float = session.send("Runtime.getHeapUsage")["usedSize"]
    return used / 1e6


def main() -> None:
    """Measure, and print a line for each figure."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("--moves", type=int, default=80)
    parser.add_argument("--minutes", type=float, default=0.0)
    parser.add_argument("--picture", type=Path)
    options = parser.parse_args()
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        sys.exit("no browser: apt-get install chromium")
    print(f"one run: {', '.join(parts())}")
    print(f"sweep of 200 points of 2 s: {sweep_seconds():.2f} s")
    command = (sys.executable, "-c", "from workbench.cli import main; main()", "bench", "--no-browser")
    with sync_playwright() as playwright, tempfile.TemporaryDirectory() as folder:
        page = playwright.chromium.launch(executable_path=chromium, args=FLAGS).new_page(
            viewport={"width": 1300, "height": 1000}
        )
        begin = time.perf_counter()
        with subprocess.Popen(command, cwd=folder, stdout=subprocess.PIPE, text=True) as server:
            assert server.stdout is not None
            address = server.stdout.readline().split()[-1]
            troubles: list[str] = []
            page.on("console", lambda line: troubles.append(line.text) if line.type == "error" else None)
            page.on("pageerror", lambda error: troubles.append(str(error)))
            page.goto(address)
            page.wait_for_selector("canvas")
            print(f"ready to use: {time.perf_counter() - begin:.1f} s after the command")
            page.wait_for_timeout(3000)
            times = moved(page, options.moves)
            print(f"slider moved to four scopes redrawn: {quantiles(times)}, {len(times)} moves")
            if options.picture is not None:
                picture(page, options.picture)
            if options.minutes:
                levels = [(megabytes(server.pid), heap(page))]
                for _ in range(SPANS):
                    dragged(page, options.minutes / SPANS)
                    page.wait_for_timeout(2000)
                    levels.append((megabytes(server.pid), heap(page)))
                program, browser_side = (" -> ".join(f"{level[i]:.0f}" for level in levels) for i in (0, 1))
                print(f"{options.minutes:g} min of dragging: program {program} MB, page {browser_side} MB", flush=True)
            print(f"errors in the console: {len(troubles)}")
            server.terminate()
    print(f"memory of this process at most {resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024:.0f} MB")


def picture(page: "Page", path: Path) -> None:
    """The page with a pinned run, another gain and a sweep."""
    page.get_by_role("button", name="As opened").click()
    page.wait_for_timeout(500)
    page.get_by_role("button", name="Pin", exact=True).click()
    page.get_by_label("kp", exact=True).fill("1200")
    page.get_by_label("kp", exact=True).press("Enter")
    page.get_by_role("button", name="Sweep", exact=True).click()
    page.wait_for_timeout(8000)
    page.screenshot(path=path, full_page=True)


if __name__ == "__main__":
    main()
