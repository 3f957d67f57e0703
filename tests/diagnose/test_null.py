"""A record is held against what the same plant would leave if nothing were missing."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from diagnoses import balances_with_effects
from made_up_balances import FORCE, made_balance, made_motion

from plants.registry import plants
from workbench.diagnose.residual_stage import ResidualStage
from workbench.diagnose.residuals.motion import Motion, motion_of
from workbench.diagnose.residuals.null import surrogate, with_fitted_floor
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

SPRING = 2e4
TRUTH = {**read_parameters(named_sets()["owen2001_simulation"]), "spring_stiffness": SPRING}


def stage_of_a_drive(folder: Path, channel: str, noise: float) -> ResidualStage:
    """15 s of a mass that a force of 900 N drives against a spring: it sticks, and bristles show every noise."""
    plant = plants()["drive_force"]
    parameters = build(plant.Parameters, TRUTH)
    state, inputs = plant.equilibrium(parameters, 0.0)
    feed = Feed(plant.command, Multisine(900.0, 0.2, (1, 2, 3)))
    run = simulate(Setup(plant, parameters, state, inputs, 15.0, feeds=(feed,)))
    position = run.measurements[:, 0] + noise * np.random.default_rng(1).standard_normal(run.time.size)
    force = run.inputs[:, plant.input_index(plant.command)]
    pd.DataFrame({"time": run.time, "force": force, "position": position}).to_parquet(folder / "record.parquet")
    (folder / "experiment.toml").write_text(
        f'title = "a drive"\n[plant]\nmodel = "drive_force"\nparameters = "owen2001_simulation"\n'
        f'[plant.set]\nspring_stiffness = "{SPRING} N/m"\n[channels]\ntime = {{ column = "time", unit = "s" }}\n'
        f'{channel} = {{ column = "force", unit = "N" }}\nposition = {{ column = "position", unit = "m" }}\n'
        '[[records]]\nfile = "record.parquet"\n'
    )
    return balances_with_effects(folder / "experiment.toml")


@pytest.mark.parametrize(("channel", "noise"), [("force", 5e-6), ("command", 5e-6), ("command", 0.0)])
def test_a_drive_that_lacks_nothing_is_left_alone(tmp_path: Path, channel: str, noise: float) -> None:
    (result,) = stage_of_a_drive(tmp_path, channel, noise).results
    assert all(not step.added for step in result.steps)
    assert result.balance.simulated
    assert 0.05 < result.before.rms < 1.5


def test_a_floor_is_left_by_parameters_of_its_own() -> None:
    """What a balance's own parameters make good on a record they make good where nothing is missing, too."""
    motion = made_motion()
    balance = made_balance(
        [motion], lambda m, values: values["viscous"] * m.velocity, {"viscous": 1000.0}, ("viscous",)
    )
    assert balance.stacked({"viscous": 700.0}).std() > 3.0
    assert with_fitted_floor(balance, [[motion]], {"viscous": 700.0}, {}).floor == pytest.approx(FORCE, rel=0.05)


def test_a_floor_tells_how_far_draws_of_noise_are_from_each_other() -> None:
    """Of two draws one leaves 1 N and one, which goes twice as far, 2 N: beside a floor of sqrt(2.5) N."""
    calm, loud = made_motion(), made_motion(travel=0.08)

    def explained(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
        more = np.sqrt(3.0) * (np.max(motion.position) > 0.03) * np.cos(np.pi * np.arange(motion.time.size))
        return np.asarray(values["viscous"] * motion.velocity + values["load_force"] * more)

    balance = made_balance([calm, loud], explained, {"viscous": 1000.0, "load_force": 1.0}, ("viscous",))
    floored = with_fitted_floor(balance, [[calm], [loud]], {"viscous": 1000.0, "load_force": 0.0}, {})
    assert floored.floor == pytest.approx(np.sqrt(2.5), rel=0.05)
    assert floored.spread == pytest.approx(np.sqrt(0.5 / 2.5), rel=0.05)
    assert with_fitted_floor(balance, [[calm]], {"viscous": 1000.0, "load_force": 0.0}, {}).spread is None


def noisy(motion: Motion, noise: np.ndarray, step: float = 0.0) -> Motion:
    """The motion as its sensor would show it with that noise, of a converter that counts in steps."""
    shown = motion.position + noise
    shown = step * np.rint(shown / step) if step else shown
    return motion_of(replace(motion.record, channels={"position": shown}))


def test_a_surrogate_has_the_noise_of_its_record_at_every_frequency() -> None:
    """Noise that drifts away does not end where it began: no jump from its end to its beginning is noise in it."""
    clean = made_motion()
    drift = np.cumsum(1e-7 * np.random.default_rng(3).standard_normal(clean.time.size))
    motion = noisy(clean, drift)
    other = surrogate(motion, {"position": clean.position}, 0)
    fast = [float(np.std(np.diff(one.measured["position"] - clean.position, 2))) for one in (motion, other)]
    assert abs(drift[-1] - drift[0]) > 50.0 * fast[0]
    assert fast[1] == pytest.approx(fast[0], rel=0.1)
    assert not np.array_equal(other.measured["position"], motion.measured["position"])


def test_a_converter_s_steps_are_in_a_surrogate_as_in_its_record() -> None:
    """Where a rod rests its sensor shows the same step again and again, and hardly any noise."""
    clean, step = made_motion(), 2e-5
    moving = 0.4 * step + 0.02 * np.sin(2.0 * np.pi * 0.31 * np.maximum(clean.time - 10.0, 0.0)) ** 2
    still = motion_of(replace(clean.record, channels={"position": moving}))
    motion = noisy(still, 0.05 * step * np.random.default_rng(4).standard_normal(moving.size), step)
    other = surrogate(motion, {"position": still.position}, 0)
    levels = other.measured["position"] / step
    assert levels == pytest.approx(np.rint(levels), abs=1e-6)
    resting = clean.time < 9.0
    assert np.mean(np.diff(motion.measured["position"][resting]) != 0.0) < 0.05
    assert np.mean(np.diff(other.measured["position"][resting]) != 0.0) < 0.2
