"""Tuning studies: what is wrong in one is told in a line, and the shipped one reaches what it is for."""

from pathlib import Path

import pytest
from command import DRIVE, STUDIES, workbench, write
from tuned_study import STUDY, robust, tuned

from workbench.study.reading import read_study
from workbench.tune.prepare import prepared
from workbench.tune.run import tune_all

# --- mistakes ---


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("[tune.objective]\nrms_error = 1", "", "tune.objective: is missing"),
        ("rms_error = 1", "rms_error = 0", "all weights are 0; give at least one of rms_error, "),
        ("rms_error = 1", "rms_errors = 1", 'unknown key; did you mean "rms_error"?'),
        (
            "[tune.objective]",
            "[tune.gains.p]\nkq = {}\n[tune.objective]",
            'p.kq: "pid" has no such gain; expected one of kp, ki, kd',
        ),
        (
            "[tune.objective]",
            '[tune.gains.p]\nkp = { min = "9 V/m", max = "5 V/m" }\n[tune.objective]',
            "tune.gains.p.kp: min 9 is not below max 5 (SI); turn the limits round",
        ),
        (
            "[tune.objective]",
            '[tune.gains.p]\nkp = { min = "9 m" }\n[tune.objective]',
            'tune.gains.p.kp.min: got "9 m"',
        ),
        (
            "[tune.objective]",
            "[tune.gains.p]\nki = {}\n[tune.objective]",
            "p.ki: has no documented range here; give it min",
        ),
        ("trials = 20", 'trials = 20\nyardstick = "q"', 'tune.yardstick: unknown controller "q"'),
        (
            "[tune.objective]",
            "[tune.gains.luger]\nlead = {}\n[tune.objective]",
            'unknown controller "luger"; did you mean',
        ),
        (
            'kind = "sine"\namplitude = "5 mm"\nfrequency = "2 Hz"',
            'kind = "steps"\nlevels = ["1 mm"]\ndwell = "1 s"',
            "the yardstick's steady_state_error_m is",
        ),
        ("trials = 20", "trials = 20\nwhere = { rpm = 7 }", "[tune] where: no case of p has rpm 7"),
        ("rms_error = 1", "steady_state_error = 1", "steady_state_error_m does not apply to any of the cases"),
    ],
)
def test_mistakes_are_told_in_a_line(tmp_path: Path, old: str, new: str, message: str) -> None:
    assert STUDY.count(old) == 1
    text = STUDY.replace(old, new)
    if "steps" in new:  # a P leaves nothing there
        text = text.replace("rms_error = 1", "steady_state_error = 1")
    answer = workbench("tune", write(tmp_path, text), "--controller", "p", "--out", tmp_path / "out")
    assert answer.code == 2
    assert message in answer.err
    assert "Traceback" not in answer.err
    assert answer.err.count("\n") == 1


# --- the study that is shipped ---


@pytest.mark.parametrize(
    ("name", "fast", "slow"),
    [("p", 1.54e-3, 0.079e-3), ("p_feedforward", 0.238e-3, 0.0138e-3), ("lugre", 56e-6, 0.7e-6)],
)
def test_tuned_gains_are_better_than_the_defaults_of_the_valve_table(
    tmp_path: Path, name: str, fast: float, slow: float
) -> None:
    """Reference errors of this project with default gains, computed apart from this program: rms, both sines."""
    study, names = prepared(read_study(STUDIES / "tuning.toml"), [name], 14)
    result = tune_all(study, names, tmp_path / "results.sqlite", 2).tuned[0]
    assert result.score is not None
    errors = [run.metrics["rms_error_m"] for run in result.score.runs]
    assert errors[0] < fast
    assert errors[1] < slow
    assert min(result.score.margins.gain_dB / 6.0, result.score.margins.phase_deg / 45.0) >= 1.0


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (STUDY.replace("trials = 20", "trials = 20\ndraws = 8"), "tune.draws: needs [uncertainty], which says what"),
        (
            robust().replace("bulk_modulus = {", "bulk_modules = {"),
            'uncertainty.scale.bulk_modules: unknown parameter; did you mean "bulk_modulus"?',
        ),
        (
            STUDY.replace('model = "non_rotating"', 'model = "rotating"\nbristle = "isotropic"')
            .replace("[axes]\n", "[axes]\nrpm = [10, 20]\n")
            .replace("[tune.objective]", '[tune.rotation]\nrpm = { min = "5 rpm", max = "9 rpm" }\n[tune.objective]'),
            "tune.rotation.rpm: is tuned: expected one value on the axis rpm",
        ),
    ],
    ids=["no_uncertainty", "unknown_parameter", "two_speeds"],
)
def test_what_cannot_be_drawn_or_turned_leaves_no_folder(tmp_path: Path, text: str, message: str) -> None:
    study, out = write(tmp_path, text), tmp_path / "out"
    for answer in (workbench("tune", study, "--out", out), workbench("check", study)):
        assert answer.code == 2
        assert message in answer.err
    assert not out.exists()


def test_the_added_pd_can_be_tuned_alone(tmp_path: Path) -> None:
    without = STUDY.replace('pd = { type = "pid", kp = "500 V/m", kd = "2 V s/m" }\n', "").replace('"pd", ', "")
    assert tuned(tmp_path, without, "pd", trials=4).tuned[0].best is not None


@pytest.mark.usefixtures("dots_alone")
def test_a_drive_without_a_largest_command_is_tuned_without_classic_points(tmp_path: Path) -> None:
    study = write(
        tmp_path,
        DRIVE.replace('levels = ["1 m"]', 'levels = ["1 mm"]').replace('kp = "3 N/m"', 'kp = "3 N/mm"\nkd = "60 N s/m"')
        + "[tune]\ntrials = 4\nseeds = 1\n[tune.objective]\nrms_error = 1\n[tune.constraints]\nlimit_cycle = false\n"
        + "gain_margin_dB = 0\nphase_margin_deg = 0\n",
    )
    answer = workbench("tune", study, "--out", tmp_path / "out")
    assert (answer.code, answer.err) == (0, "")
