"""Running studies: what a folder of results holds, that nothing changes its bytes, and that a killed run goes on."""

import json
import os
import re
import shutil
import signal
import sqlite3
import subprocess
import sys
import time
from contextlib import closing
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import DRIVE, FIGURE, PROCESS, STUDY, changed, ran, workbench, write

from workbench.study.probes import decay_rate
from workbench.study.store import Store, read_results

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

MANY = (
    changed('"1 s"', '"0.3 s"')
    .replace('"0.4 s"', '"0.1 s"')
    .replace(
        "[0, 460]", "[0, 460]\n" + '"controllers.p.kp" = [100, 200, 300, 400]\n"simulation.seed" = [1, 2, 3, 4, 5]'
    )
    + 'method = "rk4"\nstep = "2.5 us"\n'
    + NOISE
)
"""40 cases that take a little while each."""


def rows(folder: Path) -> int:
    """Rows committed so far."""
    try:
        with closing(sqlite3.connect(f"file:{folder / 'results.sqlite'}?mode=ro", uri=True)) as connection:
            return int(connection.execute("SELECT COUNT(*) FROM results").fetchone()[0])
    except sqlite3.Error:
        return 0


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
    assert answer == (0, "a study for tests\n  rpm: 0, 460\n  2 cases, 2 s of simulated time\n", "")
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


# --- folders that do not serve ---


def complaint(folder: Path, *options: str | Path, study: str = STUDY) -> str:
    """What a run that is refused says, without the folder."""
    answer = workbench("run", write(folder, study), *options)
    assert (answer.code, answer.err.count("\n")) == (2, 1)
    return answer.err.removeprefix("error: ").rstrip("\n").replace(str(folder), "@")


def test_results_are_not_replaced_unasked(tmp_path: Path) -> None:
    out = ran(tmp_path, STUDY)
    before = (out / "results.csv").read_bytes()
    said = complaint(tmp_path, "--out", out, study=changed("5 mm", "6 mm"))
    assert said == "@/results: holds results already; go on with --resume, start anew with --overwrite"
    assert (out / "results.csv").read_bytes() == before
    assert (ran(tmp_path, changed("5 mm", "6 mm"), "--overwrite") / "results.csv").read_bytes() != before


def test_another_study_cannot_be_resumed(tmp_path: Path) -> None:
    out = ran(tmp_path, STUDY)
    before = (out / "results.csv").read_bytes()
    said = complaint(tmp_path, "--out", out, "--resume", study=changed("5 mm", "6 mm"))
    assert said == "@/results: its results are of another study; start anew with --overwrite, or choose another --out"
    assert (out / "results.csv").read_bytes() == before
    assert (out / "study.toml").read_text(encoding="utf-8") == STUDY


def test_nothing_cannot_be_resumed(tmp_path: Path) -> None:
    said = complaint(tmp_path, "--out", tmp_path / "none", "--resume")
    assert said == "@/none: holds no results to resume; leave --resume out"
    assert not (tmp_path / "none").exists()
    (tmp_path / "none").mkdir()
    write(tmp_path / "none", "not a database", "results.sqlite")
    said = complaint(tmp_path, "--out", tmp_path / "none", "--resume")
    assert said.startswith("@/none/results.sqlite: not a results file of this program (")


def test_resume_or_overwrite(tmp_path: Path) -> None:
    said = complaint(tmp_path, "--out", tmp_path / "out", "--resume", "--overwrite")
    assert said == "--resume and --overwrite: choose one"


@pytest.mark.parametrize("place", ["file", "file/below", "/proc/no/such/folder"])
def test_a_folder_that_cannot_be_written(tmp_path: Path, place: str) -> None:
    write(tmp_path, "mine", "file")
    folder = Path(place) if place.startswith("/") else tmp_path / place
    said = complaint(tmp_path, "--out", folder)
    assert "cannot be written (" in said
    assert said.endswith("choose another folder with --out")
    assert (tmp_path / "file").read_text(encoding="utf-8") == "mine"


@pytest.mark.parametrize("options", [(), ("--overwrite",)])
def test_files_of_others_are_never_removed(tmp_path: Path, options: tuple[str, ...]) -> None:
    """A thesis has a folder of figures of its own."""
    (tmp_path / "figures").mkdir()
    write(tmp_path / "figures", "mine", "rig.svg")
    said = complaint(tmp_path, "--out", tmp_path, *options)
    assert said == "@: holds study.toml, figures that no run wrote; choose another folder with --out"
    assert (tmp_path / "figures" / "rig.svg").read_text(encoding="utf-8") == "mine"


SCENARIO = 'title = "t"\nsource = "s"\n[plant.scale]\ncoulomb = 1.5\n'


def scenario_study(folder: Path) -> str:
    """A study that names one of the two scenario files beside it."""
    (folder / "scenarios").mkdir()
    write(folder / "scenarios", SCENARIO, "worn.toml")
    write(folder / "scenarios", SCENARIO, "other.toml")
    return changed("[0, 460]", '[0]\nscenario = ["worn"]')


def test_results_can_be_run_again_from_their_copy_of_the_study(tmp_path: Path) -> None:
    """Also into themselves; the scenario file comes along, one that the study does not name stays behind."""
    out = ran(tmp_path, scenario_study(tmp_path))
    assert [path.name for path in (out / "scenarios").iterdir()] == ["worn.toml"]
    expected = (out / "results.csv").read_bytes()
    shutil.rmtree(tmp_path / "scenarios")
    for again, option in ((tmp_path / "again", ()), (out, ("--overwrite",)), (out, ("--resume",))):
        answer = workbench("run", out / "study.toml", "--out", again, *option)
        assert (answer.code, answer.err) == (0, "")
        assert (again / "results.csv").read_bytes() == expected
        assert (again / "scenarios" / "worn.toml").read_text(encoding="utf-8") == SCENARIO


def test_scenarios_of_others_are_never_removed(tmp_path: Path) -> None:
    """Results beside the study: refused where a folder of scenarios is, and one that came later is kept."""
    study = scenario_study(tmp_path)
    mine = write(tmp_path, study, "mine.toml")
    refused = workbench("run", mine, "--out", tmp_path)
    assert refused.err.replace(str(tmp_path), "@") == (
        "error: @: holds scenarios that no run wrote; choose another folder with --out\n"
    )
    (tmp_path / "scenarios").rename(tmp_path / "later")
    assert workbench("run", write(tmp_path, STUDY, "plain.toml"), "--out", tmp_path).code == 0
    (tmp_path / "later").rename(tmp_path / "scenarios")
    assert workbench("run", mine, "--out", tmp_path, "--overwrite").code == 0
    assert sorted(path.name for path in (tmp_path / "scenarios").iterdir()) == ["other.toml", "worn.toml"]


def test_a_cluster_that_does_not_answer(tmp_path: Path) -> None:
    said = complaint(tmp_path, "--out", tmp_path / "out", "--cluster", "nonsense://nowhere")
    assert said.startswith(("nonsense://nowhere: no scheduler answers there (", "--cluster needs the extra"))


# --- killed, and in parallel ---


def test_the_same_bytes_whatever_the_jobs_killed_and_resumed_or_not(tmp_path: Path) -> None:
    """A real process, killed with SIGKILL once some cases are committed, and resumed."""
    study = write(tmp_path, MANY)
    killed = tmp_path / "killed"
    process = subprocess.Popen(
        [*PROCESS, "run", str(study), "--out", str(killed), "--jobs", "1"],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
    )
    deadline = time.monotonic() + 120.0
    while rows(killed) < 3 and process.poll() is None and time.monotonic() < deadline:
        time.sleep(0.005)
    process.send_signal(signal.SIGKILL)
    _, complaints = process.communicate(timeout=60.0)
    assert (process.returncode, complaints.count(b"\n")) == (-signal.SIGKILL, 1)
    assert b"warning: " in complaints, "less than a period is left after the transient"
    assert 3 <= rows(killed) < 40
    assert not (killed / "results.csv").exists(), "no table before all cases are done"

    unfinished = workbench("table", killed)
    assert unfinished.code == 2
    assert "holds no finished results" in unfinished.err
    kept = rows(killed)
    assert workbench("run", study, "--out", killed, "--jobs", "2", "--resume").code == 0
    assert workbench("run", study, "--out", tmp_path / "one", "--jobs", "1").code == 0
    assert workbench("run", study, "--out", tmp_path / "two", "--jobs", "2").code == 0
    first, second, resumed = ((tmp_path / name / "results.csv").read_bytes() for name in ("one", "two", "killed"))
    assert first == second == resumed
    assert first.count(b"\n") == 41
    assert kept < 40


def test_resume_runs_only_what_is_missing(tmp_path: Path) -> None:
    """A row in the database stands, even an absurd one."""
    out = ran(tmp_path, STUDY)
    with closing(sqlite3.connect(out / "results.sqlite")) as connection, connection:
        connection.execute("UPDATE results SET rms_error_m = 42 WHERE case_index = 0")
        connection.execute("DELETE FROM results WHERE case_index = 1")
    before = pd.read_csv(out / "results.csv")
    ran(tmp_path, STUDY, "--resume")
    after = pd.read_csv(out / "results.csv")
    assert after["rms_error_m"].tolist() == [42.0, before["rms_error_m"][1]]


def test_a_row_is_committed_as_it_ends(tmp_path: Path) -> None:
    """A second connection sees it while the first is open."""
    store = Store.create(tmp_path / "out", ["rpm", "outcome"], {"study": "a"}, overwrite=False)
    store.add(1, {"rpm": 460, "outcome": "completed"})
    assert rows(tmp_path / "out") == 1
    store.add(0, {"outcome": "diverged"})
    assert store.done() == {0, 1}
    assert store.frame()["outcome"].tolist() == ["diverged", "completed"]
    store.close()


PIPED = """\
from workbench.cli import main, progress
progress.INTERVAL = {interval}
main()
"""


def piped(folder: Path, interval: str) -> subprocess.CompletedProcess[str]:
    """A run of six short cases, one at a time, with its output in pipes."""
    study = write(folder, changed("rpm = [0, 460]", "rpm = [0, 50, 100, 150, 200, 250]"))
    options = ["run", str(study), "--out", str(folder / "out"), "--jobs", "1"]
    command = [sys.executable, "-c", PIPED.format(interval=interval), *options]
    return subprocess.run(command, capture_output=True, text=True, check=True)


def test_plain_lines_when_piped(tmp_path: Path) -> None:
    """How far it is, and how long it may take; no control codes, and nothing of a run that is short."""
    told = piped(tmp_path, "0.0")
    lines = told.stderr.splitlines()
    assert [line.partition(",")[0] for line in lines] == [f"{count} of 6 cases" for count in range(1, 6)]
    assert all(re.fullmatch(r"\d of 6 cases, about \d+ (s|min) left", line) for line in lines)
    assert "\x1b" not in told.stdout + told.stderr
    again = tmp_path / "again"
    again.mkdir()
    assert piped(again, "1e9").stderr == ""


def test_a_line_is_seen_when_it_is_written(tmp_path: Path) -> None:
    """The plan of a study that is still running, in a pipe."""
    study = write(tmp_path, changed('duration = "1 s"', 'duration = "500 s"'))
    command = [*PROCESS, "run", str(study), "--out", str(tmp_path / "out"), "--jobs", "1"]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as running:
        assert running.stdout is not None
        first = running.stdout.readline()
        still = running.poll() is None
        running.kill()
    assert first == "a study for tests\n"
    assert still
