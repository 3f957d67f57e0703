"""Runs of a decision are kept as they end: one that was killed goes on to the same bytes."""

import os
import signal
import sqlite3
from collections.abc import Sequence
from contextlib import closing
from pathlib import Path

import kills
import pytest
from command import changed, killed, workbench, write
from kill_studies import DECIDE

from workbench.decide.batches import NOTHING_KEPT, BatchRuns, Kept, SampleRun, batches, run_batches
from workbench.decide.kept import kept_runs
from workbench.decide.plan import plan_decision
from workbench.errors import UserError
from workbench.study.reading import read_study

SMALL = changed("fresh_draws = 60", "fresh_draws = 42", changed("rpm = [0, 125]", "rpm = [0]", DECIDE))


def stored(folder: Path) -> int:
    """How many runs are committed."""
    try:
        with closing(sqlite3.connect(f"file:{folder / 'runs.sqlite'}?mode=ro", uri=True)) as connection:
            return int(connection.execute("SELECT COUNT(*) FROM runs").fetchone()[0])
    except sqlite3.Error:
        return 0


def test_a_run_comes_back_as_it_was_kept(tmp_path: Path) -> None:
    """NaN and None too, to the last bit; a name is there once, however many runs have it."""
    plan = plan_decision(read_study(write(tmp_path, SMALL)))
    nan = float("nan")
    values = [("search", "feed", 0.0, 0.1 + 0.2, 1.0, number, "diverged", nan, nan, None) for number in range(2)]
    runs = [SampleRun(*each, 1e-300, None, False, False, True) for each in values]
    with kept_runs(tmp_path / "runs.sqlite", plan) as kept:
        assert kept.known == {}
        for run in runs:
            kept.keep(run)
    with kept_runs(tmp_path / "runs.sqlite", plan) as kept:
        first, second = kept.known.values()
    assert [repr(run) for run in (first, second)] == [repr(run) for run in runs]
    assert list(kept.known) == [run.key for run in runs]
    assert first.controller is second.controller


def test_what_is_kept_is_not_run_again(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Half of a batch: the rest is run, on the same machine, and all is as if nothing had been kept."""
    plan = plan_decision(
        read_study(write(tmp_path, changed('speed = "20 mm/s"', 'speed = "20 mm/s"\nspeeds = ["10 mm/s"]', SMALL)))
    )
    wanted = batches("search", [(candidate, speed, 1.0) for candidate in plan.candidates for speed in plan.speeds], [0])
    made: list[SampleRun] = []
    whole = run_batches(plan, wanted, 1, kept=Kept({}, made.append))
    assert len(made) == 4
    again: list[SampleRun] = []
    known = {run.key: run for run in made[1::2]}
    assert run_batches(plan, wanted, 1, kept=Kept(known, again.append)).equals(whole)
    assert again == made[::2]
    monkeypatch.setattr("workbench.decide.batches.simulate", None)
    assert run_batches(plan, wanted, 1, kept=Kept({run.key: run for run in made}, again.append)).equals(whole)
    assert NOTHING_KEPT.known == {}


def test_a_draw_that_takes_its_process_down_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    plan = plan_decision(read_study(write(tmp_path, SMALL)))
    wanted = batches("search", [(candidate, 0.02, 1.0) for candidate in plan.candidates], [0, 1])
    ran = BatchRuns.__call__

    def dies(work: BatchRuns, places: Sequence[int]) -> list[list[SampleRun]]:
        if 1 in places:
            os.kill(os.getpid(), signal.SIGKILL)
        return ran(work, places)

    monkeypatch.setattr(BatchRuns, "__call__", dies)
    made: list[SampleRun] = []
    with pytest.raises(UserError, match=r"^draw 1 at 0 rpm: its process was killed whenever it ran, .*--jobs 1$"):
        run_batches(plan, wanted, 2, kept=Kept({}, made.append))
    assert {run.number for run in made} == {0}, "what the others have brought back is kept"


@pytest.mark.usefixtures("dots_alone")
def test_a_killed_decision_goes_on_to_the_same_bytes(tmp_path: Path) -> None:
    study, part, whole = write(tmp_path, SMALL), tmp_path / "killed", tmp_path / "whole"
    killed(lambda: stored(part) >= 3, "decide", study, "--out", part, "--jobs", "1")
    kept = stored(part)
    assert kept >= 3
    assert not (part / "decision.html").exists()
    refused = workbench("decide", study, "--out", part)
    assert refused.err == f"error: {part}: holds runs already; go on with --resume, start anew with --overwrite\n"
    for folder, jobs in ((part, "2"), (whole, "1")):
        assert workbench("decide", study, "--out", folder, "--jobs", jobs, "--resume").code == 0
    assert stored(part) == stored(whole) > kept
    first, second = kills.contents(part), kills.contents(whole)
    assert {"draws.parquet", "decision.html", "run.json", "results.csv"} <= first.keys()
    assert first == second
    assert workbench("decide", study, "--out", whole).err.endswith(
        "holds a decision already; replace it with --overwrite\n"
    )
