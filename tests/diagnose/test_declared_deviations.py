"""What is declared with a deviation moves with what is fitted: its error is no effect, and widens what rests on it."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace
from typing import cast

import numpy as np
import pytest
from driven import TRUE, driven_experiment
from made_up_balances import made_balance, made_motion

from workbench.diagnose.diagnose import diagnose
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.report.sureness import sureness
from workbench.diagnose.residual_stage import ResidualStage, with_declared_of
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.balances import balances_of, priors_of
from workbench.diagnose.residuals.fit import fit, weighing_at
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.selection.likelihood import Outlook, gain_of, gained, left_by
from workbench.diagnose.selection.selection import BalanceResult
from workbench.diagnose.selection.trials import Trial, columns_of
from workbench.diagnose.simulation.stage import SimulationStage
from workbench.fitting.least_squares import Search
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records

DURATION, NOISE = 6.0, 2e-6
"""s, m."""

EXACT = Search(flat=1e-14)
MASS, STD = 30.0, 1.5
"""kg, as declared."""


def forces(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
    """A drag in proportion to the mass, as on a slope, and a load that goes with the velocity."""
    drag = values["mass"] * values["viscous"] * motion.velocity
    return np.asarray(drag + values.get("load_force", 0.0) * (1.0 + motion.velocity / 0.04))


def slope(load: float = 0.0) -> Balance:
    """Of a mass that is one deviation more than is declared."""
    truth = {"mass": MASS + STD, "viscous": 100.0, "load_force": load}
    return replace(made_balance([made_motion()], forces, truth), priors={"mass": (MASS, STD)})


def test_what_a_record_cannot_tell_is_as_uncertain_as_it_is_declared() -> None:
    start = {"mass": MASS, "viscous": 100.0}
    first = fit(slope(), start, ["mass", "viscous"], search=EXACT)
    both = fit(slope(), first.values, ["mass", "viscous"], None, EXACT, weighing_at(first))
    held = fit(slope(), start, ["viscous"], None, EXACT, both.weighing)
    assert both.values["mass"] == pytest.approx(MASS, rel=1e-3), "nothing says otherwise"
    assert both.deviations["mass"] == pytest.approx(STD, rel=0.02)
    assert both.deviations["viscous"] / both.values["viscous"] == pytest.approx(STD / MASS, rel=0.02)
    assert held.deviations["viscous"] < 0.1 * both.deviations["viscous"]


def test_a_search_stays_where_a_declared_value_may_be() -> None:
    far = fit(slope(), {"mass": MASS, "viscous": 100.0}, ["mass"], search=EXACT)
    assert far.bounded == set()
    wrong = replace(slope(), priors={"mass": (MASS, 0.01 * STD)})
    assert fit(wrong, {"mass": MASS, "viscous": 100.0}, ["mass"], search=EXACT).bounded == {"mass"}


def test_an_effect_gains_beside_what_is_declared_what_a_fit_says() -> None:
    balance, start = slope(0.1), {"mass": MASS, "viscous": 100.0}
    whole = fit(balance, {**start, "load_force": 0.0}, ["mass", "load_force"], search=EXACT)
    before = fit(balance, start, ["mass"], None, EXACT, weighing_at(whole))
    after = fit(balance, {**before.values, "load_force": 0.0}, ["mass", "load_force"], None, EXACT, before.weighing)
    trial = Trial("constant_load", ("load_force",))
    columns = columns_of(before, [trial], {})[trial]
    promised, _ = Outlook(before, {trial: columns}).gain([trial])
    assert promised == pytest.approx(0.5 * (before.squares - after.squares), rel=1e-3)
    alone, _ = gain_of(before, columns.change, columns.low, columns.high)
    assert alone == pytest.approx(gained(balance, left_by(after), left_by(before)), rel=0.05)
    exact = replace(balance, priors={"mass": (MASS, 1e-6)})
    held = fit(exact, start, [], None, EXACT, before.weighing)
    assert held.squares > before.squares + 100.0, "a mass that is known to be wrong leaves much"


def test_balances_know_what_the_simulated_plant_says_of_a_declared_value(tmp_path: Path) -> None:
    """One that holds the mass as it is declared, as a balance does on which another does not move it."""
    values = {"mass": MASS, "viscous": 100.0}

    def sloped(motion: Motion, values: Mapping[str, float]) -> np.ndarray:
        return forces(motion, values) + 50.0 * values["mass"] * motion.acceleration

    truth = {"mass": MASS + STD, "viscous": 100.0}
    balance = replace(made_balance([made_motion()], sloped, truth, ("viscous",)), priors={"mass": (MASS, STD)})
    held = fit(balance, values, ["viscous"])
    assert held.rms > 1.05
    stage = ResidualStage([BalanceResult(balance, held, held, [], {}, {}, {})], values, values, values, {})
    found = fit(balance, truth, ["mass", "viscous"])
    simulation = cast(SimulationStage, SimpleNamespace(before=found, after=found))
    around = with_declared_of(stage, read_experiment(declared(tmp_path, 1.0, None)), simulation)
    (result,) = around.results
    assert result.before is result.after
    assert result.after.names == ("viscous",)
    assert result.after.rms == pytest.approx(1.0, abs=0.02)
    for told in (around.declared, around.baseline, around.corrected):
        assert told["mass"] == found.values["mass"]
    assert around.corrected["viscous"] == result.after.values["viscous"]


def declared(folder: Path, off: float, std: float | None) -> Path:
    """An experiment of a mass that is declared so many times what it is, with such a deviation (kg)."""
    path = driven_experiment(folder, 0.0, NOISE, DURATION, stroke=1.0)
    file = folder / "declared.toml"
    lines = file.read_text(encoding="utf-8").splitlines()
    at = lines.index("[parameters.mass]")
    lines[at + 1] = f'value = "{off * TRUE["mass"]} kg"'
    if std is not None:
        lines.insert(at + 2, f'std = "{std} kg"')
    file.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


@pytest.mark.thorough
def test_a_mass_that_is_off_by_what_is_declared_is_no_effect(tmp_path: Path) -> None:
    wrong = diagnose(declared(tmp_path, 1.1, 0.1 * TRUE["mass"]))
    assert wrong.verdict == "none_missing"
    fitted = wrong.fitted_parameters
    assert "mass moved within what is declared of it, and deviations count that" in "\n".join(sureness(wrong))
    assert fitted["mass"].value == pytest.approx(TRUE["mass"], abs=3.0 * fitted["mass"].std)
    assert fitted["mass"].std < 0.01 * TRUE["mass"], "the record tells it better"
    for name in ("coulomb", "viscous"):
        assert fitted[name].value == pytest.approx(TRUE[name], abs=3.0 * fitted[name].std)


@pytest.mark.parametrize(("std", "known"), [(None, {}), (3.0, {"mass": (TRUE["mass"], 3.0)})])
def test_what_is_declared_exactly_is_held(
    tmp_path: Path, std: float | None, known: Mapping[str, tuple[float, float]]
) -> None:
    experiment = read_experiment(declared(tmp_path, 1.0, std))
    motions = motions_of(experiment, read_records(experiment))
    (force,) = balances_of(experiment, motions, declared_values(experiment))
    assert force.priors == known
    assert {*known} <= {*force.free}
    assert ("mass" in force.free) == bool(known)


def test_what_a_user_frees_is_known_by_the_records_alone(tmp_path: Path) -> None:
    path = declared(tmp_path, 1.0, 3.0)
    path.write_text(path.read_text(encoding="utf-8") + '[fit]\nfree = ["mass", "coulomb"]\n', encoding="utf-8")
    assert priors_of(read_experiment(path), ["time", "command", "position"]) == {}
