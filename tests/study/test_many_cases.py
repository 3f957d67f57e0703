"""Studies with very many cases: they are made one by one, and those that stand for all are checked."""

from pathlib import Path

import numpy as np
import pytest
from command import STUDY, changed, ran, workbench, write

from workbench.study.cases import NAMES, Cases
from workbench.study.estimate import SAMPLED, estimate
from workbench.study.names import matches
from workbench.study.plan import MOST_CHECKED, plan
from workbench.study.reading import read_study
from workbench.study.study import DRAW
from workbench.study.unfold import unfold

UNCERTAIN = "[uncertainty]\ndraws = 3\nfriction = 0.0\nscale = { mass = { min = 0.5, max = 2.0 } }\n"

NAMED = (
    STUDY.replace("[axes]\nrpm = [0, 460]\n", "")
    + '[cases.a.axes]\nrpm = [0, 460]\n"simulation.seed" = [1, 2, 3]\n[cases.b.axes]\nrpm = ["60 rpm", 460]\n'
)
"""Six cases and two, whose axes differ."""


def cases_of(folder: Path, study: str) -> Cases:
    return unfold(read_study(write(folder, study)))


def large(count: int, text: str = STUDY) -> str:
    """So many cases, two speeds each."""
    seeds = ", ".join(map(str, range(count // 2)))
    return text.replace("rpm = [0, 460]", f'rpm = [0, 460]\n"simulation.seed" = [{seeds}]')


def test_a_case_is_the_same_however_it_is_asked_for(tmp_path: Path) -> None:
    cases = cases_of(tmp_path, NAMED)
    every = [*cases]
    assert len(cases) == len(every) == 8
    assert [case.index for case in every] == [*range(8)]
    assert [cases[i].columns for i in range(-8, 0)] == [case.columns for case in cases[:]]
    assert [cases.columns(i) for i in range(8)] == [case.columns for case in every]
    with pytest.raises(IndexError):
        cases[8]


@pytest.mark.parametrize(
    "wanted",
    [
        {},
        {"rpm": 460},
        {"rpm": "60 rpm"},
        {"case": "a", "simulation.seed": 2},
        {"simulation.seed": "3"},
        {"case": "b", "simulation.seed": None},
        {"other": 1},
        {"draw": 2},
    ],
)
@pytest.mark.parametrize("draws", ["", UNCERTAIN])
def test_cases_are_found_as_if_each_was_looked_at(tmp_path: Path, wanted: dict[str, object], draws: str) -> None:
    cases = plan(read_study(write(tmp_path, NAMED + draws))).cases
    assert len(cases) == (24 if draws else 8)
    expected = [case.index for case in cases if matches(case.columns, wanted)]
    assert cases.where(wanted).tolist() == expected


def test_those_that_stand_for_all_hold_every_name_and_every_number(tmp_path: Path) -> None:
    text = STUDY.replace(
        "rpm = [0, 460]",
        f'rpm = [0, 60, 460]\n"controllers.p.kp" = [100, 200, 300, 400]\n"simulation.seed" = {[*range(500)]}',
    )
    cases = cases_of(tmp_path, text)
    assert cases.bases == 6000
    told = [cases.columns(place) for place in cases.telling(3000)]
    assert 2000 < len(told) <= 3000
    for axis, values in cases.axes.items():
        assert {*values} == {columns[axis] for columns in told}, axis
        if axis not in NAMES:
            assert {(columns["rpm"], columns[axis]) for columns in told} >= {
                (rpm, one) for rpm in (0, 60, 460) for one in values
            }
    assert cases.telling(6000) == [*range(6000)]


def test_of_a_million_cases_few_are_built(tmp_path: Path) -> None:
    text = STUDY.replace(
        "rpm = [0, 460]", f'"controllers.p.kp" = {[*range(100, 1100)]}\n"simulation.seed" = {[*range(1000)]}'
    )
    planned = plan(read_study(write(tmp_path, text)))
    assert len(planned.cases) == 10**6
    assert MOST_CHECKED // 2 < len(planned.declared) <= MOST_CHECKED
    assert planned.cases[999_999].tables["simulation"]["seed"] == 999
    assert np.array_equal(planned.cases.where({"controllers.p.kp": 100}), np.arange(1000))


def test_a_mistake_on_any_value_of_an_axis_is_told_before_anything_runs(tmp_path: Path) -> None:
    seeds = [*range(MOST_CHECKED), -1]
    text = STUDY.replace("rpm = [0, 460]", f'rpm = [0, 460]\n"simulation.seed" = {seeds}')
    answer = workbench("run", write(tmp_path, text), "--out", tmp_path / "out")
    assert answer.code == 2
    assert "simulation.seed" in answer.err
    assert not (tmp_path / "out").exists()


def test_draws_are_numbered_and_only_the_first_tells_the_solvers_error(tmp_path: Path) -> None:
    cases = plan(read_study(write(tmp_path, STUDY + UNCERTAIN))).cases
    assert [case.axes[DRAW] for case in cases] == [1, 2, 3, 1, 2, 3]
    assert [case.tells_solver_error for case in cases] == [True, False, False] * 2
    factors = [case.overrides.sample.factors["mass"] for case in cases if case.overrides.sample is not None]
    assert factors[:3] == factors[3:]
    assert len({*factors}) == 3


def test_what_a_study_takes_is_told_from_some_of_it(tmp_path: Path) -> None:
    """Disk: of 200 cases, against what they leave; trajectories that are kept are counted."""
    text = large(200, changed('"1 s"', '"0.1 s"').replace('"0.4 s"', '"0.05 s"').replace("2 Hz", "20 Hz"))
    told = estimate(plan(read_study(write(tmp_path, text))))
    out = ran(tmp_path, text)
    left = sum((out / name).stat().st_size for name in ("results.sqlite", "results.csv", "results.parquet"))
    assert 0.5 * left < told.disk < 2.0 * left
    assert told.sampled <= SAMPLED
    kept = estimate(plan(read_study(write(tmp_path, text))), keep_all=True)
    assert kept.disk > told.disk + 200 * 1000
    assert told.seconds > 0.0
