"""Machines over decades: their records against the program's own simulation, limits against noise, and the scores."""

import json
import math
from collections import Counter
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from command import workbench
from family.cases import CASES, LIMIT, NONE, OTHER, SETS, SEVERAL, STRONG, THREE, Case, make_cases
from family.effects import EFFECTS, Effect, true_parameters
from family.experiments import SPREAD, declared_values, named, true_values, write_experiment
from family.forms import Form
from family.limits import LIMIT as AT_LIMIT
from family.limits import coarse, distance, drawn_form, free_parameters, left, strength_at, with_form
from family.machines import (
    AIR,
    DIFFERENTIAL,
    EQUAL,
    HAND,
    INTEGRATING,
    KINDS,
    LINEAR,
    MOTIONS,
    OPEN,
    PROPORTIONAL,
    ROTARY,
    Rig,
    draw_rig,
    stream,
    substeps,
)
from family.noise import KINDS as NOISES
from family.noise import QUANTISED, draw_noise
from family.physics import PLACE, PRESSURE_1
from family.records import CHANNELS, USES, outputs, record
from family.scoring import attainable, matches, offered, score
from family.suite import Options, run_cases, scores_table, times_table
from family.summary import summary, wilson
from family.unlisted import UNLISTED, Unlisted

from workbench.fitting.replay import Sampled
from workbench.records.experiment import read_experiment
from workbench.simulation.setup import Feed, Integrator, Setup
from workbench.simulation.simulate import simulate

pytestmark = pytest.mark.thorough

SHORT = (
    (EQUAL, OPEN, 36),
    (DIFFERENTIAL, INTEGRATING, 25),
    (AIR, OPEN, 30),
    (LINEAR, HAND, 30),
    (ROTARY, PROPORTIONAL, 81),
)
"""Kinds, motions and seeds whose records are short."""


def short_rig(kind: str, motion: str, seed: int) -> Rig:
    return draw_rig(kind, motion, "white", int(np.random.default_rng([seed, 0]).integers(2**31)))


def test_sets_are_whole_and_even() -> None:
    tuning, reported = (make_cases(name) for name in SETS)
    assert len({case.seed for case in [*tuning, *reported]}) == len(tuning) + len(reported)
    kinds = Counter(case.kind for case in tuning)
    assert [kinds[kind] for kind in CASES] == [60, 4 * len(EFFECTS) + 10, 60, 60, 40, 30]
    three = Counter(case.truth for case in tuning if case.kind == THREE)
    assert set(three) == set(EFFECTS)
    assert min(three.values()) >= 4
    assert sum(three.values()) >= 140
    assert {case.truth for case in tuning if case.kind == OTHER} == set(UNLISTED)
    assert len(UNLISTED) >= 6
    several = [case for case in tuning if case.kind == SEVERAL]
    assert {len(set(case.effects)) for case in several} == {2, 3}
    assert all(3.0 <= multiple <= 30.0 for case in several for multiple in case.multiples)
    strong = [case.multiples[0] for case in tuning if case.kind == STRONG]
    assert 10.0 <= min(strong) < 20.0 < 500.0 < max(strong) <= 1000.0
    for column in ("machine", "noise"):
        silent = Counter(getattr(case, column) for case in tuning if case.kind == NONE)
        assert max(silent.values()) - min(silent.values()) <= 2
    assert {(case.machine, case.motion) for case in tuning} == {(k, m) for k in KINDS for m in MOTIONS[k]}


def test_a_choice_of_cases_changes_none() -> None:
    whole = {case.name: case for case in make_cases("tuning")}
    some = make_cases("tuning", ["backlash", THREE, LIMIT], 2)
    assert [case.kind for case in some] == [THREE, THREE, *[LIMIT] * (len(some) - 2)]
    assert all(whole[case.name] == case and "backlash" in case.effects for case in some)
    with pytest.raises(ValueError, match='"friction" is no effect'):
        make_cases("tuning", ["friction"])


@pytest.mark.parametrize("kind", NOISES)
def test_whitened_noise_has_a_standard_deviation_of_one(kind: str) -> None:
    """Of the projection on a difference of records, over 400 draws: 1 within three times its own 1/sqrt(800)."""
    noise, step = draw_noise(kind, 1e-3, stream(1, kind)), 2e-3
    time = np.arange(3000) * step
    clean = 0.7 * np.sin(4.0 * time) + 0.1 * time
    apart = noise.whitened(np.exp(-((time - 3.0) ** 2)), step)
    draws = stream(2, kind)
    seen = [noise.measured(clean, noise.drawn(time.size, step, draws)) - clean for _ in range(400)]
    statistic = [apart @ noise.whitened(one, step) / np.linalg.norm(apart) for one in seen]
    assert np.std(statistic) == pytest.approx(1.0, abs=0.11)
    assert np.std(seen) == pytest.approx(noise.std, rel=0.05)


AGREEMENT = {EQUAL: 0.02, DIFFERENTIAL: 0.3, AIR: 0.2, LINEAR: 0.3, ROTARY: 0.3}
"""Largest distance to the program's own record; a limit is 2.326. As measured, with a factor of 2 to spare."""


@pytest.mark.parametrize(
    ("kind", "motion", "seed"),
    [(EQUAL, PROPORTIONAL, 0), (DIFFERENTIAL, INTEGRATING, 1), (AIR, OPEN, 0), (LINEAR, OPEN, 0), (ROTARY, OPEN, 0)],
)
def test_records_are_those_of_the_program(kind: str, motion: str, seed: int, tmp_path: Path) -> None:
    """The declared plant at the true parameters, driven by the same command, shows the same without noise.

    Rms difference over a noise's standard deviation: at most 0.3/sqrt(samples), measured 0.002 to 0.16/sqrt(samples).
    """
    rig = replace(draw_rig(kind, motion, "white", seed), fineness=2)
    made = record(rig, rig.machine, "fit")
    path = write_experiment(tmp_path, rig, dict.fromkeys(USES, made), {})
    experiment = read_experiment(path)
    parameters = experiment.parameters(json.loads((tmp_path / "truth.json").read_text(encoding="utf-8"))["values"])
    state, inputs = experiment.plant.equilibrium(parameters, 0.0)
    time = np.arange(rig.samples) * rig.sample_time
    program = simulate(
        Setup(
            experiment.plant,
            parameters,
            state,
            inputs,
            time[-1],
            feeds=(Feed(experiment.plant.command, Sampled(time, made.command), linear=False),),
            sample_time=rig.sample_time,
            integrator=Integrator("rk4", rig.sample_time / substeps(rig)),
        )
    ).measurements
    for name, noise in rig.noises.items():
        place = CHANNELS.index(name)
        apart = noise.whitened(program[:, place] - made.clean[:, place], rig.sample_time)
        assert np.linalg.norm(apart) < AGREEMENT[kind], name


@pytest.mark.parametrize(("kind", "motion", "seed"), SHORT)
def test_every_effect_does_nothing_at_none_and_more_with_strength(kind: str, motion: str, seed: int) -> None:
    rig = short_rig(kind, motion, seed)
    bare = record(rig, rig.machine, "fit")
    known: dict[str, Effect | Unlisted] = {**EFFECTS, **UNLISTED}
    for name, effect in known.items():
        if not effect.may_be(kind, motion):
            continue
        form = effect.draw(rig, stream(rig.seed, f"form {name}"))
        silent = record(rig, with_form(rig.machine, form, 0.0), "fit")
        assert np.array_equal(silent.clean, bare.clean), name
        small, large = (distance(rig, form, strength)[0] for strength in (1e-4, 1e-2))
        assert 0.0 <= small < large, name  # a spool that hardly sticks does not where its command never rests
        if name in EFFECTS:
            there = true_parameters(name, with_form(rig.machine, form, 0.1), rig.machine)
            assert there != true_parameters(name, rig.machine, rig.machine), name


@pytest.mark.parametrize(("kind", "motion", "seed"), [SHORT[0], SHORT[3]])
def test_a_limit_is_found_in_half_of_all_cases(kind: str, motion: str, seed: int) -> None:
    """With 1 % false alarms, by who knows machine and form: the likelihood ratio over 400 draws of the noise."""
    rig = coarse(short_rig(kind, motion, seed))
    form = drawn_form(rig, "cogging")
    strength, found = strength_at(rig, form, AT_LIMIT)
    assert found == pytest.approx(AT_LIMIT, rel=0.03)
    fine, _ = distance(replace(rig, fineness=4), form, strength)
    assert fine == pytest.approx(found, rel=0.02)
    made = record(rig, with_form(rig.machine, form, strength), "fit")
    apart = outputs(made, made.machine) - outputs(made, rig.machine)
    draws = stream(3, "limit")

    def noisy() -> np.ndarray:
        drawn = {name: one.drawn(rig.samples, rig.sample_time, draws) for name, one in rig.noises.items()}
        if motion == HAND:  # the noise drives the machine in the filter
            force, place = made.command + drawn["force"], made.clean[:, PLACE] + drawn["position"]
            return -made.filter.off(rig, rig.machine, None, force, place)
        return apart + np.concatenate([rig.noises[name].whitened(one, rig.sample_time) for name, one in drawn.items()])

    ratios = [apart @ noisy() / np.linalg.norm(apart) for _ in range(400)]
    assert np.mean(np.array(ratios) > AT_LIMIT) == pytest.approx(0.5, abs=0.08)


@pytest.mark.parametrize("kind", [name for name in NOISES if name != QUANTISED])
def test_a_filter_by_hand_foresees_all_but_noise(kind: str) -> None:
    """What the machine that made a record does not foresee of it is white noise of the size that its filter says.

    The rms of n samples is 1 within 1/sqrt(2 n), taken three times; a converter's steps are no noise where a rod rests.
    """
    rig = coarse(draw_rig(LINEAR, HAND, kind, 30))
    made = record(rig, rig.machine, "fit")
    logged = made.channels
    off = made.filter.off(rig, rig.machine, None, logged["force"], logged["position"])
    assert np.sqrt(np.mean(off**2)) == pytest.approx(1.0, abs=3.0 / np.sqrt(2.0 * rig.samples))
    assert abs(np.mean(off[1:] * off[:-1])) < 0.05  # to first order along the motion without noise
    assert np.max(np.abs(off)) < 5.0
    exact = made.filter.off(rig, rig.machine, None, made.command, made.clean[:, CHANNELS.index("position")])
    assert np.max(np.abs(exact)) < 1e-3


def test_what_a_fit_takes_away() -> None:
    apart = np.array([3.0, 4.0, 12.0])
    assert left(apart, []) == pytest.approx(13.0)
    assert left(apart, [np.array([0.0, 0.0, -2.0]), np.zeros(3)]) == pytest.approx(5.0)
    assert left(apart, [np.array([0.0, 0.0, 1e-9]), np.array([1.0, 0.0, 1.0])]) == pytest.approx(4.0)


def test_forms_act_by_their_weights() -> None:
    form = Form({"a": lambda s: {"load": 2.0 * s}, "b": lambda s: {"spring": s}}, {"b": -1.0})
    assert form.changes(0.5) == {"spring": -0.5}


@pytest.mark.parametrize(("kind", "motion"), [(kind, motion) for kind in KINDS for motion in MOTIONS[kind]])
def test_experiments_are_in_order(kind: str, motion: str, tmp_path: Path) -> None:
    """`workbench check` takes them; what a fit may move is declared off, all else as it is."""
    rig = replace(short_rig(kind, motion, 44), duration=2.0)
    path = write_experiment(tmp_path, rig, {use: record(rig, rig.machine, use) for use in USES}, {})
    answer = workbench("check", path)
    assert (answer.code, answer.err) == (0, "")
    assert "an experiment, in order" in answer.out
    true, declared, moved = true_values(rig), declared_values(rig), {named(rig, own) for own in free_parameters(rig)}
    assert {name for name in true if declared[name] != true[name]} == moved
    assert all(1.0 / SPREAD <= declared[name] / true[name] <= SPREAD for name in moved)
    fit, held_out = (pd.read_parquet(tmp_path / f"{use}.parquet") for use in USES)
    assert not np.array_equal(fit["x"], held_out["x"])


def of_hand(kind: str, *effects: str, multiples: tuple[float, ...]) -> Case:
    """A case whose record is short."""
    name = f"{kind}_{'_'.join(effects)}"
    return Case(name, kind, LINEAR, HAND, "white", 44, effects, multiples)


CHOSEN = [
    of_hand(NONE, multiples=()),
    of_hand(THREE, "cogging", multiples=(3.0,)),
    of_hand(SEVERAL, "constant_load", "quadratic_drag", multiples=(10.0, 20.0)),
    of_hand(OTHER, "friction_bump", multiples=(30.0,)),
]


@pytest.fixture(scope="module")
def made(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with the records of the chosen cases."""
    folder = tmp_path_factory.mktemp("family")
    done = run_cases(CHOSEN, folder, Options(target=None, keep_records=True), jobs=1)
    assert all(not result["report"] for result in done.values())
    return folder


def scores(folder: Path, stub: str) -> pd.DataFrame:
    for case in CHOSEN:
        (folder / case.name / "result.json").unlink(missing_ok=True)
    options = Options(f"family.stub:{stub}", resume=True, keep_records=True)
    results = run_cases(CHOSEN, folder, options, jobs=1)
    assert times_table(CHOSEN, results)["make_s"].max() < 0.1  # the records that are there are taken
    return scores_table(CHOSEN, results, folder)


def test_truth_says_how_strong_an_effect_is(made: Path) -> None:
    truth = json.loads((made / CHOSEN[1].name / "truth.json").read_text(encoding="utf-8"))
    (one,) = truth["effects"].values()
    assert one["d_known"] == pytest.approx(3.0 * AT_LIMIT, rel=0.04)
    assert 0.0 < one["d_profiled"] < one["d_known"]
    assert one["class"] == []
    assert set(one["parameters"]) == {"cogging_cosine", "cogging_sine", "cogging_pitch"}
    assert set(truth["candidates"]) == {name for name, effect in EFFECTS.items() if effect.may_be(LINEAR, HAND)}


def test_a_perfect_diagnosis(made: Path) -> None:
    table = scores(made, "perfect")
    assert table["set_right"].tolist() == [True, True, True, False]
    assert table["exactly_first"].tolist() == [False, True, True, False]
    assert table["none_named"].tolist() == [True, False, False, True]
    assert table["right_unexplained"].tolist() == [False, False, False, True]
    assert not table["wrong_named"].any()
    assert table["at_floor"].all()
    assert (table["position_ratio"] == 0.0).all()
    assert not table["made_worse"].any()
    assert (table["friction_covered"] == 6).all()
    assert (table["friction_intervals"] == 6).all()
    assert (table["effect_covered"] == table["effect_intervals"]).all()
    assert table["effect_intervals"].sum() == 6
    text = summary("Two kinds", table, pd.DataFrame({"case": ["a"], "make_s": [1.0], "diagnose_s": [2.0]}))
    assert "| two or three: set right | 1/1 | 100 % | 21 to 100 % |" in text
    assert "| unlisted: none named | 1/1 |" in text
    assert "2.0 s to diagnose (median)" in text


def test_a_stubborn_diagnosis(made: Path) -> None:
    table = scores(made, "stubborn")
    assert not table[["set_right", "right_first", "right_or_alternative", "none_named", "at_floor"]].any(axis=None)
    assert table["wrong_named"].all()
    assert table["position_ratio"].to_numpy() == pytest.approx(1.0)
    assert table["friction_covered"].sum() == 0
    assert (table["friction_intervals"] == 6).all()
    assert "viscous_drift 1" in summary("Wrong", table, pd.DataFrame({"make_s": [1.0], "diagnose_s": [2.0]}))


def test_a_failing_diagnosis_is_a_row(made: Path) -> None:
    table = scores(made, "failing")
    assert (table["first"] == "failed").all()
    assert (table["error"] == "ArithmeticError: no").all()
    assert not table[["set_right", "right_first", "none_named", "right_unexplained"]].any(axis=None)


def test_effects_that_no_record_tells_apart_stand_for_each_other() -> None:
    classes = [{"a", "b"}, {"a"}]
    assert matches(["a", "b"], classes)
    assert matches(["b", "a"], classes)
    assert matches([], [])
    assert not matches(["b", "b"], classes)
    assert not matches(["a"], classes)
    assert not matches(["a", "a", "b"], classes)


def test_alternatives_may_be_sets() -> None:
    found = [{"name": "a", "alternatives": ["b", "c + d"]}, {"name": "e", "alternatives": []}]
    assert offered(found) == [["a", "e"], ["b", "e"], ["c", "d", "e"], ["c", "d"]]
    assert offered([]) == [[]]


def test_shares_and_powers() -> None:
    """Wilson's interval of 8 in 10 by the formula; a power at no distance is the share of false alarms."""
    assert wilson(8, 10) == pytest.approx((0.4902, 0.9433), abs=1e-4)
    assert all(math.isnan(end) for end in wilson(0, 0))
    assert attainable(0.0, 1, signed=True) == pytest.approx(0.03)
    assert attainable(0.0, 30, signed=False) == pytest.approx(1.0 - 0.97 ** (1.0 / 30.0))
    assert attainable(3.0902, 30, signed=False) == pytest.approx(0.5, abs=0.01)
    assert attainable(8.0, 30, signed=True) > 0.999


@pytest.mark.parametrize(("beside", "power"), [({"spring_load": 12.0}, 1.0), ({"spring_load": 0.5}, 0.03)])
def test_what_no_list_has_is_told_from_each_that_one_has(beside: dict[str, float], power: float) -> None:
    case = next(one for one in make_cases(SETS[0], [OTHER]))
    inside = {"d_known": 40.0, "d_profiled": 30.0, "d_free_class": beside, "class": []}
    row = score(case, {"effects": []}, {"effects": {case.truth: inside}, "candidates": ["spring_load"] * 30})
    assert row["attainable"] == pytest.approx(power, abs=0.03)
    assert row["stood_for"] == (power < 0.5)


def test_a_leak_empties_its_chamber() -> None:
    """dP1 = -C P1 beta / V1 dt over the first sample, in which nothing has moved yet."""
    rig = replace(short_rig(EQUAL, OPEN, 58), sample_time=1e-5, duration=0.01)
    machine = rig.machine._replace(leak_1=1e-3 * rig.machine.area_1 * rig.speed / rig.machine.supply_pressure)
    leaking, bare = (record(rig, one, "fit").clean for one in (machine, rig.machine))
    volume = machine.dead_volume_1 + 0.5 * machine.area_1 * machine.stroke
    rate = machine.leak_1 * bare[0, PRESSURE_1] * machine.bulk_modulus / volume
    assert leaking[1, PRESSURE_1] - bare[1, PRESSURE_1] == pytest.approx(-rate * rig.sample_time, rel=0.03)
