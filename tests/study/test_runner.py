"""Running studies: what a folder of results holds."""

import json
import os
import re
import time
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import DRIVE, FIGURE, STUDY, changed, ran, workbench, write

from workbench.study.probes import decay_rate
from workbench.study.store import read_results

FIGURES = (
    "outcome,phase_lag_deg,gain_ratio,steady_state_error_m,steady_state_max_error_m,rms_error_m,max_error_m,"
    "settling_time_s,limit_cycle,"
    "limit_cycle_amplitude_m,limit_cycle_period_s,stuck_fraction,hydraulic_power_W,supply_power_W,rotation_power_W,"
    "motor_electric_power_W,total_power_W,motor_loss_W,paid_power_W,rotation_speed_mean_rpm,"
    "rotation_speed_min_rpm,rotation_speed_max_rpm,below_stribeck_fraction,torque_limited_fraction,"
    "motor_torque_rms_N_m,control_effort_V,jerk_rms_m_per_s3,friction_slope_N_s_per_m,"
    "friction_r_squared,friction_hysteresis_J,solver_error_m,solver_rms_error_m"
)
"""As docs and other programs read them."""

NOISE = '[sensors.position]\nnoise = "10 um"\n'


def test_columns_in_the_order_of_the_contract(tmp_path: Path) -> None:
    out = ran(tmp_path, STUDY + '[probes.top_m]\nsignal = "position"\ntake = "maximum"\n')
    lines = (out / "results.csv").read_text(encoding="utf-8").splitlines()
    assert lines[0] == f"rpm,{FIGURES},top_m"
    assert len(lines) == 3
    still, turning = (dict(zip(lines[0].split(","), line.split(","), strict=True)) for line in lines[1:])
    assert (still["rpm"], turning["rpm"]) == ("0", "460")
    assert (still["outcome"], turning["outcome"]) == ("completed", "torque-limited")  # 47 N m for a motor of 23
    assert float(still["top_m"]) == pytest.approx(float(still["gain_ratio"]) * 5e-3, rel=0.02)
    for name in ("rotation_power_W", "motor_electric_power_W", "steady_state_error_m", "limit_cycle"):
        assert still[name] == "", "a figure that does not apply is empty"
    assert float(turning["rotation_power_W"]) > 0.0


def test_parquet_holds_what_the_csv_says(tmp_path: Path) -> None:
    out = ran(tmp_path, STUDY)
    table, text = read_results(out), pd.read_csv(out / "results.csv")
    assert list(table.columns) == list(text.columns)
    for name in table.columns:
        if pd.api.types.is_numeric_dtype(table[name]):
            np.testing.assert_allclose(text[name], table[name], rtol=1e-9)
        else:
            assert [value for value in table[name] if value is not None] == text[name].dropna().tolist()


def test_an_axis_may_mix_numbers_and_quantities(tmp_path: Path) -> None:
    out = ran(tmp_path, changed("[0, 460]", '[0, "460 rpm", "48.17108735504349 rad/s"]'))
    table = pd.read_csv(out / "results.csv")
    assert table["rpm"].tolist() == ["0", "460 rpm", "48.17108735504349 rad/s"]
    assert table["rotation_power_W"][1] == pytest.approx(table["rotation_power_W"][2], rel=1e-6)
    assert len(read_results(out)) == 3


DIVERGING = changed("[0, 460]", '[0]\nscenario = ["fine", "coarse", "last"]') + (
    '[scenarios.fine]\n[scenarios.last]\n[scenarios.coarse.simulation]\nmethod = "euler"\nstep = "1 ms"\n'
    '[probes.top_m]\nsignal = "position"\ntake = "maximum"\n'
)


def test_a_case_that_diverges_is_a_row_and_the_study_goes_on(tmp_path: Path) -> None:
    """Euler's method at 1 ms is unstable on a hydraulic resonance of 1207 rad/s; a tight tolerance is not."""
    answer = workbench("run", write(tmp_path, DIVERGING), "--out", tmp_path / "out", "--keep-trajectories")
    assert (answer.code, answer.err) == (0, "")
    assert "1 of 3 cases: diverged" in answer.out
    table = pd.read_csv(tmp_path / "out" / "results.csv")
    assert table["outcome"].tolist() == ["completed", "diverged", "completed"]
    figures = [*FIGURES.split(",")[1:], "top_m"]
    assert table.loc[1, figures].isna().all()
    assert table.loc[0, "rms_error_m"] == table.loc[2, "rms_error_m"] > 0.0
    kept = pd.read_parquet(tmp_path / "out" / "trajectories" / "case_0001.parquet")
    assert 1 < len(kept) < 1001, "it stops early, and what there was of it is kept"


def test_noise_is_seeded(tmp_path: Path) -> None:
    text = changed("[0, 460]", '[0]\n"simulation.seed" = [7, 8]') + NOISE
    first = ran(tmp_path, text) / "results.csv"
    once = first.read_bytes()
    assert (ran(tmp_path, text, "--overwrite") / "results.csv").read_bytes() == once
    seven, eight = (line.split(",")[2:] for line in once.decode().splitlines()[1:])
    assert seven != eight
    other = ran(tmp_path, text.replace("[7, 8]", "[8, 9]"), "--overwrite") / "results.csv"
    assert other.read_text(encoding="utf-8").splitlines()[1].split(",")[2:] == eight


@pytest.mark.usefixtures("dots_alone")
def test_only_what_figures_draw_is_kept(tmp_path: Path) -> None:
    drawn = STUDY + FIGURE + 'curves = [{ y = "position", where = { rpm = 460 } }]\n'
    out = ran(tmp_path, drawn)
    assert [path.name for path in (out / "trajectories").iterdir()] == ["case_0001.parquet"]
    out = ran(tmp_path, drawn, "--overwrite", "--keep-trajectories")
    assert sorted(path.name for path in (out / "trajectories").iterdir()) == ["case_0000.parquet", "case_0001.parquet"]
    kept = pd.read_parquet(out / "trajectories" / "case_0000.parquet")
    assert len(kept) == 1001
    assert {"time", "position", "axial_friction", "load_pressure", "valve_voltage", "error"} <= set(kept.columns)
    out = ran(tmp_path, STUDY, "--overwrite")
    assert not (out / "trajectories").exists()


RECORDED = 'records = ["measured_position", "measured_motor_current", "motor_voltage"]\n' + STUDY


def test_a_record_holds_what_was_asked_for_and_nothing_else(tmp_path: Path) -> None:
    """File names say case and rpm, so that an experiment can pick them; a signal that a plant lacks is left out."""
    out = ran(tmp_path, RECORDED)
    assert sorted(path.name for path in (out / "records").iterdir()) == [
        "case_0_rpm_0000.parquet",
        "case_460_rpm_0001.parquet",
    ]
    standing = pd.read_parquet(out / "records" / "case_0_rpm_0000.parquet")
    turning = pd.read_parquet(out / "records" / "case_460_rpm_0001.parquet")
    assert list(standing.columns) == ["time", "measured_position", "measured_motor_current", "rpm"]
    assert list(turning.columns) == ["time", "measured_position", "measured_motor_current", "motor_voltage", "rpm"]
    assert len(turning) == 1001
    assert np.all(turning["rpm"] == 460.0)
    assert np.all(turning["measured_motor_current"] > 0.0)
    (out / "records" / "case_460_rpm_0001.parquet").unlink()
    ran(tmp_path, RECORDED, "--resume")
    assert len(list((out / "records").iterdir())) == 2
    ran(tmp_path, STUDY, "--overwrite")
    assert not (out / "records").exists()


def test_a_record_of_an_unknown_signal_is_one_line(tmp_path: Path) -> None:
    path = write(tmp_path, RECORDED.replace("measured_position", "measured_positio"))
    answer = workbench("check", path)
    assert (answer.code, answer.out) == (2, "")
    assert 'records.0: unknown signal "measured_positio"; did you mean "measured_position"?' in answer.err


def test_resuming_makes_a_trajectory_that_is_missing(tmp_path: Path) -> None:
    out = ran(tmp_path, STUDY)
    before = (out / "results.csv").read_bytes()
    ran(tmp_path, STUDY, "--resume", "--keep-trajectories")
    assert len(list((out / "trajectories").iterdir())) == 2
    assert (out / "results.csv").read_bytes() == before


def test_the_record_of_a_run(tmp_path: Path) -> None:
    out = ran(tmp_path, changed("[0, 460]", '[0]\n"simulation.seed" = [3, 1]'), "--jobs", "1")
    record = json.loads((out / "run.json").read_text(encoding="utf-8"))
    assert (record["title"], record["cases"], record["simulated_seconds"]) == ("a study for tests", 2, 2.0)
    assert (record["seeds"], record["jobs"]) == ([1, 3], 1)
    assert record["versions"]["numpy"] == np.__version__
    assert record["machine"]["cores"] == os.cpu_count()
    began = time.mktime(time.strptime(record["started"], "%Y-%m-%dT%H:%M:%SZ")) - time.timezone
    assert abs(time.time() - began) < 600.0
    assert 0.0 < record["wall_seconds"] < 600.0
    assert (out / "study.toml").read_text(encoding="utf-8") == (tmp_path / "study.toml").read_text(encoding="utf-8")


def test_a_dry_run_writes_nothing(tmp_path: Path) -> None:
    answer = workbench("run", write(tmp_path, STUDY), "--out", tmp_path / "out", "--dry-run")
    assert (answer.code, answer.err) == (0, "")
    *said, takes = answer.out.splitlines()
    assert said == ["a study for tests", "  rpm: 0, 460", "  2 cases, 2 s of simulated time"]
    assert re.fullmatch(r"  about [\d.e-]+ s on this machine and \d+ kB on the disk, told from 2 cases", takes)
    assert [path.name for path in tmp_path.iterdir()] == ["study.toml"]


def test_probes(tmp_path: Path) -> None:
    """Of a mass that a force of 1 N moves without friction: x = t^2 / 2, v = t."""
    text = changed('kp = "3 N/m"', "", DRIVE).replace('"pid"', '"open_loop"').replace("1 m", "1 N") + (
        'transient = 0.5\n[axes]\ncontroller = ["p"]\n[plant.set]\n'
        "coulomb = 0\nstribeck = 0\nviscous = 0\nbristle_stiffness = 0\nbristle_damping = 0\n"
    )
    takes = ("maximum", "minimum", "peak_to_peak", "mean", "rms", "final")
    text += "".join(f'[probes.{take}]\nsignal = "velocity"\ntake = "{take}"\n' for take in takes)
    text += '[probes.share]\nsignal = "velocity"\ntake = "share_below"\nlevel = 0.7\n'
    text += '[probes.period]\nsignal = "time"\ntake = "interval"\nevent = "velocity"\nevent_level = 0.7\n'
    (row,) = pd.read_csv(ran(tmp_path, text) / "results.csv").to_dict("records")
    assert [row[take] for take in takes] == pytest.approx(
        [1.0, 0.5, 0.5, 0.75, np.sqrt((1.0 - 0.125) / 3.0 / 0.5), 1.0], rel=2e-3
    )
    assert row["share"] == pytest.approx(0.4, abs=5e-3)
    assert np.isnan(row["period"]), "one event makes no interval"


def test_the_rate_of_a_decay() -> None:
    time = 1e-3 * np.arange(2001)
    assert decay_rate(time, 3.0 - 5.0 * np.exp(-7.0 * time)) == pytest.approx(7.0, rel=1e-3)
    assert decay_rate(time, np.ones(2001)) is None


def test_a_probe_of_a_signal_that_a_case_lacks_is_empty(tmp_path: Path) -> None:
    text = STUDY + '[probes.current_A]\nsignal = "motor_current"\ntake = "mean"\n'
    table = pd.read_csv(ran(tmp_path, text) / "results.csv")
    assert np.isnan(table["current_A"][0])
    assert table["current_A"][1] > 0.0
