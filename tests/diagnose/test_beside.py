"""A force that a sensor shows drives a plant that is kept beside its record: friction is found, and what is missing."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from driven import TRUE, driven_experiment

from workbench.diagnose.diagnose import diagnose
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.fit import fit, weighing_at
from workbench.diagnose.residuals.motion import THINNED, Motion, motion_of
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.selection.likelihood import Left, gained
from workbench.diagnose.simulation.beside import PASSING, Followed, held
from workbench.diagnose.simulation.setup import as_simulated, shooting_of
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.reading import Record, read_records

STIFFNESS = 2e4
"""N/m: of a spring that nobody declared."""

NOISE, SENSOR, DURATION = 2e-6, 1.0, 4.0
"""m, N: of both sensors; s."""

STROKE = 1.0
"""m: no end of it is reached without the spring."""


def test_a_plant_that_lacks_nothing_follows_and_its_friction_is_found(tmp_path: Path) -> None:
    diagnosis = diagnose(driven_experiment(tmp_path, 0.0, NOISE, DURATION, SENSOR, STROKE))
    assert (diagnosis.verdict, list(diagnosis.effects)) == ("none_missing", [])
    assert diagnosis.simulation is not None
    assert diagnosis.simulation.is_beside
    assert diagnosis.simulation.after.rms < 1.3  # standard deviations of the position's noise
    coulomb = diagnosis.fitted_parameters["coulomb"]
    assert coulomb.value == pytest.approx(TRUE["coulomb"], rel=0.02)
    assert abs(coulomb.value - TRUE["coulomb"]) < 3.0 * coulomb.std


@pytest.mark.thorough
def test_a_spring_that_nobody_declared_is_found(tmp_path: Path) -> None:
    diagnosis = diagnose(driven_experiment(tmp_path, STIFFNESS, NOISE, DURATION, SENSOR))
    (spring,) = diagnosis.effects
    assert spring.name == "spring_load"
    stiffness = spring.parameters["spring_stiffness"]
    assert stiffness.std is not None
    assert stiffness.value == pytest.approx(STIFFNESS, rel=0.02)
    assert diagnosis.simulation is not None
    assert diagnosis.simulation.to_json()["beside_the_record"]


def gain_of_a_compliance(experiment: Experiment, motions: list[Motion]) -> float:
    """What a load behind a spring that is not there gains in the logarithm of the likelihood."""
    how = shooting_of(experiment, motions, held=False)
    assert how is not None
    followed = how.setups[motions[0].record].reference
    assert isinstance(followed, Followed)
    values = {**declared_values(experiment), "coulomb": TRUE["coulomb"]}
    balance = how.balance(motions, ())

    def left(changed: Values) -> Left:
        fitted = fit(balance, changed, ())
        return weighing_at(fitted), fitted.residual

    frequency = 1.5 * followed.crossover / (2.0 * np.pi)
    return gained(balance, left({**values, "compliant_share": 0.3, "compliant_frequency": frequency}), left(values))


def test_a_compliance_that_quickens_the_loop_gains_by_means_and_costs_by_every_sample(tmp_path: Path) -> None:
    experiment = read_experiment(driven_experiment(tmp_path, 0.0, 2e-5, DURATION, 44.0, STROKE))
    motions = motions_of(experiment, read_records(experiment))
    whole = as_simulated(experiment, motions)
    assert (motions[0].thinning, whole[0].thinning, whole[0].grain) == (10, 1, 10)
    assert motions[0].thinning * motions[0].sample_time == pytest.approx(THINNED)
    assert gain_of_a_compliance(experiment, motions) > 0.0  # the error of slow frequencies alone
    assert gain_of_a_compliance(experiment, whole) < -5.0


def test_a_plant_that_its_command_drives_is_looked_at_by_means(tmp_path: Path) -> None:
    experiment = read_experiment(driven_experiment(tmp_path, 0.0, NOISE, 3.0))
    (motion,) = as_simulated(experiment, motions_of(experiment, read_records(experiment)))
    assert (motion.finer, motion.thinning) == (1, 10)


def test_a_long_rest_tells_nothing_and_turning_back_does() -> None:
    time = 1e-3 * np.arange(4001)
    moving = np.where(time < 1.0, np.sin(2.0 * np.pi * time), np.where(time > 2.0, np.sin(2.0 * np.pi * time), 0.0))
    channels = {"position": 1e-2 * moving, "force": moving}
    motion = motion_of(Record("record", Path("record"), "fit", 0.0, time, channels, np.ones(time.size, dtype=bool)))
    crossover = 100.0
    rests = held(motion, crossover)
    assert np.all(rests[1100:1900])
    assert not np.any(rests[2400:3900])  # it turns back in less than PASSING / crossover
    assert PASSING / crossover == pytest.approx(0.1)


def test_a_followed_position_has_its_differences_and_goes_on_from_a_time() -> None:
    time = 1e-3 * np.arange(101)
    followed = Followed(time, 2.0 * time, 1e-5, 100.0)
    position, velocity, acceleration = followed(time)
    assert position == pytest.approx(2.0 * time)
    assert velocity[1:] == pytest.approx(2.0)
    assert velocity[0] == 0.0  # as a differentiator at rest
    assert not np.any(acceleration)
    assert followed.since(0.05)(time[:50])[0] == pytest.approx(2.0 * (time[:50] + 0.05))
    assert replace(followed, time_constant=1e-3)(time)[1][1] < 2.0
