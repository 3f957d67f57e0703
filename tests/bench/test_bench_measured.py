"""A record on the bench: the plant that is declared, and the one that wrote it, beside what was measured."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from benches import controls, knob_of, short
from command import STUDIES, changed, workbench

from workbench.bench.groups import chosen, groups_of
from workbench.bench.knobs import Knob
from workbench.bench.measured import MeasuredLoop, corrected
from workbench.bench.opened import opened
from workbench.bench.outcome import outcome_of
from workbench.bench.saved import save
from workbench.bench.scopes import SCOPES
from workbench.bench.sweep import swept
from workbench.errors import UserError

NOISE, PRESSURE_NOISE = 5e-6, 2e3
"""Of the rig's sensors (m, Pa)."""

TRUE = {
    "plant.set.coulomb": 1.15 * 370.0,
    "plant.set.valve_flow_gain": 0.95 * 5.9e-4,
    "plant.set.viscous": 0.9 * 2318.0,
    "plant.set.viscous_negative": 0.9 * 3400.0,
    "plant.set.valve_overlap": 10e-6,
}
"""What studies/closed_loop/rig.toml has."""


@pytest.fixture(scope="module")
def loop(tmp_path_factory: pytest.TempPathFactory) -> MeasuredLoop:
    """The closed loop's experiment, with records of 6 s."""
    folder = tmp_path_factory.mktemp("measured")
    rig = shutil.copytree(STUDIES / "closed_loop", folder / "studies" / "closed_loop") / "rig.toml"
    rig.write_text(changed('duration = "30 s"', 'duration = "6 s"', rig.read_text(encoding="utf-8")), encoding="utf-8")
    answer = workbench("run", rig, "--out", folder / "results" / "closed_loop_rig")
    assert answer.code == 0, answer.err
    found = opened(rig.with_name("experiment.toml"))
    assert isinstance(found, MeasuredLoop)
    return found


def test_the_plant_that_wrote_a_record_is_off_it_by_the_noise(loop: MeasuredLoop) -> None:
    """But for where it began, which a record tells to the millimetre, and an open loop keeps."""
    declared, true = outcome_of(loop), outcome_of(loop.changed({"plant.model": "two_chamber", **TRUE}))
    assert declared.misfits.keys() == {"position", "pressure_1", "pressure_2"}
    assert true.misfits["position"] < 3.0 * NOISE
    assert declared.misfits["position"] > 100.0 * true.misfits["position"]
    assert true.misfits["pressure_1"] < 3.0 * PRESSURE_NOISE


def test_scopes_show_the_record_beside_the_plant(loop: MeasuredLoop) -> None:
    outcome = outcome_of(loop)
    view = SCOPES["position"].view(outcome)
    assert [curve.name for curve in view.curves] == ["recorded position", "position"]
    assert view.curves[0].y.max() == pytest.approx(1e3 * loop.record.channels["position"].max(), rel=1e-3)
    error = SCOPES["error"].view(outcome).curves[0]
    assert abs(error.y).max() > 1e3 * outcome.misfits["position"]
    assert len(SCOPES["pressures"].view(outcome).curves) == 4
    assert "open loop" in SCOPES["bode"].view(outcome).note


def test_records_are_chosen_and_everything_offered_serves(loop: MeasuredLoop) -> None:
    other = chosen(loop, "record", loop.records[2].name)
    assert isinstance(other, MeasuredLoop)
    assert other.record.use == "held_out"
    assert outcome_of(other).misfits != outcome_of(loop).misfits
    assert set(groups_of(loop)) == {"record", "machine", "friction", "effects"}
    outcome = outcome_of(loop)
    for control in [one for one in controls(outcome) if isinstance(one, Knob) and one.key.startswith("plant.")]:
        assert loop.changed(control.change(control.at(min(control.place + 0.05, 1.0)))).serves, control


def test_a_corrected_plant_comes_from_its_folder(loop: MeasuredLoop, tmp_path: Path) -> None:
    source = STUDIES.parent / "plants" / "parameters" / "owen2001_simulation.toml"
    text = source.read_text(encoding="utf-8")
    (tmp_path / "plant.toml").write_text(changed('value = "370 N"', 'value = "425 N"', text), encoding="utf-8")
    found = corrected(loop, tmp_path)
    assert found.parsed.values.true["coulomb"] == 425.0
    assert loop.parsed.values.true["coulomb"] == 370.0
    with pytest.raises(UserError, match=r"no such file; expected the folder of a diagnosis"):
        corrected(loop, tmp_path / "none")


def test_a_sweep_tells_how_far_the_plant_is_off(loop: MeasuredLoop) -> None:
    knob = knob_of(outcome_of(loop), "plant.set.viscous")
    for value, figure in swept(loop, knob, [1500.0, 2500.0], "rms_error_m", lambda: False):
        assert figure == outcome_of(loop.changed(knob.change(value))).misfits["position"]


def test_what_a_record_drives_is_no_study(loop: MeasuredLoop, tmp_path: Path) -> None:
    with pytest.raises(UserError, match=r"what a record drives is no study"):
        save(outcome_of(loop), "mine.toml", tmp_path)
    assert not list(tmp_path.iterdir())


def test_the_balances_of_the_plant_that_wrote_a_record_leave_noise(loop: MeasuredLoop) -> None:
    true = {"plant.model": "two_chamber", **TRUE}
    leaves = {key: value for key, value in true.items() if key != "plant.set.valve_overlap"}

    def rms(changes: dict[str, object], scope: str) -> float:
        view = SCOPES[scope].view(outcome_of(loop.changed(changes)))
        return float(np.sqrt(np.nanmean(np.concatenate([curve.y for curve in view.curves]) ** 2)))

    assert rms(true, "flow_balance") < 0.1 * rms(leaves, "flow_balance")  # the overlap, turned off and on
    assert rms(true, "force_balance") < 0.5 * rms({"plant.model": "two_chamber"}, "force_balance")
    assert SCOPES["flow_balance"].view(outcome_of(short())).note == "no record that tells it"
