"""Cases that are run together have the rows that each has by itself."""

import math
from pathlib import Path

import pytest
from command import changed, write

from workbench.study import case_runs
from workbench.study.case_runs import CaseRuns
from workbench.study.plan import plan
from workbench.study.reading import read_study

CASES = 18


@pytest.fixture
def work(tmp_path: Path) -> CaseRuns:
    rpm = [25.0 * place for place in range(CASES)]
    return case_runs.case_runs(plan(read_study(write(tmp_path, changed("[0, 460]", str(rpm))))), tmp_path)


def test_rows_of_cases_run_together_are_those_of_each(work: CaseRuns, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("workbench.parallel.chunks.LONGEST", math.inf)
    assert case_runs.TOGETHER < CASES
    rows = work(range(CASES))
    assert [row.case for row in rows] == [*range(CASES)]
    assert rows == [row for place in range(CASES) for row in work([place])]


def test_cases_that_take_long_are_brought_back_unmade(work: CaseRuns, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("workbench.parallel.chunks.LONGEST", 0.0)
    assert [row.case for row in work([3, 1, 2])] == [3]


def test_rows_that_take_long_are_brought_back_one_by_one(work: CaseRuns, monkeypatch: pytest.MonkeyPatch) -> None:
    """As of a loop that is held until it tells whether it hunts: all are simulated soon, and judged late."""
    monkeypatch.setattr("workbench.parallel.chunks.LONGEST", math.inf)
    judged = CaseRuns._row

    def slowly(*arguments: object) -> object:
        monkeypatch.setattr("workbench.parallel.chunks.LONGEST", 0.0)
        return judged(*arguments)  # type: ignore[arg-type]

    monkeypatch.setattr(CaseRuns, "_row", slowly)
    assert [row.case for row in work([3, 1, 2])] == [3]
