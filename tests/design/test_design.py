"""A design from an experiment file: what it writes, that it keeps the rig's limits, and what it refuses."""

import json
import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pandas as pd
import pytest
from command import workbench, write

from workbench.design import design, power, search
from workbench.design.search import ODDS
from workbench.publish.contents import read_contents
from workbench.toml.reading import read_toml

EXPERIMENT = """\
title = "A rig, before its first record"
[plant]
model = "non_rotating"
parameters = "owen2001_simulation"
[channels]
time = { column = "t", unit = "s" }
valve_voltage = { column = "u", unit = "V" }
position = { column = "x", unit = "mm" }
pressure_1 = { column = "pA", unit = "bar" }
pressure_2 = { column = "pB", unit = "bar" }
[[records]]
file = "not_there_yet.csv"
[design]
between = ["valve_deadband", "none"]
identify = ["viscous"]
sizes = { valve_overlap = "1 um", valve_overlap_negative = "1 um" }
duration = "4 s"
noise = { position = "5 um", pressure_1 = "2 kPa", pressure_2 = "2 kPa" }
[design.limits]
low = "-20 mm"
high = "20 mm"
speed = "50 mm/s"
"""


@pytest.fixture(scope="module")
def experiment(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return write(tmp_path_factory.mktemp("design"), EXPERIMENT, "experiment.toml")


@contextmanager
def quick() -> Iterator[None]:
    """A design with few pieces tried, one motion as a whole, and one machine drawn beside the declared one."""
    with (
        mock.patch.object(search, "TRIALS", (6, 6)),
        mock.patch.object(design, "COMPARED", 0),
        mock.patch.object(power, "MACHINES", 1),
    ):
        yield


@pytest.fixture(scope="module")
def designed(experiment: Path, dots_alone: None) -> tuple[Any, Path]:
    """What the command answers to a quick design, and its folder."""
    out = experiment.parent / "out"
    with quick():
        return workbench("design", experiment, "--out", out), out


def said(designed: tuple[Any, Path]) -> dict[str, Any]:
    return json.loads((designed[1] / "design.json").read_text(encoding="utf-8"))


def test_the_folder_holds_the_motion_a_study_and_a_page(designed: tuple[Any, Path]) -> None:
    answer, out = designed
    assert answer.code == 0, answer.err
    assert {item.name for item in out.iterdir()} == {
        "design.json", "design.html", "study.toml", "reference.csv", "hypothesis_1.toml", "hypothesis_2.toml",
        "tables", "figures", "contents.json",
    }  # fmt: skip
    contents = read_contents(out)
    assert contents.answer[0].startswith("Record 4 s: ")
    assert contents.answer[0] in answer.out
    assert contents.answer[0] in (out / "design.html").read_text(encoding="utf-8")


def test_the_reference_is_sampled_as_the_rig_is_and_keeps_its_limits(designed: tuple[Any, Path]) -> None:
    table = pd.read_csv(designed[1] / "reference.csv")
    assert list(table.columns) == ["time_s", "position_m"]
    assert np.diff(table["time_s"]) == pytest.approx(1e-3)
    assert table["time_s"].iloc[-1] == pytest.approx(4.0)
    assert table["position_m"].abs().max() <= 0.02
    assert table["position_m"].iloc[[0, -1]].tolist() == pytest.approx([0.0, 0.0], abs=1e-9)


def test_an_overlap_is_told_from_none_and_none_is_not_taken_for_one(designed: tuple[Any, Path]) -> None:
    pairs = {(one["true"], one["rival"]): one for one in said(designed)["told_apart"]}
    overlap = pairs["valve deadband", "nothing missing"]
    assert overlap["distance"] > np.sqrt(ODDS)
    assert 0.0 <= overlap["low"] <= overlap["power"] <= overlap["high"] <= 1.0
    assert pairs["nothing missing", "valve deadband"]["power"] > 0.9


def test_what_was_to_be_identified_is_known_better(designed: tuple[Any, Path]) -> None:
    (viscous,) = said(designed)["parameters"]
    assert viscous["name"] == "viscous"
    assert viscous["std_after"] < 0.5 * viscous["std_before"]


def test_the_study_runs_every_hypothesis(designed: tuple[Any, Path]) -> None:
    _, out = designed
    study = read_toml(out / "study.toml")[0]
    plants = ["hypothesis_1.toml", "hypothesis_2.toml"]
    assert study["cases"]["reference"]["axes"] == {"plant.parameters": plants, "reference": ["reference"]}
    answer = workbench("run", out / "study.toml", "--out", out.parent / "run", "--dry-run")
    assert answer.code == 0, answer.err
    assert "2 cases, 8 s of simulated time" in answer.out
    overlaps = [read_toml(out / name)[0]["parameters"].get("valve_overlap") for name in plants]
    assert overlaps[0]["value"] == "1e-06 m"
    assert overlaps[1]["value"] == "0 m"


@pytest.mark.thorough
def test_the_same_experiment_gives_the_same_motion(designed: tuple[Any, Path], experiment: Path) -> None:
    again = experiment.parent / "again"
    with quick():
        assert workbench("design", experiment, "--out", again).code == 0
    for name in ("design.json", "reference.csv", "study.toml"):
        assert (again / name).read_bytes() == (designed[1] / name).read_bytes(), name


@pytest.mark.parametrize(
    ("replaced", "by", "options", "expected"),
    [
        ("", "", ["--between", "backlsh,none"], '"backlsh": no effect that the channels'),
        ("", "", ["--identify", "viscos"], '--identify "viscos": unknown parameter; did you mean "viscous"?'),
        ("", "", ["--between", ",".join(["none"] * 7)], "7 hypotheses are held against each other, expected 6 at most"),
        ("", "", ["--duration", "1 s"], "duration: got 1 s, expected 4 s to 600 s"),
        ("", "", ["--duration", "long"], "--duration: "),
        (
            'low = "-20 mm"',
            'low = "30 mm"',
            [],
            "design.limits.low: got 0.03 for low and 0.02 for high",
        ),
        ('speed = "50 mm/s"', 'speed = "-1 mm/s"', [], "design.limits.speed: got -0.001, expected a value above 0"),
        ('speed = "50 mm/s"', 'speed = "1 nm/s"', [], "no piece of a motion keeps the rig's limits"),
        ('speed = "50 mm/s"', "", [], "nothing tells how fast the mass may move; give [design.limits] speed"),
        ("noise = {", "sounds = {", [], "unknown key"),
        ('position = "5 um", ', "", [], "no record is there to tell the sensors' noise"),
        ('identify = ["viscous"]', "rpm = [460]", [], "plant non_rotating does not turn"),
    ],
)
def test_what_cannot_be_designed_is_told_in_few_lines(
    experiment: Path, tmp_path: Path, replaced: str, by: str, options: list[str], expected: str
) -> None:
    path = write(tmp_path, EXPERIMENT.replace(replaced, by, 1), "experiment.toml")
    with mock.patch.object(search, "TRIALS", (4, 4)):
        answer = workbench("design", path, "--out", tmp_path / "out", *options)
    assert answer.code == 2
    assert expected in answer.err
    assert len(answer.err.strip().splitlines()) <= 3
    assert os.listdir(tmp_path) == ["experiment.toml"], "nothing is half-written"


def test_a_folder_that_is_no_diagnosis_is_refused(tmp_path: Path) -> None:
    answer = workbench("design", tmp_path, "--out", tmp_path / "out")
    assert answer.code == 2
    assert "is no diagnosis: it holds no report.json" in answer.err
    write(tmp_path, "{}", "report.json")
    answer = workbench("design", tmp_path, "--out", tmp_path / "out")
    assert "is not what workbench diagnose writes" in answer.err
    assert os.listdir(tmp_path) == ["report.json"]
