"""The rig that makes the records: two chamber pressures, LuGre friction, a valve spool, and effects on each of them.

Its equations and its integrator are its own, so that a mistake in the plant that is fitted cannot hide in the record.

    dx/dt    = v
    M dv/dt  = P1 A1 - P2 A2 - F(v, z) - c v|v| - F_load - k x - A cos(theta + phi) - cushion - cogging
    dP1/dt   = beta(P1) / V1 (Q1 - A1 v - C (P1 - P2) - C_e (P1 - P_T))        V_i = V_h + A_i L / 2
    dP2/dt   = beta(P2) / V2 (A2 v - Q2 + C (P1 - P2))
    dx_s/dt  = (K_sv V(t - delay) - x_s) / tau_sv
    x_o > 0:  Q1 = K x_o sqrt(P_s' - P1),  Q2 = K x_o sqrt(P2 - P_T)
    x_o < 0:  Q1 = K x_o sqrt(P1 - P_T),   Q2 = K x_o sqrt(P_s' - P2)
    P_i >= P_T: check valves let oil in from the tank before a chamber empties
    dz/dt    = v - sigma0 |v| z / g,   F = sigma0 z + sigma1 dz/dt + a2(t) v

Owen 2001, 3.2 (LuGre: (3.31) to (3.33)); Merritt 1967 for valve, leakage and bulk modulus. All in SI.
"""

from typing import NamedTuple

import numpy as np
from numba import njit

ATMOSPHERE = 101325.0
"""Pa. Pressures are gauge pressures; the air in the oil sees the absolute ones."""

SUBSTEPS = 20
"""Integration steps a sample of 1 ms."""

STUCK_SPEED = 5e-4
"""m/s. Below it the dwell time of the contact grows."""

FORGETTING_DISTANCE = 2e-4
"""m. Distance of sliding, about twice what the bristle takes to break away, in which the strength of a dwell fades."""

DWELL_TIME = 1.0
"""s. Time constant with which static friction grows in a dwell."""

COGGING_PITCH = 4e-3
"""m."""

POSITION, VELOCITY, PRESSURE_1, PRESSURE_2, BRISTLE, SPOOL, DWELL, OPENING = range(8)
"""Columns of the simulated states; OPENING is where the play of the spool has left the ports (m)."""


class Rig(NamedTuple):
    """True parameters of one rig; what stands with a default is an effect, silent at it."""

    area_1: float  # m^2
    area_2: float  # m^2
    stroke: float  # m
    hose_volume: float  # m^3
    bulk_modulus: float  # Pa
    supply_pressure: float  # Pa
    tank_pressure: float  # Pa
    flow_gain: float  # m^2/(s Pa^0.5)
    spool_gain: float  # m/V
    spool_time: float  # s
    spool_limit: float  # m
    voltage_limit: float  # V
    mass: float  # kg
    coulomb: float  # N
    stribeck: float  # N
    viscous: float  # N s/m
    stribeck_velocity: float  # m/s
    bristle_stiffness: float  # N/m
    bristle_damping: float  # N s/m
    retracting_level: float = 1.0  # of the level, v < 0
    retracting_viscous: float = 1.0  # of the viscosity, v < 0
    level_linear: float = 0.0  # c1 of 1 + c1 xi + c2 xi^2, xi = 2 x / stroke
    level_quadratic: float = 0.0  # c2
    level_pressure: float = 0.0  # N/Pa, of |P1 - P2|
    memory: float = 0.0  # s, lag of the velocity that the level sees
    dwell_growth: float = 0.0  # of the Stribeck friction, after a long dwell
    quadratic_drag: float = 0.0  # N s^2/m^2
    viscous_drift: float = 0.0  # 1/s, relative
    load: float = 0.0  # N, against extension
    spring: float = 0.0  # N/m
    rotary_force: float = 0.0  # N
    rotary_phase: float = 0.0  # rad
    rotation_speed: float = 0.0  # rad/s
    rotation_start: float = 0.0  # rad
    overlap: float = 0.0  # m, half width
    leakage: float = 0.0  # m^3/(s Pa)
    supply_resistance: float = 0.0  # Pa s/m^3
    air: float = 0.0  # volume share of air at atmospheric pressure
    delay: float = 0.0  # s
    backlash: float = 0.0  # m, full width
    pressure_1_offset: float = 0.0  # Pa
    cushion_stiffness: float = 0.0  # N/m
    cushion_start: float = 0.0  # m, from the middle
    cogging: float = 0.0  # N
    external_leakage: float = 0.0  # m^3/(s Pa), chamber 1 to tank
    spool_play: float = 0.0  # m, half width


@njit(cache=True, inline="always")
def _play(state: float, driver: float, half: float) -> float:
    """The follower of a play of half width `half` (m): it moves when the driver pushes it."""
    return min(max(state, driver - half), driver + half)


@njit(cache=True, inline="always")
def _returned(gain: float, drop: float) -> float:
    """Flow (m^3/s) gain sqrt(drop) to the tank; back from it where a chamber is below the tank's pressure."""
    return gain * np.sign(drop) * np.sqrt(abs(drop))


@njit(cache=True, inline="always")
def _drawn(gain: float, drop: float, resistance: float) -> float:
    """Flow (m^3/s) q = gain sqrt(drop - R q): through the valve, from a supply that yields by R q."""
    drop = max(drop, 0.0)
    if resistance == 0.0:
        return gain * np.sqrt(drop)
    half = 0.5 * gain * gain * resistance
    return np.sqrt(half * half + gain * gain * drop) - half


@njit(cache=True)
def _rates(y: np.ndarray, out: np.ndarray, time: float, voltage: float, lagged: float, p: Rig) -> None:
    """Rates of the first six states into `out`; `lagged` is the velocity that the friction level sees."""
    x, v, p1, p2, z, spool = y[0], y[1], y[2], y[3], y[4], y[5]
    # friction
    extending = v >= 0.0
    share = 1.0 if extending else p.retracting_level
    xi = 2.0 * x / p.stroke
    peak = p.stribeck * (1.0 + p.dwell_growth * (1.0 - np.exp(-y[6] / DWELL_TIME)))
    level = share * (p.coulomb + peak * np.exp(-((lagged / p.stribeck_velocity) ** 2)))
    level *= 1.0 + p.level_linear * xi + p.level_quadratic * xi * xi
    level += p.level_pressure * abs(p1 - p2)
    bristle = v - p.bristle_stiffness * abs(v) * z / max(level, 1.0)
    viscous = p.viscous * max(1.0 + p.viscous_drift * time, 0.1) * (1.0 if extending else p.retracting_viscous)
    force = p.bristle_stiffness * z + p.bristle_damping * bristle + viscous * v
    # other forces against extension
    force += p.quadratic_drag * v * abs(v) + p.load + p.spring * x
    if p.rotary_force != 0.0:
        force += p.rotary_force * np.cos(p.rotation_start + p.rotation_speed * time + p.rotary_phase)
    if p.cogging != 0.0:
        force += p.cogging * np.sin(2.0 * np.pi * x / COGGING_PITCH)
    if p.cushion_stiffness != 0.0:
        force += p.cushion_stiffness * np.sign(x) * max(abs(x) - p.cushion_start, 0.0)
    # flow
    opening = _play(y[7], spool, p.spool_play)
    opening = np.sign(opening) * max(abs(opening) - p.overlap, 0.0)
    gain = p.flow_gain * abs(opening)
    if opening >= 0.0:
        into_1 = _drawn(gain, p.supply_pressure - p1, p.supply_resistance)
        out_of_2 = _returned(gain, p2 - p.tank_pressure)
    else:
        into_1 = -_returned(gain, p1 - p.tank_pressure)
        out_of_2 = -_drawn(gain, p.supply_pressure - p2, p.supply_resistance)
    across = p.leakage * (p1 - p2)
    outside = p.external_leakage * (p1 - p.tank_pressure)
    air = p.air * ATMOSPHERE
    give_1 = 1.0 / p.bulk_modulus + air / (p1 + ATMOSPHERE) ** 2
    give_2 = 1.0 / p.bulk_modulus + air / (p2 + ATMOSPHERE) ** 2
    volume_1 = p.hose_volume + 0.5 * p.area_1 * p.stroke
    volume_2 = p.hose_volume + 0.5 * p.area_2 * p.stroke
    target = min(max(p.spool_gain * voltage, -p.spool_limit), p.spool_limit)
    out[0] = v
    out[1] = (p1 * p.area_1 - p2 * p.area_2 - force) / p.mass
    out[2] = (into_1 - p.area_1 * v - across - outside) / (volume_1 * give_1)
    out[3] = (p.area_2 * v - out_of_2 + across) / (volume_2 * give_2)
    if p1 <= p.tank_pressure:
        out[2] = max(out[2], 0.0)
    if p2 <= p.tank_pressure:
        out[3] = max(out[3], 0.0)
    out[4] = bristle
    out[5] = (target - spool) / p.spool_time


@njit(cache=True)
def run(
    p: Rig,
    gain: float,
    feed: np.ndarray,
    noise: np.ndarray,
    quantum: np.ndarray,
    sample_time: float,
    substeps: int,
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Simulate one record: sample, P control, hold, integrate by RK4.

    Args:
        p: the `Rig`.
        gain: V/m of the error of the measured position; 0 leaves the loop open.
        feed: shape (samples,): with a gain the wanted position (m), without one the voltage (V).
        noise: shape (samples, 3): of position (m) and both pressures (Pa).
        quantum: 3 steps of the converters, same units; 0 for none.
        sample_time: s.
        substeps: integration steps a sample.

    Returns:
        states at the samples, shape (samples, 8); position and pressures as measured, shape (samples, 3); voltage (V).
    """
    samples = feed.size
    states, measured, voltages = np.zeros((samples, 8)), np.zeros((samples, 3)), np.zeros(samples)
    y, stage, trial = np.zeros(8), np.zeros((4, 6)), np.zeros(8)
    y[2] = y[3] = 0.5 * (p.supply_pressure + p.tank_pressure)
    h = sample_time / substeps
    delay = round(p.delay / h)
    lag = round(p.memory / h)
    past = np.zeros(lag + 2)  # velocity of the last steps; the newest is at `now % past.size`
    reading = np.zeros(3)
    shown = 0.0
    for k in range(samples):
        shown = _play(shown, y[0], 0.5 * p.backlash)
        reading[0], reading[1], reading[2] = shown, y[2] + p.pressure_1_offset, y[3]
        for j in range(3):
            value = reading[j] + noise[k, j]
            measured[k, j] = quantum[j] * np.rint(value / quantum[j]) if quantum[j] > 0.0 else value
        wish = gain * (feed[k] - measured[k, 0]) if gain > 0.0 else feed[k]
        voltages[k] = min(max(wish, -p.voltage_limit), p.voltage_limit)
        states[k] = y
        for i in range(substeps):
            now = k * substeps + i
            voltage = voltages[(now - delay) // substeps] if now >= delay else 0.0
            time = now * h
            past[now % past.size] = y[1]
            before = past[(now - lag) % past.size] if now >= lag else 0.0
            after = past[(now - lag + 1) % past.size] if now >= lag and lag > 0 else before
            for s in range(4):
                weight = 0.0 if s == 0 else (1.0 if s == 3 else 0.5)
                for j in range(8):
                    trial[j] = y[j] + weight * h * stage[s - 1, j] if s > 0 and j < 6 else y[j]
                lagged = trial[1] if lag == 0 else before + weight * (after - before)
                _rates(trial, stage[s], time + weight * h, voltage, lagged, p)
            for j in range(6):
                y[j] += h / 6.0 * (stage[0, j] + 2.0 * stage[1, j] + 2.0 * stage[2, j] + stage[3, j])
            y[6] = y[6] + h if abs(y[1]) < STUCK_SPEED else y[6] * np.exp(-abs(y[1]) * h / FORGETTING_DISTANCE)
            y[7] = _play(y[7], y[5], p.spool_play)
    return states, measured, voltages
