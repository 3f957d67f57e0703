"""What one chamber loses is told over its pressure: no push on a valve, which fills one as it empties the other."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from diagnosis.generator import make_experiment

from plants.effects.curves import CURVES
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.along import Along
from workbench.diagnose.residuals.motion import motion_of
from workbench.diagnose.simulation import lacking as lacking_room
from workbench.diagnose.simulation.fits import Fitting
from workbench.diagnose.simulation.lacking import dependence_of, lacking
from workbench.diagnose.simulation.own_curves import curves_of
from workbench.diagnose.simulation.setup import shooting_of
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records

FREE = ("coulomb", "viscous", "valve_flow_gain")

NOISE = {"position": 2e-6, "pressure_1": 2e3, "pressure_2": 2e3}
"""m, Pa."""


def test_what_one_chamber_loses_above_a_pressure_is_told_over_that(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = make_experiment(tmp_path, {}, 5)
    record = tmp_path / "fit.parquet"
    pd.read_parquet(record).iloc[:6000].to_parquet(record)
    experiment = read_experiment(path)
    (motion,) = motions_of(experiment, read_records(experiment))
    how, values = shooting_of(experiment, [motion], held=False), declared_values(experiment)
    assert how is not None
    assert ("velocity", CURVES["flow", "velocity"]) in curves_of(how.along.plant)

    relief = CURVES["flow", "pressure_1"]
    share, low, high, *nodes = relief.own_names
    plain = how.simulated(motion, values)
    above, most = np.quantile(plain["pressure_1"], [0.6, 1.0])
    lost = -2e-10 * np.maximum(np.linspace(-1.0, 1.0, len(nodes)), 0.0)
    curve = {share: 1.0, low: 2.0 * above - most, high: most, **dict(zip(nodes, lost, strict=True))}
    leaking = replace(how, along=Along(how.along.plant.with_effects(relief), how.along.flow))
    draw = np.random.default_rng(3)
    shown = {
        name: signal + NOISE[name] * draw.standard_normal(signal.size)
        for name, signal in leaking.simulated(motion, {**values, **curve}).items()
    }
    motion = motion_of(replace(motion.record, channels={**motion.record.channels, **shown}))
    how = shooting_of(experiment, [motion], held=False)
    assert how is not None
    fitting = Fitting([motion], FREE, {})
    fitted = fitting.final(fitting.found(how, values))
    told = dependence_of(lacking(fitted.how, fitted.fit))
    assert told is not None
    assert (told.balance, {*told.signals[:2]}) == ("flow", {"pressure_1", "pressure_2"}), "which go together"
    monkeypatch.setattr(lacking_room, "_flows", lambda *_: [])
    assert dependence_of(lacking(fitted.how, fitted.fit)) is None, "a push on the valve sees nothing of it"
