"""A slow log of command and position alone, from a valve-driven axis: what `workbench identify` finds in it."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from command import STUDIES, workbench

from plants.valve_axis import VALVE_AXIS
from workbench.fitting.replay import WARM, observe_all
from workbench.parameters.sets import build, read_parameters
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

AXIS = STUDIES / "valve_axis"
STEP, JITTER, NOISE = 0.053, 0.010, 10e-6
FOUND = ("velocity_gain", "dead_band", "command_delay")


def logged(folder: Path, duration: float, **changes: float) -> Path:
    """A log of the winch of studies/valve_axis, driven by hand: jitter, gaps, repeated stamps, 10 um of noise."""
    generator = np.random.default_rng(5)
    parameters = build(VALVE_AXIS.Parameters, {**read_parameters(AXIS / "machine.toml"), **changes})
    state, inputs = VALVE_AXIS.equilibrium(parameters, 0.0)
    lever = Feed("valve_voltage", Multisine(3.5, 0.05, (1, 4, 9, 17)))
    run = simulate(Setup(VALVE_AXIS, parameters, state, inputs, duration, feeds=(lever,), sample_time=0.01))
    count = int(duration / STEP) - 1
    stamps = STEP * np.arange(1, count + 1) + generator.uniform(-JITTER, JITTER, count)
    for start in (24.0, 51.0):
        stamps = stamps[(stamps < start) | (stamps > start + 0.4)]
    command = np.interp(stamps, run.time, run.command)
    position = np.interp(stamps, run.time, run.state("position")) + NOISE * generator.standard_normal(stamps.size)
    stamps[[300, 600]] = stamps[[299, 599]]
    table = np.column_stack([stamps, command, 1e3 * position])
    np.savetxt(folder / "log.csv", table, "%.6f", ",", header="time_s,command_V,position_mm", comments="")
    for name in ("believed.toml", "machine.toml"):
        (folder / name).write_text((AXIS / name).read_text())
    text = re.sub(r'file = ".*"', 'file = "log.csv"', (AXIS / "experiment.toml").read_text())
    (folder / "experiment.toml").write_text(text)
    return folder


def found(folder: Path) -> dict[str, dict[str, float]]:
    """What the command writes of each parameter that is fitted."""
    answer = workbench("identify", folder / "experiment.toml", "--out", folder / "out")
    assert answer.code == 0, answer.err
    rows = json.loads((folder / "out" / "identified.json").read_text())["parameters"]
    return {name: row["simulation"] for name, row in rows.items() if "simulation" in row}


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """75 s with two gaps."""
    return logged(tmp_path_factory.mktemp("slow"), 75.0)


@pytest.fixture(scope="module")
def identified(folder: Path, dots_alone: None) -> dict[str, dict[str, float]]:
    """What it finds in that log."""
    return found(folder)


@pytest.mark.parametrize("suffix", ["", "_negative"])
@pytest.mark.parametrize("name", FOUND)
def test_gain_dead_band_and_delay_are_found_from_a_guess_off_by_two_and_more(
    folder: Path, identified: dict[str, dict[str, float]], name: str, suffix: str
) -> None:
    truth, guess = (read_parameters(folder / file)[name + suffix] for file in ("machine.toml", "believed.toml"))
    assert max(guess / truth, truth / guess) >= 2.0
    assert identified[name + suffix]["value"] == pytest.approx(truth, rel=0.05)


@pytest.mark.parametrize("suffix", ["", "_negative"])
@pytest.mark.parametrize("name", FOUND)
def test_deviations_know_that_samples_are_old_and_the_way_between_them_is_not(
    folder: Path, identified: dict[str, dict[str, float]], name: str, suffix: str
) -> None:
    """A position that is up to a sample older than its command shows as a delay, by up to 2.4 deviations."""
    truth, found = read_parameters(folder / "machine.toml")[name + suffix], identified[name + suffix]
    assert abs(found["value"] - truth) < 2.0 * found["std"]
    if name == "command_delay":
        assert found["std"] == pytest.approx(STEP / np.sqrt(6.0), rel=0.05)


def test_a_dead_band_and_a_delay_that_are_not_there_are_found_to_be_none(tmp_path: Path, dots_alone: None) -> None:
    """They end at 0 or next to it, whatever was guessed, and what is fitted beside them comes out right."""
    absent = {f"{name}{suffix}": 0.0 for name in ("dead_band", "command_delay") for suffix in ("", "_negative")}
    fitted = found(logged(tmp_path, 33.0, **absent, axis_time_constant=0.033))
    values = {name: number["value"] for name, number in fitted.items()}
    truth = read_parameters(AXIS / "machine.toml")
    for suffix in ("", "_negative"):
        assert values[f"velocity_gain{suffix}"] == pytest.approx(truth[f"velocity_gain{suffix}"], rel=1e-3)
        assert 0.0 <= values[f"dead_band{suffix}"] < 2e-3
        assert 0.0 <= values[f"command_delay{suffix}"] < 2e-3
    assert values["axis_time_constant"] == pytest.approx(0.033, rel=0.05)


def test_a_drift_is_found_and_biases_nothing(tmp_path: Path, dots_alone: None) -> None:
    """A load that pulls at the axis while the valve is closed; nobody declared it."""
    fitted = found(logged(tmp_path, 33.0, drift_velocity=4e-3))
    truth = {**read_parameters(AXIS / "machine.toml"), "drift_velocity": 4e-3}
    for name in ("drift_velocity", *(f"{name}{suffix}" for name in FOUND for suffix in ("", "_negative"))):
        assert fitted[name]["value"] == pytest.approx(truth[name], rel=0.05)


def test_a_dead_band_beyond_the_largest_command_is_told(tmp_path: Path, dots_alone: None) -> None:
    folder = logged(tmp_path, 40.0)
    believed = (folder / "believed.toml").read_text().replace('value = "2.2 V"', 'value = "20 V"')
    believed = believed.replace('value = "25 mm/(s V)"', 'value = "1000 mm/(s V)"')  # without the band far too fast
    (folder / "believed.toml").write_text(believed)
    answer = workbench("identify", folder / "experiment.toml", "--out", folder / "out")
    assert answer.code == 2
    assert "is a dead band declared beyond the largest command" in answer.err


def test_windows_begin_anew_and_miss_only_what_a_piece_begins_with(folder: Path) -> None:
    experiment = read_experiment(folder / "experiment.toml")
    for record in read_records(experiment):
        windows = list(observe_all(record, experiment))
        compared = np.concatenate([item.time[np.isfinite(item.measured["position"])] for item in windows])
        np.testing.assert_array_equal(np.unique(compared), compared)
        known = record.time[record.valid & (record.time >= WARM)]
        assert set(known.tolist()) <= set(compared.tolist())
