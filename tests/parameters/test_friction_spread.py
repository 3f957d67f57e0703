"""Friction drawn for each seed: its mean and deviation, and the draws of a study."""

from pathlib import Path

import numpy as np
import pytest
from scenario_study import FILE_HEAD, FOLDER, resolved, study_file
from support import registered

from workbench.parameters.sets import LEAST_SHARE, drawn, named_sets, read_deviations, read_parameters


@pytest.mark.parametrize(("name", "mean", "deviation"), [("coulomb", 330.0, 30.0), ("bristle_stiffness", 2.6e6, 0.6e6)])
def test_draws_have_the_mean_and_deviation_of_table_5_2(name: str, mean: float, deviation: float) -> None:
    """Over n seeds: within four standard errors, deviation / sqrt(n) and deviation / sqrt(2 n)."""
    n = 2000
    draws = np.array([drawn(name, mean, deviation, seed) for seed in range(n)])
    assert np.mean(draws) == pytest.approx(mean, abs=4.0 * deviation / np.sqrt(n))
    assert np.std(draws) == pytest.approx(deviation, abs=4.0 * deviation / np.sqrt(2.0 * n))
    assert np.all(draws >= LEAST_SHARE * mean)


def test_draws_are_independent_and_never_non_physical() -> None:
    seeds = range(500)
    coulomb, negative = (
        np.array([drawn(name, 1.0, 1.0, s) for s in seeds]) for name in ("coulomb", "coulomb_negative")
    )
    assert abs(np.corrcoef(coulomb, negative)[0, 1]) < 4.0 / np.sqrt(500)
    assert min(coulomb.min(), negative.min()) >= LEAST_SHARE
    assert min(drawn("load_force", 0.0, 1.0, s) for s in seeds) < -1.0  # a load may pull either way


@pytest.mark.parametrize(("name", "relative"), [("coulomb", 30 / 330), ("stribeck", 15 / 150),
    ("viscous", 2500 / 22800), ("stribeck_velocity", 0.3 / 2.4), ("bristle_stiffness", 0.6 / 2.6),
    ("bristle_damping", 0.1 / 1.1)])  # fmt: skip
def test_simulated_actuator_has_the_relative_spread_of_the_rig(name: str, relative: float) -> None:
    """Table 5.2, mean and deviation of each parameter, rounded."""
    path = named_sets()["owen2001_simulation"]
    assert read_deviations(path)[name] / read_parameters(path)[name] == pytest.approx(relative, rel=0.02)


def test_spread_is_the_same_for_every_controller_and_not_for_every_seed(tmp_path: Path) -> None:
    spread = (FOLDER / "friction_spread.toml").read_text(encoding="utf-8")
    p, inverse = resolved(study_file(tmp_path, ["friction_spread"], friction_spread=spread))
    assert p.setup.parameters == inverse.setup.parameters
    level = p.setup.parameters.friction.positive
    assert level.coulomb == drawn("coulomb", 370.0, 34.0, 3) != 370.0
    assert level == p.setup.parameters.friction.negative  # a set with one direction stays symmetric
    assert all(
        a != b
        for a, b in zip(level, registered("non_rotating", duration=1.0).parameters.friction.positive, strict=True)
    )

    text = (tmp_path / "study.toml").read_text(encoding="utf-8")
    (tmp_path / "study.toml").write_text(text.replace("seed = 3", "seed = 4"), encoding="utf-8")
    assert resolved(tmp_path / "study.toml")[0].setup.parameters.friction.positive.coulomb != level.coulomb


def test_spread_draws_each_direction_and_is_scaled_afterwards(tmp_path: Path) -> None:
    text = FILE_HEAD + '[plant]\nparameters = "owen2001_experiment"\nspread.coulomb = 2\nscale.coulomb = 3\n'
    truth = resolved(study_file(tmp_path, ["rig"], rig=text))[0].setup.parameters.friction
    assert truth.positive.coulomb == pytest.approx(3.0 * drawn("coulomb", 330.0, 60.0, 3), rel=1e-15)
    assert truth.negative.coulomb == pytest.approx(3.0 * drawn("coulomb_negative", 290.0, 50.0, 3), rel=1e-15)
    assert truth.positive.viscous == 22800.0
