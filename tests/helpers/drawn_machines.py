"""Cylinders drawn over decades: machines that nobody had in mind."""

import numpy as np


def _log(draw: np.random.Generator, low: float, high: float) -> float:
    return float(np.exp(draw.uniform(np.log(low), np.log(high))))


def _friction(draw: np.random.Generator, static: float, mass: float) -> dict[str, float]:
    """A contact that breaks away at `static` (N): its bristle bends by 5 to 100 um, damped by 0.2 to 1 of critical."""
    stiffness = static / _log(draw, 5e-6, 1e-4)
    coulomb = static * draw.uniform(0.4, 0.9)
    return {
        "coulomb": coulomb,
        "stribeck": static - coulomb,
        "viscous": static / _log(draw, 0.05, 1.0),
        "stribeck_velocity": _log(draw, 2e-3, 0.05),
        "bristle_stiffness": stiffness,
        "bristle_damping": draw.uniform(0.2, 1.0) * 2.0 * float(np.sqrt(stiffness * mass)),
    }


def hydraulic(seed: int, *, equal: bool = False) -> dict[str, float]:
    """Values of a hydraulic cylinder: bores of 16 to 250 mm, 3 to 35 MPa, speeds of 0.05 to 1 m/s at full travel."""
    draw = np.random.default_rng([seed, 1])
    area = 0.25 * np.pi * _log(draw, 0.016, 0.25) ** 2
    ratio = 1.0 if equal else draw.uniform(0.4, 0.95)
    supply, stroke = _log(draw, 3e6, 35e6), _log(draw, 0.05, 2.0)
    mass = area * supply / _log(draw, 5.0, 100.0)
    spool, limit = _log(draw, 2e-4, 5e-3), 10.0
    speed = min(_log(draw, 0.05, 1.0), 3.0 * stroke)
    return {
        "piston_area_1": area,
        "piston_area_2": ratio * area,
        "stroke": stroke,
        "hose_volume": area * stroke * draw.uniform(0.02, 0.5),
        "dead_volume_1": 0.0 if equal else area * stroke * draw.uniform(0.01, 0.3),
        "dead_volume_2": 0.0 if equal else area * stroke * draw.uniform(0.01, 0.3),
        "bulk_modulus": _log(draw, 0.3e9, 1.7e9),
        "supply_pressure": supply,
        "tank_pressure": 0.0 if equal else draw.uniform(0.0, 5e5),
        "valve_flow_gain": area * speed / (spool * float(np.sqrt(0.5 * supply))),
        "valve_position_gain": spool / limit,
        "valve_time_constant": _log(draw, 2e-3, 3e-2),
        "spool_limit": spool,
        "voltage_limit": limit,
        "mass": mass,
        "load_force": 0.0 if equal else draw.uniform(-0.2, 0.2) * area * supply,
        "end_stop_stiffness": area * supply / 2e-5,
        "end_stop_damping": 5.0,
        **_friction(draw, area * supply * _log(draw, 0.01, 0.2), mass),
    }


def pneumatic(seed: int) -> dict[str, float]:
    """Values of a pneumatic cylinder: bores of 10 to 125 mm, 2 to 10 bar, 0.2 to 3 m/s at full travel."""
    draw = np.random.default_rng([seed, 2])
    area = 0.25 * np.pi * _log(draw, 0.010, 0.125) ** 2
    supply, stroke = _log(draw, 2e5, 1e6), _log(draw, 0.05, 1.0)
    mass = area * supply / _log(draw, 5.0, 100.0)
    spool, speed = _log(draw, 2e-4, 2e-3), min(_log(draw, 0.2, 3.0), 4.0 * stroke)
    return {
        "piston_area_1": area,
        "piston_area_2": area * draw.uniform(0.75, 1.0),
        "stroke": stroke,
        "dead_volume_1": area * stroke * draw.uniform(0.03, 0.5),
        "dead_volume_2": area * stroke * draw.uniform(0.03, 0.5),
        "supply_pressure": supply,
        "sonic_conductance": area * speed / 1e5,
        "critical_pressure_ratio": draw.uniform(0.15, 0.5),
        "valve_position_gain": spool / 5.0,
        "valve_time_constant": _log(draw, 2e-3, 1e-2),
        "spool_limit": spool,
        "voltage_limit": 5.0,
        "polytropic_exponent": draw.uniform(1.05, 1.4),
        "exhaust_gain": draw.uniform(0.7, 1.3),
        "leakage_conductance": area * speed / 1e5 * draw.uniform(0.0, 0.01),
        "mass": mass,
        "load_force": draw.uniform(-0.1, 0.1) * area * supply,
        "end_stop_stiffness": area * supply / 1e-4,
        "end_stop_damping": 2.0,
        **_friction(draw, area * supply * _log(draw, 0.01, 0.2), mass),
    }


MOTOR = {
    "rotary_inertia": 2e-3,
    "piston_radius": 15e-3,
    "torque_constant": 0.6,
    "back_emf_constant": 0.6,
    "motor_inductance": 8e-3,
    "motor_resistance": 1.5,
    "bearing_viscous": 2e-3,
}
"""A motor that turns a rod, without limits and with equal constants."""
