"""What a converter that counts in coarse steps leaves of a position that rests says nothing of the plant."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from driven import driven_experiment

from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.motion import UNIFORM, motion_of
from workbench.diagnose.simulation.counting import FINE, HARMONICS, is_coarse, over_steps
from workbench.diagnose.simulation.setup import shooting_of
from workbench.records.experiment import read_experiment
from workbench.records.reading import Record, read_records

STEP = 1e-3
"""m: of a converter."""


def record_of(position: np.ndarray) -> Record:
    """A record of a position at 1 kHz."""
    time = 1e-3 * np.arange(position.size)
    return Record("record", Path("record"), "fit", 0.0, time, {"position": position}, np.ones(time.size, dtype=bool))


def counted(values: np.ndarray, noise: float) -> np.ndarray:
    """What a converter gives for values with noise of a standard deviation in steps."""
    draw = np.random.default_rng(1)
    return np.asarray(STEP * np.rint(values / STEP + noise * draw.standard_normal(values.size)))


@pytest.mark.parametrize("noise", [1.0 / 6.0, 1.0 / 4.0])
def test_waves_over_a_step_are_the_mean_error_of_a_converter(noise: float) -> None:
    values = np.linspace(0.0, 20.0 * STEP, 400_000)
    motion = motion_of(record_of(counted(values, noise)))
    amplitudes, *_ = np.linalg.lstsq(over_steps(motion, "position", values), motion.measured["position"] - values)
    k = np.arange(1, HARMONICS + 1)
    sines = STEP / np.pi * (-1.0) ** k / k * np.exp(-2.0 * (np.pi * k * noise) ** 2)  # Widrow and Kollar 2008
    assert amplitudes.reshape(HARMONICS, 2)[:, 0] == pytest.approx(np.zeros(HARMONICS), abs=5e-3 * STEP)
    assert amplitudes.reshape(HARMONICS, 2)[:, 1] == pytest.approx(sines, abs=5e-3 * STEP)


def test_noise_makes_a_straight_line_of_steps_that_are_fine_beside_it() -> None:
    rests = np.zeros(4000)
    assert is_coarse(motion_of(record_of(counted(rests + 0.5 * STEP, 0.25))), "position")
    assert not is_coarse(motion_of(record_of(counted(rests + 0.5 * STEP, 1.0))), "position")
    assert not is_coarse(motion_of(record_of(np.random.default_rng(1).standard_normal(4000))), "position")
    left = np.exp(-2.0 * (np.pi * FINE) ** 2) / np.pi
    assert left == pytest.approx(0.0023, abs=1e-4)
    assert np.hypot(FINE, UNIFORM) == pytest.approx(0.577, abs=1e-3)


def test_a_coarse_position_says_nothing_over_its_steps(tmp_path: Path) -> None:
    path, noise = driven_experiment(tmp_path, 0.0, 0.0, 3.0), 0.2
    frame = pd.read_parquet(tmp_path / "record.parquet")
    frame["position"] = counted(frame["position"].to_numpy(), noise)
    frame.to_parquet(tmp_path / "record.parquet", index=False)
    experiment = read_experiment(path)
    motions, values = motions_of(experiment, read_records(experiment)), declared_values(experiment)
    how = shooting_of(experiment, motions, held=False)
    assert how is not None
    starting, _ = how.starting(motions, values)
    undecided, groups = how.undecided(motions, values)
    own = undecided[:, starting.shape[1] :]
    assert np.array_equal(undecided[:, : starting.shape[1]], starting)
    assert own.shape[1] == 2 * HARMONICS
    assert np.all(np.linalg.norm(own, axis=0) > 0.0)
    assert len(groups) == 1
    weighing = how.balance(motions, ()).beside(values)
    assert np.array_equal(weighing[0], undecided)
    pieces = replace(how, length=0.5)
    assert not np.any(pieces.undecided(motions, values)[0][:, starting.shape[1] :])
