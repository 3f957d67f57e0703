"""Counts, lengths and sizes that nobody means: each is refused in a line that says what the most is."""

import os
from pathlib import Path

import pytest
from command import FIGURE, STUDY, changed, workbench, write
from mistakes import said

from workbench.study.plan import plan
from workbench.study.reading import read_study

CURVE = '[[figures.panels.curves]]\ny = "position"\nwhere = { rpm = 0 }\n'
TABLE = (
    '[[tables]]\nname = "t{}"\ntitle = "t"\nindex = "rpm"\n[[tables.columns]]\nresult = "rms_error_m"\nlabel = "e"\n'
)
PANEL = '[[figures.panels]]\nx_label = "x"\ny_label = "y"\n' + CURVE


def axis(count: int) -> str:
    return str(list(range(count)))


LIMITS = {
    "cases": (
        changed(
            "rpm = [0, 460]", f"rpm = {axis(1000)}\n'plant.scale.mass' = {axis(1000)}\n'simulation.seed' = {axis(1000)}"
        ),
        "@:6: axes: make 1000000000 cases, expected at most 4000000: leave an axis out, or values of it",
    ),
    "draws": (STUDY + "[uncertainty]\ndraws = 1000001\n", "@:22: uncertainty.draws: got 1000001: "),
    "samples": (
        changed('duration = "1 s"', 'duration = "1e9 s"'),
        "@:18: simulation: duration 1e+09 s at a sample_time of 0.001 s: expected between 1 and 2e+07 samples",
    ),
    "steps": (
        STUDY + 'method = "rk4"\nstep = "1e-12 s"\n',
        "@:18: simulation: step 1e-12 s: makes 1e+12 steps of the duration of 1 s, expected at most 1e+10",
    ),
    "tolerance": (STUDY + "tolerance = 1e-300\n", "@:21: simulation.tolerance: got 1e-300: "),
    "hold_limit": (
        STUDY + 'hold_limit = "1e9 s"\n',
        "@:18: simulation: hold_limit 1e+09 s at a sample_time of 0.001 s: expected at most 2e+07 samples",
    ),
    "delay": (
        STUDY + '[sensors]\ndelay = "1e9 s"\n',
        "@: sensors.delay: 1e+12 samples are kept on their way, expected at most 1e+06",
    ),
    "digits": (STUDY + TABLE.format(1) + "digits = 1000000000\n", "@:28: tables.0.columns.0.digits: got 1000000000: "),
    "panels": (STUDY + FIGURE + CURVE + PANEL * 400, "@:24: figures.0.panels: has 401 entries, expected at most 40"),
    "tables": (
        STUDY + "".join(TABLE.format(i) for i in range(1001)),
        "@:21: tables: has 1001 entries, expected at most 1000",
    ),
    "range": (
        STUDY + FIGURE + "x_range = [nan, 1.0]\n" + CURVE,
        "@:27: figures.0.panels.0.x_range.0: got nan: ",
    ),
    "no range": (
        STUDY + FIGURE + "y_range = [1.0, 1.0]\n" + CURVE,
        "@:27: figures.0.panels.0.y_range: got [1.0, 1.0], expected two different numbers, none beyond 1e+30",
    ),
    "far range": (
        STUDY + FIGURE + "y_range = [1.0, 1e300]\n" + CURVE,
        "@:27: figures.0.panels.0.y_range: got [1.0, 1e+300], expected two different numbers, none beyond 1e+30",
    ),
    "a text": (
        STUDY + FIGURE.replace('"x"', f'"{"x" * 401}"') + CURVE,
        "@:25: figures.0.panels.0.x_label: has 401 characters on 1 lines, expected at most 400 on 8",
    ),
    "harmonics": (
        changed('kind = "sine"', 'kind = "multisine"\nharmonics = [1000000000000]'),
        "@:15: references.sine.harmonics.0: got 1000000000000: ",
    ),
    "a reference": (
        changed('frequency = "2 Hz"', 'frequency = "1e200 Hz"'),
        "@:13: references.sine: grows beyond all numbers within 1 s; expected less, or slower",
    ),
    "a rotation": (
        changed("rpm = [0, 460]", "rpm = [1e300]"),
        "@:2: plant: no number can hold where this machine rests: a value of it, or its rotation, is too large",
    ),
    "a name of a file": (STUDY + TABLE.format("x" * 300), "@:22: tables.0.name: got 't"),
    "a hidden file": (STUDY + TABLE.replace("t{}", ".."), "@:22: tables.0.name: got '..': "),
    "a unit": (
        changed('"5 mm"', '"5 m**9**9**9"'),
        '@:15: references.sine.amplitude: got "5 m**9**9**9", which is not a number with a unit; ',
    ),
}


@pytest.mark.parametrize("limit", LIMITS)
def test_it_is_refused(tmp_path: Path, limit: str) -> None:
    text, expected = LIMITS[limit]
    found = said(tmp_path, text)
    assert (found[: len(expected)] if expected.endswith((" ", "'t")) else found) == expected


def test_a_million_cases_are_not_too_many(tmp_path: Path) -> None:
    """They pass the count; the values of the last axis are then refused."""
    text = changed("rpm = [0, 460]", f"rpm = {axis(1000)}\n'plant.scale.mass' = {axis(1000)}\nnothing = [0]")
    assert said(tmp_path, text).startswith("@:9: axes.nothing: unknown axis; ")


def test_a_step_that_no_method_takes_is_no_limit(tmp_path: Path) -> None:
    """The step that a study does not name counts for nothing, however long the run."""
    path = tmp_path / "study.toml"
    path.write_text(changed('duration = "1 s"', 'duration = "2e7 s"\nsample_time = "1 s"'), encoding="utf-8")
    assert plan(read_study(path)).simulated_seconds == 4e7


def test_a_mass_of_nothing_is_told_without_a_word_of_numpy(tmp_path: Path) -> None:
    answer = workbench("check", write(tmp_path, changed("[axes]", "scale = { mass = 0.0 }\n[axes]")))
    assert answer.code == 0
    assert "its rates at rest are no numbers: expected nothing to be 0" in answer.err


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes")
@pytest.mark.parametrize(
    ("before", "after"),
    [
        ('"owen2001_simulation"', '"pipe.toml"'),
        ('type = "pid"', 'gains = "pipe"'),
        (
            'kind = "sine"\namplitude = "5 mm"\nfrequency = "2 Hz"',
            'kind = "recorded"\nfile = "pipe"\ntime = "t"\nvalue = "x"',
        ),
    ],
)
def test_a_pipe_is_no_file(tmp_path: Path, before: str, after: str) -> None:
    """Reading it would never end."""
    for name in ("pipe", "pipe.toml"):
        os.mkfifo(tmp_path / name)
    answer = workbench("check", write(tmp_path, changed(before, after)))
    assert answer.code == 2
    assert "is a pipe or a device, expected a file" in answer.err
