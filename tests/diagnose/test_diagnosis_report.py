"""The report of a diagnosis: the command end to end, its files, and what a kill leaves."""

import json
import os
from pathlib import Path
from typing import TYPE_CHECKING

import pandas as pd
import pytest
from browsing import from_disk
from command import Answer, changed, workbench, write
from deadband import OVERLAP
from experiments import TRUTH
from page_numbers import pictures_of, text_of

from workbench.diagnose.report import folder as report_folder
from workbench.diagnose.result import Diagnosis
from workbench.parameters.sets import read_deviations, read_parameters

if TYPE_CHECKING:
    from playwright.sync_api import Browser

STUDY = changed(
    'model = "by_rpm"\nparameters = "owen2001_simulation"\n\n[axes]\nrpm = [0, 460]\n',
    'model = "two_chamber"\nparameters = "out/plant.toml"\n',
)


@pytest.fixture(scope="module")
def folder(experiment: Path) -> Path:
    return experiment.parent


@pytest.fixture(scope="module")
def answer(diagnosed: tuple[Answer, Diagnosis]) -> Answer:
    return diagnosed[0]


# --- the command ---


def test_the_command_says_what_it_found(answer: Answer) -> None:
    assert (answer.code, answer.err) == (0, "")
    assert "\nFound: valve deadband (valve_overlap = " in answer.out
    assert "| residual of the flow balance " in answer.out


def test_every_file_is_there(folder: Path, answer: Answer) -> None:
    out = folder / "out"
    written = {str(item.relative_to(out)) for item in out.rglob("*") if item.is_file()}
    rounds = pd.read_csv(out / "tables" / "evidence.csv")["balance"].value_counts()
    names = [
        "parameters",
        "simulation",
        *(f"{b}_{what}" for b in ("flow", "force") for what in FIGURES),
        *(["simulation_evidence"] if rounds["simulation"] > 1 else []),  # rounding decides whether any effect is tried
    ]
    figures = {f"figures/{name}.png" for name in names}
    tables = {f"tables/{name}.{e}" for name in ("effects", "error", "parameters", "evidence") for e in ENDINGS}
    assert written == {"report.json", "report.html", "plant.toml", "contents.json"} | figures | tables
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
    assert report["fitted"]["coulomb"]["identified"] is True
    assert report["baseline"]["bulk_modulus"]["identified"] is False  # the overlap, left out, is taken for soft oil
    stiffness = {fit: report[fit]["bulk_modulus"]["value"] / TRUTH["bulk_modulus"] for fit in ("baseline", "fitted")}
    assert stiffness["baseline"] < 0.1
    assert stiffness["fitted"] == pytest.approx(1.0, abs=0.02)


def test_the_page_shows_every_figure_that_there_is(folder: Path, answer: Answer) -> None:
    page = (folder / "out" / "report.html").read_text()
    assert "Found: valve deadband (valve_overlap = " in page
    pictures = [path.read_bytes() for path in (folder / "out" / "figures").glob("*.png")]
    assert sorted(pictures_of(page)) == sorted(pictures)
    assert text_of(page).count("<img") == len(pictures) >= 10
    assert " nan" not in text_of(page)


def test_the_page_opens_from_disk_without_a_network(browser: "Browser", folder: Path, answer: Answer) -> None:
    with from_disk(browser, folder / "out" / "report.html") as page:
        assert page.locator(".answer").inner_text().startswith("Found: valve deadband (valve_overlap = ")
        alive = page.locator("figure.picture:has(script)")
        assert alive.count() >= 10
        alive.first.scroll_into_view_if_needed()
        page.wait_for_selector(".live-shown canvas", state="attached")
        assert page.evaluate("document.documentElement.scrollWidth") <= 1300


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
    assert "two_chamber" in next(line for line in checked.out.splitlines() if line.startswith("  serves "))
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
    monkeypatch.setattr(report_folder, "pictures_of", lambda diagnosis: {})


def killed(*_: object) -> None:
    raise KeyboardInterrupt


@pytest.mark.usefixtures("undrawn")
@pytest.mark.parametrize("where", ["write_frame", "plant_file", "page"])
def test_a_kill_while_writing_leaves_nothing(
    diagnosis: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, where: str
) -> None:
    monkeypatch.setattr(report_folder, where, killed)
    with pytest.raises(KeyboardInterrupt):
        report_folder.write_diagnosis(diagnosis, tmp_path / "out")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.usefixtures("undrawn")
def test_a_kill_while_replacing_leaves_no_report_and_can_be_repeated(
    diagnosis: Diagnosis, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    out = tmp_path / "out"
    report_folder.write_diagnosis(diagnosis, out)
    (out / "notes.txt").write_text("the reader's own")
    move = os.replace

    def stopped(source: Path, target: Path) -> None:
        if target.name == "plant.toml":
            raise KeyboardInterrupt
        move(source, target)

    with monkeypatch.context() as patch:
        patch.setattr(os, "replace", stopped)
        with pytest.raises(KeyboardInterrupt):
            report_folder.write_diagnosis(diagnosis, out)
    assert not (out / "report.json").exists()
    with report_folder.claimed_folder(out, overwrite=False):
        report_folder.write_diagnosis(diagnosis, out)
    assert json.loads((out / "report.json").read_text())["verdict"] == "effect_found"
    ours = {"report.json", "report.html", "plant.toml", "contents.json", "tables"}
    assert {item.name for item in out.iterdir()} == ours | {"notes.txt"}
