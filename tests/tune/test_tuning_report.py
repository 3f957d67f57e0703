"""The report of a tuning: its files, its tables against results.csv, its words, and what a kill leaves."""

import functools
import html
import json
import math
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from unittest import mock

import numpy as np
import pandas as pd
import pytest
from command import Answer, changed, workbench, write

from workbench.linear.margins import Margins
from workbench.linear.open_loop import margins
from workbench.publish.pictures import save
from workbench.study.reading import read_study
from workbench.tune.prepare import prepared, task_for
from workbench.tune.report import folder as report
from workbench.tune.report.bode import curve_of, lowest_frequency
from workbench.tune.report.history import history_picture
from workbench.tune.report.importance import importance, importance_picture
from workbench.tune.report.panels import SIDES
from workbench.tune.report.rows import end_of
from workbench.tune.report.step import largest_jump
from workbench.tune.report.tables import differ_words, margin, number, with_interval
from workbench.tune.report.words import first_lines
from workbench.tune.result import Quantile, Tuning
from workbench.tune.run import tune_all
from workbench.tune.space import Dimension

STUDY = """\
title = "two controllers, tuned"
question = "Which is better?"
[plant]
model = "non_rotating"
parameters = "owen2001_simulation"

[references.fast]
kind = "sine"
amplitude = "5 mm"
frequency = "2 Hz"

[references.slow]
kind = "sine"
amplitude = "5 mm"
frequency = "1 Hz"

[axes]
reference = ["fast", "slow"]
controller = ["p", "pd"]

[controllers.p]
type = "pid"
kp = "600 V/m"

[controllers.pd]
type = "pid"
kp = "500 V/m"
kd = "2 V s/m"

[simulation]
duration = "1.5 s"
transient = "0.5 s"

[tune]
trials = 16
seeds = 2

[tune.objective]
rms_error = 1

[tune.constraints]
hold_duration = "1 s"

[tune.gains.p]
kp = { min = "100 V/m", max = "600 V/m" }
"""
"""The P controller is best at the end of its range, where the study has it."""

WILD = '[controllers.wild]\ntype = "pid"\nkp = "20000 V/m"\n\n[simulation]'
LIMITS = '[tune.gains.wild]\nkp = { min = "20000 V/m", max = "50000 V/m" }\n'

ON_DRAWS = (
    changed(
        "trials = 16", "trials = 12\ndraws = 8\nfresh_draws = 8\nquantile = 0.5\nwhere = { reference = 'fast' }", STUDY
    )
    .replace("[simulation]", WILD)
    .replace('"p", "pd"', '"p", "pd", "wild"')
) + f"{LIMITS}[uncertainty]\nfriction = 0\n[uncertainty.scale]\nmass = {{ min = 0.8, max = 1.3 }}\n"
"""Half of the machines is a quantile that eight draws bound."""

FILES = {"study.toml", "results.csv", "trials.csv", "results.sqlite", "tuning.html", "run.json"}
PICTURES = ("history", "importance", "step", "error", "bode_p", "bode_pd")


def tuned(folder: Path, text: str) -> Answer:
    """The command, with figures as PNG alone: the other formats take long."""
    with mock.patch.object(report, "save", functools.partial(save, formats=("png",))):
        return workbench("tune", write(folder, text), "--out", folder / "out")


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("tuned")


@pytest.fixture(scope="module")
def answer(folder: Path) -> Answer:
    return tuned(folder, STUDY)


@pytest.fixture(scope="module")
def drawn(tmp_path_factory: pytest.TempPathFactory) -> tuple[Path, Answer]:
    """A tuning on draws, with a controller that no gains make stable."""
    folder = tmp_path_factory.mktemp("drawn")
    return folder / "out", tuned(folder, ON_DRAWS)


@pytest.fixture(scope="module")
def tuning(tmp_path_factory: pytest.TempPathFactory) -> Tuning:
    folder = tmp_path_factory.mktemp("found")
    study, names = prepared(read_study(write(folder, STUDY)), ["all"], 16)
    return tune_all(study, names, folder / "trials.sqlite")


def results(out: Path) -> pd.DataFrame:
    return pd.read_csv(out / "results.csv").set_index("controller")


def table(out: Path, name: str) -> pd.DataFrame:
    return pd.read_csv(out / "tables" / f"{name}.csv", dtype=str, keep_default_na=False)


def page(out: Path) -> str:
    return html.unescape((out / "tuning.html").read_text(encoding="utf-8"))


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
    for name in PICTURES:
        assert f'src="figures/{name}.png"' in text
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


# --- draws, and a controller that cannot be made stable ---


def test_a_controller_without_feasible_gains_is_told(drawn: tuple[Path, Answer]) -> None:
    out, answer = drawn
    assert answer.code == 0, answer.err
    (line,) = [line for line in answer.out.splitlines() if line.startswith("wild: ")]
    assert "no trial keeps all constraints" in line
    assert line in page(out)
    assert results(out).loc["wild", "outcome"] == line.removeprefix("wild: ").removesuffix(".")
    assert table(out, "tuning").set_index("controller").loc["wild", "outcome"] == "no feasible gains"
    assert not (out / "tuned" / "wild.toml").exists()
    assert not (out / "figures" / "bode_wild.png").exists()
    assert "No loop of wild: " in page(out)


def test_taken_up_again_a_tuning_says_the_same(drawn: tuple[Path, Answer]) -> None:
    """Trials that come from the file leave the same bytes."""
    out, answer = drawn
    before = {name: (out / name).read_bytes() for name in ("results.csv", "trials.csv", "tuning.html")}
    with mock.patch.object(report, "save", functools.partial(save, formats=("png",))):
        again = workbench("tune", out.parent / "study.toml", "--out", out, "--resume")
    assert again == answer
    assert before == {name: (out / name).read_bytes() for name in before}


def test_quantiles_on_draws_have_intervals(drawn: tuple[Path, Answer]) -> None:
    out, _ = drawn
    cells, rows = table(out, "tuning").set_index("controller"), results(out)
    for name in ("p", "pd"):
        for kind in ("searched", "fresh"):
            for when, key in (("before", "start"), ("after", "tuned")):
                numbers = [rows.loc[name, f"{key}_on_{kind}_{part}"] for part in ("value", "low", "high")]
                value, low, high = map(number, numbers)
                assert cells.loc[name, f"0.5 quantile, {kind} draws, {when}"] == f"{value} ({low} to {high})"
    assert rows.loc["pd", "objective"] == rows.loc["pd", "tuned_on_searched_value"]
    assert rows.loc["pd", "objective_before"] == rows.loc["pd", "start_on_searched_value"]


def test_the_page_says_whether_gains_are_fitted_to_their_draws(drawn: tuple[Path, Answer]) -> None:
    out, _ = drawn
    text, rows = page(out), results(out).loc[["p", "pd"]]
    overlap = (rows["tuned_on_searched_low"] <= rows["tuned_on_fresh_high"]) & (
        rows["tuned_on_fresh_low"] <= rows["tuned_on_searched_high"]
    )
    fine = " and ".join(overlap[overlap].index)
    assert f"No sign of overfitting of {fine}: the intervals on searched and on fresh draws overlap." in text
    assert "Best is pd with a 0.5 quantile of the objective on draws that the search has not seen of " in text
    assert "over 8 drawn machines, the same for every controller, is made small; 8 others check it" in text


def test_an_interval_says_why_it_has_no_end() -> None:
    assert with_interval(Quantile(0.41, 0.38, 0.47, 100), 0.9) == "0.410 (0.380 to 0.470)"
    few = with_interval(Quantile(0.41, 0.38, math.inf, 12), 0.9)
    assert few == "0.410 (0.380 upwards, not bounded by so few draws)"
    failing = with_interval(Quantile(0.41, 0.38, math.inf, 200), 0.9)
    assert failing == "0.410 (0.380 upwards, infinite: runs fail on too many draws)"


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
