"""Experiments whose records hold effects that the experiment file does not declare.

    path = make_experiment(folder, {"valve_deadband": 0.5}, seed=3)

makes fit.parquet, held_out.parquet, experiment.toml and truth.json, which no program reads. The true parameters differ
from the declared ones, too: a residual that better parameters remove is not an effect.
"""

import json
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from zlib import crc32

import numpy as np
import pandas as pd

from .effects import EFFECTS, UNLISTED
from .physics import POSITION, PRESSURE_1, SUBSTEPS, Rig, run
from .reference import make_reference

DECLARED = "owen2001_simulation"
SAMPLE_TIME = 1e-3

NOMINAL = Rig(
    area_1=6.33e-4,
    area_2=6.33e-4,
    stroke=60e-3,
    hose_volume=8.9e-6,
    bulk_modulus=1724e6,
    supply_pressure=2.94e6,
    tank_pressure=0.0,
    flow_gain=5.9e-4,
    spool_gain=6e-5,
    spool_time=12e-3,
    spool_limit=0.6e-3,
    voltage_limit=10.0,
    mass=34.0,
    coulomb=370.0,
    stribeck=217.0,
    viscous=2318.0,
    stribeck_velocity=0.032,
    bristle_stiffness=5.77e6,
    bristle_damping=2.28e4,
)
"""What is declared: Owen 2001, appendix B, column 'simulation', as the set `owen2001_simulation` gives it."""

SPREAD = {
    "coulomb": 0.2,
    "stribeck": 0.2,
    "viscous": 0.2,
    "flow_gain": 0.2,
    "bulk_modulus": 0.3,
    "stribeck_velocity": 0.2,
    "bristle_stiffness": 0.3,
}
"""Largest relative difference between what is true and what is declared."""

NOISE = np.array([5e-6, 2e3, 2e3])
"""Standard deviations of position (m) and both pressures (Pa)."""

QUANTUM = np.array([1e-6, 6e6 / 2**16, 6e6 / 2**16])
"""Converter steps, same units."""

ANGLE_NOISE = 1e-3
"""rad."""

GAIN = (150.0, 300.0)
"""V/m."""

DURATION = (40.0, 60.0)
"""s."""

USES = ("fit", "held_out")

COLUMNS = {
    "time": ("time", "s", 1.0),
    "valve_voltage": ("voltage", "V", 1.0),
    "position": ("position", "mm", 1e-3),
    "pressure_1": ("pressure_a", "bar", 1e5),
    "pressure_2": ("pressure_b", "bar", 1e5),
    "rotation_angle": ("angle", "rad", 1.0),
}
"""Channel -> column, unit, that unit in SI."""


@dataclass(frozen=True, eq=False)
class Simulated:
    """One record as it was (states, shape (samples, 8)) and as it was measured (by channel, SI)."""

    states: np.ndarray
    channels: Mapping[str, np.ndarray]
    reference: np.ndarray


def _draw(seed: int, purpose: str) -> np.random.Generator:
    """A random stream of its own for each purpose, so that an effect does not change the noise."""
    return np.random.default_rng([seed, crc32(purpose.encode())])


def true_rig(seed: int, effects: Mapping[str, float], unlisted: Mapping[str, float] | None = None) -> Rig:
    """The rig with the parameters that this seed draws, and the effects."""
    draw = _draw(seed, "parameters")
    values = NOMINAL._asdict()
    for name, spread in SPREAD.items():
        values[name] *= 1.0 + draw.uniform(-spread, spread)
    rig = Rig(**values)
    for known, chosen in ((EFFECTS, effects), (UNLISTED, unlisted or {})):
        for name, strength in chosen.items():
            values |= known[name].change(rig, strength, _draw(seed, name))
    return Rig(**values)


def simulate(
    rig: Rig, seed: int, use: str, *, substeps: int = SUBSTEPS, noisy: bool = True, duration: float | None = None
) -> Simulated:
    """The record of a rig for `use` ("fit" or "held_out"): same plant and loop, another reference, other noise.

    `substeps` a sample, `noisy` with noise and quantisation, `duration` (s) in place of the drawn one.
    """
    loop = _draw(seed, "loop")
    gain, drawn = loop.uniform(*GAIN), round(loop.uniform(*DURATION), 1)
    duration = drawn if duration is None else duration
    reference = make_reference(duration, SAMPLE_TIME, _draw(seed, f"reference {use}"))
    noise = _draw(seed, f"noise {use}").standard_normal((reference.size, 4))
    scatter = noise[:, :3] * NOISE if noisy else np.zeros((reference.size, 3))
    quantum = QUANTUM if noisy else np.zeros(3)
    states, measured, voltage = run(rig, gain, reference, scatter, quantum, SAMPLE_TIME, substeps)
    time = np.arange(reference.size) * SAMPLE_TIME
    channels = {"time": time, "valve_voltage": voltage}
    channels |= dict(zip(("position", "pressure_1", "pressure_2"), measured.T, strict=True))
    if rig.rotation_speed:
        angle = rig.rotation_start + rig.rotation_speed * time
        channels["rotation_angle"] = angle + ANGLE_NOISE * noise[:, 3]
    return Simulated(states, channels, reference)


def check_physical(record: Simulated, rig: Rig) -> None:
    """A record that no rig could have given is a mistake here.

    Raises:
        ValueError: end stop reached, a chamber below the tank's pressure, no finite numbers, or a saturated valve.
    """
    if not np.all(np.isfinite(record.states)):
        raise ValueError("the record diverges")
    if np.max(np.abs(record.states[:, POSITION])) >= 0.5 * rig.stroke:
        raise ValueError("the piston reaches an end stop")
    if np.min(record.states[:, PRESSURE_1 : PRESSURE_1 + 2]) < -1e4:
        raise ValueError("a chamber's pressure is negative")
    if np.mean(np.abs(record.channels["valve_voltage"]) >= rig.voltage_limit) > 0.01:
        raise ValueError("the valve is saturated")


def make_experiment(
    folder: Path, effects: Mapping[str, float], seed: int, unlisted: Mapping[str, float] | None = None
) -> Path:
    """Write records, truth.json and experiment.toml into `folder`; returns the experiment's path.

    Args:
        folder: made if it is missing.
        effects: strength (0 to 1) by the name of an effect of `EFFECTS`.
        seed: of true parameters, loop, references, noise and of the form of the effects.
        unlisted: the same by names of `UNLISTED`.

    Raises:
        KeyError: an unknown effect.
        ValueError: the record would not be physical.
    """
    folder.mkdir(parents=True, exist_ok=True)
    rig = true_rig(seed, effects, unlisted)
    for use in USES:
        record = simulate(rig, seed, use)
        check_physical(record, rig)
        columns = {COLUMNS[name][0]: values / COLUMNS[name][2] for name, values in record.channels.items()}
        pd.DataFrame(columns).to_parquet(folder / f"{use}.parquet", index=False)
    truth = {"effects": dict(effects), "unlisted": dict(unlisted or {}), "seed": seed, "rig": rig._asdict()}
    (folder / "truth.json").write_text(json.dumps(truth, indent=2) + "\n", encoding="utf-8")
    path = folder / "experiment.toml"
    path.write_text(_experiment_text(record.channels, seed), encoding="utf-8")
    return path


def _experiment_text(channels: Mapping[str, np.ndarray], seed: int) -> str:
    """The experiment file; it says nothing of what is to be found."""
    lines = [
        f'title = "record {seed}"',
        "[plant]",
        'model = "non_rotating"',
        f'parameters = "{DECLARED}"',
        "[channels]",
    ]
    for name in channels:
        column, unit, _ = COLUMNS[name]
        lines.append(f'{name} = {{ column = "{column}", unit = "{unit}" }}')
    for use in USES:
        lines += ["[[records]]", f'file = "{use}.parquet"', f'use = "{use}"']
    text = "\n".join(lines) + "\n"
    tomllib.loads(text)
    return text
