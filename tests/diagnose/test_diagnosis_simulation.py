"""The simulation stage: what smoothing hides shows in the simulated plant; a complete one leaves noise alone."""

import json
import shutil
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from diagnosis.generator import make_experiment

from workbench.diagnose.diagnose import diagnose
from workbench.diagnose.readiness import motions_of
from workbench.errors import UserError
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records

SEED = 5


def shortened(path: Path, seconds: int = 12) -> Path:
    """The same with the first seconds of each record."""
    for record in path.parent.glob("*.parquet"):
        pd.read_parquet(record).iloc[: 1000 * seconds].to_parquet(record)
    return path


@pytest.mark.thorough
def test_air_in_the_oil_is_found_by_simulation_alone(tmp_path: Path) -> None:
    diagnosis = diagnose(shortened(make_experiment(tmp_path, {"entrained_air": 0.5}, SEED)))
    truth = json.loads((tmp_path / "truth.json").read_text())["rig"]
    assert diagnosis.simulation is not None
    assert not any(step.added for result in diagnosis.results for step in result.steps)  # the balances do not see it
    assert [effect.name for effect in diagnosis.effects] == ["entrained_air"]
    assert diagnosis.effects[0].parameters["air_fraction"].value == pytest.approx(truth["air"], rel=0.01)
    assert diagnosis.simulation.before.rms > 2.0
    assert diagnosis.simulation.after.rms < 1.05  # standard deviations of the sensors' noise
    fitted = diagnosis.simulation.after.values
    assert fitted["bulk_modulus"] == pytest.approx(truth["bulk_modulus"], rel=0.02)
    assert fitted["coulomb"] == pytest.approx(truth["coulomb"], rel=0.02)


def test_a_complete_plant_leaves_noise_and_nothing_is_added(tmp_path: Path) -> None:
    diagnosis = diagnose(shortened(make_experiment(tmp_path, {}, SEED), 6))
    assert diagnosis.verdict == "none_missing"
    assert diagnosis.simulation is not None
    assert diagnosis.simulation.after.rms < 1.05
    assert diagnosis.simulation.is_trusted


@pytest.mark.parametrize(
    ("change", "said"),
    [
        (lambda frame: frame.iloc[:50], "are too little for a diagnosis; expected at least 2 s"),
        (lambda frame: frame.assign(position=1.0 + 1e-3 * np.sin(1e4 * frame["time"] ** 2)), "nothing moves beyond"),
    ],
    ids=["short", "at_rest"],
)
def test_a_record_that_says_nothing_is_refused_in_a_line(
    tmp_path: Path, change: Callable[[pd.DataFrame], pd.DataFrame], said: str
) -> None:
    path = make_experiment(tmp_path, {}, SEED)
    record = tmp_path / "fit.parquet"
    change(pd.read_parquet(record)).to_parquet(record)
    with pytest.raises(UserError, match=said):
        diagnose(path)


def test_a_copy_under_another_name_is_refused_in_a_line(tmp_path: Path) -> None:
    """Held out it would test nothing."""
    path = make_experiment(tmp_path, {}, SEED)
    shutil.copy(tmp_path / "fit.parquet", tmp_path / "held_out.parquet")
    with pytest.raises(
        UserError, match=r"held_out\.parquet: holds the same samples as .*fit\.parquet; expected another"
    ):
        diagnose(path)


@pytest.mark.parametrize(
    ("name", "value", "said"),
    [
        ("stribeck", "0 N", '"stribeck" is declared 0, and a fit moves it by factors; give it a start'),
        ("voltage_limit", "", r'"voltage_limit" is in no balance that the records\' channels allow \(flow and force\)'),
    ],
)
def test_a_free_parameter_that_no_fit_could_move_is_refused_in_a_line(
    tmp_path: Path, name: str, value: str, said: str
) -> None:
    path = make_experiment(tmp_path, {}, SEED)
    changed = f'[plant.set]\n{name} = "{value}"\n' if value else ""
    path.write_text(f'{path.read_text()}\n{changed}[fit]\nfree = ["coulomb", "{name}"]\n')
    with pytest.raises(UserError, match=said):
        diagnose(path)


def test_two_records_of_one_label_are_numbered(tmp_path: Path) -> None:
    """Two pieces of one file were drawn over each other."""
    experiment = read_experiment(make_experiment(tmp_path, {}, SEED))
    (record,) = read_records(experiment, "fit")
    labels = [motion.record.label for motion in motions_of(experiment, [record, record, record])]
    assert labels == [record.label, f"{record.label} (2)", f"{record.label} (3)"]
