"""What is wrong in the code of a plug-in is told in one line that names it and its package."""

import importlib
from dataclasses import replace
from pathlib import Path

import pytest
from command import DRIVE, changed, workbench, write
from plugin_site import brings, visible

import workbench as wb
from plants.effects.registry import EFFECTS
from plants.laws.lugre import LUGRE
from plants.registry import DRIVE_FORCE
from workbench.errors import UserError
from workbench.parameters import sets

FAILING = """\
from workbench.metrics.interface import Column, Metric
def iae(observed):
    return {"iae_m_s": observed.run.signals["eror"].sum()}
IT = Metric("iae", (Column("iae_m_s", "m s", "integral of the error's magnitude"),), iae)
"""


def test_a_metric_that_raises_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With its package, the case, and what was raised; in Python the same without the case."""
    brings(tmp_path, "friction_workbench.metrics", "iae = failing_metric:IT")
    visible(tmp_path, monkeypatch)
    write(tmp_path, FAILING, "failing_metric.py")
    told = 'metric "iae" of the package "other" fails: KeyError: \'eror\' (--debug shows all of it)'
    study = write(tmp_path, changed("[simulation]", '[axes]\n"controllers.p.kp" = ["3 N/m"]\n[simulation]', DRIVE))
    assert workbench("check", study).code == 0
    done = workbench("run", study, "--out", tmp_path / "out")
    assert (done.code, done.err) == (2, f"error: controllers.p.kp 3 N/m: {told}\n")
    with pytest.raises(UserError) as raised:
        workbench("--debug", "run", study, "--out", tmp_path / "again")
    assert isinstance(raised.value.__cause__, KeyError)
    with pytest.raises(UserError) as raised:
        wb.evaluate(wb.simulate(wb.Study(study).setup()))
    assert str(raised.value) == told


def test_a_metric_that_finds_what_it_does_not_declare_is_one_line(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    brings(tmp_path, "friction_workbench.metrics", "iae = other_metric:IT")
    visible(tmp_path, monkeypatch)
    write(
        tmp_path,
        FAILING.replace('observed.run.signals["eror"].sum()', "1.0").replace('"iae_m_s":', '"iae":'),
        "other_metric.py",
    )
    done = workbench("run", write(tmp_path, DRIVE), "--out", tmp_path / "out")
    assert done.code == 2
    assert done.err.endswith('metric "iae" of the package "other" finds iae, which its columns do not declare\n')


BRANCHING = """\
from plants.equation import equation
from plants.laws.interface import FrictionLaw, Nothing
@equation
def level(velocity, p):
    if velocity > 0.0:
        return p.friction.positive.coulomb
    return -p.friction.negative.coulomb
@equation
def friction(velocity, contact, held, p):
    return level(velocity, p), Nothing()
IT = FrictionLaw("mine", "a law", "a test", friction, level)
"""


def test_a_law_with_an_if_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It cannot be recorded, so that nothing of it is run."""
    brings(tmp_path, "friction_workbench.friction_laws", "mine = branching:IT")
    visible(tmp_path, monkeypatch)
    write(tmp_path, BRANCHING, "branching.py")
    study = write(tmp_path, changed('"canudas1995"', '"canudas1995"\nfriction = "mine"', DRIVE))
    assert workbench("check", study).code == 0
    done = workbench("run", study, "--out", tmp_path / "out")
    assert (done.code, done.err) == (
        2,
        'error: friction law "mine" of the package "other" cannot be compiled: "level" (branching.py, line 5) branches '
        'on a value; in place of a condition ("if", "and", "max") use select(condition, a, b) '
        "(--debug shows all of it)\n",
    )
    with pytest.raises(UserError) as raised:
        workbench("--debug", "run", study, "--out", tmp_path / "again")
    assert isinstance(raised.value.__cause__, ValueError)


UNMARKED = """\
from typing import Annotated, NamedTuple
from plants.effects.interface import DISTURBANCE, Effect, Number
from plants.equation import equation
class Own(NamedTuple):
    magnet_force: Annotated[float, "N"] = 0.0
{mark}
def pull(disturbance, moment, memory, p, own):
    {body}
numbers = {{"magnet_force": Number(0.0, 1.0, 0.1)}}
IT = Effect(name="magnet", balance="force", words="a magnet pulls", source="a test", numbers=numbers, Own=Own,
            inputs={{DISTURBANCE: pull}})
"""

MAGNET = changed('parameters = "canudas1995"', 'parameters = "canudas1995"\nset.magnet_force = "1 N"', DRIVE)


def test_an_effect_with_an_if_is_one_line(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    brings(tmp_path, "friction_workbench.effects", "magnet = branching_effect:IT")
    visible(tmp_path, monkeypatch)
    body = "return disturbance + own.magnet_force if moment.position > 0.1 else disturbance"
    write(tmp_path, UNMARKED.format(mark="@equation", body=body), "branching_effect.py")
    monkeypatch.setattr(sets, "known_units", sets.known_units.__wrapped__)
    done = workbench("run", write(tmp_path, MAGNET), "--out", tmp_path / "out")
    assert done.code == 2
    told = 'error: effect "magnet" of the package "other" cannot be compiled: "pull" (branching_effect.py, line 8) '
    assert done.err.startswith(f"{told}branches on a value; ")


def test_a_function_without_the_mark_of_equations_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the package is listed, and where Python puts the effect, or the law, into a plant."""
    brings(tmp_path, "friction_workbench.effects", "magnet = unmarked:IT")
    visible(tmp_path, monkeypatch)
    write(tmp_path, UNMARKED.format(mark="", body="return disturbance + own.magnet_force"), "unmarked.py")
    told = 'function "pull" is no equation; decorate it with @equation'
    reason = f'unmarked:IT of the package "other" cannot be used (TypeError: {told}); mend or uninstall the package'
    assert EFFECTS.broken() == {"magnet": reason}
    with pytest.raises(ValueError, match=f'effect "magnet": {told}'):
        DRIVE_FORCE.with_effects(importlib.import_module("unmarked").IT)
    law = replace(LUGRE, name="mine", friction=lambda velocity, contact, held, p: (velocity, contact))
    with pytest.raises(ValueError, match='friction law "mine": function "<lambda>" is no equation'):
        DRIVE_FORCE.with_friction(law)


def test_a_broken_plugin_may_have_the_name_that_is_not_known(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Why it cannot be used stands behind the hint: for a parameter, and for a column of a table."""
    brings(
        tmp_path, "friction_workbench.effects", "magnet = absent_effect:IT\n[friction_workbench.metrics]\niae = no:IT"
    )
    visible(tmp_path, monkeypatch)
    effect, metric = (
        f"{module}:IT of the package \"other\" cannot be used (ModuleNotFoundError: No module named '{module}'); "
        "mend or uninstall the package"
        for module in ("absent_effect", "no")
    )
    for line in ('set.magnet_force = "1 N"', "scale.magnet_force = 2.0"):
        study = write(tmp_path, changed('"canudas1995"', f'"canudas1995"\n{line}', DRIVE))
        done = workbench("check", study)
        assert done.code == 2
        assert "unknown parameter" in done.err
        assert done.err.endswith(f" {effect}\n")
    table = (
        '[axes]\ncontroller = ["p"]\n[[tables]]\nname = "t"\ntitle = "t"\nindex = "controller"\n[[tables.columns]]\n'
    )
    study = write(tmp_path, f'{DRIVE}{table}result = "iae_m_s"\nlabel = "IAE"\nunit = "m s"\n')
    done = workbench("check", study)
    assert done.code == 2
    assert 'unknown figure "iae_m_s"; ' in done.err
    assert done.err.endswith(f" {metric}\n")
