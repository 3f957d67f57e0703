"""A force that a sensor shows drives a plant that is kept beside its record: friction is found, and what is missing."""

from pathlib import Path

import numpy as np
import pytest
from driven import TRUE, driven_experiment
from scipy.linalg import expm, solve_discrete_are

from plants.equation import fields, replaced, to_array
from plants.interface import Measurement
from plants.observed import corrected
from plants.registry import plants
from workbench.diagnose.diagnose import diagnose
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.fit import fit, weighing_at
from workbench.diagnose.residuals.motion import THINNED, Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.selection.likelihood import Left, gained
from workbench.diagnose.simulation import setup
from workbench.diagnose.simulation.beside import Followed
from workbench.diagnose.simulation.filters import filtered, least_doubt
from workbench.diagnose.simulation.kalman import over_sample, pushed_over_sample
from workbench.diagnose.simulation.setup import as_simulated, shooting_of
from workbench.parameters.sets import build
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.reading import read_records
from workbench.simulation.compilation import plant_addresses

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
        return weighing_at(fitted), fitted.residual, 0.0

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


@pytest.mark.parametrize(("many", "thinning"), [(setup.MANY, 1), (1000, 10)])
def test_a_plant_that_its_command_drives_is_looked_at_by_means_where_samples_are_many(
    many: int, thinning: int, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    experiment = read_experiment(driven_experiment(tmp_path, 0.0, NOISE, 3.0))
    monkeypatch.setattr(setup, "MANY", many)
    (motion,) = as_simulated(experiment, motions_of(experiment, read_records(experiment)))
    assert motion.thinning == thinning


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


def test_what_the_filter_does_not_foresee_is_as_large_as_it_says(tmp_path: Path) -> None:
    """Under way, at rest, where a contact breaks away, and from the first sample on, where its velocity is not known.

    Over its standard deviation white noise of that many samples has an rms of 1 within 1/sqrt(2 n) and none beyond 5;
    the sensors' deviations are themselves estimated from the record, to a few parts in a hundred.
    """
    experiment = read_experiment(driven_experiment(tmp_path, 0.0, NOISE, DURATION, SENSOR, STROKE))
    motions = as_simulated(experiment, motions_of(experiment, read_records(experiment)))
    (motion,), values = motions, true_values(experiment)
    how = shooting_of(experiment, motions, held=False)
    assert how is not None
    how = filtered(how, motions, values)
    ((_, run),) = how.runs(motion, values)
    followed = how.setups[motion.record].reference
    assert isinstance(followed, Followed)
    error = motion.measured["position"] - run.measurements[:, Measurement._fields.index("position")]
    off = error / followed.spread / motion.sensed["position"]
    slow = np.abs(motion.velocity) < 0.02 * np.max(np.abs(motion.velocity))
    assert np.count_nonzero(slow) > 100
    assert np.max(np.abs(off)) < 5.0
    assert np.sqrt(np.mean(off**2)) == pytest.approx(1.0, abs=0.06)
    assert np.sqrt(np.mean(off[slow] ** 2)) == pytest.approx(1.0, abs=0.15)


def test_a_filter_whose_plant_is_far_off_doubts_its_force(tmp_path: Path) -> None:
    experiment = read_experiment(driven_experiment(tmp_path, 0.0, NOISE, DURATION, SENSOR, STROKE))
    motions = as_simulated(experiment, motions_of(experiment, read_records(experiment)))
    how = shooting_of(experiment, motions, held=False)
    assert how is not None
    assert least_doubt(how, motions, true_values(experiment)) == 1.0
    assert least_doubt(how, motions, declared_values(experiment)) > 10.0


@pytest.mark.parametrize("both_ways", [False, True])
def test_where_a_state_goes_within_a_sample_is_that_of_the_matrix_exponential(both_ways: bool) -> None:
    """Of a drive that slides fast and far from breaking away its equations are as good as linear."""
    plant = plants()["drive_force"]
    parameters = build(plant.Parameters, TRUE)
    state, inputs = plant.equilibrium(parameters, 0.0)
    speed, span = 0.5, 1e-3
    names = [item.name for item in fields(plant.State)]
    places = np.array([names.index(name) for name in corrected(plant)])
    level = TRUE["coulomb"] / TRUE["bristle_stiffness"]
    start = to_array(replaced(state, {"velocity": speed, "bristle_deflection": level}))
    given = to_array(inputs._replace(**{plant.command: TRUE["coulomb"] + TRUE["viscous"] * speed}))
    sampling = (
        plant_addresses(plant)[0],
        to_array(parameters),
        places,
        1e-6 * np.array([0.1, speed, level]),
        plant.input_index(plant.command),
        1e-3,
        span,
        64,
    )
    moved, held = over_sample(sampling, 0.0, start, given, both_ways)
    pushed = pushed_over_sample(sampling, 0.0, start, given)
    mass, stiffness, damping = (TRUE[name] for name in ("mass", "bristle_stiffness", "bristle_damping"))
    relaxes = stiffness * speed / TRUE["coulomb"]
    rates = np.array(
        [
            [0.0, 1.0, 0.0],
            [0.0, -TRUE["viscous"] / mass, (damping * relaxes - stiffness) / mass],
            [0.0, 0.0, -relaxes],
        ]
    )
    both = np.block([[rates, np.eye(3)], [np.zeros((3, 6))]])
    wanted = expm(span * both)
    assert moved[:2, :2] == pytest.approx(wanted[:2, :2], rel=1e-3, abs=1e-6)
    assert held[:2, :2] == pytest.approx(wanted[:2, 3:5], rel=1e-3, abs=1e-9)
    assert pushed[1] == pytest.approx(wanted[1, 4] / mass, rel=1e-3)


def test_a_followed_position_goes_on_from_a_time_with_its_gains() -> None:
    time = 1e-3 * np.arange(101)
    gains = np.column_stack([time, 2.0 * time])
    followed = Followed(time, 2.0 * time, time, ("position", "velocity"), gains, np.ones(time.size))
    position, velocity, acceleration = followed(time)
    assert position == pytest.approx(2.0 * time)
    assert not np.any(velocity)
    assert not np.any(acceleration)
    later = followed.since(0.05)
    assert later(time[:50])[0] == pytest.approx(2.0 * (time[:50] + 0.05))
    first, second = later.feeds
    assert (first.input, second.input) == ("gain_of_position", "gain_of_velocity")
    assert second.signal(time[:50])[0] == pytest.approx(2.0 * (time[:50] + 0.05))
