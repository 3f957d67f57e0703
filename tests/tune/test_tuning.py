"""Tuning: the same budget and goal for all, gains that keep the constraints, the same gains whatever happens."""

import math
import sqlite3
from dataclasses import replace
from pathlib import Path

import control
import numpy as np
import pytest
from command import killed, workbench, write
from scipy.stats import binom
from tuned_study import HUNTING, STUDY, ready, robust, tuned

from controllers.settings import usable
from plants.equation import to_array
from workbench.errors import UserError
from workbench.linear.open_loop import open_loop
from workbench.metrics.statistics import quantile
from workbench.study.reading import read_study
from workbench.study.resolve import resolve
from workbench.study.unfold import unfold
from workbench.toml.gain_file import gain_file_text, read_gain_file
from workbench.tune.prepare import task_for
from workbench.tune.report.gain_files import gain_file
from workbench.tune.result import Tuning, infeasible, interval
from workbench.tune.starts import classic_points

pytestmark = pytest.mark.usefixtures("dots_alone")


def outcome(tuning: Tuning) -> list[object]:
    """All that has to be the same."""
    return [(each.task.label, each.best, each.number, each.seeds, each.trials) for each in tuning.tuned]


# --- the same gains whatever happens ---


@pytest.mark.parametrize(
    "text", [pytest.param(STUDY, id="declared"), pytest.param(robust(), id="drawn", marks=pytest.mark.thorough)]
)
def test_jobs_do_not_change_the_gains(tmp_path: Path, text: str) -> None:
    several = text.replace("seeds = 1", "seeds = 2")
    serial = tuned(tmp_path / "one", several, ("p", "lugre"), trials=12, jobs=1)
    parallel = tuned(tmp_path / "two", several, ("p", "lugre"), trials=12, jobs=2)
    assert outcome(serial) == outcome(parallel)
    assert [each.task.name for each in serial.tuned] == ["p", "lugre"]
    assert len(serial.tuned[1].trials) <= 2 * 12
    assert list(serial.tuned[1].seeds) == [1, 2]


def test_going_on_does_not_change_the_gains(tmp_path: Path) -> None:
    whole = tuned(tmp_path / "whole", STUDY, "p", trials=14)
    tuned(tmp_path / "parts", STUDY, "p", trials=5)
    tuned(tmp_path / "parts", STUDY, "p", trials=10)
    assert outcome(tuned(tmp_path / "parts", STUDY, "p", trials=14)) == outcome(whole)


def test_a_killed_command_goes_on_to_the_same_gains(tmp_path: Path) -> None:
    study, part, whole = write(tmp_path, STUDY), tmp_path / "killed", tmp_path / "whole"
    options = ("--controller", "lugre", "--trials", "24")
    killed(lambda: stored(part) >= 6, "tune", study, *options, "--out", part, "--jobs", "1")
    assert 6 <= stored(part) < 24
    assert not (part / "tuned").exists()
    refused = workbench("tune", study, *options, "--out", part)
    assert "holds trials already; go on with --resume" in refused.err
    assert workbench("tune", study, *options, "--out", part, "--jobs", "2", "--resume").code == 0
    assert workbench("tune", study, *options, "--out", whole, "--jobs", "1").code == 0
    for name in ("tuned/lugre.toml", "trials.csv", "results.csv"):
        assert (part / name).read_bytes() == (whole / name).read_bytes(), name


def stored(folder: Path) -> int:
    """How many trials a killed search has committed."""
    try:
        with sqlite3.connect(f"file:{folder / 'results.sqlite'}?mode=ro", uri=True) as connection:
            return int(connection.execute("SELECT COUNT(*) FROM trials").fetchone()[0])
    except sqlite3.Error:
        return 0


def test_one_controller_and_all_of_them_share_a_folder(tmp_path: Path) -> None:
    """A PD that is added beside others makes no other study of theirs; nor does a change of another controller."""
    without = STUDY.replace('pd = { type = "pid", kp = "500 V/m", kd = "2 V s/m" }\n', "").replace('"pd", ', "")
    alone = tuned(tmp_path, without, "lugre", trials=4).tuned[0]
    every = tuned(tmp_path, without, "all", trials=4)
    assert every.tuned[1].best == alone.best
    changed = without.replace('law = "valve_inversion"', 'law = "acceleration_feedback"')
    assert tuned(tmp_path, changed, "p", trials=4).tuned[0].best == every.tuned[0].best
    with pytest.raises(UserError, match="its trials of lugre, seed 1 are of another study"):
        tuned(tmp_path, changed, "lugre", trials=4)


def test_trials_of_another_study_are_not_taken(tmp_path: Path) -> None:
    tuned(tmp_path / "one", STUDY, "p", trials=4)
    other = write(tmp_path / "one", STUDY.replace('"2 Hz"', '"1 Hz"'))
    answer = workbench("tune", other, "--controller", "p", "--out", tmp_path / "one", "--resume")
    assert answer.code == 2
    assert "its trials of p, seed 1 are of another study or version of the program" in answer.err


# --- fair ---


def test_all_meet_the_same_machines(tmp_path: Path) -> None:
    study, names = ready(tmp_path, robust(), "all")
    tasks = [task_for(study, name) for name in names]
    for number in range(3):
        machines = [task.sampled(task.start, number)[0].setup for task in tasks]
        assert len({to_array(each.parameters).tobytes() for each in machines}) == 1
        assert len({each.seed for each in machines}) == 1
    first, second = (to_array(tasks[0].sampled(tasks[0].start, number)[0].setup.parameters) for number in range(2))
    assert not np.array_equal(first, second)


def test_a_pd_is_always_among_them(tmp_path: Path) -> None:
    without = STUDY.replace('pd = { type = "pid", kp = "500 V/m", kd = "2 V s/m" }\n', "").replace('"pd", ', "")
    study, names = ready(tmp_path, without, "all")
    assert names == ["p", "lugre", "pd"]
    added = task_for(study, "pd")
    p = task_for(study, "p")
    (placed,) = [point for point in classic_points(p, p.start) if point.name == "pole_placement_pd"]
    assert (added.settings.kp, added.settings.kd) == (placed.settings["kp"], placed.settings["kd"])
    assert {each.name for each in added.dimensions} == {"kp", "kd", "velocity_time_constant"}
    assert ready(tmp_path, STUDY, "all")[1] == ["p", "pd", "lugre"]
    assert ready(tmp_path, without, "p")[1] == ["p"]


def test_every_controller_documents_ranges_about_its_defaults() -> None:
    from controllers.registry import controllers

    for controller in controllers().values():
        for item in usable(controller).values():
            if item.tuned is None:
                continue
            low, high = item.tuned.low, item.tuned.high
            assert low < high
            default = 1.0 if item.tuned.by_factor else item.default
            assert default is None or low <= float(default) <= high or default == 0.0, (controller.name, item.name)
            assert item.about.admits(low), (controller.name, item.name)


# --- constraints ---


def test_a_hunting_loop_is_never_returned(tmp_path: Path) -> None:
    """K_i 1000 V/(m s) hunts on soft hoses and 500 does not; the error falls with K_i all the way."""
    result = tuned(tmp_path, HUNTING, "pi", jobs=2).tuned[0]
    hunting = [trial for trial in result.trials if trial.violations["limit cycle"] > 0.0]
    assert min(result.trials, key=lambda trial: trial.value) in hunting
    assert all(trial.point["ki"] > 500.0 for trial in hunting)
    assert result.best is not None
    assert result.best["ki"] <= 1000.0
    assert result.trials[result.number] not in hunting
    assert not any(trial.feasible for trial in hunting)


def test_an_infeasible_set_says_what_fails_and_by_how_much(tmp_path: Path) -> None:
    text = STUDY + "[tune.constraints]\nphase_margin_deg = 89\n"
    result = tuned(tmp_path, text, "p").tuned[0]
    assert result.best is None
    most, count = max(trial.phase_margin_deg for trial in result.trials), len(result.trials)
    assert infeasible(result) == (
        f"no trial keeps all constraints; most often broken: phase margin, in {count} of {count} trials; "
        "the nearest has "
        f"{most:.1f} deg, 89 deg are asked for"
    )
    hunting, rest = {"phase margin": -0.5, "limit cycle": 1.0}, {"phase margin": 0.2, "limit cycle": -1.0}
    apart = [replace(result.trials[0], violations=each) for each in (hunting, rest, rest)]
    assert infeasible(replace(result, trials=apart)) == (
        "no trial keeps all constraints; of 3 trials broken: phase margin in 2, limit cycle in 1"
    )


def test_a_gain_file_carries_the_margins_of_its_loop(tmp_path: Path) -> None:
    """Read again, the gains give the margins; those of a P also come from the plant's own transfer function."""
    tuning = tuned(tmp_path, STUDY, "all", trials=8, jobs=2)
    for result in tuning.tuned:
        path = write(tmp_path, gain_file_text(gain_file([result])), f"{result.task.name}.toml")
        (kept,) = read_gain_file(path).at
        using = STUDY.replace("[controllers]\n", f'[controllers]\nagain = {{ gains = "{path.name}" }}\n')
        using = using.replace('controller = ["p", "pd", "lugre"]', 'controller = ["again"]')
        study = read_study(write(tmp_path, using, "using.toml"))
        setup = resolve(study, unfold(study)[0]).setup
        loop = open_loop(setup, 2.0 * np.pi * 2.0 * 5e-3)
        gain, phase, _, _ = control.margin(control.frd(loop, np.geomspace(0.1, np.pi / setup.sample_time, 4000)))
        assert kept.margins.gain_margin_dB == pytest.approx(20.0 * math.log10(gain), abs=0.05)
        assert kept.margins.phase_margin_deg == pytest.approx(phase, abs=0.1)
        assert kept.margins.gain_margin_dB >= 6.0
        assert kept.margins.phase_margin_deg >= 45.0


# --- gain files ---


def test_a_study_runs_with_a_gain_file_as_with_its_numbers(tmp_path: Path) -> None:
    result = tuned(tmp_path, STUDY, "lugre").tuned[0]
    assert result.best is not None
    write(tmp_path, gain_file_text(gain_file([result])), "lugre.toml")
    using = STUDY.replace(
        'lugre = { type = "lugre", law = "valve_inversion" }', 'lugre = { gains = "lugre.toml", injection = 0.2 }'
    )
    study = read_study(write(tmp_path, using, "using.toml"))
    resolved = resolve(study, unfold(study)[2])
    assert resolved.settings == result.task.settings_at(result.best)._replace(injection=0.2)
    answer = workbench("check", tmp_path / "lugre.toml")
    assert "tuned gains of lugre, in order\n  any speed: law valve_inversion" in answer.out
    lost = workbench("check", write(tmp_path, using.replace("lugre.toml", "lugres.toml"), "lost.toml"))
    assert "controllers.lugre.gains: " in lost.err
    assert 'did you mean "lugre.toml"' in lost.err


# --- quantiles ---


def test_the_quantile_is_the_draw_of_that_rank() -> None:
    values = [float(value) for value in range(32, 0, -1)]
    assert quantile(values, 0.9) == 29.0
    assert quantile(values, 0.5) == 16.0
    assert quantile([3.0, math.inf, 1.0], 0.6) == 3.0


def test_the_interval_of_a_quantile_has_its_probability() -> None:
    """200 draws: between ranks of which the binomial distribution says at least 95 %, and no narrower one does."""
    result = interval([float(rank) for rank in range(1, 201)], 0.9)
    low, high = int(result.low), int(result.high)
    assert (result.value, low, high) == (180.0, 171, 189)
    assert binom.cdf(high - 1, 200, 0.9) - binom.cdf(low - 1, 200, 0.9) >= 0.95
    few = interval([1.0, 2.0, 3.0, 4.0], 0.9)
    assert (few.value, few.high) == (4.0, math.inf)


def test_the_gains_are_measured_on_machines_that_the_search_has_not_met(tmp_path: Path) -> None:
    result = tuned(tmp_path, robust(), "pd").tuned[0]
    assert result.score is not None
    assert result.on_searched["tuned"].value == result.score.value == result.trials[result.number].value
    assert (result.on_searched["tuned"].draws, result.on_fresh["tuned"].draws) == (8, 12)
    assert result.on_fresh["tuned"].value != result.on_searched["tuned"].value
    assert result.on_fresh["tuned"].low <= result.on_fresh["tuned"].value <= result.on_fresh["tuned"].high
