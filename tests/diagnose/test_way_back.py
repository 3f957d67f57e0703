"""A search that began where the plant had lost its way: what it found says no more than that."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import pytest
from driven import TRUE, driven_experiment

from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.fit import fit
from workbench.diagnose.selection.unexplained import Dependence
from workbench.diagnose.simulation import stage
from workbench.diagnose.simulation.fits import Fitting
from workbench.diagnose.simulation.reached import SimulationStart
from workbench.diagnose.simulation.setup import shooting_of
from workbench.diagnose.simulation.stage import Searches, SimulationStage
from workbench.progress import silent
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records

NAMES = ("coulomb", "viscous")

FOUND = {"spring_load": ("spring_stiffness",)}


@pytest.mark.parametrize(("stiffness", "stays"), [(500.0, False), (0.0, True)])
def test_effects_that_leave_more_than_none_are_sought_anew(stiffness: float, stays: bool, tmp_path: Path) -> None:
    """A spring of 500 N/m that is none, beside the true friction, and one of no stiffness, which leaves as much."""
    experiment = read_experiment(driven_experiment(tmp_path, 0.0, 5e-6, 2.5, stroke=1.0))
    motions = motions_of(experiment, read_records(experiment))
    how, declared = shooting_of(experiment, motions, held=False), declared_values(experiment)
    assert how is not None
    base = Fitting(motions, NAMES, {}).begun(how, {**declared, **{name: TRUE[name] for name in NAMES}})
    how, before = base.how, fit(base.fit.balance, base.fit.values, ())

    def left(values: Mapping[str, float]) -> SimulationStage:
        after = replace(before, values=dict(values), residual=before.balance.stacked(values))
        return SimulationStage(how, before, before, {}, after, FOUND, [], {"spring_load": 9.0}, {}, ["cogging"])

    found = left({**before.values, "spring_stiffness": stiffness})
    start = SimulationStart(NAMES, declared, declared, declared, {}, {})
    searches = Searches(experiment, motions, start, silent)
    again = searches.anew(base, found)
    if stays:
        assert again is found
    else:
        pieces = replace(base, how=replace(base.how, length=0.5))
        assert searches.anew(pieces, found) is found, "of pieces less is left"
        assert found.after.rms > 10.0
        assert again.effects == {}
        assert again.dropped == ["cogging", "spring_load"], "by balances, and now"
        assert again.after.rms == pytest.approx(1.0, abs=0.1), "of a plant that lacks nothing"


def test_effects_do_not_stand_in_once_more_for_what_a_curve_explains(tmp_path: Path) -> None:
    """A spring that is none leaves 10 deviations, and one that is weaker less: both leave a curve over time."""
    experiment = read_experiment(driven_experiment(tmp_path, 0.0, 5e-6, 2.5, stroke=1.0))
    motions = motions_of(experiment, read_records(experiment))
    how, declared = shooting_of(experiment, motions, held=False), declared_values(experiment)
    assert how is not None
    values = {**declared, **{name: TRUE[name] for name in NAMES}}
    before, weaker = (
        fit(how.balance(motions, ()), {**values, "spring_stiffness": each}, ()) for each in (500.0, 200.0)
    )
    curve = Dependence("force", {"time": 1.0}, 9.0)
    found = SimulationStage(how, before, before, {}, before, {}, [], {}, {}, [], curve, ("spring_load",))
    again = SimulationStage(how, before, before, {}, weaker, FOUND, [], {}, {}, [])
    assert weaker.rms < before.rms
    assert stage._tells_more(again, found), "nothing is left to be explained"
    assert not stage._tells_more(replace(again, lacks=curve), found)
    assert stage._tells_more(replace(again, lacks=curve), replace(found, stood_in=(), lacks=None))
    assert not stage._tells_more(replace(again, effects={}), found)
