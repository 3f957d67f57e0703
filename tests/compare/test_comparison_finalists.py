"""Who is measured again, and what hunts: it never wins, those behind it are measured, and rare hunting is open."""

from dataclasses import replace

import pandas as pd
import pytest
from made_up_comparison import SPEC, STEPS, cell, compared, verdict, whole

from workbench.compare.candidates import Cell
from workbench.compare.finalists import finalists
from workbench.compare.report.overview import hunting_sentences
from workbench.compare.report.words import sentences
from workbench.compare.section import COMPARISON


def test_what_hunts_never_wins_in_any_motion() -> None:
    """A plain loop that swings 1.40 mm while its mean error is 0.00207 mm was called sufficient."""
    errors = {("p", 0.0): 0.00207e-3, ("lugre", 0.0): 0.5e-3, ("p", 10.0): 0.3e-3}
    steps = cell(errors, place=STEPS, noise=0.01)
    hunts = (steps["controller"] == "p") & (steps["rpm"] == 0) & (steps["draw"] >= 7)
    steps.loc[hunts, ["limit_cycle", "limit_cycle_amplitude_m"]] = ["sustained", 1.4e-3]
    spec = SPEC.model_copy(update={"negligible": 0.013e-3})
    for reference in ("steps", "sine"):
        sine = cell(errors, noise=0.01)
        judged = compared(pd.concat([steps, sine]), spec).verdicts[Cell("rig", "nominal", reference)]
        assert judged.kind == "avoid"
        assert "nothing" not in judged.best
        told = sentences(spec, judged)
        assert "No candidate of plain at rest holds: hunts (least often p at rest, on 4 of 10 draws)." in told
    assert ("p", 0.0) not in [(each.controller, each.rpm) for each in finalists(spec, steps)]
    steps.loc[hunts, "limit_cycle"] = "too_short"
    assert verdict(steps, spec).kind == "avoid", "what may hunt does not win either"
    steps.loc[hunts, "limit_cycle"] = "decaying"
    assert verdict(steps, spec).kind == "nothing needed"
    assert hunting_sentences(compared(sine), "nominal")[0] == "Hunting was not judged: no reference holds still."


def test_who_hunts_only_on_a_fresh_draw_does_not_win_either() -> None:
    errors = {("p", 0.0): 9e-4, ("lugre", 0.0): 5e-4, ("p", 10.0): 3e-4, ("pi", 10.0): 4e-4}
    search = cell(errors, place=STEPS, noise=0.01)
    fresh = cell(errors, range(11, 21), place=STEPS, noise=0.01, seed=2)
    assert verdict(search, fresh=fresh).best["avoid"].controller == "p"
    fresh.loc[(fresh["controller"] == "p") & (fresh["rpm"] == 10) & (fresh["draw"] == 15), "limit_cycle"] = "sustained"
    judged = verdict(search, fresh=fresh)
    assert (judged.kind, judged.best["avoid"].controller, judged.fresh) == ("avoid", "pi", True)


def hunting_on(frame: pd.DataFrame, controller: str, rpm: float, draws: list[int]) -> pd.DataFrame:
    """The same where a candidate swings on these draws."""
    hunts = (frame["controller"] == controller) & (frame["rpm"] == rpm) & frame["draw"].isin(draws)
    return frame.assign(limit_cycle=frame["limit_cycle"].mask(hunts, "sustained"))


def test_what_rests_on_who_hunts_rarely_cannot_be_told() -> None:
    """One draw of sixty used to take a class out, and the verdict turned with the number of draws."""
    errors = {("p", 0.0): 9e-4, ("lugre", 0.0): 2e-4, ("p", 10.0): 3e-4}
    search = cell(errors, place=STEPS, noise=0.01)
    fresh = cell(errors, range(11, 61), place=STEPS, noise=0.01, seed=2)
    assert verdict(search, fresh=fresh).kind == "compensate"
    rarely = verdict(search, fresh=hunting_on(fresh, "lugre", 0.0, [15]))
    assert (rarely.kind, rarely.strictly, rarely.otherwise) == ("cannot be told", "avoid", "compensate")
    assert rarely.pair is None
    assert "compensate" not in rarely.best
    told = sentences(SPEC, rarely)
    assert told[0].startswith(
        "Cannot be told: avoid without what hunts on any draw, compensate with what hunts rarely: lugre at rest, 0.2"
    )
    assert told[0].endswith("hunts at a standstill on 1 of 50 draws, so on 0.0506 to 10.6 % of such machines.")
    often = verdict(search, fresh=hunting_on(fresh, "lugre", 0.0, [15, 20, 25, 30, 35, 40, 45]))
    assert (often.kind, often.otherwise) == ("avoid", None), "at least 5.8 % of such machines hunt"
    better = cell(errors | {("static_map", 0.0): 2.5e-4}, range(11, 61), place=STEPS, noise=0.01, seed=2)
    behind = verdict(
        cell(errors | {("static_map", 0.0): 2.5e-4}, place=STEPS, noise=0.01),
        fresh=hunting_on(better, "lugre", 0.0, [15]),
    )
    assert (behind.kind, behind.best["compensate"].controller) == ("compensate", "static_map")
    assert sentences(SPEC, behind)[1].startswith("Of compensation at rest, lugre at rest, 0.2")
    same = verdict(search, fresh=hunting_on(fresh, "p", 0.0, [15]))
    assert (same.kind, same.otherwise) == ("compensate", None), "the verdict does not rest on who hunts rarely"


def test_whoever_stands_behind_what_hunts_is_measured_until_one_holds() -> None:
    errors = {("p", 0.0): 9e-4, ("p", 10.0): 3e-4} | {(f"lugre{i}", 0.0): (1 + i) * 1e-4 for i in range(9)}
    search, fresh = (cell(errors, draws, 0.01, place=STEPS) for draws in (range(1, 11), range(11, 61)))
    measured: list[str] = []
    rounds = []
    for name in ("lugre0", "lugre1", "lugre2", "lugre3", "lugre4"):
        fresh = hunting_on(fresh, name, 0.0, [15, 20, 25, 30, 35, 40, 45])
    while wanted := finalists(SPEC, search, fresh[fresh["controller"].isin(measured)] if measured else None):
        rounds.append([each.controller for each in wanted if each.controller not in measured])
        measured += rounds[-1]
    assert rounds == [["p", "p", "lugre0"], ["lugre1", "lugre2", "lugre3"], ["lugre4", "lugre5", "lugre6"]]
    judged = verdict(search, fresh=fresh[fresh["controller"].isin(measured)])
    assert (judged.kind, judged.best["compensate"].controller) == ("avoid", "lugre5")


def test_the_order_of_the_study_decides_nothing() -> None:
    """Errors too small to be told used to tie, and whoever was listed first stood for its class."""
    errors = {("p", 0.0): 3e-9, ("pi", 0.0): 2e-9, ("lugre", 0.0): 3e-9, ("tafazoli", 0.0): 1e-9, ("p", 10.0): 1e-9}
    search, fresh = (cell(errors, draws, 0.01, place=STEPS) for draws in (range(1, 11), range(11, 61)))
    for step in (1, -1):
        best = verdict(search.iloc[::step], fresh=fresh).best
        assert (best["nothing"].controller, best["compensate"].controller) == ("pi", "tafazoli")
    hunting = hunting_on(fresh, "pi", 0.0, [15])
    assert verdict(search, fresh=hunting).kind == "nothing needed", "who errs as little as others is not in front"


def test_where_all_hunt_in_the_search_the_best_that_may_do_so_rarely_is_measured() -> None:
    errors = {("p", 0.0): 9e-4, ("p", 10.0): 3e-4, ("lugre", 0.0): 1e-4, ("tafazoli", 0.0): 2e-4}
    search = cell(errors, place=STEPS, noise=0.01)
    search = hunting_on(hunting_on(search, "lugre", 0.0, [1, 2, 3, 4]), "tafazoli", 0.0, [5])
    first = finalists(SPEC, search)
    assert {finalist.controller for finalist in first} == {"p"}
    fresh = cell(errors, range(11, 61), place=STEPS, noise=0.01, seed=2)
    known = fresh[fresh["controller"] == "p"]
    assert [finalist.controller for finalist in finalists(SPEC, search, known)] == ["tafazoli"]
    fresh = fresh[fresh["controller"] != "lugre"]
    assert finalists(SPEC, search, hunting_on(fresh, "tafazoli", 0.0, [15])) == []
    assert verdict(search, fresh=hunting_on(fresh, "tafazoli", 0.0, [15])).kind == "cannot be told"


@pytest.mark.parametrize("outcome", ["diverged", "torque-limited", "stuck"])
def test_what_does_not_complete_on_every_draw_never_wins(outcome: str) -> None:
    frame = cell({("p", 0.0): 9e-4, ("lugre", 0.0): 5e-4, ("p", 10.0): 3e-4, ("p", 25.0): 4e-4}, noise=0.01)
    frame.loc[(frame["rpm"] == 10) & (frame["draw"] == 3), "outcome"] = outcome
    assert verdict(frame).best["avoid"].rpm == 25
    frame.loc[frame["rpm"] == 25, "outcome"] = outcome
    judged = verdict(frame)
    assert judged.kind == "compensate", "nothing that rotates holds"
    assert f"No candidate of rotation holds: {outcome}." in sentences(SPEC, judged)
    assert verdict(frame.assign(outcome=outcome)).kind == "none holds"


def test_a_difference_within_the_solver_error_does_not_count() -> None:
    frame = cell({("p", 0.0): 9e-4, ("lugre", 0.0): 5e-4, ("p", 10.0): 3e-4}, noise=0.01)
    assert verdict(frame.assign(solver_rms_error_m=4e-4)).kind == "nothing needed"
    assert verdict(frame.assign(solver_error_m=4e-4)).kind != "nothing needed", "positions part where slips do"


def test_the_verdict_rests_on_fresh_draws() -> None:
    """Picked on draws where it is lucky, a candidate is judged where it is not."""
    search = cell({("p", 0.0): 9e-4, ("lugre", 0.0): 5e-4, ("p", 10.0): 1e-4}, noise=0.01)
    fresh = cell({("p", 0.0): 9e-4, ("lugre", 0.0): 5e-4, ("p", 10.0): 8e-4}, range(11, 21), noise=0.01, seed=2)
    assert verdict(search).kind == "avoid"
    assert verdict(search, fresh=fresh).kind == "compensate"


def test_finalists_are_the_best_of_each_class_and_family_and_the_cheapest_that_is_level() -> None:
    errors = {
        ("p", 0.0): 9e-4,
        ("pi", 0.0): 5e-4,
        ("load_pressure", 0.0): 4e-4,
        ("lugre", 0.0): 3e-4,
        ("tafazoli", 0.0): 8e-4,
        ("p", 10.0): 2.05e-4,
        ("p", 25.0): 2e-4,
        ("p", 50.0): 4e-4,
        ("lugre", 10.0): 1e-4,
        ("load_pressure", 10.0): 3e-4,
    }
    frame = cell(errors, noise=0.01)
    assert [(each.controller, each.rpm) for each in finalists(SPEC, frame)] == [
        ("pi", 0.0),
        ("load_pressure", 0.0),
        ("lugre", 0.0),
        ("p", 10.0),
        ("p", 25.0),
        ("lugre", 10.0),
        ("load_pressure", 10.0),
    ]
    again = COMPARISON.again(SPEC, frame, None)
    assert again is not None
    assert set(again.wanted[0]) == {"machine", "scenario", "reference", "controller", "rpm"}
    bare = COMPARISON.again(SPEC, frame.drop(columns="machine"), None)
    assert bare is not None
    assert set(bare.wanted[0]) == {"scenario", "reference", "controller", "rpm"}


def test_finalists_in_motion_are_measured_where_they_might_hunt_and_each_once() -> None:
    frame = whole()
    chosen = finalists(SPEC, frame)
    assert len(chosen) == len(set(chosen)) < len(frame) / 10
    moving = [finalist for finalist in chosen if finalist.cell.reference == "sine"]
    assert moving
    assert all(replace(each, cell=each.cell._replace(reference="steps")) in chosen for each in moving)
    assert chosen == finalists(SPEC, frame.sample(frac=1.0, random_state=1).sort_index())


def test_many_that_cannot_be_told_apart_are_not_all_measured_again() -> None:
    errors = {(f"lugre{i}", 0.0): 5e-4 for i in range(12)} | {("p", 0.0): 9e-4, ("p", 10.0): 9e-4}
    assert len(finalists(SPEC, cell(errors, noise=0.3))) <= 5
