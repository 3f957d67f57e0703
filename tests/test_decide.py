"""Deciding: intervals and tests against published values, machines that are the same for all, answers that must be."""

import math
from pathlib import Path

import pandas as pd
import pytest
from command import STUDIES, changed, fails, workbench, write

from workbench.decide.decision import Decision, decide
from workbench.decide.judgement import Judged, judge, non_dominated, ordered, results
from workbench.decide.plan import Plan, plan_decision
from workbench.metrics.statistics import quantile, quantile_interval, share_interval, sign_test
from workbench.report.decision_words import assumptions, millimetres, paragraph, question
from workbench.study.decide_schema import DecideTable
from workbench.study.document import read_study

STUDY = """\
title = "a decision, for tests"
[plant]
model = "by_rpm"
bristle = "isotropic"
parameters = "owen2001_simulation"
[simulation]
seed = 1
[controllers.feed]
type = "pid"
kp = "500 V/m"
feedforward = 1
[controllers.lugre]
type = "lugre"
law = "valve_inversion"
[uncertainty]
scale.mass = { min = 0.8, max = 1.5 }
noise.position = { max = "2 um" }
[decide]
accuracy = "1 mm"
speed = "20 mm/s"
amplitude = "1 mm"
power = "1 kW"
draws = 3
rpm = [0, 125]
plain = ["feed"]
"""

TABLE = DecideTable.model_validate(
    {"accuracy": 1e-5, "speed": 8e-3, "amplitude": 5e-3, "power": 80.0, "rpm": [0, 25], "plain": ["feed"]}
)


def planned(folder: Path, text: str = STUDY) -> Plan:
    return plan_decision(read_study(write(folder, text)))


def decided(folder: Path, text: str = STUDY) -> Decision:
    return decide(planned(folder, text), jobs=2)


def judged(controller: str, rpm: float, error: float, power: float, met: int = 0) -> Judged:
    """A candidate with this error quantile and power, which `met` of 64 draws keep to."""
    passed = (True,) * met + (False,) * (64 - met)
    kind = "rotation" if rpm else "plain"
    shares, errors = share_interval(met, 64), (error, 0.9 * error, 1.1 * error)
    return Judged(controller, rpm, 8e-3, 1.0, kind, "completed", passed, *shares, 0.5, 1.0, *errors, power, power)


@pytest.mark.parametrize(
    ("successes", "trials", "low", "high"),
    [(81, 263, 0.2553, 0.3662), (15, 148, 0.0624, 0.1605), (0, 20, 0.0, 0.1611), (1, 29, 0.0061, 0.1718)],
)
def test_interval_of_a_share_is_as_published(successes: int, trials: int, low: float, high: float) -> None:
    """Newcombe 1998, Statistics in Medicine 17, 857, table I, method 3 (Wilson's score)."""
    assert share_interval(successes, trials) == pytest.approx((low, high), abs=5e-5)


def test_interval_of_a_quantile_is_between_the_textbook_ranks() -> None:
    """The median of ten: the second to the ninth (97.9 %; Conover, Practical Nonparametric Statistics, section 3.2)."""
    values = [float(value) for value in range(10, 0, -1)]
    assert (quantile(values, 0.5), quantile_interval(values, 0.5)) == (5.0, (2.0, 9.0))
    assert quantile_interval(values, 0.9)[1] == math.inf  # 0.9^10 = 0.35: the largest may well be below it
    assert quantile(values, 0.9) == 9.0


def test_sign_test_counts_what_differs() -> None:
    """Six of six: 2 / 2^6; five of six: 2 (1 + 6) / 2^6."""
    first, second = [True] * 6 + [True, False], [False] * 6 + [True, False]
    assert sign_test(first, second) == (6, 0, pytest.approx(0.03125))
    assert sign_test([*first[:5], False], [*second[:5], True]) == (5, 1, pytest.approx(0.21875))
    assert sign_test(first, first) == (0, 0, 1.0)


def test_non_dominated_set_of_points() -> None:
    """The best of about one power, then each that is better than all that need less."""
    points = [(3.0, 9.0), (3.1, 8.0), (26.0, 7.0), (26.5, 7.5), (100.0, 7.0), (240.0, 5.0), (250.0, 6.0)]
    rows = [judged("feed", 0.0, error, power) for power, error in points]
    front = [(row.mean_power, row.error) for row in non_dominated([*rows, judged("feed", 0.0, math.inf, 1.0)])]
    assert front == [(3.1, 8.0), (26.0, 7.0), (240.0, 5.0)]


def test_candidates_that_meet_come_first_by_power_then_error() -> None:
    rows = [
        judged("nearer", 25.0, 1.1e-5, 20.0, 50),
        judged("dear", 25.0, 1e-6, 25.0, 64),
        judged("cheap", 0.0, 9e-6, 3.0, 60),
        judged("cheap and better", 0.0, 5e-6, 3.1, 60),
        judged("far", 0.0, 1e-4, 3.0, 0),
        judged("very far", 0.0, 1e-3, 3.0, 0),
    ]
    assert [row.controller for row in ordered(rows, TABLE)] == [
        "cheap and better", "cheap", "dear", "nearer", "far", "very far"]  # fmt: skip


def test_runs_that_do_not_complete_do_not_meet() -> None:
    """Three of four complete: the 90 % quantile of the error has no bound, and is left empty."""
    place = {"controller": "feed", "rpm": 0.0, "speed_m_per_s": 8e-3, "spread": 1.0}
    outcomes = ["completed", "stuck", "completed", "completed"]
    rows = [
        {**place, "draw": i, "outcome": outcome, "error_m": 1e-6, "power_W": 3.0 + i}
        | {"meets_accuracy": outcome == "completed", "meets_power": outcome == "completed"}
        for i, outcome in enumerate(outcomes)
    ]
    (found,) = judge(pd.DataFrame(rows), TABLE)
    assert (found.met, found.outcome, found.error) == (3, "3 completed, 1 stuck", math.inf)
    assert found.mean_power == pytest.approx((3.0 + 5.0 + 6.0) / 3.0)
    assert pd.isna(results([found])["error_quantile_m"][0])


def test_machines_are_the_same_for_all_and_nested_over_the_spread(tmp_path: Path) -> None:
    plan = planned(tmp_path, STUDY.replace("draws = 3", "draws = 3\nspreads = [0, 0.5]"))
    first, other = (plan.machine((name, 0.0), 0.02, 1.0, 2).setup for name in ("feed", "lugre"))
    assert (first.parameters, first.sensors, first.seed) == (other.parameters, other.sensors, other.seed)
    turning = plan.machine(("feed", 125.0), 0.02, 1.0, 2).setup
    assert (turning.parameters.friction, turning.seed) == (first.parameters.friction, first.seed)

    drawn = [plan.machine(("feed", 0.0), 0.02, spread, 2).setup for spread in (0.0, 0.5, 1.0)]
    none, half, whole = (setup.parameters.friction.positive for setup in drawn)
    for name in none._fields:
        of_half, of_whole = getattr(half, name) - getattr(none, name), getattr(whole, name) - getattr(none, name)
        assert of_half != 0.0
        assert of_half == pytest.approx(0.5 * of_whole)
    assert len({setup.parameters.body.mass for setup in drawn}) == 1
    assert plan.machine(("feed", 0.0), 0.02, 1.0, 1).setup.parameters != first.parameters


def test_a_large_accuracy_takes_plain_control(tmp_path: Path) -> None:
    found = decided(tmp_path)
    given = found.answer(0.02, 1.0)
    assert (given.kind, given.best.controller, given.best.rpm, given.best.met) == ("plain", "feed", 0.0, 3)
    assert paragraph(found).startswith("Plain control suffices: feed without rotation on 3 of 3 machines")


def test_friction_without_a_compensator_takes_rotation(tmp_path: Path) -> None:
    """Rotation takes the friction out of the way of P with feed-forward, and costs what the power limit leaves."""
    text = changed('accuracy = "1 mm"', 'accuracy = "30 um"\ncontrollers = ["feed"]', STUDY)
    text = changed("[simulation]", "scale = { coulomb = 4, stribeck = 4 }\n[simulation]", text)
    text = changed('speed = "20 mm/s"', 'speed = "5 mm/s"', text)
    found = decided(tmp_path, text)
    given = found.answer(found.table.speed, 1.0)
    assert (given.kind, given.best.rpm, given.best.met) == ("rotation", 125.0, 3)
    still = next(row for row in found.asked if row.rpm == 0)
    assert (still.met, still.accurate, still.within_power) == (0, 0.0, 1.0)
    assert "Only rotation suffices: feed at 125 rpm" in paragraph(found)

    poor = decided(tmp_path, changed('power = "1 kW"', 'power = "10 W"', text))
    assert poor.answer(poor.table.speed, 1.0).kind is None


def test_a_nanometre_is_met_by_nothing_and_the_miss_is_told(tmp_path: Path) -> None:
    found = decided(tmp_path, changed('accuracy = "1 mm"', 'accuracy = "1 nm"', STUDY))
    given = found.answer(0.02, 1.0)
    assert (given.kind, given.best.met, given.best.error) == (None, 0, min(row.error for row in found.asked))
    said = paragraph(found)
    assert said.startswith("Nothing that was tried suffices. Nearest is ")
    assert f"at the 90 % quantile it misses the accuracy by {millimetres(given.best.error - 1e-9)} (" in said


def test_the_words_hold_the_numbers_of_the_table(tmp_path: Path) -> None:
    """Everything that the answer tells of the best of each kind stands in its row of the table."""
    out = tmp_path / "out"
    answer = workbench("decide", write(tmp_path, STUDY), "--out", out)
    assert (answer.code, answer.err) == (0, "")
    assert "Asked: an rms error of at most 1 mm at 20 mm/s (a sine of 1 mm, 3.18 Hz) with at most 1000 W" in answer.out
    candidates = pd.read_csv(out / "tables" / "candidates.csv", dtype=str)
    for name, rpm in (("feed", "0"), ("lugre", "0")):
        row = candidates[(candidates["candidate"] == name) & (candidates["rotation (rpm)"] == rpm)].iloc[0]
        error, power = row["rms error, 90 % (mm)"], row["mean power (W)"]
        assert row["on"] == "3 of 3"
        assert (
            f"{name} without rotation on 3 of 3 machines (probability 1.00, 95 % interval 0.44 to 1.00)" in answer.out
        )
        assert f"with at most {error} mm on 90 % of them at {power} W on average" in answer.out
    page = (out / "decision.html").read_text(encoding="utf-8")
    assert "Plain control suffices: feed without rotation" in page
    assert {path.suffix for path in (out / "figures").glob("error_against_power.*")} == {".pdf", ".svg", ".png"}
    fails(workbench("decide", tmp_path / "study.toml", "--out", out), "holds a decision already", "--overwrite")
    assert workbench("table", out, "--column", "probability", "--where", "rpm=125").code == 0


def test_the_same_bytes_whatever_the_number_of_jobs(tmp_path: Path) -> None:
    text = changed("draws = 3", 'draws = 3\nspeeds = ["10 mm/s"]\nspreads = [0]', STUDY)
    path = write(tmp_path, text)
    written = []
    for jobs in ("1", "2"):
        out = tmp_path / jobs
        assert workbench("decide", path, "--out", out, "--jobs", jobs).code == 0
        written.append([(out / name).read_bytes() for name in ("results.csv", "draws.parquet", "decision.html")])
        assert sorted(item.name for item in (out / "figures").glob("*.png")) == [
            "error_against_power.png", "error_against_speed.png", "map.png"]  # fmt: skip
    assert written[0] == written[1]
    frame = pd.read_csv(tmp_path / "1" / "results.csv")
    assert list(frame["rpm"].unique()) == [0, 125]
    assert len(frame) == 2 * 2 * 2 * 2


def test_without_uncertainty_there_is_one_machine(tmp_path: Path) -> None:
    head, rest = STUDY[: STUDY.index("[uncertainty]")], STUDY[STUDY.index("[decide]") :]
    found = decided(tmp_path, head + rest + "spread = 0\n")
    assert [row.draws for row in found.rows] == [1] * 4
    assert "on the declared machine" in question(found)
    assert "machines" not in paragraph(found)
    fails(
        workbench("decide", write(tmp_path, head + rest), "--out", tmp_path / "out"),
        ":",
        "decide.spread: the study has",
    )


@pytest.mark.parametrize(
    ("old", "new", "said"),
    [
        ('accuracy = "1 mm"', 'accuracy = "0 mm"', "study.toml:19: decide.accuracy: got 0.0: input should be "),
        ("rpm = [0, 125]", "rpm = []", "study.toml:24: decide.rpm: is empty: expected at least one entry"),
        ("rpm = [0, 125]", "rpm = [0, 0]", "study.toml:18: decide: rpm holds a value twice"),
        ('plain = ["feed"]', 'plain = ["fed"]', 'study.toml:25: decide.plain: unknown controller "fed"; did you mean'),
        ('plain = ["feed"]', 'plain = ["feed"]\ncontrollers = ["x"]', 'study.toml:26: decide.controllers: unknown '),
        ('plain = ["feed"]', 'plain = ["feed"]\nspeeds = []', "study.toml:26: decide.speeds: is empty"),
        ('model = "by_rpm"', 'model = "non_rotating"', 'study.toml:24: decide.rpm: plant "non_rotating" does not '),
        ('speed = "20 mm/s"', 'speed = "2 m/s"', "study.toml:20: decide.speed: 2 m/s over 0.001 m is a period of "),
        ('amplitude = "1 mm"', 'amplitude = "40 mm"', "study.toml:21: decide.amplitude: got 0.04 m, the stroke ends "),
        ("[decide]", "[decide]\nspred = 1", 'study.toml:19: decide.spred: unknown key; did you mean "spread"?'),
        ("scale.mass", "scale.mas", 'study.toml:16: uncertainty.scale.mas: unknown parameter; did you mean "mass"?'),
        ('law = "valve_inversion"', 'law = "valve_inversion"\nkp = "1 V/m"', "study.toml:15: controllers.lugre.kp: "),
        ('"owen2001_simulation"', '"owen2002"', 'study.toml:5: plant.parameters: unknown parameter set "owen2002"'),
        ('type = "lugre"', 'type = "lugr"', 'study.toml:13: controllers.lugre.type: unknown controller "lugr"'),
        ("[simulation]", "spread.coulomb = 1\n[simulation]", "study.toml:6: plant.spread: [decide] spreads friction"),
    ],
)  # fmt: skip
def test_mistakes_are_told_in_a_line(tmp_path: Path, old: str, new: str, said: str) -> None:
    path = write(tmp_path, changed(old, new, STUDY))
    fails(workbench("decide", path, "--out", tmp_path / "out"), said)
    fails(workbench("check", path), said)
    assert not (tmp_path / "out").exists()


def test_tuned_gains_are_taken_from_their_file(tmp_path: Path) -> None:
    gains = (
        'title = "t"\nsource = "s"\ntype = "pid"\nsettings = { kp = "300 V/m", feedforward = 0.9 }\nobjective = {}\n'
        'margins = { speed = "1 mm/s" }\nsearch = {}\n'
    )
    write(tmp_path, gains, "feed.toml")
    text = changed('type = "pid"\nkp = "500 V/m"\nfeedforward = 1', 'gains = "feed.toml"', STUDY)
    found = decided(tmp_path, text)
    assert found.plan.loops["feed", 0.0].gains.proportional == 300.0
    assert "Tuned gains: feed; all others as the study gives them." in " ".join(assumptions(found))


def test_a_study_without_decide(tmp_path: Path) -> None:
    path = write(tmp_path, STUDY[: STUDY.index("[decide]")])
    fails(workbench("decide", path, "--out", tmp_path / "out"), "study.toml: has no [decide]")


def test_run_points_to_decide(tmp_path: Path) -> None:
    fails(workbench("run", STUDIES / "decision.toml", "--out", tmp_path / "out"), "use workbench decide ")
