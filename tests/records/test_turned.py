"""Experiments of machines whose rod turns, by a key."""

from pathlib import Path

import pytest
from command import write

from workbench.errors import UserError
from workbench.records.experiment import Experiment, read_experiment


def experiment(tmp_path: Path, plant: str) -> Experiment:
    text = f"""title = "turned"
[plant]
parameters = "owen2001_experiment"
{plant}
[channels]
time = {{ column = "t", unit = "s" }}
position = {{ column = "x", unit = "mm" }}
[[records]]
file = "one.csv"
"""
    return read_experiment(write(tmp_path, text, "experiment.toml"))


def test_a_cylinder_s_rod_turns_by_a_key(tmp_path: Path) -> None:
    turned = experiment(tmp_path, 'model = "cylinder"\nturned = "rod"\nbristle = "anisotropic"\nrotation = "ideal"')
    assert turned.plant.name == "rotating_cylinder_anisotropic_ideal"
    assert turned.plant.rotary_command == "surface_speed"


def test_a_plant_without_a_rod_that_turns_is_told_so(tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r'plant\.turned: plant "rotating_isotropic" has no rod that turns'):
        experiment(tmp_path, 'model = "rotating_isotropic"\nturned = "rod"')
