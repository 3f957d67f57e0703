"""Decisions of studies: machines that are the same for all, answers that must be, words that hold the numbers."""

import json
import re
from pathlib import Path

import pandas as pd
import pytest
from command import STUDIES, changed, fails, workbench, write
from kill_studies import DECIDE as STUDY

from workbench.decide.batches import batches, run_batches
from workbench.decide.candidate import candidate_results
from workbench.decide.plan import Plan, plan_decision
from workbench.decide.report.answer import paragraph
from workbench.decide.report.map import failing
from workbench.decide.report.names import millimetres, watts
from workbench.decide.report.words import assumptions, price, question
from workbench.decide.result import Decision
from workbench.decide.run import decide
from workbench.study.reading import read_study

FEW = changed("fresh_draws = 60", "probability = 0.5\nfresh_draws = 8", STUDY)
"""With few fresh draws, which can show the probability that is asked for."""


def planned(folder: Path, text: str = STUDY) -> Plan:
    return plan_decision(read_study(write(folder, text)))


def decided(folder: Path, text: str = STUDY) -> Decision:
    return decide(planned(folder, text), jobs=2)


def test_machines_are_the_same_for_all_and_nested_over_the_spread(tmp_path: Path) -> None:
    plan = planned(tmp_path, STUDY.replace("draws = 3", "draws = 3\nspreads = [0, 0.5]"))
    first, other = (plan.sampled((name, 0.0), 0.02, 1.0, 2, "search").setup for name in ("feed", "lugre"))
    assert (first.parameters, first.sensors, first.seed) == (other.parameters, other.sensors, other.seed)
    turning = plan.sampled(("feed", 125.0), 0.02, 1.0, 2, "search").setup
    assert (turning.parameters.friction, turning.seed) == (first.parameters.friction, first.seed)

    drawn = [plan.sampled(("feed", 0.0), 0.02, spread, 2, "search").setup for spread in (0.0, 0.5, 1.0)]
    none, half, whole = (setup.parameters.friction.positive for setup in drawn)
    for name in none._fields:
        of_half, of_whole = getattr(half, name) - getattr(none, name), getattr(whole, name) - getattr(none, name)
        assert of_half != 0.0
        assert of_half == pytest.approx(0.5 * of_whole)
    assert len({setup.parameters.body.mass for setup in drawn}) == 1
    assert plan.sampled(("feed", 0.0), 0.02, 1.0, 1, "search").setup.parameters != first.parameters
    assert plan.sampled(("feed", 0.0), 0.02, 1.0, 2, "fresh").setup.parameters != first.parameters


def test_a_large_accuracy_takes_plain_control(tmp_path: Path) -> None:
    progress: list[tuple[str, float | None]] = []
    decision = decide(planned(tmp_path), 2, lambda doing, done=None, /: progress.append((doing, done)))
    shares = [done for _, done in progress if done is not None]
    assert progress[0][0] == "search: 2 of 12 runs"
    assert progress[-1][0] == "fresh draws, round 4: 60 of 60 runs"
    assert len(shares) == len(progress)
    assert max(shares) < 1.0
    given = decision.answer(0.02, 1.0)
    assert (given.kind, given.best.controller, given.best.rpm, given.best.met) == ("plain", "feed", 0.0, 60)
    assert paragraph(decision).startswith("Plain control suffices: feed without rotation on 60 of 60 fresh machines")
    content = json.loads(json.dumps(decision.to_json(), allow_nan=False))
    (cell,) = content["cells"]
    assert (cell["kind"], cell["settled"], cell["best"]["controller"]) == ("plain", True, "feed")
    assert (cell["best"]["met"], cell["best"]["standing"]) == (60, "meets")
    assert len(cell["candidates"]) == 4
    assert content["runs"] == len(decision.draws)


def test_friction_without_a_compensator_takes_rotation(tmp_path: Path) -> None:
    """Rotation takes the friction out of the way of P with feed-forward, and costs what the power limit leaves."""
    text = changed('accuracy = "1 mm"', 'accuracy = "30 um"\ncontrollers = ["feed"]', STUDY)
    text = changed("[simulation]", "scale = { coulomb = 4, stribeck = 4 }\n[simulation]", text)
    text = changed('power = "2 kW"', 'power = "20 kW"', text)
    text = changed('speed = "20 mm/s"', 'speed = "5 mm/s"', text)
    decision = decided(tmp_path, text)
    given = decision.answer(decision.table.speed, 1.0)
    assert (given.kind, given.best.rpm, given.best.met) == ("rotation", 125.0, 60)
    still = next(row for row in decision.asked.rows if row.rpm == 0)
    assert (still.met, still.accurate, still.within_power) == (0, 0.0, 1.0)
    assert "Only rotation suffices: feed at 125 rpm" in paragraph(decision)

    poor = decided(tmp_path, changed('power = "20 kW"', 'power = "30 W"', text))
    assert poor.answer(poor.table.speed, 1.0).kind is None
    failed = {row.kind: row.main_failure for row in failing(poor, poor.asked)}
    assert failed == {"plain": "accuracy", "rotation": "power"}


def test_a_nanometre_is_met_by_nothing_and_the_miss_is_told(tmp_path: Path) -> None:
    decision = decided(tmp_path, changed('accuracy = "1 mm"', 'accuracy = "1 nm"', STUDY))
    given = decision.answer(0.02, 1.0)
    assert (given.kind, given.best.met, given.best.error) == (None, 0, min(row.error for row in decision.asked.rows))
    words = paragraph(decision)
    assert words.startswith("Nothing that was tried suffices. Nearest is ")
    assert f"at the 90 % quantile it misses the accuracy by {millimetres(given.best.error - 1e-9)} (" in words


def test_the_words_hold_the_numbers_of_the_table(tmp_path: Path) -> None:
    """Everything that the answer tells of the best of each kind stands in its row of the table."""
    out = tmp_path / "out"
    answer = workbench("decide", write(tmp_path, STUDY), "--out", out)
    assert (answer.code, answer.err) == (0, "")
    assert "Asked: an rms error of at most 1 mm at 20 mm/s (a sine of 1 mm, 3.18 Hz) with at most 2000 W" in answer.out
    candidates = pd.read_csv(out / "tables" / "candidates.csv", dtype=str)
    for name, rpm in (("feed", "0"), ("lugre", "0")):
        row = candidates[(candidates["candidate"] == name) & (candidates["rotation (rpm)"] == rpm)].iloc[0]
        error, power = row["rms error, 90 % (mm)"], row["mean power (W)"]
        assert (row["search"], row["fresh"]) == ("3 of 3", "60 of 60")
        assert f"{name} without rotation on 60 of 60 fresh machines (probability 1, 95 % interval 0." in answer.out
        assert f"with at most {error} mm on 90 % of them at {power} W on average" in answer.out
    page = (out / "decision.html").read_text(encoding="utf-8")
    assert "Plain control suffices: feed without rotation" in page
    assert {path.suffix for path in (out / "figures").glob("error_against_power.*")} == {".pdf", ".svg", ".png"}
    fails(workbench("decide", tmp_path / "study.toml", "--out", out), "holds a decision already", "--overwrite")
    assert workbench("table", out, "--column", "probability", "--where", "rpm=125").code == 0


@pytest.mark.usefixtures("png_alone")
def test_the_same_bytes_whatever_the_number_of_jobs(tmp_path: Path) -> None:
    text = changed("\ndraws = 3", '\ndraws = 3\nspeeds = ["10 mm/s"]\nspreads = [0]', FEW)
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
    decision = decided(tmp_path, head + rest + "spread = 0\n")
    assert [row.draws for row in decision.asked.rows] == [1] * 4
    assert "on the declared machine" in question(decision)
    assert "machines" not in paragraph(decision)
    fails(
        workbench("decide", write(tmp_path, head + rest), "--out", tmp_path / "out"),
        ":",
        "decide.spread: the study has",
    )


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ('accuracy = "1 mm"', 'accuracy = "0 mm"', "study.toml:20: decide.accuracy: got 0.0: input should be "),
        ("rpm = [0, 125]", "rpm = []", "study.toml:25: decide.rpm: is empty: expected at least one entry"),
        ("rpm = [0, 125]", "rpm = [0, 0]", "study.toml:19: decide: rpm holds a value twice"),
        ('plain = ["feed"]', 'plain = ["fed"]', 'study.toml:26: decide.plain: unknown controller "fed"; did you mean'),
        ('plain = ["feed"]', 'plain = ["feed"]\ncontrollers = ["x"]', 'study.toml:27: decide.controllers: unknown '),
        ('plain = ["feed"]', 'plain = ["feed"]\nspeeds = []', "study.toml:27: decide.speeds: is empty"),
        ('model = "by_rpm"', 'model = "non_rotating"', 'study.toml:25: decide.rpm: plant "non_rotating" does not '),
        ('speed = "20 mm/s"', 'speed = "2 m/s"', "study.toml:21: decide.speed: 2 m/s over 0.001 m is a period of "),
        ('amplitude = "1 mm"', 'amplitude = "40 mm"', "study.toml:22: decide.amplitude: got 0.04 m, the stroke ends "),
        ("[decide]", "[decide]\nspred = 1", 'study.toml:20: decide.spred: unknown key; did you mean "spread"?'),
        ("scale.mass", "scale.mas", 'study.toml:17: uncertainty.scale.mas: unknown parameter; did you mean "mass"?'),
        ('law = "valve_inversion"', 'law = "valve_inversion"\nkp = "1 V/m"', "study.toml:16: controllers.lugre.kp: "),
        ('"owen2001_simulation"', '"owen2002"', 'study.toml:5: plant.parameters: unknown parameter set "owen2002"'),
        ('type = "lugre"', 'type = "lugr"', 'study.toml:14: controllers.lugre.type: unknown controller "lugr"'),
        ("[simulation]", "spread.coulomb = 1\n[simulation]", "study.toml:7: plant.spread: [decide] spreads friction"),
    ],
)  # fmt: skip
def test_mistakes_are_told_in_a_line(tmp_path: Path, old: str, new: str, words: str) -> None:
    path = write(tmp_path, changed(old, new, STUDY))
    fails(workbench("decide", path, "--out", tmp_path / "out"), words)
    fails(workbench("check", path), words)
    assert not (tmp_path / "out").exists()


def test_tuned_gains_are_taken_from_their_file(tmp_path: Path) -> None:
    gains = (
        'title = "t"\nsource = "s"\ntype = "pid"\n[[at]]\nrpm = 0\nsettings = { kp = "300 V/m", feedforward = 0.9 }\n'
        'objective = {}\nmargins = { speed = "1 mm/s" }\nsearch = {}\n'
        '[[at]]\nrpm = 125\nsettings = { kp = "200 V/m", feedforward = 0.8 }\n'
        'objective = {}\nmargins = { speed = "1 mm/s" }\nsearch = {}\n'
    )
    write(tmp_path, gains, "feed.toml")
    text = changed('type = "pid"\nkp = "500 V/m"\nfeedforward = 1', 'gains = "feed.toml"', FEW)
    decision = decided(tmp_path, text)
    assert [decision.plan.loops["feed", rpm].gains.proportional for rpm in (0.0, 125.0)] == [300.0, 200.0]
    assert "Tuned gains: feed; all others as the study gives them." in " ".join(assumptions(decision))


def test_rotating_does_not_change_what_the_pump_pays(tmp_path: Path) -> None:
    """The pump pays supply pressure times the flow that the motion takes: P_s A 2/pi v for a sine of peak speed v."""
    decision = decided(tmp_path, changed("draws = 3", 'draws = 2\nspread = 0\nmachine = "thesis_simulation"', STUDY))
    rows = decision.draws[decision.draws["stage"] == "search"]
    still, turning = (rows[rows["rpm"] == rpm] for rpm in (0, 125))
    assert turning["supply_power_W"].mean() == pytest.approx(still["supply_power_W"].mean(), rel=0.05)
    assert still["motor_electric_power_W"].isna().all()
    added = turning["power_W"].mean() - turning["supply_power_W"].mean()
    words = price(decision)
    assert added == pytest.approx(turning["motor_electric_power_W"].mean())
    assert words.startswith(f"Rotating adds {watts(added)} at 125 rpm at the motor's terminals.")
    assert "rotating does not change what the pump pays" in words
    assert question(decision).startswith("Asked of the thesis simulation: an rms error")


def test_the_number_of_draws_is_told_before_and_a_machine_is_chosen(tmp_path: Path) -> None:
    path = write(tmp_path, STUDY)
    told = workbench("decide", path, "--out", tmp_path / "out", "--dry-run", "--machine", "thesis_rig")
    assert (told.code, told.err) == (0, "")
    assert "machine: thesis_rig" in told.out
    assert "of 60 fresh draws 60 or more show a probability above 0.9" in told.out
    assert "The least number that can show it is 42" in told.out
    assert re.search(r"about [\d.]+ s for the search on this machine, and [\d.]+ s for the fresh draws", told.out)
    assert not (tmp_path / "out").exists()
    few = workbench("check", write(tmp_path, changed("fresh_draws = 60", "fresh_draws = 41", STUDY)))
    assert "41 fresh draws cannot show a probability above 0.9, not even 41 of 41: at least 42 are needed" in few.out
    fails(
        workbench("decide", path, "--out", tmp_path / "out", "--machine", "thesis_rg"),
        'decide.machine: unknown machine "thesis_rg"; did you mean "thesis_rig"?',
    )


def test_the_interval_holds_what_further_machines_do(tmp_path: Path) -> None:
    """A small run of benchmarks/decide_coverage.py: the choice on 300 machines that it has not met."""
    text = changed('accuracy = "1 mm"', 'accuracy = "0.12 mm"\nprobability = 0.5', STUDY)
    decision = decided(tmp_path, text)
    named = decision.asked.answer().best
    assert named.stage == "fresh"
    wanted = [(named.candidate, named.speed, named.spread)]
    (later,) = candidate_results(
        run_batches(decision.plan, batches("fresh", wanted, range(60, 360)), 2), decision.table
    )
    assert named.low <= later.probability <= named.high


def test_a_study_without_decide(tmp_path: Path) -> None:
    path = write(tmp_path, STUDY[: STUDY.index("[decide]")])
    fails(workbench("decide", path, "--out", tmp_path / "out"), "study.toml: has no [decide]")


def test_run_points_to_decide(tmp_path: Path) -> None:
    fails(workbench("run", STUDIES / "decision.toml", "--out", tmp_path / "out"), "use workbench decide ")
