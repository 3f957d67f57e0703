"""The report of a tuning: its files, its tables against results.csv, its words, its figures, and what a kill leaves."""

import json
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np
import pytest
from command import Answer, write
from page_numbers import pictures_of
from reported_tuning import STUDY, page, reported, results, table

from workbench.linear.margins import Margins
from workbench.linear.open_loop import margins
from workbench.study.reading import read_study
from workbench.tune.prepare import prepared, task_for
from workbench.tune.report import folder as report
from workbench.tune.report.bode import curve_of, lowest_frequency
from workbench.tune.report.history import history_picture
from workbench.tune.report.importance import importance, importance_picture
from workbench.tune.report.panels import SIDES
from workbench.tune.report.rows import end_of
from workbench.tune.report.step import largest_jump
from workbench.tune.report.tables import differ_words, margin, number
from workbench.tune.report.words import first_lines
from workbench.tune.result import Tuning
from workbench.tune.run import tune_all
from workbench.tune.space import Dimension

FILES = {"contents.json", "study.toml", "results.csv", "trials.csv", "results.sqlite", "tuning.html", "run.json"}
PICTURES = ("history", "importance", "step", "error", "bode_p", "bode_pd")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("tuned")


@pytest.fixture(scope="module")
def answer(folder: Path, png_alone: None) -> Answer:
    return reported(folder, STUDY)


@pytest.fixture(scope="module")
def tuning(folder: Path, answer: Answer) -> Tuning:
    """The same, of the trials that the command left."""
    study, names = prepared(read_study(folder / "study.toml"), ["all"], 16)
    return tune_all(study, names, folder / "out" / "results.sqlite")


# --- files ---


def test_every_file_is_there(folder: Path, answer: Answer) -> None:
    assert answer.code == 0, answer.err
    out = folder / "out"
    written = {str(item.relative_to(out)) for item in out.rglob("*") if item.is_file()}
    tables = {f"tables/{name}.{e}" for name in ("tuning", "gains", "classic") for e in ("csv", "md", "tex")}
    figures = {f"figures/{name}.png" for name in PICTURES}
    assert written == FILES | tables | figures | {"tuned/p.toml", "tuned/pd.toml"}


def test_the_page_shows_every_figure_that_there_is(folder: Path, answer: Answer) -> None:
    text = page(folder / "out")
    drawn = [(folder / "out" / "figures" / f"{name}.png").read_bytes() for name in PICTURES]
    assert sorted(pictures_of((folder / "out" / "tuning.html").read_text(encoding="utf-8"))) == sorted(drawn)
    assert text.count("<img") == len(PICTURES)
    assert "nan" not in text.replace("dominant", "")


def test_run_json_says_what_ran(folder: Path, answer: Answer) -> None:
    record = json.loads((folder / "out" / "run.json").read_text())
    assert record["title"] == "two controllers, tuned"
    assert record["controllers"] == ["p", "pd"]
    assert (record["trials"], record["seeds"]) == (16, {"search": [1, 2]})
    assert {"study", "tune", "program", "jobs", "wall_seconds", "started", "machine"} <= set(record)
    assert {"optuna", "numpy", "python"} <= set(record["versions"])


def test_the_result_is_json(tuning: Tuning) -> None:
    """What the folder says of how it was made, and of each controller what stands in results.csv."""
    content = json.loads(json.dumps(tuning.to_json(), allow_nan=False))
    assert content["controllers"] == ["p", "pd"]
    assert {"title", "study", "tune", "program", "trials", "seeds"} <= set(content)
    for kept, tuned in zip(content["tunings"], tuning.tuned, strict=True):
        assert tuned.score is not None
        assert (kept["controller"], kept["outcome"]) == (tuned.task.name, "tuned")
        assert kept["after"]["objective"] == tuned.score.value
        assert kept["before"]["objective"] == tuned.start.value
        assert kept["settings"]["kp"].endswith(" V/m")
        assert set(kept["objective_of_each_seed"]) == {"1", "2"}


def test_a_kill_leaves_neither_page_nor_record(tuning: Tuning, tmp_path: Path) -> None:
    """Where they stand from an earlier tuning, they go first."""
    for name in report.LAST:
        write(tmp_path, "old", name)
    with (
        mock.patch.object(report, "traces_of", side_effect=KeyboardInterrupt),
        pytest.raises(KeyboardInterrupt),
    ):
        report.write_tuning(tuning, tmp_path, began=0.0)
    assert not any((tmp_path / name).exists() for name in report.LAST)


# --- tables ---


def test_the_table_holds_the_numbers_of_the_results(folder: Path, answer: Answer) -> None:
    cells, rows = table(folder / "out", "tuning").set_index("controller"), results(folder / "out")
    assert list(cells.index) == list(rows.index) == ["p", "pd"]
    for name, row in rows.iterrows():
        shown = cells.loc[name]
        assert shown["objective, before"] == number(row["objective_before"])
        assert shown["objective, after"] == number(row["objective"])
        for when in ("before", "after"):
            assert shown[f"gain margin, {when} (dB)"] == margin(row[f"gain_margin_dB_{when}"])
            assert shown[f"phase margin, {when} (deg)"] == margin(row[f"phase_margin_deg_{when}"])
            for case in ("fast", "slow"):
                error = 1e3 * row[f"rms_error_m_{case}_{when}"]
                assert shown[f"rms error, {case}, {when} (mm)"] == number(error)
        assert shown["outcome"] == row["outcome"] == "tuned"
        assert shown["seeds differ"] == differ_words(row["seeds_differ"])


def test_the_yardstick_is_one_before_tuning(folder: Path, answer: Answer) -> None:
    assert results(folder / "out").loc["p", "objective_before"] == pytest.approx(1.0, rel=1e-12)


def test_a_gain_at_the_end_of_its_range_is_told(folder: Path, answer: Answer) -> None:
    gains = table(folder / "out", "gains").set_index(["controller", "gain"])
    kp = gains.loc[("p", "kp")]
    assert (kp["before"], kp["after"], kp["min"], kp["max"]) == ("600.0", "600.0", "100.0", "600.0")
    assert (kp["unit"], kp["scale"], kp["at an end"]) == ("V/m", "logarithmic", "upper")
    assert "At an end of their range stand kp of p (upper, 600.0 V/m)" in page(folder / "out")


@pytest.mark.parametrize(
    ("low", "high", "logarithmic", "value", "end"),
    [
        (1.0, 100.0, True, 1.04, "lower"),
        (1.0, 100.0, True, 1.06, ""),
        (1.0, 100.0, False, 1.9, "lower"),
        (0.0, 1.5, False, 1.486, "upper"),
        (0.0, 1.5, False, 1.48, ""),
    ],
)
def test_an_end_is_a_hundredth_of_the_range(low: float, high: float, logarithmic: bool, value: float, end: str) -> None:
    assert end_of(Dimension("kp", "V/m", low, high, logarithmic, low), value) == end


def test_classic_tunings_stand_beside_the_tuned_ones(folder: Path, answer: Answer) -> None:
    cells = table(folder / "out", "classic")
    tuned_here = cells[cells["method"] == "tuned here"].set_index("controller")
    assert len(cells) > len(tuned_here) == 2
    assert tuned_here.loc["pd", "objective"] == number(results(folder / "out").loc["pd", "objective"])


# --- words ---


def test_the_sentences_hold_the_numbers_of_the_table(folder: Path, answer: Answer) -> None:
    text, rows = page(folder / "out"), results(folder / "out")
    best, other = rows["objective"].idxmin(), rows["objective"].idxmax()
    values = {name: number(rows.loc[name, "objective"]) for name in rows.index}
    assert f"Best is {best} with an objective of {values[best]}, before {other} with {values[other]}." in text
    before, after = rows.loc["pd", "objective_before"], rows.loc["pd", "objective"]
    change = f"{100.0 * (after / before - 1.0):+.0f} %"
    assert f"Tuning lowered the objective of pd ({number(before)} to {number(after)}, {change})." in text
    assert "It left that of p as it was." in text


def test_a_smaller_objective_of_the_table_is_explained(tuning: Tuning) -> None:
    """Gains of the study that break a constraint stand in the table with a smaller objective than the best's."""
    p, pd_ = tuning.tuned
    assert p.score is not None
    assert pd_.score is not None
    least = min(p.score.nominal, pd_.score.nominal)
    start = replace(pd_.start, nominal=0.5 * least, violations={**pd_.start.violations, "phase margin": 12.0})
    lines = first_lines(replace(tuning, tuned=[p, replace(pd_, start=start)]))
    assert lines[1] == f"The gains of the study give pd less ({number(0.5 * least)}), but they break phase margin."
    assert not any("give" in line for line in first_lines(tuning))


def test_the_command_says_what_the_page_says(folder: Path, answer: Answer) -> None:
    first, *_ = answer.out.splitlines()
    assert first.startswith("Best is ")
    assert first in page(folder / "out")
    assert "| controller " in answer.out
    assert f"wrote {folder / 'out' / 'tuning.html'}" in answer.out


def test_the_page_says_what_was_held_equal(folder: Path, answer: Answer) -> None:
    text = page(folder / "out")
    assert "Budget: 2 searches of 16 trials each" in text
    assert "Objective: rms error; each figure over that of p with the gains of the study" in text
    assert "a gain margin of at least 6 dB and a phase margin of at least 45 deg" in text
    assert "Draws: none" in text


# --- figures ---


def test_a_loop_is_drawn_with_the_margins_that_it_has(folder: Path, answer: Answer) -> None:
    """|L| is 1 and its phase the margin above -180 degrees at one crossing; the reverse at the other."""
    task = task_for(read_study(folder / "study.toml"), "pd")
    setup = task.declared(task.start)[0].setup
    asked = margins(setup, 0.03)
    curve = curve_of(setup, asked, lowest_frequency([asked], setup.sample_time))
    assert np.interp(asked.phase_frequency, curve.frequency, curve.amplitude) == pytest.approx(0.0, abs=0.01)
    phase = np.interp(asked.phase_frequency, curve.frequency, curve.phase)
    assert phase == pytest.approx(asked.phase_deg - 180.0, abs=0.05)
    level = np.interp(asked.gain_frequency, curve.frequency, curve.amplitude)
    assert level == pytest.approx(-asked.gain_dB, abs=0.05)
    assert curve.phase[0] == pytest.approx(-90.0, abs=2.0)


def test_a_loop_without_crossings_has_an_axis() -> None:
    none = Margins(math.inf, math.inf, math.inf, math.inf, True, 0.03)
    assert lowest_frequency([none], 1e-3) == pytest.approx(0.002 * math.pi * 1e3)


def test_the_best_so_far_falls_to_the_best(tuning: Tuning) -> None:
    axes = history_picture(tuning).figure.axes[1]
    (line,) = [line for line in axes.lines if line.get_label() == "best so far"]
    heights = np.asarray(line.get_ydata(), dtype=float)
    assert np.all(np.diff(heights) <= 0.0)
    each = tuning.tuned[1]
    assert heights[-1] == pytest.approx(each.trials[each.number].value)


def test_importance_is_told_of_enough_feasible_trials(tuning: Tuning) -> None:
    """The same trials give the same shares, which make a whole."""
    assert importance(tuning.tuned[0]) == "kp is the only gain"
    with mock.patch("workbench.tune.report.importance.FEWEST", 4):
        shares = importance(tuning.tuned[1])
        assert isinstance(shares, dict)
        assert sum(shares.values()) == pytest.approx(1.0)
        assert shares == importance(tuning.tuned[1])
        assert not isinstance(importance_picture(tuning), str)


def test_before_and_after_differ_in_more_than_colour() -> None:
    assert len({side["linestyle"] for side in SIDES.values()}) == 2


def test_the_step_that_is_drawn_is_the_largest() -> None:
    """A rod at 0 that is asked for 0, then 10 mm, then 7 mm: the second counts, from its jump to the next."""
    levels = np.repeat([0.0, 0.010, 0.007], [100, 200, 50])
    run = SimpleNamespace(reference=(levels, 0.0 * levels, 0.0 * levels), state=lambda name: np.zeros(levels.size))
    assert largest_jump(run) == (0.010, slice(100, 300))
    run.state = lambda name: np.full(levels.size, -0.02)
    assert largest_jump(run) == (0.02, slice(0, 100))
