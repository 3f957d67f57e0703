"""An exported plant in FMPy, an importer that is not ours: in short what `make fmu-proof` shows of more plants."""

import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from short_loop import small

from workbench.export.fmi.fmu import VERSIONS, exported
from workbench.simulation.setup import Integrator
from workbench.simulation.simulate import simulate

pytest.importorskip("fmpy")
pytestmark = pytest.mark.skipif(shutil.which("cc") is None, reason="needs a C compiler")


@pytest.mark.parametrize("fmi", VERSIONS)
def test_another_importer_finds_no_fault_and_the_same_motion(fmi: int, tmp_path: Path) -> None:
    from fmpy.validation import validate_fmu
    from fmu_importer import KINDS, closed_loop, opened

    setup = replace(small().simulation, duration=0.2, integrator=Integrator(tolerance=1e-9))
    path = tmp_path / "plant.fmu"
    path.write_bytes(exported(setup, fmi, "a plant").archive)
    assert validate_fmu(str(path)) == []
    positions = simulate(setup).state("position")
    for kind in KINDS:
        with opened(path, fmi, kind) as machine:
            assert np.max(np.abs(closed_loop(machine, setup) - positions)) < 1e-9
    with opened(path, fmi, "co-simulation") as machine:
        machine.write({"valve_voltage": 2.0})
        machine.advance(0.0, 0.1)
        saved = machine.save()
        machine.advance(0.1, 0.1)
        gone, ahead = machine.read(["position"]), machine.read(["time", "position"])
        for leave in (lambda: None, machine.instance.terminate, machine.instance.reset):
            leave()
            machine.restore(saved)
            assert machine.read(["time"]) == [0.1]
            machine.advance(0.1, 0.1)
            assert machine.read(["time", "position"]) == ahead
        assert abs(gone[0]) > 1e-4
