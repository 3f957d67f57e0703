"""Which method simulates a plant: what relaxes fast asks for an implicit one, what swings fast does not."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from driven import driven_experiment

from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.simulation.setup import shooting_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.stiffness import COARSE, STABLE, STIFF, method_for
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records
from workbench.simulation.simulate import Integrator, simulate


def driven(folder: Path) -> tuple[Shooting, Motion, dict[str, float]]:
    """How a mass that a force drives is simulated, its motion, and values with little friction."""
    experiment = read_experiment(driven_experiment(folder, 0.0, 1e-6, 4.0, stroke=1.0))
    (motion,) = motions_of(experiment, read_records(experiment))
    how = shooting_of(experiment, [motion])
    assert how is not None
    smooth = {"mass": 300.0, "coulomb": 10.0, "stribeck": 0.0, "viscous": 1000.0, "bristle_damping": 0.0}
    return how, motion, {**declared_values(experiment), **smooth}


def with_steps(motion: Motion, values: Values, steps: float) -> dict[str, float]:
    """Values with a bristle of which stability asks so many steps of a sample at the mean speed."""
    speed = float(np.mean(np.abs(motion.velocity)))
    return {**values, "bristle_stiffness": steps * STABLE * values["coulomb"] / speed / motion.record.sample_time}


def test_a_contact_whose_bristle_is_hardly_seen_is_stiff(tmp_path: Path) -> None:
    how, motion, values = driven(tmp_path)
    for share, method in ((0.9, "dormand_prince"), (1.1, "ros34pw2")):
        assert method_for(how.along, motion, with_steps(motion, values, share * STIFF), COARSE) == method


@pytest.mark.parametrize("changed", ["spring_stiffness", "mass"])
def test_what_swings_fast_is_not(tmp_path: Path, changed: str) -> None:
    """Where it swings by a radian in a sample, on a spring or on its bristles where it sticks, explicit steps are as
    long as any others.
    """
    how, motion, values = driven(tmp_path)
    stiff, step = with_steps(motion, values, 1.1 * STIFF), motion.record.sample_time
    swinging = {"spring_stiffness": stiff["mass"] / step**2, "mass": stiff["bristle_stiffness"] * step**2}
    assert method_for(how.along, motion, {**stiff, changed: swinging[changed]}, COARSE) == "dormand_prince"


def test_what_settles_more_slowly_is_followed(tmp_path: Path) -> None:
    """Where the motion itself settles by a radian in a sample, far slower than the bristles, steps are as short as that
    asks for.
    """
    how, motion, values = driven(tmp_path)
    stiff, step = with_steps(motion, values, 1.5 * STIFF), motion.record.sample_time
    assert method_for(how.along, motion, stiff, COARSE) == "ros34pw2"
    damped = {**stiff, "viscous": stiff["mass"] / step}
    assert method_for(how.along, motion, damped, COARSE) == "dormand_prince"


def test_a_finer_tolerance_asks_more_of_the_method_of_lower_order(tmp_path: Path) -> None:
    how, motion, values = driven(tmp_path)
    stiff = with_steps(motion, values, 4.0 * STIFF)
    assert method_for(how.along, motion, stiff, COARSE) == "ros34pw2"
    assert method_for(how.along, motion, stiff, 1e-3 * COARSE) == "dormand_prince"


def test_a_stiff_plant_is_simulated_in_few_steps(tmp_path: Path) -> None:
    how, motion, values = driven(tmp_path)
    stiff = with_steps(motion, values, 50.0)
    plant = how.along.having(how.along.acts(stiff), alone=True)
    ((_, setup),) = how.pieces(motion, stiff, plant)
    assert setup.integrator == Integrator("ros34pw2")
    run, explicit = simulate(setup), simulate(replace(setup, integrator=Integrator(tolerance=1e-9)))
    assert run.steps < 0.2 * explicit.steps
    assert np.max(np.abs(run.state("position") - explicit.state("position"))) < 1e-5 * np.ptp(run.state("position"))
