"""A force that a sensor shows drives a plant that is kept beside its record: friction is found, and what is missing."""

from pathlib import Path

import numpy as np
import pytest
from driven import TRUE, driven_experiment
from scipy.linalg import expm, solve_discrete_are

from workbench.diagnose.diagnose import diagnose
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.fit import fit, weighing_at
from workbench.diagnose.residuals.motion import THINNED, Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.selection.likelihood import Left, gained
from workbench.diagnose.simulation.beside import Followed, riccati
from workbench.diagnose.simulation.filters import filtered
from workbench.diagnose.simulation.setup import as_simulated, shooting_of
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.reading import read_records

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
    (motion,) = diagnosis.results[0].balance.motions
    whole = diagnosis.simulation.along(diagnosis.experiment, [motion])
    assert isinstance(whole.setups[motion.record].reference, Followed)  # by what was found, as the errors are told
    assert diagnosis.errors.fit.after.position is not None
    assert diagnosis.errors.fit.after.position < 1.5 * NOISE
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


def true_values(experiment: Experiment) -> Values:
    """What is declared, with the friction that is true."""
    return {**declared_values(experiment), "coulomb": TRUE["coulomb"]}


def gain_of_a_compliance(experiment: Experiment, motions: list[Motion]) -> float:
    """What a load behind a spring that is not there gains in the logarithm of the likelihood."""
    how = shooting_of(experiment, motions, held=False)
    assert how is not None
    values = true_values(experiment)
    how, noise = filtered(how, motions, values), motions[0].sensed
    balance = how.balance(motions, ())

    def left(changed: Values) -> Left:
        fitted = fit(balance, changed, ())
        return weighing_at(fitted), fitted.residual

    frequency = 1.5 * np.sqrt(noise["force"] / (TRUE["mass"] * noise["position"])) / (2.0 * np.pi)
    return gained(balance, left({**values, "compliant_share": 0.3, "compliant_frequency": frequency}), left(values))


def test_a_compliance_that_is_not_there_gains_no_more_than_noise_would(tmp_path: Path) -> None:
    experiment = read_experiment(driven_experiment(tmp_path, 0.0, 2e-5, DURATION, 44.0, STROKE))
    motions = motions_of(experiment, read_records(experiment))
    whole = as_simulated(experiment, motions)
    assert (motions[0].thinning, whole[0].thinning, whole[0].grain) == (10, 1, 10)
    assert motions[0].thinning * motions[0].sample_time == pytest.approx(THINNED)
    for looked_at in (motions, whole):
        assert gain_of_a_compliance(experiment, looked_at) < np.log(20.0)  # in one of twenty, at most (Wald 1945)


def test_a_plant_that_its_command_drives_is_looked_at_by_means(tmp_path: Path) -> None:
    experiment = read_experiment(driven_experiment(tmp_path, 0.0, NOISE, 3.0))
    (motion,) = as_simulated(experiment, motions_of(experiment, read_records(experiment)))
    assert (motion.finer, motion.thinning) == (1, 10)


def following(experiment: Experiment, motions: list[Motion]) -> Followed:
    """The filter that keeps the plant beside the first record, with the friction that is true."""
    how = shooting_of(experiment, motions, held=False)
    assert how is not None
    followed = filtered(how, motions, true_values(experiment)).setups[motions[0].record].reference
    assert isinstance(followed, Followed)
    return followed


def test_a_filter_corrects_what_slides_as_that_of_a_mass_with_its_friction_does(tmp_path: Path) -> None:
    experiment = read_experiment(driven_experiment(tmp_path, 0.0, NOISE, DURATION, SENSOR, STROKE))
    (motion,) = as_simulated(experiment, motions_of(experiment, read_records(experiment)))
    followed, step = following(experiment, [motion]), motion.sample_time
    assert followed.corrected == ("position", "velocity", "bristle_deflection")
    sliding = int(np.argmax(np.abs(motion.velocity)))
    rates = np.array([[0.0, 1.0], [0.0, -TRUE["viscous"] / TRUE["mass"]]])
    moved, push = expm(step * rates), step * np.array([0.0, motion.sensed["force"] / TRUE["mass"]])
    seen = np.array([[1.0, 0.0]])
    variance = solve_discrete_are(
        moved.T, seen.T, np.outer(push, push) + 1e-30 * np.eye(2), np.array([[motion.sensed["position"] ** 2]])
    )
    innovation = variance[0, 0] + motion.sensed["position"] ** 2
    wanted = moved @ variance[:, 0] / innovation / step
    assert followed.corrections[sliding, :2] == pytest.approx(wanted, rel=0.1)
    assert followed.spread[sliding] == pytest.approx(np.sqrt(innovation) / motion.sensed["position"], rel=0.02)
    assert followed.tells[sliding]


def test_a_rest_tells_nothing_and_what_goes_on_does(tmp_path: Path) -> None:
    experiment = read_experiment(driven_experiment(tmp_path, 0.0, NOISE, DURATION, SENSOR, STROKE))
    (motion,) = as_simulated(experiment, motions_of(experiment, read_records(experiment)))
    tells, speed = following(experiment, [motion]).tells, np.abs(motion.velocity)
    assert np.all(tells[speed > 0.2 * np.max(speed)])
    assert not np.all(tells)


def test_what_is_not_known_of_a_rest_grows_with_it() -> None:
    count, step, noise = 400, 1e-3, 1e-6
    moved = np.tile(np.eye(2) + step * np.array([[0.0, 1.0], [0.0, -50.0]]), (count, 1, 1))
    pushed = np.tile([0.0, 1e-5], (count, 1))
    speed = np.where(np.arange(count) < 200, 1.0, 0.0)
    _, spread, tells = riccati(moved, pushed, noise, speed, step)
    assert np.all(tells[:200])
    assert not np.any(tells[200:])
    assert np.all(np.diff(spread[200:]) > 0.0)
    assert spread[150] == pytest.approx(spread[199])


def test_a_followed_position_goes_on_from_a_time_with_its_gains() -> None:
    time = 1e-3 * np.arange(101)
    gains, ones = np.column_stack([time, 2.0 * time]), np.ones(time.size)
    followed = Followed(time, 2.0 * time, time, ("position", "velocity"), gains, ones, ones > 0.0)
    position, velocity, acceleration = followed(time)
    assert position == pytest.approx(2.0 * time)
    assert not np.any(velocity)
    assert not np.any(acceleration)
    later = followed.since(0.05)
    assert later(time[:50])[0] == pytest.approx(2.0 * (time[:50] + 0.05))
    first, second = later.feeds
    assert (first.input, second.input) == ("gain_of_position", "gain_of_velocity")
    assert second.signal(time[:50])[0] == pytest.approx(2.0 * (time[:50] + 0.05))
