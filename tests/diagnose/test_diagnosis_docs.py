"""What docs/diagnosis.md shows is what the program takes: its experiment, and the effects that are listed."""

from pathlib import Path

import numpy as np
import pytest
from command import ROOT, workbench, write
from snippets.given import given

from plants.effects.curves import nodes_of
from plants.effects.registry import effects
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records

PAGE = ROOT / "docs" / "diagnosis.md"
DOCS = PAGE.read_text(encoding="utf-8")


def test_the_experiment_to_copy_is_in_order(tmp_path: Path) -> None:
    path = write(tmp_path, DOCS.partition("```toml\n")[2].partition("```")[0], "experiment.toml")
    given(PAGE, tmp_path)
    answer = workbench("check", path)
    assert (answer.code, answer.err) == (0, "")
    assert answer.out.startswith(f"{path}: an experiment, in order\n")
    assert "\n  diagnose: can use it\n" in answer.out
    assert "run_a.csv: fit, 9.999 s at 1000 Hz\n" in answer.out
    assert "run_b.csv: held_out, 9.799 s at 1000 Hz\n" in answer.out
    experiment = read_experiment(path)
    (record,) = read_records(experiment, "held_out")
    assert experiment.values["mass"] == 12.0
    assert float(np.mean(record.channels["position"])) == pytest.approx(0.0, abs=2e-3)
    assert float(np.max(record.channels["valve_voltage"])) == pytest.approx(0.5, rel=1e-3)
    assert float(np.max(record.channels["pressure_2"])) == pytest.approx(19.7e5, rel=0.01)


def test_a_record_is_for_the_fit_unless_it_says_otherwise(tmp_path: Path) -> None:
    text = DOCS.partition("```toml\n")[2].partition("```")[0]
    path = write(tmp_path, "\n".join(line for line in text.splitlines() if not line.startswith("use =")), "e.toml")
    assert [spec.use for spec in read_experiment(path).records] == ["fit", "fit"]


def test_list_tells_of_every_effect_its_balance_meaning_and_parameters() -> None:
    title, *lines = workbench("list", "effects").out.splitlines()
    assert title == "effects"
    named = [line for line in lines if line[2] != " "]
    assert [line.split()[:2] for line in named] == [[effect.name, effect.balance] for effect in effects().values()]
    plain = [" ".join(line.split()) for line in lines]
    told = [
        "internal_leakage flow oil leaks from one chamber into the other",
        "leakage_coefficient m^3/(s Pa) the plant's own searched from 0 to 1 times the machine's own scale",
        "unequal_areas flow the second chamber's piston area is not the declared one",
        "The second chamber's piston area over its declared value.",
        "area_ratio 1 default 1 searched from 0.2 to 2",
        "coulomb_negative N the plant's own searched from 0 up",
    ]
    assert [line for line in told if line not in plain] == []
    (shares,) = (line for line in plain if line.startswith("Shares of the friction in mid-stroke"))
    assert plain[plain.index(shares) + 1] == "friction_gradient 1 default 0 searched from -0.9 to 0.9"
    for effect in effects().values():
        names = set(effect.numbers) - set(nodes_of(effect.name)[1:-1])
        assert names <= {line.split()[0] for line in lines if line[2] == " "}
