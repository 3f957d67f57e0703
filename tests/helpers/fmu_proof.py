"""`make fmu-proof`: exported plants in FMPy, in closed loop over 3 s, beside the studies that they are from.

Prints a table: whether FMPy finds fault with the FMU, and the largest distance of its positions from the study's, with
FMPy's solver (model exchange, CVode) and with the FMU's own (co-simulation), for FMI 2.0 and 3.0. Ends with 1 where one
is not below 1e-6 m or rad.
"""

import sys
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from fmpy.validation import validate_fmu
from fmu_importer import KINDS, closed_loop, opened
from tabulate import tabulate

from workbench.export.fmi.fmu import VERSIONS, exported
from workbench.simulation.sensors import Sensors
from workbench.simulation.setup import Integrator, Setup
from workbench.simulation.simulate import simulate
from workbench.study.reading import read_study
from workbench.study.resolve import resolve
from workbench.study.unfold import unfold

STUDIES = Path(__file__).parents[2] / "studies"
DURATION = 3.0
TOLERANCE = 1e-9
"""Of the study's integration: what is to be seen are differences of the equations, not of two solvers."""

BOUND = 1e-6

CASES: dict[str, tuple[dict[str, object], ...]] = {
    "thesis_chapter3": ({"rpm": 0}, {"rpm": 460}),
    "differential_cylinder": ({"rpm": 0, "controller": "pid", "reference": "fast_sine"},),
    "pneumatic_cylinder": ({"rpm": 0, "controller": "pid", "reference": "fast_sine"},),
    "rotary_drive": ({"controller": "friedland_park", "reference": "fast"},),
    "two_inertia_drive": ({"controller": "pid", "reference": "slow"},),
    "comparison": ({"machine": "thesis_rig", "rpm": 75, "controller": "load_pressure", "scenario": "measured_rig"},),
}
"""By study, values of axes: the first case that has them."""


def setups() -> list[Setup]:
    """What is proved: the cases above, over 3 s, with ideal sensors."""
    found = []
    for name, wanted in CASES.items():
        study = read_study(STUDIES / f"{name}.toml")
        cases = unfold(study)
        for where in wanted:
            setup = resolve(study, cases[int(cases.where(where)[0])]).setup
            exact = Integrator(tolerance=TOLERANCE)
            found.append(replace(setup, duration=DURATION, sensors=Sensors(), integrator=exact))
    return found


def main() -> int:
    rows, bad = [], 0
    with TemporaryDirectory() as folder:
        for setup in setups():
            positions = simulate(setup).state("position")
            for fmi in VERSIONS:
                path = Path(folder, f"plant_{fmi}.fmu")
                path.write_bytes(exported(setup, fmi, "proof").archive)
                problems = validate_fmu(str(path))
                distances = []
                for kind in KINDS:
                    with opened(path, fmi, kind) as machine:
                        distances.append(float(np.max(np.abs(closed_loop(machine, setup) - positions))))
                bad += bool(problems) + sum(not distance < BOUND for distance in distances)
                told = "none" if not problems else "; ".join(problems)
                moved = float(np.ptp(positions))
                rows.append([setup.plant.name, setup.loop.controller.name, f"{fmi}.0", told, moved, *distances])
                print(f"  {setup.plant.name}, FMI {fmi}.0", file=sys.stderr, flush=True)
    header = ["plant", "controller", "FMI", "faults found", "moves by", *KINDS]
    print(tabulate(rows, header, floatfmt=".2g"))
    return 1 if bad else 0


if __name__ == "__main__":
    sys.exit(main())
