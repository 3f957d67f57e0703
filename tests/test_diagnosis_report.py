"""The report of a diagnosis: the command end to end, its files, its words, and what a kill leaves."""

import functools
import json
import os
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np
import pytest
from command import Answer, changed, workbench, write
from experiments import CHANNELS, TRUTH, save_record

from plants.drive import DRIVE_FORCE
from plants.effects import EFFECTS
from plants.non_rotating import Inputs
from plants.two_chamber import TWO_CHAMBER
from workbench.diagnose.diagnose import Diagnosis, diagnose
from workbench.diagnose.unexplained import Dependence
from workbench.parameters import build, read_deviations, read_parameters
from workbench.report import diagnosis
from workbench.report.diagnosis_figures import pictures_of
from workbench.report.diagnosis_names import PLAIN, interval, percent, quantity
from workbench.report.diagnosis_parameter_figure import parameters_figure
from workbench.report.diagnosis_reasons import why_none
from workbench.report.diagnosis_series import autocorrelation, binned, parts_of, shown_signals
from workbench.report.diagnosis_tables import error_table, evidence_table, parameter_table
from workbench.report.diagnosis_words import sureness, verdict_sentence
from workbench.report.figures import save
from workbench.simulation.references import Multisine
from workbench.simulation.simulate import Feed, Setup, simulate

OVERLAP = 1e-5
"""m. Half of what the valve's voltage moves the spool by in these records."""

EXPERIMENT = f"""\
title = "a valve with overlap"
[plant]
model = "non_rotating"
parameters = "owen2001_experiment"
{CHANNELS}[[records]]
file = "fit.parquet"
[[records]]
file = "other.parquet"
use = "held_out"
"""

STUDY = changed(
    'model = "by_rpm"\nparameters = "owen2001_simulation"\n\n[axes]\nrpm = [0, 460]\n',
    'model = "two_chamber"\nparameters = "out/plant.toml"\n',
)


def make_record(folder: Path, name: str, effect: Mapping[str, float], amplitude: float, seed: int) -> None:
    """15 s in both directions, with white noise."""
    parameters = build(TWO_CHAMBER.Parameters, {**TRUTH, **effect})
    state, _ = TWO_CHAMBER.equilibrium(parameters, 0.0)
    feed = Feed("valve_voltage", Multisine(amplitude, 0.2, (1, 2, 3, 5)))
    run = simulate(Setup(TWO_CHAMBER, parameters, state, Inputs(0.0, 0.0), 15.0, feeds=(feed,)))
    save_record(folder / f"{name}.parquet", run, seed)


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("diagnosis")
    make_record(path, "fit", {"valve_overlap": OVERLAP}, 0.6, 1)
    make_record(path, "other", {"valve_overlap": OVERLAP}, 0.5, 2)
    write(path, EXPERIMENT, "experiment.toml")
    return path


@pytest.fixture(scope="module")
def answer(folder: Path) -> Answer:
    """The command, run once for all tests, with the figures as PNG alone: the other formats take long."""
    with mock.patch.object(diagnosis, "save", functools.partial(save, formats=("png",))):
        return workbench("diagnose", folder / "experiment.toml", "--out", folder / "out")


@pytest.fixture(scope="module")
def found(folder: Path) -> Diagnosis:
    return diagnose(folder / "experiment.toml")


# --- the command ---


def test_the_command_says_what_it_found(answer: Answer) -> None:
    assert (answer.code, answer.err) == (0, "")
    assert "\nFound: valve deadband (valve_overlap = " in answer.out
    assert "| residual of the flow balance " in answer.out


def test_every_file_is_there(folder: Path, answer: Answer) -> None:
    out = folder / "out"
    written = {str(item.relative_to(out)) for item in out.rglob("*") if item.is_file()}
    names = [
        "parameters",
        "simulation",
        "simulation_evidence",
        *(f"{b}_{what}" for b in ("flow", "force") for what in FIGURES),
    ]
    figures = {f"figures/{name}.png" for name in names}
    tables = {f"tables/{name}.{e}" for name in ("effects", "error", "parameters", "evidence") for e in ENDINGS}
    assert written == {"report.json", "report.html", "plant.toml"} | figures | tables
    assert not list(folder.glob(".out*"))


FIGURES = ("time", "signals", "evidence", "whiteness")
ENDINGS = ("csv", "md", "tex")


def test_the_report_has_the_keys_of_the_contract(folder: Path, answer: Answer) -> None:
    report = json.loads((folder / "out" / "report.json").read_text())
    assert {"verdict", "effects", "unexplained", "error", "baseline"} <= set(report)
    assert report["verdict"] == "effect_found"
    (effect,) = report["effects"]
    assert set(effect) == {"name", "balance", "parameters", "alternatives", "evidence"}
    overlap = effect["parameters"]["valve_overlap"]
    assert abs(overlap["value"] - OVERLAP) < 0.02 * OVERLAP
    assert overlap["unit"] == "m"
    assert overlap["std"] < 0.01 * OVERLAP
    for use in ("fit", "held_out"):
        before, after = report["error"][use]["before"], report["error"][use]["after"]
        assert set(before) == set(after) >= {"force_rms_N", "flow_rms_m3_per_s"}
        assert after["flow_rms_m3_per_s"] < 0.2 * before["flow_rms_m3_per_s"]
    assert report["baseline"]["coulomb"]["identified"] is True


def test_the_page_shows_every_figure_that_there_is(folder: Path, answer: Answer) -> None:
    page = (folder / "out" / "report.html").read_text()
    assert "Found: valve deadband (valve_overlap = " in page
    for picture in (folder / "out" / "figures").glob("*.png"):
        assert f'src="figures/{picture.name}"' in page
    assert page.count("<img") == 11
    assert " nan" not in page


def test_a_study_can_name_the_corrected_plant(folder: Path, answer: Answer) -> None:
    plant = folder / "out" / "plant.toml"
    values, deviations = read_parameters(plant), read_deviations(plant)
    assert set(values) == {*TRUTH, "valve_overlap"}
    assert abs(values["valve_overlap"] - OVERLAP) < 0.02 * OVERLAP
    assert {"valve_overlap", "coulomb", "valve_flow_gain"} <= set(deviations)
    assert values["mass"] == TRUTH["mass"]
    assert "mass" not in deviations
    checked = workbench("check", plant)
    assert checked.code == 0
    assert "serves two_chamber" in checked.out
    study = workbench("check", write(folder, STUDY))
    assert (study.code, study.err) == (0, "")


def test_results_are_replaced_only_on_demand(folder: Path, answer: Answer) -> None:
    path, out = folder / "experiment.toml", folder / "out"
    again = workbench("diagnose", path, "--out", out)
    assert again == (2, "", f"error: {out}: holds a diagnosis already; replace it with --overwrite\n")
    foreign = folder / "foreign"
    (foreign / "tables").mkdir(parents=True)
    refused = workbench("diagnose", path, "--out", foreign, "--overwrite")
    message = f"error: {foreign}: holds tables that no diagnosis wrote; choose another --out\n"
    assert refused == (2, "", message)


# --- a kill ---


@pytest.fixture
def undrawn(monkeypatch: pytest.MonkeyPatch) -> None:
    """No figures: they take long, and the page is written without them."""
    monkeypatch.setattr(diagnosis, "pictures_of", lambda found: {})


def killed(*_: object) -> None:
    raise KeyboardInterrupt


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("where", ["write_frame", "plant_file", "page"])
def test_a_kill_while_writing_leaves_nothing(
    found: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    monkeypatch.setattr(diagnosis, where, killed)
    with pytest.raises(KeyboardInterrupt):
        diagnosis.write_diagnosis(found, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("undrawn")
def test_a_kill_while_replacing_leaves_no_report_and_can_be_repeated(
    found: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    diagnosis.write_diagnosis(found, out)
    (out / "notes.txt").write_text("the reader's own")
    move = os.replace

    def stopped(source: Path, target: Path) -> None:
        if target.name == "plant.toml":
            raise KeyboardInterrupt
        move(source, target)

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", stopped)
        with pytest.raises(KeyboardInterrupt):
            diagnosis.write_diagnosis(found, out)
    assert not (out / "report.json").exists()
    diagnosis.check_folder(out, overwrite=False)
    diagnosis.write_diagnosis(found, out)
    assert json.loads((out / "report.json").read_text())["verdict"] == "effect_found"
    assert {item.name for item in out.iterdir()} == {"report.json", "report.html", "plant.toml", "tables", "notes.txt"}


# --- words and tables ---


def other(one: Diagnosis, verdict: str, **changes: Any) -> Diagnosis:
    return replace(one, report={**one.report, "verdict": verdict}, **changes)


def test_every_verdict_has_its_sentence(found: Diagnosis) -> None:
    one = replace(found.found[0], alternatives=["internal_leakage", "supply_droop"])
    ambiguous = verdict_sentence(other(found, "ambiguous", found=[one]))
    assert ambiguous == "Ambiguous: the data cannot tell valve deadband from internal leakage or supply droop."
    unexplained = other(found, "unexplained", found=[], unexplained=Dependence("force", {"position": 0.4}))
    assert verdict_sentence(unexplained) == (
        "Unexplained: the force balance's residual depends on position (40 % of its variance); no known effect "
        "explains it."
    )
    none = other(found, "none_missing", found=[])
    assert "simulated along the records, is off by 1.4 standard deviations" in verdict_sentence(none)
    none = replace(none, simulated=None)
    assert verdict_sentence(none).startswith("None missing: the declared plant, with its own parameters fitted, expl")
    far = {"force": {**found.report["floor"]["force"], "after": 79.3}}
    noisy = verdict_sentence(replace(none, report={**none.report, "floor": far}))
    assert noisy.startswith("None missing that is known: ")
    assert "; but it is 79 times the noise floor: the plant is not complete, " in noisy
    assert verdict_sentence(other(found, "rejected_on_held_out")).startswith("Rejected on held-out records: valve dead")


def test_on_rejection_the_plant_stays_as_declared(found: Diagnosis, tmp_path: Path) -> None:
    text = diagnosis.plant_file(other(found, "rejected_on_held_out"))
    values = dict(read_parameters(write(tmp_path, text, "plant.toml")))
    assert values == pytest.approx(dict(found.experiment.values), rel=1e-9)
    assert "std" not in text


def doubting(one: Diagnosis, side: str, name: str, **changes: Any) -> Diagnosis:
    """A diagnosis whose fit of that side does not identify a parameter."""
    fits = {**one.report[side], name: {**one.report[side][name], "identified": False, **changes}}
    return replace(one, report={**one.report, side: fits})


def test_what_is_not_identified_is_marked_and_by_which_fit(found: Diagnosis) -> None:
    marked = doubting(found, "baseline", "stribeck", std=1e4)
    table = parameter_table(marked).set_index("parameter")
    assert table.loc["stribeck", "remark"] == "not identified by the baseline"
    assert table.loc["coulomb", "remark"] == ""
    assert table.loc["valve_overlap", "remark"] == "of an effect"
    lines = sureness(marked)
    baseline = next(line for line in lines if line.startswith("Without effects (baseline) the records do not identify"))
    assert "stribeck" in baseline
    assert "With what was found they identify every parameter that was fitted." in lines
    both = doubting(marked, "fitted", "stribeck", std=1e4)
    remark = parameter_table(both).set_index("parameter").loc["stribeck", "remark"]
    assert remark == "not identified by the baseline, with effects"
    assert any(
        line.startswith("With what was found the records do not identify stribeck: its st") for line in sureness(both)
    )


def test_a_value_that_is_not_identified_stands_in_the_plant_without_a_deviation(
    found: Diagnosis, tmp_path: Path
) -> None:
    """Stopped at a bound its deviation would be 0: a study must not take that for certainty."""
    stopped = doubting(doubting(found, "fitted", "bristle_damping", std=0.0), "fitted", "stribeck", std=1e4)
    path = write(tmp_path, diagnosis.plant_file(stopped), "plant.toml")
    values, deviations = read_parameters(path), read_deviations(path)
    fitted = found.report["fitted"]
    assert values["bristle_damping"] == pytest.approx(fitted["bristle_damping"]["value"])
    assert values["stribeck"] == pytest.approx(fitted["stribeck"]["value"])
    assert not {"bristle_damping", "stribeck"} & set(deviations)
    assert "coulomb" in deviations
    text = path.read_text()
    assert "not identified, the fit ran to the end of its range; it goes with the other values" in text
    assert "not identified, its standard deviation exceeds half its value; it goes with the other values" in text


def test_a_plant_that_cannot_hold_what_was_found_is_not_called_corrected(found: Diagnosis, tmp_path: Path) -> None:
    """It is the plant fitted without effects: the values of the other fit lack what was fitted beside them."""
    poorer = replace(found, experiment=replace(found.experiment, plant=DRIVE_FORCE))
    text = diagnosis.plant_file(poorer)
    assert "not the corrected plant" in text
    assert "drive_force cannot hold valve deadband: the values are those of the fit without effects" in text
    values = read_parameters(write(tmp_path, text, "plant.toml"))
    assert "valve_overlap" not in values
    assert values["coulomb"] == pytest.approx(found.report["baseline"]["coulomb"]["value"])
    said = "plant.toml does not have valve deadband, which drive_force cannot hold: it is not the corrected plant"
    assert said in diagnosis.summary(poorer)
    assert diagnosis.summary(poorer).endswith("for model = drive_force, which cannot hold valve deadband")
    assert diagnosis.summary(found).endswith("the corrected plant; a study names it with model = two_chamber")


def test_noise_is_judged_on_held_out_records_too(found: Diagnosis) -> None:
    """1.99 floors there, 0.77 on the records that were fitted."""
    floor, error = found.results[-1].balance.floor, found.report["error"]
    floors = {**found.report["floor"], "force": {**found.report["floor"]["force"], "after": 0.77}}

    def said(times: float) -> str:
        after = {**error["held_out"]["after"], "force_rms_N": times * floor}
        errors = {**error, "held_out": {**error["held_out"], "after": after}}
        lines = sureness(replace(found, report={**found.report, "floor": floors, "error": errors}))
        return next(line for line in lines if line.startswith("What is left of the force balance"))

    assert said(1.99) == (
        "What is left of the force balance is 0.770 times its noise floor, and 1.99 times on held-out records: the "
        "sensors' noise explains all of it on the records that were fitted, but not on the held-out ones."
    )
    assert said(1.05).endswith("times on held-out records: the sensors' noise explains all of it.")


def test_what_is_far_from_its_floor_and_not_called_unexplained_is_accounted_for(found: Diagnosis) -> None:
    """EMPS: 80 times the floor, and no dependence."""
    floors = {**found.report["floor"], "force": {**found.report["floor"]["force"], "after": 80.6}}
    far = replace(found, simulated=None, unexplained=None, report={**found.report, "floor": floors})
    assert (
        "What is left of the force balance is not called unexplained, since it depends on no measured signal by more "
        "than 15 % of its variance: nothing measured says what is missing." in sureness(far)
    )
    assert not any("not called unexplained" in line for line in sureness(found))


def test_what_stopped_the_best_effect_is_told(found: Diagnosis) -> None:
    (flow, *_) = found.results
    step = flow.steps[0]
    best = step.candidates[0]

    def said(one: Any = best, before: Any = step.before) -> str:
        return why_none(replace(flow, steps=[replace(step, before=before, candidates=[one], added=None)]))

    assert said().startswith("No effect was added to the flow balance: the best, valve deadband, would lower it by ")
    assert "it was withdrawn: what it left went on to depend on a signal" in said()
    ended = replace(best, fit=replace(best.fit, bounded=frozenset({"valve_overlap"})))
    assert "but valve_overlap ran to the end of its range, and so is no estimate." in said(ended)
    assert "would lower it by 0 % on data that its fit has not seen, but 5 % and more are asked for." in said(
        replace(best, fit=step.before)
    )
    at_floor = replace(step.before, residual=step.before.residual / step.before.rms)
    assert "the balance is at its noise floor without any." in said(best, at_floor)


def test_where_nothing_was_added_no_column_speaks_of_effects(found: Diagnosis) -> None:
    none = other(found, "none_missing", found=[])
    assert list(error_table(none).columns) == ["error (rms)", "unit", "fit", "held-out", "noise floor"]
    assert list(parameter_table(none).columns)[:5] == [
        "parameter",
        "unit",
        "declared",
        "fitted",
        "fitted, 95 % interval",
    ]


# --- figures ---


def test_the_axis_of_parameters_is_that_of_the_values_however_wide_an_interval_is(found: Diagnosis) -> None:
    """Coulomb friction of 300 N +- 2.3 MN, once: no tick was left, and 0 looked like decades."""
    wide = doubting(found, "baseline", "coulomb", std=2.3e6)
    (picture, plain) = (parameters_figure(one) for one in (wide, found))
    assert picture is not None
    assert plain is not None
    (axes,) = picture.figure.axes
    low, high = axes.get_xlim()
    assert high - low < 10.0 * np.ptp(plain.figure.axes[0].get_xlim())
    assert sum(low <= tick <= high for tick in axes.get_xticks()) >= 2
    place = [label.get_text() for label in axes.get_yticklabels()].index("coulomb") - 0.14  # of the baseline
    assert {"<", ">"} <= {line.get_marker() for line in axes.lines if np.all(line.get_ydata() == place)}


def test_before_and_after_have_scales_of_their_own(found: Diagnosis) -> None:
    pictures = pictures_of(found)
    before, after = pictures["flow_time"].figure.axes[0], pictures["flow_time"].figure.axes[2]
    assert before.get_title().endswith('record "fit", before')
    assert after.get_title().endswith('record "fit", after')
    assert before.get_ylim()[1] > 3.0 * after.get_ylim()[1]
    _, _, error_before, _, error_after, _ = pictures["simulation"].figure.axes[:6]
    assert error_before.get_ylim()[1] > 3.0 * error_after.get_ylim()[1]
    assert "its spread (± 1 std), after" in [
        text.get_text() for text in pictures["flow_signals"].figure.legends[0].texts
    ]
    (evidence, *_) = pictures["flow_evidence"].figure.axes
    asked = next(line.get_xdata()[0] for line in evidence.lines if line.get_linewidth() == 2.0)
    nothing = next(line.get_xdata()[0] for line in evidence.lines if line.get_linestyle() == "--")
    assert asked == pytest.approx(0.95 * nothing)  # 4 %, and 1 % for the one parameter
    assert any(text.get_text().startswith("gain ") for text in evidence.texts)


def test_the_signal_that_a_found_effect_acts_on_is_shown(found: Diagnosis) -> None:
    part = parts_of(found, found.results[0].balance)[0]
    assert "pressure_1" not in shown_signals(found, part)
    seal = replace(found.found[0], name="pressure_dependent_friction")
    assert {"pressure_1", "pressure_2"} <= set(shown_signals(replace(found, found=[seal]), part))


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


def test_tables_show_readable_units(found: Diagnosis) -> None:
    errors = error_table(found).set_index("error (rms)")
    assert list(errors["unit"]) == ["cm^3/s", "N", "mm", "kPa"]
    flow = found.report["error"]["fit"]["before"]["flow_rms_m3_per_s"]
    assert float(errors.loc["residual of the flow balance", "fit, before"]) == pytest.approx(1e6 * flow, rel=1e-2)
    evidence = evidence_table(found)
    assert list(evidence[evidence["outcome"] == "added"]["candidate"]) == ["valve deadband"]
    assert quantity("valve_overlap", 1.2346e-5, 3e-8) == "12.346 ± 0.030 µm"
    assert quantity("bulk_modulus", 1.7e9) == "1700 MPa"


def test_every_effect_is_said_in_plain_words() -> None:
    assert set(PLAIN) == set(EFFECTS)


# --- series ---


def test_bins_show_what_a_residual_depends_on() -> None:
    generator = np.random.default_rng(5)
    signal = generator.uniform(-1.0, 1.0, 24000)
    residual = 3.0 * signal**2 + 0.1 * generator.standard_normal(24000)
    residual[::50] = np.nan
    centre, mean, spread = binned(signal, residual)
    assert centre.size == 24
    np.testing.assert_allclose(mean[2:-2], 3.0 * centre[2:-2] ** 2, atol=0.02)
    assert np.all(spread < 0.25)


def test_autocorrelation_of_a_first_order_process_with_gaps() -> None:
    """phi^k, whatever is missing."""
    noise = np.random.default_rng(6).standard_normal(40_000)
    for k in range(1, noise.size):
        noise[k] += 0.8 * noise[k - 1]
    noise[10_000:20_000] = np.nan
    lags, values, white = autocorrelation([noise[:30_000], noise[30_000:]])
    np.testing.assert_allclose(values[:6], 0.8 ** np.arange(6), atol=0.03)
    assert lags[1] == pytest.approx(0.01)
    assert white == pytest.approx(1.96 / np.sqrt(30_000), rel=1e-6)
