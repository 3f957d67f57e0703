"""Effects that held-out records speak against are not named: a weak spring, which both records have, or neither."""

from dataclasses import replace
from pathlib import Path

import pytest
from driven import TRUE, driven_experiment

from plants.effects.registry import effects
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.selection.search import LEVEL
from workbench.diagnose.simulation.fits import Fitting
from workbench.diagnose.simulation.held_out import HeldOut, likelier, swings_by_itself, without_refuted
from workbench.diagnose.simulation.reached import SimulationStart
from workbench.diagnose.simulation.setup import shooting_of
from workbench.diagnose.simulation.stage import SimulationStage
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.reading import read_records

OWN, SPRING = ("coulomb", "viscous"), "spring_stiffness"

OFF = 1.05
"""Times its friction of a plant that a held-out record knows better than the record of its fit."""

WEAK = 1.0
"""N/m: six standard deviations of what a record tells."""


def recorded(folder: Path, stiffness: float, seed: int) -> tuple[Experiment, list[Motion]]:
    folder.mkdir()
    experiment = read_experiment(driven_experiment(folder, stiffness, 5e-6, 2.5, stroke=1.0, seed=seed))
    return experiment, motions_of(experiment, read_records(experiment))


@pytest.mark.parametrize("there", [True, False])
def test_what_only_its_own_record_asked_for_is_not_named(there: bool, tmp_path: Path) -> None:
    experiment, motions = recorded(tmp_path / "fit", WEAK if there else 0.0, 1)
    _, held_out = recorded(tmp_path / "held_out", WEAK if there else 0.0, 2)
    how, declared = shooting_of(experiment, motions, held=False), declared_values(experiment)
    assert how is not None
    values = {**declared, **{name: TRUE[name] for name in OWN}}
    sprung = Fitting(motions, (*OWN, SPRING), {}).begun(how, {**values, SPRING: WEAK})
    plain = Fitting(motions, OWN, {})
    before = plain.final(plain.found(how, values)).fit
    effects = {"spring_load": (SPRING,)}
    found = SimulationStage(
        sprung.how, before, sprung.fit, effects, sprung.fit, effects, [], {"spring_load": 18.0}, {"spring_load": []}, []
    )
    start = SimulationStart(OWN, declared, declared, declared, effects, {})
    kept = without_refuted(experiment, found, held_out, start)
    after, without = map(HeldOut.of(experiment, found, held_out).left_by, (found.after, before))
    assert (likelier(after, without) > 10.0) is there
    assert without_refuted(experiment, found, [], start) is found, "nothing speaks against it"
    if there:
        assert kept is found
        off = replace(found.after, values={**found.after.values, "coulomb": OFF * found.after.values["coulomb"]})
        astray = replace(found, after=off)
        assert likelier(HeldOut.of(experiment, astray, held_out).left_by(off), without) < -LEVEL
        assert without_refuted(experiment, astray, held_out, start) is astray, "it is the friction that speaks"
    else:
        assert (kept.effects, kept.gains, kept.alternatives) == ({}, {}, {})
        assert (kept.refuted, kept.dropped) == (["spring_load"], ["spring_load"])
        assert kept.after is kept.before
        assert SPRING not in kept.after.names


def test_of_what_swings_by_itself_another_record_says_nothing() -> None:
    assert [effect for effect in effects() if swings_by_itself(effect)] == ["supply_ripple"]
