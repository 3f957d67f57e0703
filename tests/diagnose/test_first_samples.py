"""Where a record begins: a start that goes farther than its sensors allow makes up for what the plant lacks."""

from dataclasses import replace

import numpy as np
import pytest
from driven import driven_shooting

from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.simulation.first_samples import sensed_at_first
from workbench.diagnose.simulation.fits import Fitting, begun
from workbench.diagnose.simulation.nearer import freely
from workbench.diagnose.simulation.setup import AWAY
from workbench.diagnose.simulation.shooting import Shooting

FINE = 1e-8
"""m. Noise of a position sensor beside which no plant is right."""


@pytest.fixture(scope="module")
def fine(tmp_path_factory: pytest.TempPathFactory) -> tuple[Shooting, list[Motion], dict[str, float]]:
    """6 s of a mass whose position a fine sensor shows."""
    return driven_shooting(tmp_path_factory.mktemp("fine"), FINE, 6.0)


@pytest.mark.parametrize(
    ("noise", "within"),
    [(0.0, 1e-4), (1e-8, 1e-3), (1e-5, 0.05)],
)
def test_the_velocity_at_the_first_sample_is_that_of_its_neighbours(
    fine: tuple[Shooting, list[Motion], dict[str, float]], noise: float, within: float
) -> None:
    """x = 0.02 t + 1.4 t^2 - 3 t^3: within 50 ms the velocity becomes eight times as much."""
    (motion,) = fine[1]
    time = motion.record.time
    position = 0.02 * time + 1.4 * time**2 - 3.0 * time**3
    position = position + noise * np.random.default_rng(2).standard_normal(time.size)
    made = replace(motion, measured={**motion.measured, "position": position}, sensed={"position": noise})
    first, velocity = sensed_at_first(made)
    assert first == position[0]
    assert velocity == pytest.approx(0.02, abs=within)


def test_a_plant_far_from_noise_runs_freely_from_what_its_sensors_show(
    fine: tuple[Shooting, list[Motion], dict[str, float]],
) -> None:
    how, motions, declared = fine
    (motion,) = motions
    wrong = {**declared, "viscous": 1.5 * declared["viscous"], "coulomb": 0.8 * declared["coulomb"]}
    assert Fitting(motions, (), {}).begun(how, wrong).is_astray
    (begins,) = begun(how, motions, wrong).begins.values()
    places = [how.along.names.index(name) for name in ("position", "velocity")]
    position, velocity = sensed_at_first(motion)
    assert begins[0, places] == pytest.approx([position - motion.position[0], velocity - motion.velocity[0]], abs=1e-15)
    assert np.count_nonzero(begins) <= 2, "no other state is moved"


def test_the_parameters_of_a_free_run_are_those_that_leave_least(
    fine: tuple[Shooting, list[Motion], dict[str, float]],
) -> None:
    """With half of its viscous friction unknown to the fit, no other coulomb friction leaves less."""
    how, motions, declared = fine
    wrong = {**declared, "viscous": 0.5 * declared["viscous"]}
    found = freely(Fitting(motions, ("coulomb",), {}), how, wrong)
    balance = how.as_sensed(motions).balance(motions, ())
    for factor in (0.99, 1.01):
        beside = {**found.values, "coulomb": factor * found.values["coulomb"]}
        assert np.mean(balance.stacked(beside) ** 2) > found.rms**2


def test_a_simulation_that_leaves_its_record_is_over(fine: tuple[Shooting, list[Motion], dict[str, float]]) -> None:
    """A negative spring takes the mass away ever faster; what is stiff would take ever shorter steps."""
    how, (motion,), declared = fine
    pushed = {**declared, "spring_stiffness": -10.0 * declared["viscous"], "end_stop_stiffness": 0.0}
    (_, run), *_ = how.runs(motion, pushed)
    assert run.outcome == "diverged"
    farthest = AWAY * np.max(np.abs(motion.measured["position"]))
    assert farthest < np.max(np.abs(run.state("position"))) * 1.1 < 3.0 * farthest
