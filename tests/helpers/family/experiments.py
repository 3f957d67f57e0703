"""Experiment folders: records, the file that says what is believed of the rig, and the truth that no program reads."""

import json
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from .limits import free_parameters
from .machines import HAND, ROTARY, Rig, stream
from .parameters import DRIVE, HYDRAULIC
from .records import USES, Record

TRUTH = "truth.json"

SPREAD = 3.0
"""Largest factor between what is true of a free parameter and what is declared."""

UNITS = {
    "coulomb": "N",
    "stribeck": "N",
    "viscous": "N s/m",
    "stribeck_velocity": "m/s",
    "bristle_stiffness": "N/m",
    "bristle_damping": "N s/m",
    "mass": "kg",
    "load_force": "N",
    "end_stop_stiffness": "N/m",
    "end_stop_damping": "s/m",
    "force_gain": "N/V",
    "piston_area_1": "m^2",
    "piston_area_2": "m^2",
    "stroke": "m",
    "hose_volume": "m^3",
    "dead_volume_1": "m^3",
    "dead_volume_2": "m^3",
    "bulk_modulus": "Pa",
    "supply_pressure": "Pa",
    "tank_pressure": "Pa",
    "valve_flow_gain": "m^2/(s Pa^0.5)",
    "sonic_conductance": "m^3/(s Pa)",
    "critical_pressure_ratio": "1",
    "polytropic_exponent": "1",
    "valve_position_gain": "m/V",
    "valve_time_constant": "s",
    "spool_limit": "m",
    "voltage_limit": "V",
}
"""Of the declared parameters of a straight axis."""

TURNED_UNITS = {
    "N": "N m",
    "N s/m": "N m s/rad",
    "m/s": "rad/s",
    "N/m": "N m/rad",
    "kg": "kg m^2",
    "s/m": "s/rad",
    "N/V": "N m/V",
}

TURNED_NAMES = {"mass": "inertia", "load_force": "load_torque", "force_gain": "torque_gain"}

COLUMNS = {
    "time": ("t", "s", 1.0),
    "valve_voltage": ("u", "V", 1.0),
    "command": ("u", "", 1.0),
    "position": ("x", "mm", 1e-3),
    "pressure_1": ("pA", "bar", 1e5),
    "pressure_2": ("pB", "bar", 1e5),
    "force": ("F", "N", 1.0),
}
"""Channel -> column, unit, that unit in SI."""


def named(rig: Rig, own: str) -> str:
    """The program's name of a free parameter of `Machine`."""
    if own == "flow_gain":
        return "valve_flow_gain" if rig.machine.actuator == HYDRAULIC else "sonic_conductance"
    return {"polytropic": "polytropic_exponent"}.get(own, own)


def true_values(rig: Rig) -> dict[str, float]:
    """The plant's parameters (SI) as they are, by the program's names for a straight axis."""
    m = rig.machine
    values = {
        "mass": m.mass,
        "load_force": 0.0,
        "end_stop_stiffness": 0.0,
        "end_stop_damping": 0.0,
        "coulomb": m.coulomb,
        "stribeck": m.stribeck,
        "viscous": m.viscous,
        "stribeck_velocity": m.stribeck_velocity,
        "bristle_stiffness": m.bristle_stiffness,
        "bristle_damping": m.bristle_damping,
    }
    if m.actuator == DRIVE:
        return values | ({"force_gain": m.command_gain, "voltage_limit": m.command_limit} if _by_volts(rig) else {})
    values |= {
        "piston_area_1": m.area_1,
        "piston_area_2": m.area_2,
        "stroke": m.stroke,
        "supply_pressure": m.supply_pressure,
        "valve_position_gain": m.spool_gain,
        "valve_time_constant": m.spool_time,
        "spool_limit": m.spool_limit,
        "voltage_limit": m.command_limit,
    }
    if m.actuator == HYDRAULIC:
        return values | {
            "hose_volume": m.dead_volume_1,
            "bulk_modulus": m.bulk_modulus,
            "tank_pressure": m.tank_pressure,
            "valve_flow_gain": m.flow_gain,
        }
    return values | {
        "dead_volume_1": m.dead_volume_1,
        "dead_volume_2": m.dead_volume_2,
        "sonic_conductance": m.flow_gain * m.spool_limit,
        "critical_pressure_ratio": m.critical_ratio,
        "polytropic_exponent": m.polytropic,
    }


def _by_volts(rig: Rig) -> bool:
    return rig.plant.endswith("_voltage")


def declared_values(rig: Rig) -> dict[str, float]:
    """The same as they are declared: what a fit may move is off by up to `SPREAD` either way."""
    draw, values = stream(rig.seed, "declared"), true_values(rig)
    for own in free_parameters(rig):
        factor = float(np.exp(draw.uniform(-np.log(SPREAD), np.log(SPREAD))))
        if own == "polytropic":  # it lies between 1 and 1.4 for everybody
            values["polytropic_exponent"] = draw.uniform(1.05, 1.4)
        else:
            values[named(rig, own)] *= factor
    return values


def parameters_text(rig: Rig, values: Mapping[str, float]) -> str:
    """A parameters file."""
    turns = rig.kind == ROTARY
    lines = [f'title = "rig {rig.seed}"', 'source = "drawn"']
    for name, value in values.items():
        unit = TURNED_UNITS.get(UNITS[name], UNITS[name]) if turns else UNITS[name]
        text = f"{float(value)!r}" if unit == "1" else f"{float(value)!r} {unit}"
        lines += [f"[parameters.{_turned(rig, name)}]", f'value = "{text}"', 'source = "drawn"']
    return "\n".join(lines) + "\n"


def _turned(rig: Rig, name: str) -> str:
    return TURNED_NAMES.get(name, name) if rig.kind == ROTARY else name


def experiment_text(rig: Rig, channels: list[str]) -> str:
    """The experiment file; it says nothing of what is to be found."""
    lines = [
        f'title = "record {rig.seed}"',
        "[plant]",
        f'model = "{rig.plant}"',
        'parameters = "declared.toml"',
    ]
    if rig.machine.actuator == DRIVE:
        lines += ["[fit]", f"free = {json.dumps(list(free_parameters(rig)))}"]
    lines.append("[channels]")
    for name in channels:
        column, unit = _column(rig, name)[:2]
        called = "torque" if name == "force" and rig.kind == ROTARY else name
        lines.append(f'{called} = {{ column = "{column}", unit = "{unit}" }}')
    for use in USES:
        lines += ["[[records]]", f'file = "{use}.parquet"', f'use = "{use}"']
    text = "\n".join(lines) + "\n"
    tomllib.loads(text)
    return text


def _column(rig: Rig, name: str) -> tuple[str, str, float]:
    """Column, unit, and that unit in SI."""
    column, unit, size = COLUMNS[name]
    if name == "command":
        force = "N m" if rig.kind == ROTARY else "N"
        return column, "V" if _by_volts(rig) else force, 1.0
    if rig.kind == ROTARY and name == "position":
        return column, "rad", 1.0
    return (column, "N m", 1.0) if rig.kind == ROTARY and name == "force" else (column, unit, size)


def write_experiment(folder: Path, rig: Rig, records: Mapping[str, Record], truth: Mapping[str, Any]) -> Path:
    """Records, declared.toml, experiment.toml and truth.json in a folder; returns the experiment's path."""
    folder.mkdir(parents=True, exist_ok=True)
    for use, made in records.items():
        columns = {_column(rig, name)[0]: values / _column(rig, name)[2] for name, values in made.channels.items()}
        pd.DataFrame(columns).to_parquet(folder / f"{use}.parquet", index=False)
        names = list(made.channels)
    (folder / "declared.toml").write_text(parameters_text(rig, declared_values(rig)), encoding="utf-8")
    about = {
        "rig": {"kind": rig.kind, "plant": rig.plant, "motion": rig.motion, "seed": rig.seed},
        "values": {_turned(rig, name): value for name, value in true_values(rig).items()},
        "sample_time": rig.sample_time,
        "duration": rig.duration,
        "by_hand": rig.motion == HAND,
        "noise": {name: noise.std for name, noise in rig.noises.items()},
    }
    text = json.dumps({**about, **truth}, indent=2, default=float)
    (folder / TRUTH).write_text(text + "\n", encoding="utf-8")
    path = folder / "experiment.toml"
    path.write_text(experiment_text(rig, names), encoding="utf-8")
    return path
