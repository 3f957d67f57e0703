"""The motor in words: its constants, what they leave open, its limits, and what a run asks of it beyond them."""

from pathlib import Path

import numpy as np
from command import STUDY, write

from plants.motor import LIMITS, Motor
from plants.registry import plants
from workbench.compare.report.motor import motor_in_words
from workbench.compare.report.page import motors
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.study.reading import read_study

VALUES = read_parameters(named_sets()["owen2001_experiment"])


def motor(**changes: float) -> Motor:
    built: Motor = build(plants()["rotating_isotropic"].Parameters, {**VALUES, **changes}).motor
    return built


def test_the_printed_motor() -> None:
    """0.6685 / 0.77 is 13 % less; 30 A of 0.77 N m/A are 23.1 N m; 208 V three-phase, rectified, 294 V."""
    assert motor_in_words(motor()) == (
        "The motor's constants as printed, K_t 0.77 N m/A and K_bemf 0.6685 V s/rad: apart from the winding's loss its "
        "terminals take 13 % less power than reaches the rod. Its limits: 23.1 N m (30 A) at most, 294 V, 500 rpm; "
        "8 N m for ever."
    )


def test_a_consistent_motor_without_limits() -> None:
    free = motor(back_emf_constant=0.77, motor_nominal_torque=np.inf, **dict.fromkeys(LIMITS, np.inf))
    assert motor_in_words(free) == (
        "A power-consistent motor, K_t 0.77 N m/A and K_bemf 0.77 V s/rad: what enters at its terminals is shaft power "
        "and loss. Its limits: none."
    )


def test_a_set_that_knows_no_limits_has_none() -> None:
    """Parameter files and corrected plants of before."""
    old = {name: value for name, value in VALUES.items() if name not in (*LIMITS, "motor_nominal_torque")}
    built = build(plants()["rotating_anisotropic"].Parameters, old).motor
    assert all(np.isinf(getattr(built, name)) for name in (*LIMITS, "motor_nominal_torque"))


def test_the_page_of_results_needs_no_gain_files(tmp_path: Path) -> None:
    """A folder of results holds its study, not the files of gains that it names."""
    text = STUDY.replace('type = "pid"\nkp = "500 V/m"', 'gains = "not_here.toml"')
    assert text != STUDY
    (words,) = motors(read_study(write(tmp_path, text)))
    assert words.startswith("The motor's constants as printed")
