"""What a report of a diagnosis says: verdicts, reasons, tables, and what stands in the corrected plant."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import write
from diagnoses import doubting, rejected, unexplained, with_held_out, with_left, without_effects

from plants.effects.curves import CURVES
from plants.effects.registry import effects
from plants.registry import DRIVE_FORCE
from workbench.diagnose.effects import effects_of_both
from workbench.diagnose.report.folder import plant_file, summary
from workbench.diagnose.report.names import interval, percent, quantity
from workbench.diagnose.report.sureness import of_term, sureness, why_none
from workbench.diagnose.report.tables import error_table, evidence_table, parameter_table
from workbench.diagnose.report.verdict import dependence_words, next_words, verdict_sentence
from workbench.diagnose.result import BeforeAfter, Diagnosis, Errors
from workbench.diagnose.selection.balance_curves import CurveFit
from workbench.diagnose.selection.unexplained import Dependence, OfferedTerm, TermErrors
from workbench.diagnose.simulation.by_curve import Curved
from workbench.diagnose.simulation.fits import Simulated
from workbench.parameters.sets import read_deviations, read_parameters
from workbench.publish.tables import shown_number
from workbench.publish.words import plain_name


def test_it_is_said_that_deviations_rest_on_what_is_held(diagnosis: Diagnosis) -> None:
    assert any("Deviations take what is held for exact, mass and areas too" in line for line in sureness(diagnosis))


def test_it_is_said_where_other_numbers_of_an_effect_do_as_well(diagnosis: Diagnosis) -> None:
    simulation = diagnosis.simulation
    assert simulation is not None
    assert not any("do not tell which" in line for line in sureness(diagnosis))
    (effect,) = simulation.effects
    either = replace(simulation, otherwise={effect: [("one", "two"), ("three",)]})
    found = effects_of_both(diagnosis.effects, either)
    (told,) = (line for line in sureness(replace(diagnosis, effects=found)) if "do not tell which" in line)
    assert told.endswith(
        " But one with two or three in the place of valve_overlap would leave as little: the records do not tell which."
    )


def test_it_is_said_that_a_loop_leads_the_plant(diagnosis: Diagnosis) -> None:
    simulation = diagnosis.simulation
    assert simulation is not None
    assert simulation.to_json()["led_by_rad_s"] is None
    assert not any("loop" in line for line in sureness(diagnosis))
    led = replace(simulation, how=replace(simulation.how, crossover=5.0))
    assert led.to_json()["led_by_rad_s"] == 5.0
    (told,) = (line for line in sureness(replace(diagnosis, simulation=led)) if "loop" in line)
    assert told.startswith(
        "Simulated from end to end, led by a loop of 5.0 rad/s that it does not do without, and fitted"
    )
    assert told.endswith("take the loop's force for known and may be several times too small.")


def test_every_verdict_has_its_sentence(diagnosis: Diagnosis) -> None:
    two = replace(diagnosis.effects[0], alternatives=["internal_leakage", "supply_droop"])
    ambiguous = replace(diagnosis, effects=[two])
    assert ambiguous.verdict == "ambiguous"
    assert verdict_sentence(ambiguous) == (
        "Ambiguous: the data cannot tell valve deadband from internal leakage or supply droop."
    )
    left = unexplained(diagnosis, "force", {"position": 0.4})
    assert left.verdict == "unexplained"
    assert verdict_sentence(left) == (
        "Unexplained: the force balance's residual depends on position (40 % of its variance); no known effect "
        "explains it."
    )
    left = unexplained(diagnosis, "force", {"position": 1.0, "time": 0.6}, 250.0)
    assert verdict_sentence(left) == (
        "Unexplained: the simulated plant lacks something in the force balance over position (250) and time (150): by "
        "so much a curve there raises the logarithm of its likelihood; no known effect explains it."
    )
    none = without_effects(diagnosis)
    assert none.verdict == "none_missing"
    assert none.simulation is not None
    off = f"{none.simulation.result.after.rms:.1f}"
    assert f"simulated along the records, is off by {off} standard deviations" in verdict_sentence(none)
    noise = none.simulation.after
    hum = replace(
        none, simulation=replace(none.simulation, after=replace(noise, residual=3.6 / noise.rms * noise.residual))
    )
    assert verdict_sentence(hum).endswith(
        "is off by 3.6 standard deviations of the sensors' noise, more than noise from sample to sample: the rest is "
        "slow or hums, and goes with no signal; no known effect lowers that on data left out."
    )
    none = replace(none, simulation=None)
    assert verdict_sentence(none).startswith("None missing: the declared plant, with its own parameters fitted, expl")
    assert " (" in verdict_sentence(none).partition("times the noise floor")[2], "judged on held-out records too"
    far = with_left(none, {"force": 79.3})
    assert far.verdict == "undecided"
    assert verdict_sentence(far).startswith("Undecided: no known effect lowers what is left on data left out, ")
    assert "; but it is 79 times the noise floor: the plant is not complete, " in verdict_sentence(far)
    worse = rejected(diagnosis)
    assert worse.verdict == "rejected_on_held_out"
    assert verdict_sentence(worse).startswith("Rejected on held-out records: valve dead")


def test_effects_that_only_stood_in_for_something_are_told_of(diagnosis: Diagnosis) -> None:
    left = unexplained(diagnosis, "force", {"position": 1.0}, 250.0)
    assert left.simulation is not None
    assert not any("The search found" in line for line in sureness(left))
    found = replace(left, simulation=replace(left.simulation, stood_in=("spring_load", "cogging")))
    assert (
        "The search found spring load and cogging, not named here: one curve over a signal does in their place, or "
        "what is left beside them says more than they do."
    ) in sureness(found)


def test_effects_of_balances_that_the_simulated_plant_does_without_are_told_of(diagnosis: Diagnosis) -> None:
    simulation = diagnosis.simulation
    assert simulation is not None
    near = replace(simulation, dropped=("internal_leakage",))
    said = "Added to the balances, and not named here: internal leakage. Simulated along the records, the plant"
    assert f"{said} does as well without." in sureness(replace(diagnosis, simulation=near))
    lost = replace(near, after=replace(near.after, residual=1e3 * near.after.residual))
    told = next(line for line in sureness(replace(diagnosis, simulation=lost)) if line.startswith(said))
    assert "without it comes near them neither, so that the balances may be right" in told


def test_effects_that_held_out_records_speak_against_are_told_of_once(diagnosis: Diagnosis) -> None:
    simulation = diagnosis.simulation
    assert simulation is not None
    refuted = replace(simulation, dropped=("internal_leakage",), refuted=("internal_leakage",))
    lines = sureness(replace(diagnosis, simulation=refuted))
    assert (
        "The search found internal leakage, not named here: without, the plant follows the held-out records within "
        "noise, and they are likelier."
    ) in lines
    assert not any("Added to the balances" in line for line in lines)


def test_what_the_written_parameters_do_is_told_where_free_runs_have_their_own(diagnosis: Diagnosis) -> None:
    fitted, tested = (
        BeforeAfter(Errors({}, position=before), Errors({}, position=after))
        for before, after in ((4.14e-3, 4.91e-3), (7.39e-3, 14.27e-3))
    )
    own = replace(diagnosis, errors=replace(diagnosis.errors, written=(fitted, tested)))
    assert (
        "Free runs in the table have parameters of their own; with those of plant.toml one is off by 4.9 mm (4.1 mm "
        "without what was found) on the fit records and 14 mm (7.4 mm without what was found) on the held-out records."
    ) in sureness(own)
    assert "parameters_written" in str(own.errors.to_json()["held_out"])
    assert not any("Free runs in the table" in line for line in sureness(diagnosis))


def test_a_plant_that_follows_with_a_curve_alone_is_told_of(diagnosis: Diagnosis) -> None:
    left, simulation = unexplained(diagnosis, "force", {"position": 1.0}, 250.0), diagnosis.simulation
    assert simulation is not None
    (force,) = (result for result in diagnosis.results if result.balance.name == "force")
    curve = CurveFit("position", CURVES["force", "position"], diagnosis.experiment.plant, force.before)
    by_curve = Curved(curve, Simulated(simulation.how, simulation.after), simulation.before, {})
    far = replace(simulation.after, residual=700.0 / simulation.after.rms * simulation.after.residual)
    runs = Errors({}, position=5e-6), Errors({}, position=6e-6)
    left = replace(
        left,
        simulation=replace(simulation, after=far, curved=by_curve),
        errors=replace(left.errors, with_curve=runs),
    )
    lines = sureness(left)
    near = shown_number(simulation.after.rms, 3)
    assert (
        "Simulated from end to end and fitted to the fit records, the plant is off by 700 standard deviations of the "
        "sensors' noise; with a curve over position for what the force balance lacks, fitted beside its parameters, by "
        f"{near}. The parameters are of that fit, and go with the curve."
    ) in lines
    assert any(
        line.startswith("With that curve switched on a free run is off in position by 0.0050 mm") for line in lines
    )
    assert any("That curve is a data-driven term over position: it would lower" in line for line in lines)
    told = left.errors.to_json()["held_out"]
    assert isinstance(told, dict)
    assert told["with_curve"] == {"position_rms_m": 6e-6}
    go = "go with the curve for what no known effect explains: it is off"
    assert f"its own parameters fitted, which {go}" in summary(left)
    beside = replace(left, effects=diagnosis.effects)
    assert f"the corrected plant, whose parameters {go}" in summary(beside)
    assert next_words(beside, "DIR").endswith("position_force_curve_share = 1 in DIR/plant.toml")


def test_a_plant_to_which_nothing_was_added_is_not_called_corrected(diagnosis: Diagnosis) -> None:
    none, left = without_effects(diagnosis), unexplained(diagnosis, "force", {"position": 1.0}, 250.0)
    fitted = "plant.toml: the declared plant with its own parameters fitted"
    assert f"{fitted}; a study names it with model" in summary(none)
    assert f"{fitted}; it lacks what no known effect explains; a study names it with model" in summary(left)
    assert next_words(none, "DIR") == ""
    assert next_words(left, "DIR") == (
        "To simulate the plant with a curve over position for what is not explained: position_force_curve_share = 1 in "
        "DIR/plant.toml"
    )


@pytest.mark.parametrize("far", [False, True])
def test_a_free_run_that_gets_worse_rejects_what_was_found_however_far_from_noise(
    diagnosis: Diagnosis, far: bool
) -> None:
    simulation, tested = diagnosis.simulation, diagnosis.errors.held_out
    assert simulation is not None
    assert tested.after.position is not None
    after = replace(simulation.after, residual=1e3 * simulation.after.residual) if far else simulation.after
    assert replace(simulation, after=after).is_trusted is not far
    worse = BeforeAfter(replace(tested.after, position=0.9 * tested.after.position), tested.after)
    errors = replace(diagnosis.errors, held_out=worse, gained=None)
    rejected = replace(diagnosis, simulation=replace(simulation, after=after), errors=errors)
    assert rejected.is_rejected
    assert "worse is position, simulated against measured (from" in verdict_sentence(rejected)


@pytest.mark.parametrize(("left", "is_rejected"), [(0.49, False), (0.51, True)])
def test_a_balance_of_a_plant_far_from_noise_rejects_unless_its_free_run_is_far_better(
    diagnosis: Diagnosis, left: float, is_rejected: bool
) -> None:
    simulation, tested = diagnosis.simulation, diagnosis.errors.held_out
    assert simulation is not None
    assert tested.after.position is not None
    far = replace(simulation, after=replace(simulation.after, residual=1e3 * simulation.after.residual))
    balances = {name: 0.9 * error for name, error in tested.after.balances.items()}
    before = replace(tested.before, balances=balances, position=tested.after.position / left)
    errors = replace(diagnosis.errors, held_out=BeforeAfter(before, tested.after), gained=None)
    with_effects = [replace(result, effects={"valve_deadband": ("valve_overlap",)}) for result in diagnosis.results]
    judged = replace(diagnosis, results=with_effects, errors=errors)
    assert replace(judged, simulation=far).is_rejected is is_rejected
    assert not judged.is_rejected, "of one that follows its records the free run alone counts"


def test_a_floor_of_other_motion_is_none_where_the_simulated_plant_follows_that(diagnosis: Diagnosis) -> None:
    left = with_left(diagnosis, {"force": 0.77})
    balances = {"force": 1.99 * diagnosis.results[-1].balance.floor}
    told = "where that is no floor, and the simulated plant follows them within their noise"
    assert any(told in line for line in sureness(with_held_out(left, balances)))
    assert not any(told in line for line in sureness(with_held_out(left, balances, position=1e-3)))


def test_what_gets_worse_and_rejects_nothing_is_told(diagnosis: Diagnosis) -> None:
    tested = diagnosis.errors.held_out
    before, after = replace(tested.before, load_pressure=1.0e4), replace(tested.after, load_pressure=1.45e4)
    worse = replace(diagnosis, errors=replace(diagnosis.errors, held_out=BeforeAfter(before, after)))
    assert worse.verdict == "effect_found"
    told = "worse is load pressure, simulated against measured (from 10.0 to 14.5 kPa). It does not reject"
    assert any(told in line for line in sureness(worse))
    assert not any("Not all gets better" in line for line in sureness(rejected(worse)))


def test_on_rejection_the_plant_stays_as_declared(diagnosis: Diagnosis, tmp_path: Path) -> None:
    text = plant_file(rejected(diagnosis))
    values = dict(read_parameters(write(tmp_path, text, "plant.toml")))
    assert values == pytest.approx(dict(diagnosis.experiment.values), rel=1e-9)
    assert "std" not in text


def test_what_is_not_identified_is_marked_and_by_which_fit(diagnosis: Diagnosis) -> None:
    marked = doubting(diagnosis, "baseline_parameters", "stribeck", std=1e4)
    table = parameter_table(marked).set_index("parameter")
    assert table.loc["stribeck", "remark"] == "not identified by the baseline"
    assert table.loc["coulomb", "remark"] == ""
    assert table.loc["valve_flow_gain", "remark"] == "not identified by the baseline"  # the overlap moves it
    assert table.loc["valve_overlap", "remark"] == "of an effect"
    lines = sureness(marked)
    baseline = next(line for line in lines if line.startswith("Without effects (baseline) the records do not identify"))
    assert "stribeck" in baseline
    assert baseline.endswith(
        "beyond what its standard deviation allows or the standard deviation exceeds half the value."
    )
    assert "With what was found they identify every parameter that was fitted." in lines
    both = doubting(marked, "fitted_parameters", "stribeck", std=1e4)
    remark = parameter_table(both).set_index("parameter").loc["stribeck", "remark"]
    assert remark == "not identified by the baseline, with effects"
    assert any(
        line.startswith("With what was found the records do not identify stribeck: the st") for line in sureness(both)
    )


def test_a_value_that_is_not_identified_stands_in_the_plant_without_a_deviation(
    diagnosis: Diagnosis, tmp_path: Path
) -> None:
    """Stopped at a bound its deviation would be 0: a study must not take that for certainty."""
    stopped = doubting(
        doubting(diagnosis, "fitted_parameters", "bristle_damping", std=0.0), "fitted_parameters", "stribeck", std=1e4
    )
    path = write(tmp_path, plant_file(stopped), "plant.toml")
    values, deviations = read_parameters(path), read_deviations(path)
    fitted = diagnosis.fitted_parameters
    assert values["bristle_damping"] == pytest.approx(fitted["bristle_damping"].value)
    assert values["stribeck"] == pytest.approx(fitted["stribeck"].value)
    assert not {"bristle_damping", "stribeck"} & set(deviations)
    assert "coulomb" in deviations
    text = path.read_text()
    assert "not identified, the fit ran to the end of its range; it goes with the other values" in text
    assert "not identified, the standard deviation exceeds half the value; it goes with the other values" in text


def test_a_plant_that_cannot_hold_what_was_found_is_not_called_corrected(diagnosis: Diagnosis, tmp_path: Path) -> None:
    """It is the plant fitted without effects: the values of the other fit lack what was fitted beside them."""
    poorer = replace(diagnosis, experiment=replace(diagnosis.experiment, plant=DRIVE_FORCE))
    text = plant_file(poorer)
    assert "not the corrected plant" in text
    assert "drive_force cannot hold valve deadband: the values are those of the fit without effects" in text
    values = read_parameters(write(tmp_path, text, "plant.toml"))
    assert "valve_overlap" not in values
    assert values["coulomb"] == pytest.approx(diagnosis.baseline_parameters["coulomb"].value)
    said = "plant.toml does not have valve deadband, which drive_force cannot hold: it is not the corrected plant"
    assert said in summary(poorer)
    assert summary(poorer).endswith("for model = drive_force, which cannot hold valve deadband")
    assert summary(diagnosis).endswith("the corrected plant; a study names it with model = two_chamber")


EXPLAINED = {
    (0.77, 1.05): "0.770 times its noise floor, and 1.05 times on held-out records: the sensors' noise explains all of "
    "it.",
    (0.77, 1.99): "0.770 times its noise floor, and 1.99 times on held-out records: the sensors' noise explains all of "
    "it on the records that were fitted, but not on the held-out ones.",
    (1.24, 1.01): "1.24 times its noise floor, and 1.01 times on held-out records: the sensors' noise explains all of "
    "it on the held-out records, but not on those that were fitted.",
    (
        1.24,
        1.99,
    ): "1.24 times its noise floor, and 1.99 times on held-out records: not all of it is the sensors' noise.",
    (1.24, 0.0): "1.24 times its noise floor: not all of it is the sensors' noise.",
    (0.77, 0.0): "0.770 times its noise floor: the sensors' noise explains all of it.",
}
"""Floors that are left on the records that were fitted, and on held-out ones (0: there are none)."""


@pytest.mark.parametrize("floors", EXPLAINED)
def test_noise_is_judged_on_held_out_records_too(diagnosis: Diagnosis, floors: tuple[float, float]) -> None:
    fitted, tested = floors
    floor, left = diagnosis.results[-1].balance.floor, with_left(diagnosis, {"force": fitted})
    lines = sureness(with_held_out(left, {"force": tested * floor}, position=1e-3))  # m: it does not follow
    line = next(line for line in lines if line.startswith("What is left of the force balance"))
    spread = diagnosis.results[-1].balance.spread
    assert spread is not None, "several draws made the floor"
    drawn = f"noise floor (from draw to draw of that noise ± {shown_number(100.0 * spread, 2)} %)"
    said = EXPLAINED[floors].replace("noise floor", drawn, 1)
    assert line == f"What is left of the force balance is {said}"


@pytest.mark.parametrize("floors", [1e20, np.nan])
def test_a_balance_that_runs_away_is_not_held_against_its_floor(diagnosis: Diagnosis, floors: float) -> None:
    """What swings along the motion may go beyond all bounds, and no quiet sensor is why."""
    lines = sureness(with_left(diagnosis, {"force": floors}))
    assert "The force balance runs away along the measured motion, and tells nothing." in lines
    assert not any(line.startswith("What is left of the force balance is") for line in lines)


def test_what_is_far_from_its_floor_and_not_called_unexplained_is_accounted_for(diagnosis: Diagnosis) -> None:
    """EMPS: 80 times the floor, and no dependence."""
    far = replace(with_left(diagnosis, {"force": 80.6}), simulation=None, unexplained=None)
    assert (
        "What is left of the force balance is not called unexplained, since it depends on no measured signal by more "
        "than 15 % of its variance: nothing measured says what is missing." in sureness(far)
    )
    assert not any("not called unexplained" in line for line in sureness(diagnosis))


def test_what_stopped_the_best_effect_is_told(diagnosis: Diagnosis) -> None:
    (flow, *_) = diagnosis.results
    step = flow.steps[0]
    best = step.candidates[0]
    had: dict[str, tuple[str, ...]] = {}

    def said(one: Any = best, before: Any = step.before) -> str:
        return why_none(replace(flow, effects=had, steps=[replace(step, before=before, candidates=[one], added=())]))

    known = f"the best, {plain_name(best.effect)}, stands out by {best.deviations:.1f} standard deviations of the noise"
    assert said().startswith(f"No effect was added to the flow balance: {known}, ")
    assert "but it was not taken: it takes too little of the residual" in said()
    fitted = best.fit if best.fit is not None else step.before
    ended = replace(best, fit=replace(fitted, bounded=frozenset({"valve_overlap"})))
    assert "but valve_overlap ran to the end of its range, and so is no estimate." in said(ended)
    at_floor = replace(step.before, residual=step.before.residual / step.before.rms)
    assert "but the balance is at its noise floor without any." in said(best, at_floor)
    poor = replace(best, gain=2.0, asked=8.0)
    assert "stands out by 2.0 standard deviations of the noise, where 4.0 are asked of one among so many." in said(poor)
    had["internal_leakage"] = ("leakage_coefficient",)
    assert said().startswith(f"No further effect was added to the flow balance, which has internal leakage: {known}, ")


def test_a_term_that_makes_it_worse_does_not_lower_it() -> None:
    term = OfferedTerm("velocity", np.zeros(2), np.zeros(2), "N", TermErrors(1.0, 0.5))
    worse = replace(term, held_out=TermErrors(71.3, 73.5))
    assert "would not lower it on the held-out records: 71.3 N without it, 73.5 N with it" in of_term(worse)
    assert "would lower it on the fit records: 1.00 N without it, 0.500 N with it" in of_term(term)


def test_where_nothing_was_added_no_column_speaks_of_effects(diagnosis: Diagnosis) -> None:
    none = without_effects(diagnosis)
    assert list(error_table(none).columns) == ["error (rms)", "unit", "fit", "held-out", "noise floor"]
    assert list(parameter_table(none).columns)[:5] == [
        "parameter",
        "unit",
        "declared",
        "fitted",
        "fitted, 95 % interval",
    ]


# --- numbers ---


def test_numbers_have_the_digits_that_say_something() -> None:
    assert [percent(share) for share in (0.63, 0.997, 1.0, -0.9998, 0.0)] == [
        "63 %",
        "99.7 %",
        "100 %",
        "-99.98 %",
        "0 %",
    ]
    assert quantity("friction_per_pressure", 6.593e-6, 1.7e-7) == "0.6593 ± 0.017 N/bar"
    assert quantity("coulomb_negative", 775.9295, 0.0070) == "775.9295 ± 0.0070 N"
    assert interval(413.0225, 0.0475) == "412.975 to 413.070"
    assert quantity("leakage_coefficient", 1.200038e-12, 3.3e-17) == "0.1200038 ± 3.3e-06 cm^3/(s bar)"
    assert interval(0.1200038, 6.5e-06) == "0.1199973 to 0.1200103"


def test_tables_show_readable_units(diagnosis: Diagnosis) -> None:
    errors = error_table(diagnosis).set_index("error (rms)")
    assert list(errors["unit"]) == ["cm^3/s", "N", "mm", "kPa"]
    flow = diagnosis.errors.fit.before.balances["flow"]
    assert float(errors.loc["residual of the flow balance", "fit, before"]) == pytest.approx(1e6 * flow, rel=1e-2)
    evidence = evidence_table(diagnosis)
    assert list(evidence[evidence["outcome"] == "added"]["candidate"]) == ["valve deadband"]
    assert quantity("valve_overlap", 1.2346e-5, 3e-8) == "12.346 ± 0.030 µm"
    assert quantity("bulk_modulus", 1.7e9) == "1700 MPa"


def test_every_effect_is_said_in_plain_words() -> None:
    assert all(effect.words for effect in effects().values())


@pytest.mark.parametrize(
    ("count", "said"),
    [
        (4, "over position (100), velocity (75), pressure 1 (50) and pressure 2 (25): by so much"),
        (5, "over position (100), velocity (75), pressure 1 (50) and 2 more: by so much"),
    ],
)
def test_of_many_signals_the_strongest_are_named(count: int, said: str) -> None:
    names = ["position", "velocity", "pressure_1", "pressure_2", "time"][:count]
    shares = {name: 1.0 - 0.25 * k for k, name in enumerate(names)}
    assert said in dependence_words(Dependence("flow", shares, 100.0), "m")
