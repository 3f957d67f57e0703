"""How often the 90 % intervals of identified friction hold the truth, over drawn machines and records.

    python benchmarks/identify_coverage.py [machines]

Of each machine mass, bulk modulus, valve gain and friction are drawn; the first three are declared with the standard
deviation of the draw and held, friction is fitted to one record of 4 s with noise of its own. Beside it the same
with what is held taken for right.
"""

import sys
import tempfile
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd

from plants.registry import THESIS
from workbench.identify.identification import identify
from workbench.parameters.corrected import Entry, parameter_file
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.records.experiment import Experiment, read_experiment
from workbench.simulation.references import Multisine
from workbench.simulation.simulate import Feed, Setup, simulate

UNCERTAIN = {"mass": 0.1, "bulk_modulus": 0.1, "valve_flow_gain": 0.01}
"""Standard deviations of what is held, as shares."""

FRICTION = 0.1
"""Of what is fitted: the declared values are off by as much."""

NORMAL_90 = 1.644854
FREE = ("coulomb", "coulomb_negative", "viscous", "viscous_negative")
NOISE = {"position": 5e-6, "pressure_1": 2e3, "pressure_2": 2e3}

EXPERIMENT = """\
title = "a drawn machine"
[plant]
model = "non_rotating"
parameters = "declared.toml"
[fit]
free = ["coulomb", "viscous"]
[channels]
time = { column = "time", unit = "s" }
valve_voltage = { column = "valve_voltage", unit = "V" }
position = { column = "position", unit = "m" }
pressure_1 = { column = "pressure_1", unit = "Pa" }
pressure_2 = { column = "pressure_2", unit = "Pa" }
[[records]]
file = "record.parquet"
"""


def drawn(folder: Path, number: int) -> tuple[Experiment, dict[str, float]]:
    """An experiment on a record of the machine of that number, and its true parameters."""
    generator = np.random.default_rng([7, number])
    declared = dict(read_parameters(named_sets()["owen2001_experiment"]))
    truth = dict(declared)
    for name, share in {**UNCERTAIN, **dict.fromkeys(FREE, FRICTION)}.items():
        truth[name] *= 1.0 + share * float(np.clip(generator.standard_normal(), -2.5, 2.5))
    parameters = build(THESIS.Parameters, truth)
    state, inputs = THESIS.equilibrium(parameters, 0.0)
    feed = Feed("valve_voltage", Multisine(float(generator.uniform(0.5, 1.5)), 0.25, (1, 2, 3)))
    run = simulate(Setup(THESIS, parameters, state, inputs, 4.0, feeds=(feed,)))
    noisy = {name: run.signals[name] + std * generator.standard_normal(run.time.size) for name, std in NOISE.items()}
    pd.DataFrame({"time": run.time, "valve_voltage": run.command, **noisy}).to_parquet(folder / "record.parquet")
    entries = [
        Entry(name, value, UNCERTAIN[name] * value if name in UNCERTAIN else None, "drawn")
        for name, value in declared.items()
    ]
    (folder / "declared.toml").write_text(parameter_file("declared", "drawn", entries, THESIS.axis))
    path = folder / "experiment.toml"
    path.write_text(EXPERIMENT)
    return read_experiment(path), truth


def main(machines: int) -> None:
    """Print the share of intervals that hold the truth, of each parameter and of all."""
    away: dict[str, list[list[float]]] = {"as identified": [], "what is held taken for right": []}
    for number in range(machines):
        with tempfile.TemporaryDirectory() as folder:
            experiment, truth = drawn(Path(folder), number)
            for kind, own in zip(away, (experiment, replace(experiment, deviations={})), strict=True):
                fit = identify(own, "simulation").simulation
                assert fit is not None
                if fit.refuted:
                    continue
                found = [(fit.estimates[name], truth[name]) for name in FREE if name in fit.estimates]
                away[kind].append([abs(one.value - true) / (one.std or 0.0) for one, true in found])
    for kind, rows in away.items():
        table = np.array([row for row in rows if len(row) == len(FREE)]).reshape(-1, len(FREE))
        print(f"{kind}: {machines - len(rows)} of {machines} machines are refuted by their records")
        if not table.size:
            continue
        held = np.mean(table < NORMAL_90, axis=0)
        each = ", ".join(f"{name} {100.0 * share:.0f} %" for name, share in zip(FREE, held, strict=True))
        print(f"  of {len(table)} others hold the truth: {each}; together {100.0 * np.mean(table < NORMAL_90):.0f} %")


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 40)
