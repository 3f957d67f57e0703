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

from plants.non_rotating import Inputs
from plants.two_chamber import TWO_CHAMBER
from workbench.diagnose.diagnose import Diagnosis, diagnose
from workbench.diagnose.unexplained import Dependence
from workbench.parameters import build, read_deviations, read_parameters
from workbench.report import diagnosis
from workbench.report.diagnosis_series import autocorrelation, binned
from workbench.report.diagnosis_tables import error_table, evidence_table, parameter_table
from workbench.report.diagnosis_words import EFFECTS, PLAIN, quantity, sureness, verdict_sentence
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


def test_what_is_not_identified_is_marked(found: Diagnosis) -> None:
    baseline = {name: {**one, "identified": name != "stribeck"} for name, one in found.report["baseline"].items()}
    marked = replace(found, report={**found.report, "baseline": baseline})
    table = parameter_table(marked).set_index("parameter")
    assert table.loc["stribeck", "remark"] == "not identified by the baseline"
    assert table.loc["coulomb", "remark"] == ""
    assert table.loc["valve_overlap", "remark"] == "of an effect"
    assert any(line.startswith("The records do not identify stribeck:") for line in sureness(marked))


def test_tables_show_readable_units(found: Diagnosis) -> None:
    errors = error_table(found).set_index("error (rms)")
    assert list(errors["unit"]) == ["cm^3/s", "N", "mm", "kPa"]
    flow = found.report["error"]["fit"]["before"]["flow_rms_m3_per_s"]
    assert float(errors.loc["residual of the flow balance", "fit, before"]) == pytest.approx(1e6 * flow, rel=1e-2)
    evidence = evidence_table(found)
    assert list(evidence[evidence["outcome"] == "added"]["candidate"]) == ["valve deadband"]
    assert quantity("valve_overlap", 1.2346e-5, 3e-8) == "12.35 ± 0.030 µm"
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
