"""What is wrong in the code of a plug-in is told in one line that names it and its package."""

from pathlib import Path

import pytest
from command import DRIVE, changed, workbench, write
from plugin_site import brings, visible

import workbench as wb
from workbench.errors import UserError


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
