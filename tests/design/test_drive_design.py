"""A design for a drive, which no fluid moves: its plain loop, and what its parameters make up for."""

import json
from pathlib import Path
from unittest import mock

import pytest
from command import workbench, write
from declared_parameters import write_declared

from plants.effects.scales import PITCHES
from plants.registry import plants
from workbench.design import design, power, search
from workbench.design.asked import asked_of
from workbench.design.declared import _asked_sizes, hypotheses_of
from workbench.design.design import SPARE
from workbench.design.hypotheses import Hypothesis
from workbench.records.experiment import read_experiment

EXPERIMENT = """\
title = "A drive, before its first record"
[plant]
model = "drive_force"
parameters = "drive.toml"
[channels]
time = { column = "t", unit = "s" }
force = { column = "u", unit = "N" }
position = { column = "x", unit = "mm" }
[[records]]
file = "not_there_yet.csv"
[design]
between = ["none", "quadratic_drag"]
sizes = { drag_coefficient = "0.05 N s^2/m^2" }
duration = "4 s"
sample_time = "4 ms"
noise = { position = "20 um" }
limits = { low = "-30 mm", high = "30 mm", speed = "120 mm/s" }
"""

SIZES = 'cogging_cosine = "20 mN"'

VALUES = {
    "mass": 0.83,
    "load_force": 0.0,
    "coulomb": 2.1,
    "stribeck": 0.9,
    "stribeck_velocity": 8e-3,
    "viscous": 11.0,
    "bristle_stiffness": 4e4,
    "bristle_damping": 60.0,
    "end_stop_stiffness": 0.0,
    "end_stop_damping": 0.0,
}


def test_what_viscous_friction_makes_up_for_is_not_told(tmp_path: Path) -> None:
    """0.05 N s^2/m^2 at 0.1 m/s are 0.5 mN, beside 1.1 N of viscous friction that is not known; none comes first."""
    write_declared(tmp_path / "drive.toml", plants()["drive_force"], VALUES)
    path = write(tmp_path, EXPERIMENT, "experiment.toml")
    with mock.patch.object(search, "TRIALS", (8, 8)):
        answer = workbench("design", path, "--out", tmp_path / "out")
    assert answer.code == 2
    assert "no motion within the rig's limits tells nothing missing and quadratic drag apart" in answer.err
    assert "after its refit no rival is off by more than 0.0" in answer.err
    assert not (tmp_path / "out").exists()


def test_a_size_by_a_plain_name_is_that_of_both_directions() -> None:
    known = ("valve_overlap", "valve_overlap_negative")
    assert _asked_sizes({"valve_overlap": 1e-6}, known) == dict.fromkeys(known, 1e-6)
    both = {"valve_overlap": 1e-6, "valve_overlap_negative": 2e-6}
    assert _asked_sizes(both, known) == both


def with_cogging(folder: Path, sizes: str = SIZES) -> Path:
    """The drive's experiment with cogging of some sizes in the place of a drag."""
    write_declared(folder / "drive.toml", plants()["drive_force"], VALUES)
    text = EXPERIMENT.replace('"quadratic_drag"', '"cogging"').replace('drag_coefficient = "0.05 N s^2/m^2"', sizes)
    return write(folder, text.replace('sample_time = "4 ms"', 'sample_time = "10 ms"'), "experiment.toml")


REACH = 2.0 * 30e-3 * SPARE
"""m: as far as the drive goes."""


def cogging_of(path: Path) -> Hypothesis:
    """The hypothesis of an experiment."""
    experiment = read_experiment(path)
    asked, channels = asked_of(experiment, (), (), None), ("time", "force", "position")
    return hypotheses_of(experiment, asked, channels, (REACH, 0.1, 4e-3))[1]


def test_a_pitch_that_nobody_knows_is_counted_in_three_sizes(tmp_path: Path) -> None:
    """One that is said is the only one."""
    several = cogging_of(with_cogging(tmp_path))
    pitches = [each.values["cogging_pitch"] for each in (several, *several.others)]
    assert pitches == pytest.approx([REACH * PITCHES[2], REACH * PITCHES[0], REACH * PITCHES[-1]])
    alone = cogging_of(with_cogging(tmp_path, f'{SIZES}, cogging_pitch = "10 mm"'))
    assert alone.values["cogging_pitch"] == pytest.approx(0.01)
    assert alone.others == ()


@pytest.mark.thorough
def test_the_power_is_told_for_each_pitch(tmp_path: Path, dots_alone: None) -> None:
    """And the page says which."""
    path = with_cogging(tmp_path)
    with (
        mock.patch.object(search, "TRIALS", (4, 4)),
        mock.patch.object(design, "COMPARED", 0),
        mock.patch.object(power, "MACHINES", 1),
    ):
        assert workbench("design", path, "--out", tmp_path / "out").code == 0
    none, cogging = json.loads((tmp_path / "out" / "design.json").read_text(encoding="utf-8"))["hypotheses"]
    assert [shape["cogging_pitch"] for shape in cogging["shapes"]] == pytest.approx(
        [REACH * PITCHES[2], REACH * PITCHES[0], REACH * PITCHES[-1]]
    )
    assert none["shapes"] == []
    page = (tmp_path / "out" / "design.html").read_text(encoding="utf-8")
    assert "mean over them: cogging pitch 5.70 mm, cogging pitch 0.570 mm or cogging pitch 57.0 mm." in page
