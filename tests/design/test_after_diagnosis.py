"""A design from the folder of a diagnosis: its hypotheses, fitted to the records, and what the diagnosis ends with."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from deadband import OVERLAP
from experiments import TRUTH

from workbench.design import diagnosed, open_questions
from workbench.diagnose.report.verdict import next_words
from workbench.diagnose.result import Diagnosis
from workbench.progress import silent

OWN = ("coulomb", "stribeck", "viscous", "stribeck_velocity", "bristle_stiffness", "bristle_damping")
FLOW = ("valve_flow_gain", "bulk_modulus")


@pytest.fixture(scope="module")
def folder(experiment: Path, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What an ambiguous diagnosis of a valve with overlap would leave."""
    numbers = {name: {"value": TRUTH[name], "unit": "", "std": 0.0, "identified": True} for name in (*OWN, *FLOW)}
    overlap = {
        name: {"value": OVERLAP, "unit": "m", "std": 1e-7} for name in ("valve_overlap", "valve_overlap_negative")
    }
    report = {
        "experiment": experiment.as_posix(),
        "verdict": "ambiguous",
        "effects": [{"name": "valve_deadband", "parameters": overlap, "alternatives": ["internal_leakage"]}],
        "baseline": numbers,
        "fitted": {**numbers, "viscous": {**numbers["viscous"], "identified": False}},
        "simulation": {"voltage_is_held": False},
    }
    folder = tmp_path_factory.mktemp("diagnosed")
    (folder / "report.json").write_text(json.dumps(report), encoding="utf-8")
    return folder


def test_what_was_found_is_held_against_its_alternative(folder: Path) -> None:
    reported = diagnosed.read_diagnosis(folder)
    assert reported.vague == ["viscous"]
    assert reported.held is False
    evidence = diagnosed.evidence_of(reported, silent)
    assert evidence.fit.excess == pytest.approx(1.0, abs=0.2), "the plant follows its records"
    assert set(evidence.noise) == {"position", "pressure_1", "pressure_2"}
    overlap, leakage = open_questions.hypotheses_of(reported, evidence, (), silent)
    assert (overlap.name, leakage.name) == ("valve deadband", "internal leakage")
    assert overlap.values["valve_overlap"] == pytest.approx(OVERLAP, rel=0.05)
    assert leakage.values["valve_overlap"] == 0.0
    assert leakage.values["leakage_coefficient"] > 0.0
    deviation = np.sqrt(overlap.covariance[[u.name for u in overlap.unknowns].index("coulomb")].max())
    assert 0.0 < deviation < 0.05, "the records tell the friction"
    hidden, none = open_questions.hypotheses_of(reported, evidence, ("position_dependent_volume", "none"), silent)
    assert none.name == "valve deadband", "what was found stays beside"
    assert none.is_part_of(hidden)
    squares = evidence.fit.seen_at({**evidence.fit.values, **hidden.values})
    # of one that the records put at x deviations, |x| < SHOWN, squares change by SHOWN (SHOWN - 2 x)
    assert -(open_questions.SHOWN**2) < squares - evidence.fit.squares < 2.0 * open_questions.SHOWN**2


def test_an_ambiguous_diagnosis_ends_with_the_command(diagnosis: Diagnosis) -> None:
    two = replace(diagnosis.effects[0], alternatives=["internal_leakage"])
    said = next_words(replace(diagnosis, effects=[two]), "DIR")
    assert said == "What to record to tell them apart: workbench design DIR --out DIR_next"
    assert next_words(diagnosis, "DIR") == ""
