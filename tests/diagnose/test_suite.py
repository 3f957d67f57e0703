"""The suite's scores, on diagnoses that are right, wrong, or fail; the sets of cases."""

from pathlib import Path

import pandas as pd
import pytest
from diagnosis.cases import SETS, make_cases
from diagnosis.effects import EFFECTS, UNLISTED
from diagnosis.scoring import confusion, figures
from diagnosis.suite import run_cases

CHOSEN = ("valve_deadband_0.5_0", "quadratic_drag_0.5_0", "constant_load+viscous_drift_0.7_1", "none_3", "cogging_1_0")


def scores(out: Path, stub: str, *, resume: bool = False) -> pd.DataFrame:
    cases = [case for case in make_cases("tuning") if case.name in CHOSEN]
    table, _ = run_cases(cases, out, f"diagnosis.stub:{stub}", jobs=1, resume=resume)
    return table.set_index("case")


def test_sets_have_every_case_and_other_seeds() -> None:
    tuning, reported = (make_cases(name) for name in SETS)
    assert len(tuning) == len(reported) == 18 * 3 * 2 + 6 * 2 + 12 + 4 * 2
    assert len({case.seed for case in [*tuning, *reported]}) == len(tuning) + len(reported)
    assert {case.truth for case in tuning} >= {*EFFECTS, *UNLISTED, "none"}
    some = make_cases("tuning", ["backlash", "none"], [0.03])
    assert [case.name for case in some[:2]] == ["backlash_0.03_0", "backlash_0.03_1"]
    assert len(some) == 2 + 12
    with pytest.raises(ValueError, match='"friction" is no effect'):
        make_cases("tuning", ["friction"])


def test_a_perfect_diagnosis(tmp_path: Path) -> None:
    table = scores(tmp_path, "perfect")
    listed = table.loc[list(CHOSEN[:3])]
    assert listed[["right_first", "right_or_alternative", "all_named"]].all(axis=None)
    assert (listed["held_out_ratio"] == 0.1).all()
    assert (table["over_floor"] == 1.0).all()
    assert table.loc["none_3", "none_named"]
    assert table.loc["cogging_1_0", "right_unexplained"]
    assert not table["wrong_named"].any()
    pd.testing.assert_frame_equal(scores(tmp_path, "failing", resume=True), table)  # nothing was run again
    assert "| valve_deadband |  |  | **1** |  |" in confusion(table.reset_index())
    assert "| no effect: none named | 1/1 |" in figures(table.reset_index())
    assert "| cogging: unexplained, right balance and signal, no name | 1/1 |" in figures(table.reset_index())


def test_a_stubborn_diagnosis(tmp_path: Path) -> None:
    table = scores(tmp_path, "stubborn")
    assert table["right_first"].tolist() == [False, False, True, False, False]
    assert table["right_or_alternative"].tolist() == [True, False, True, False, False]
    assert not table["all_named"][:3].any()
    assert not table["right_unexplained"].any()
    assert (table["held_out_ratio"].dropna() == 1.0).all()


def test_a_failing_diagnosis_is_a_row(tmp_path: Path) -> None:
    table = scores(tmp_path, "failing")
    assert (table["first"] == "failed").all()
    assert (table["error"] == "ArithmeticError: no").all()
    assert not table[["right_first", "none_named", "right_unexplained"]].any(axis=None)
