"""Sketches show a motion with few points: its extremes, and where much happens."""

import sqlite3
from pathlib import Path

import numpy as np
import pytest
from benches import short
from page_numbers import read_shorts

from workbench.publish.page.packed import LEVELS
from workbench.simulation.run import TRUE, Run
from workbench.simulation.simulate import simulate
from workbench.study.sketches import BYTES, BYTES_A_POINT, COMMAND, ERROR, LEAST, MOST, REFERENCE, points_for, sketch_of
from workbench.study.store import read_sketches
from workbench.study.study import INDEX


@pytest.fixture(scope="module")
def run() -> Run:
    return simulate(short().resolved.setup)


@pytest.mark.parametrize("points", [LEAST, 234, MOST])
def test_a_sketch_keeps_extremes_and_few_points(run: Run, points: int) -> None:
    sketch = read_shorts(sketch_of(run, points))
    assert list(sketch) == ["time", REFERENCE, ERROR, COMMAND, "velocity", TRUE]
    assert points // 4 <= sketch["time"].size <= points + 4
    assert np.all(np.diff(sketch["time"]) > 0.0)
    for name, signal in ((ERROR, run.signals["error"]), (COMMAND, run.signals[run.plant.command])):
        step = np.ptp(signal) / LEVELS
        assert sketch[name].min() == pytest.approx(signal.min(), abs=step)
        assert sketch[name].max() == pytest.approx(signal.max(), abs=step)


def test_the_friction_loop_is_seen_in_it(run: Run) -> None:
    """Between the points of 300 friction over velocity is nowhere further than 6 % of its range from their polygon."""
    sketch = read_shorts(sketch_of(run, 300))
    loop = np.column_stack([run.signals["velocity"], run.signals[TRUE]])
    drawn = np.column_stack([sketch["velocity"], sketch[TRUE]])
    scale = np.ptp(loop, axis=0)
    start, step = (drawn / scale)[:-1], np.diff(drawn / scale, axis=0)
    square = np.maximum(np.sum(step**2, axis=1), 1e-300)
    away = []
    for point in loop[::7] / scale:
        share = np.clip(np.sum((point - start) * step, axis=1) / square, 0.0, 1.0)
        away.append(np.min(np.hypot(*(start + share[:, None] * step - point).T)))
    assert max(away) < 0.06


def test_reference_less_error_is_the_position(run: Run) -> None:
    sketch = read_shorts(sketch_of(run, 234))
    position = np.interp(sketch["time"], run.time, run.signals["position"])
    step = (np.ptp(run.signals["error"]) + np.ptp(run.signals["reference_position"])) / LEVELS
    assert np.max(np.abs(sketch[REFERENCE] - sketch[ERROR] - position)) < 3.0 * step


def test_all_sketches_of_a_study_fit_on_a_page(run: Run) -> None:
    assert points_for(1) == MOST
    assert points_for(10**6) == LEAST
    count = 2000
    assert count * len(sketch_of(run, points_for(count))) < 1.3 * BYTES
    assert points_for(count) == BYTES // (count * BYTES_A_POINT)


def test_results_of_an_earlier_version_have_none(tmp_path: Path) -> None:
    with sqlite3.connect(tmp_path / "results.sqlite") as connection:
        connection.execute("CREATE TABLE results (number INTEGER)")
    connection.close()
    assert read_sketches(tmp_path) == {}
    assert read_sketches(tmp_path / "none") == {}


def test_a_sketch_from_elsewhere_ends_no_script(tmp_path: Path) -> None:
    with sqlite3.connect(tmp_path / "results.sqlite") as connection:
        connection.execute(f"CREATE TABLE sketches ({INDEX} INTEGER PRIMARY KEY, content TEXT)")
        connection.execute("INSERT INTO sketches VALUES (0, '</script><script>alert(1)</script>')")
    connection.close()
    assert "<" not in read_sketches(tmp_path)[0]
