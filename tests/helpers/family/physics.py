"""The equations that make the records, and their integrator; nothing of the program is imported here.

    dx/dt   = v
    M dv/dt = P1 A1 - P2 A2 (or G u) - F(v, z) - what effects add
    dz/dt   = v sgn(1 - r) |1 - r|^n,  r = sigma0 z sgn(v) / g(v);  n = 1 is LuGre's rate
    F       = sigma0 z + sigma1 dz/dt + a2 v,   g = a0 + a1 exp(-(v / v_s)^2)
    oil:    dP1/dt = beta / V1 (Q1 - A1 v),   dP2/dt = beta / V2 (A2 v - Q2),   Q = K x_o sqrt(drop)
    air:    dP1/dt = n / V1 (R T m1 - P1 A1 v), ...                              ISO 6358
    dx_s/dt = (K_sv u - x_s) / tau

Canudas de Wit, Olsson, Astrom and Lischinsky 1995; Dahl 1968; Merritt 1967; Beater 2007. Pressures are relative to the
atmosphere. RK4 with fixed steps; the command holds over each sample.

All in one file: numba keeps compiled code on disk, and does not notice an edit in another file that it calls.
"""

import math
from typing import Any, TypeAlias

import numpy as np
from numba import njit

from .parameters import DRIVE, HYDRAULIC, Machine

Numbers: TypeAlias = Any
"""A `Machine` as a NumPy record, which compiled code passes by its address: as a tuple it would be copied at each call.
"""

_RECORD = np.dtype([(name, np.float64) for name in Machine._fields])

ATMOSPHERE = 101325.0
"""Pa."""

LAMINAR_DROP = 1e4
"""Pa. Below it an orifice's root bends into a cubic that passes through 0, with equal value and slope at its end."""

GAS_ENERGY = 287.05 * 293.15
"""J/kg. R T of the air."""

NORMAL_DENSITY = 1.185
"""kg/m^3 of ISO 6358, at 293.15 K."""

LAMINAR_RATIO = 0.999
"""Ratio of pressures beyond which the flow of air falls on a line to 0."""

LEAST_SHAPE = 0.05
"""Share of its friction that a contact keeps along the stroke."""

SHORT_MEMORY = 2.0
"""Steps below which a lag of the friction is taken to first order: as a state it would be too fast for them."""

STICKS_AGAIN = 0.02
"""Share of its band at which a spool that goes to its target has arrived."""

X, V, P1, P2, SPOOL, Z, LAGGED, RESTED, SLIP, HUNG_X, HUNG_V, SHOWN = range(12)
STATES = 12
"""Places in the state; LAGGED is the velocity that the friction's level sees, SLIP the second element's force, HUNG_*
the mass on a spring, SHOWN what a slow position sensor shows."""

POSITION, PRESSURE_1, PRESSURE_2, PLACE, SPEED = range(5)
"""Columns of what `run` gives: what sensors show without noise, then position and velocity of the mass."""

OPEN_GAIN, DAMPING, INTEGRAL, FILTER = range(4)
"""Places in a loop: u a m, u a m/s, u a (m s), time constant (s) of the velocity's filter."""


def numbers(machine: Machine) -> Numbers:
    """A machine as compiled functions here take it."""
    return np.array([tuple(machine)], dtype=_RECORD)[0]


@njit(cache=True, error_model="numpy", inline="always")
def _root(drop: float) -> float:
    """sgn(d) sqrt(|d|), laminar within `LAMINAR_DROP`."""
    if abs(drop) > LAMINAR_DROP:
        return math.copysign(math.sqrt(abs(drop)), drop)
    s = drop / LAMINAR_DROP
    return math.sqrt(LAMINAR_DROP) * s * (5.0 - s * s) / 4.0


@njit(cache=True, error_model="numpy", inline="always")
def _fed(gain: float, drop: float, droop: float) -> float:
    """Flow q = gain root(drop - R q) from a supply that yields by R q."""
    if droop == 0.0 or drop <= LAMINAR_DROP:
        return gain * _root(drop)
    half = 0.5 * gain * gain * droop
    return math.sqrt(half * half + gain * gain * drop) - half


@njit(cache=True, error_model="numpy", inline="always")
def air_flow(conductance: float, before: float, behind: float, critical: float) -> float:
    """Mass flow (kg/s) through an opening; backwards where the pressure behind is the higher."""
    high, low = max(before, behind) + ATMOSPHERE, min(before, behind) + ATMOSPHERE
    ratio = low / high
    beyond = max(min(ratio, LAMINAR_RATIO) - critical, 0.0) / (1.0 - critical)
    share = math.sqrt(1.0 - beyond * beyond) * min((1.0 - ratio) / (1.0 - LAMINAR_RATIO), 1.0)
    flow = conductance * NORMAL_DENSITY * high * share
    return flow if before >= behind else -flow


@njit(cache=True, error_model="numpy")
def _level(y: np.ndarray, v: float, reversals: float, p: Numbers) -> float:
    """The level g (N) of the contact."""
    forward = v >= 0.0
    coulomb = p.coulomb if forward else p.coulomb * p.coulomb_ratio
    stribeck = p.stribeck if forward else p.stribeck * p.stribeck_ratio
    if p.friction_gradient != 0.0 or p.friction_curvature != 0.0:
        xi = 2.0 * y[X] / p.stroke
        shape = max(1.0 + p.friction_gradient * xi + p.friction_curvature * xi * xi, LEAST_SHAPE)
        coulomb *= shape
        stribeck *= shape
    if p.friction_per_pressure != 0.0:
        coulomb += p.friction_per_pressure * abs(y[P1] - y[P2])
    if p.static_rise != 0.0:
        stribeck *= 1.0 + p.static_rise * y[RESTED]
    speed = y[LAGGED]
    level = coulomb + stribeck * math.exp(-((speed / p.stribeck_velocity) ** 2))
    if p.bump != 0.0:
        level *= 1.0 + p.bump * math.exp(-(((y[X] - p.bump_place) / p.bump_width) ** 2))
    if p.wear != 0.0:
        level *= 1.0 - p.wear * (1.0 - math.exp(-reversals / p.wear_count))
    return level


@njit(cache=True, error_model="numpy")
def _resistance(y: np.ndarray, out: np.ndarray, time: float, reversals: float, p: Numbers) -> float:
    """What resists the motion (N), and into `out` the rates of all that the contact and the loads remember."""
    x, v, z = y[X], y[V], y[Z]
    level = _level(y, v, reversals, p)
    left = 1.0 - p.bristle_stiffness * z * (1.0 if v >= 0.0 else -1.0) / level
    if p.dahl_exponent != 1.0:
        left = math.copysign(abs(left) ** p.dahl_exponent, left)
    rate = v * left
    out[Z] = rate
    viscous = p.viscous if v >= 0.0 else p.viscous * p.viscous_ratio
    if p.viscous_drift != 0.0:
        viscous *= max(1.0 + p.viscous_drift * time, 0.0)
    if p.warming != 0.0:
        viscous *= 1.0 + p.warming * (1.0 - math.exp(-time / p.warming_time))
    force = p.bristle_stiffness * z + p.bristle_damping * rate + viscous * v
    force += p.drag * v * abs(v) + p.load + p.spring * x
    out[LAGGED] = (v - y[LAGGED]) / p.memory_time if p.memory_time > 0.0 else 0.0
    if p.static_rise != 0.0:
        forgotten = abs(v - rate) * y[RESTED] / p.static_rise_distance
        out[RESTED] = (1.0 - y[RESTED]) / p.static_rise_time - forgotten
    if p.slip_level != 0.0:
        force += y[SLIP]
        out[SLIP] = p.slip_stiffness * (v - abs(v) * y[SLIP] / p.slip_level)
    if p.cogging_cosine != 0.0 or p.cogging_sine != 0.0:
        angle = 2.0 * math.pi * x / p.cogging_pitch
        force += p.cogging_cosine * math.cos(angle) + p.cogging_sine * math.sin(angle)
    if p.cushion_stiffness != 0.0:
        side = 1.0 if p.cushion_start >= 0.0 else -1.0
        force += side * p.cushion_stiffness * max(side * (x - p.cushion_start), 0.0)
    if p.hung_share != 0.0:
        hung = p.hung_share * p.mass
        pull = hung * p.hung_frequency * (p.hung_frequency * (x - y[HUNG_X]) + 2.0 * p.hung_damping * (v - y[HUNG_V]))
        force += pull
        out[HUNG_X] = y[HUNG_V]
        out[HUNG_V] = pull / hung
    if p.step != 0.0 and time >= p.step_time:
        force += p.step
    if p.cubic != 0.0:
        force += p.cubic * x * x * x
    if p.notch != 0.0:
        gone = (abs(v) - p.notch_speed) / p.notch_width
        force += math.copysign(p.notch * math.exp(-gone * gone), v)
    return force


@njit(cache=True, error_model="numpy")
def _flows(y: np.ndarray, out: np.ndarray, time: float, p: Numbers) -> float:
    """Rates of both pressures into `out`; the force of the piston (N)."""
    x, v, p1, p2, spool = y[X], y[V], y[P1], y[P2], y[SPOOL]
    opening = max(spool - p.overlap_positive, 0.0) + min(spool + p.overlap_negative, 0.0)
    size = abs(opening)
    if p.gain_curve != 0.0:
        size *= 1.0 + p.gain_curve * size / p.spool_limit
    if opening < 0.0:
        size *= p.gain_ratio
    gain = p.flow_gain * size
    supply = p.supply_pressure
    if p.ripple != 0.0:
        supply += p.ripple * math.sin(p.ripple_frequency * time + p.ripple_phase)
    shape = 1.0 + p.area_gradient * 2.0 * x / p.stroke
    area_1, area_2 = p.area_1 * shape, p.area_2 * shape
    way = p.following * (x + p.area_gradient * x * x / p.stroke)  # what both areas sweep: dV/dt is A(x) v
    volume_1 = p.dead_volume_1 + p.area_1 * (0.5 * p.stroke + way)
    volume_2 = p.dead_volume_2 + p.area_2 * (0.5 * p.stroke - way)
    lost = 0.0
    if p.window != 0.0:
        gone = (v - p.window_speed) / p.window_width
        lost = p.window * math.exp(-gone * gone)
    if p.relief != 0.0:
        lost += p.relief * max(p1 - p.relief_pressure, 0.0)
    if p.actuator == HYDRAULIC:
        if opening >= 0.0:
            into, outof = _fed(gain, supply - p1, p.droop), gain * _root(p2 - p.tank_pressure)
        else:
            into, outof = -gain * _root(p1 - p.tank_pressure), -_fed(gain, supply - p2, p.droop)
        across = p.leakage * (p1 - p2)
        into += -across - p.leak_1 * (p1 - p.tank_pressure) - lost
        outof += -across + p.leak_2 * (p2 - p.tank_pressure)
        give_1 = give_2 = 1.0 / p.bulk_modulus
        if p.air != 0.0:
            give_1 += p.air * ATMOSPHERE / (max(p1, 0.0) + ATMOSPHERE) ** 2
            give_2 += p.air * ATMOSPHERE / (max(p2, 0.0) + ATMOSPHERE) ** 2
        out[P1] = (into - area_1 * v) / (volume_1 * give_1)
        out[P2] = (area_2 * v - outof) / (volume_2 * give_2)
    else:
        if opening >= 0.0:
            into = air_flow(gain, supply, p1, p.critical_ratio)
            outof = air_flow(gain, p2, 0.0, p.critical_ratio)
        else:
            into = -air_flow(gain, p1, 0.0, p.critical_ratio)
            outof = -air_flow(gain, supply, p2, p.critical_ratio)
        into -= lost
        if p.leakage != 0.0:
            across = air_flow(p.leakage, p1, p2, p.critical_ratio)
            into -= across
            outof -= across
        if p.leak_1 != 0.0:
            into -= air_flow(p.leak_1, p1, 0.0, p.critical_ratio)
        if p.leak_2 != 0.0:
            outof += air_flow(p.leak_2, p2, 0.0, p.critical_ratio)
        out[P1] = p.polytropic / volume_1 * (GAS_ENERGY * into - (p1 + ATMOSPHERE) * area_1 * v)
        out[P2] = p.polytropic / volume_2 * ((p2 + ATMOSPHERE) * area_2 * v - GAS_ENERGY * outof)
    return p1 * area_1 - p2 * area_2


@njit(cache=True, error_model="numpy")
def _rates(
    y: np.ndarray, out: np.ndarray, time: float, command: float, held: bool, reversals: float, p: Numbers
) -> None:
    """Rates of the state into `out`; a `held` spool stands still."""
    resistance = _resistance(y, out, time, reversals, p)
    if p.actuator == DRIVE:
        force = p.command_gain * command
        if p.fading != 0.0:
            force *= 1.0 - p.fading * (command / p.command_limit) ** 2
    else:
        force = _flows(y, out, time, p)
        target = min(max(p.spool_gain * command, -p.spool_limit), p.spool_limit)
        out[SPOOL] = 0.0 if held else (target - y[SPOOL]) / p.spool_time
    out[X] = y[V]
    out[V] = (force - resistance) / (p.mass * (1.0 - p.hung_share))


@njit(cache=True, error_model="numpy", inline="always")
def _lags(p: Numbers, h: float) -> bool:
    """Whether the friction's lag is a state, which short steps follow."""
    return bool(p.memory_time >= SHORT_MEMORY * h)


@njit(cache=True, error_model="numpy")
def _step(
    y: np.ndarray,
    work: np.ndarray,
    t: float,
    h: float,
    command: float,
    held: bool,
    reversals: float,
    behind: float,
    p: Numbers,
) -> None:
    """One step of RK4, in place; `behind` is by how much a friction that hardly lags does, `work` five more states."""
    trial, k1, k2, k3, k4 = work
    lagging = _lags(p, h)
    if not lagging:
        y[LAGGED] = y[V] - behind
    _rates(y, k1, t, command, held, reversals, p)
    for j in range(STATES):
        trial[j] = y[j] + 0.5 * h * k1[j]
    if not lagging:
        trial[LAGGED] = trial[V] - behind
    _rates(trial, k2, t + 0.5 * h, command, held, reversals, p)
    for j in range(STATES):
        trial[j] = y[j] + 0.5 * h * k2[j]
    if not lagging:
        trial[LAGGED] = trial[V] - behind
    _rates(trial, k3, t + 0.5 * h, command, held, reversals, p)
    for j in range(STATES):
        trial[j] = y[j] + h * k3[j]
    if not lagging:
        trial[LAGGED] = trial[V] - behind
    _rates(trial, k4, t + h, command, held, reversals, p)
    for j in range(STATES):
        y[j] += h / 6.0 * (k1[j] + 2.0 * k2[j] + 2.0 * k3[j] + k4[j])


@njit(cache=True, error_model="numpy", inline="always")
def _lagging(shown: float, before: float, after: float, h: float, lag: float) -> float:
    """What a sensor that lags shows after a step in which the position goes on a line: exact, however short the lag."""
    slope = (after - before) / h
    return after - slope * lag + (shown - before + slope * lag) * math.exp(-h / lag)


@njit(cache=True, error_model="numpy")
def _shown(y: np.ndarray, rider: float, p: Numbers) -> float:
    """What the position sensor shows without noise; `rider` is where a play has left its coupling."""
    x = y[SHOWN] if p.sensor_lag > 0.0 else (rider if p.backlash > 0.0 else y[X])
    if p.sensor_cosine != 0.0 or p.sensor_sine != 0.0:
        angle = 2.0 * math.pi * x / p.sensor_pitch
        x += p.sensor_cosine * math.cos(angle) + p.sensor_sine * math.sin(angle)
    return x


@njit(cache=True, error_model="numpy")
def _arriving(u: np.ndarray, at: float, step: float, sample_time: float) -> float:
    """The held command, as it was `at` a time (s) on: its mean over one step (0 before the record)."""
    first, last = at / sample_time, (at + step) / sample_time
    k = math.floor(first + 1e-9)
    if k + 1 >= last - 1e-9:
        return u[k] if k >= 0 else 0.0
    share = (k + 1 - first) / (last - first)
    before = u[k] if k >= 0 else 0.0
    after = u[k + 1] if k + 1 >= 0 else 0.0
    return share * before + (1.0 - share) * after


@njit(cache=True, error_model="numpy")
def run(
    p: Numbers,
    start: np.ndarray,
    u: np.ndarray,
    closed: bool,
    loop: np.ndarray,
    reference: np.ndarray,
    noise: np.ndarray,
    quantum: float,
    sample_time: float,
    substeps: int,
) -> np.ndarray:
    """One record: read the sensors, give the command, hold it, integrate.

    Args:
        p: `numbers` of the machine with its effects.
        start: state at the first sample, shape (STATES,).
        u: the command, shape (samples,); of a closed loop what is added to the controller's, and after the call the
            whole command.
        closed: whether there is a controller: u = k (r - x_m) - d v_f + i sum(r - x_m), within the command's limit.
        loop: its gains, by `OPEN_GAIN`, `DAMPING`, `INTEGRAL` and `FILTER`.
        reference: wanted position, shape (samples,).
        noise: of the position that the controller sees, shape (samples,).
        quantum: converter step of it; 0 for none.
        sample_time: s.
        substeps: integration steps a sample.

    Returns:
        shape (samples, 5): see `POSITION` and those behind it; NaN where it diverges.
    """
    samples = u.size
    shown = np.zeros((samples, 5))
    y, work = start.copy(), np.zeros((5, STATES))
    h = sample_time / substeps
    rider, reversals, way, carried = y[X], 0.0, 0.0, 0.0
    stuck = p.spool_band > 0.0
    total, before, slope, earlier, behind = 0.0, 0.0, 0.0, 0.0, 0.0
    for k in range(samples):
        time = k * sample_time
        position = _shown(y, rider, p)
        if closed:
            measured = position + noise[k]
            if quantum > 0.0:
                measured = quantum * np.rint(measured / quantum)
            error = reference[k] - measured
            moved = (measured - before) / sample_time if k > 0 else 0.0
            slope += (moved - slope) * sample_time / (loop[FILTER] + sample_time)
            before = measured
            wish = u[k] + loop[OPEN_GAIN] * error - loop[DAMPING] * slope + loop[INTEGRAL] * total
            u[k] = min(max(wish, -p.command_limit), p.command_limit)
            if u[k] == wish:
                total += error * sample_time
        shown[k, POSITION], shown[k, PRESSURE_1], shown[k, PRESSURE_2] = position, y[P1] + p.offset_1, y[P2]
        shown[k, PLACE], shown[k, SPEED] = y[X], y[V]
        for i in range(substeps):
            t = time + i * h
            command = u[k] if p.delay == 0.0 else _arriving(u, t - p.delay, h, sample_time)
            if p.play > 0.0:
                carried = min(max(carried, command - 0.5 * p.play), command + 0.5 * p.play)
                command = carried
            if p.spool_band > 0.0:
                gap = abs(min(max(p.spool_gain * command, -p.spool_limit), p.spool_limit) - y[SPOOL])
                stuck = gap < (p.spool_band if stuck else STICKS_AGAIN * p.spool_band)
            if p.wear != 0.0 and y[V] * way < 0.0 and abs(y[V]) > 0.1 * p.stribeck_velocity:
                reversals += 1.0
            if abs(y[V]) > 0.1 * p.stribeck_velocity:
                way = y[V]
            if not _lags(p, h):
                behind = p.memory_time * (y[V] - earlier) / h
                earlier = y[V]
            place = y[X]
            _step(y, work, t, h, command, stuck, reversals, behind, p)
            if p.sensor_lag > 0.0:
                y[SHOWN] = _lagging(y[SHOWN], place, y[X], h, p.sensor_lag)
            if p.backlash > 0.0:
                rider = min(max(rider, y[X] - 0.5 * p.backlash), y[X] + 0.5 * p.backlash)
        if not (abs(y[X]) < 1e6 and abs(y[Z]) < 1e6 and abs(y[P1]) < 1e12 and abs(y[P2]) < 1e12):
            shown[k:] = np.nan
            return shown
    return shown


# --- by hand: a filter that knows the machine ----------------------------------------------------------------------


@njit(cache=True, error_model="numpy")
def _driven(y: np.ndarray, told: np.ndarray, work: np.ndarray, time: float, force: float, h: float, p: Numbers) -> None:
    """A drive over one sample, in place, under a force that holds; `told` are how often it turned back, which way it
    goes, its speed a step before, and how many steps a sample has.
    """
    for i in range(int(told[3])):
        if p.wear != 0.0 and y[V] * told[1] < 0.0 and abs(y[V]) > 0.1 * p.stribeck_velocity:
            told[0] += 1.0
        if abs(y[V]) > 0.1 * p.stribeck_velocity:
            told[1] = y[V]
        behind = p.memory_time * (y[V] - told[2]) / h
        told[2] = y[V]
        _step(y, work, time + i * h, h, force / p.command_gain, False, told[0], behind, p)


@njit(cache=True, error_model="numpy")
def gains_along(
    p: Numbers,
    start: np.ndarray,
    force: np.ndarray,
    places: np.ndarray,
    nudges: np.ndarray,
    pushed: np.ndarray,
    shown: np.ndarray,
    turned: np.ndarray,
    uncertain: np.ndarray,
    white: np.ndarray,
    sample_time: float,
    substeps: int,
) -> tuple[np.ndarray, np.ndarray]:
    """Gains (samples, states and noises) of a Kalman filter that knows a drive under a force without noise, and the
    standard deviations (m) of what it does not foresee of the position.

    Args:
        p: `numbers` of the machine.
        start: state at the first sample, shape (STATES,).
        force: N, shape (samples,).
        places: which states are corrected; behind these come what noises remember.
        nudges: changes of these states over which derivatives are taken.
        pushed, shown: what noises add to the force and to the position, by what they remember.
        turned: what becomes of that in a sample, and
        uncertain: its covariance at first; what a sample adds to it keeps that.
        white: standard deviations of force (N) and position (m) without memory.
    """
    samples, states, count = force.size, places.size, places.size + pushed.size
    gains, spread = np.zeros((samples, count)), np.zeros(samples)
    y, work, h = start.copy(), np.zeros((5, STATES)), sample_time / substeps
    told, moved = np.array([0.0, 0.0, 0.0, float(substeps)]), np.zeros((count, count))
    covariance, drives, sees = np.zeros((count, count)), np.zeros(count), np.zeros(count)
    covariance[states:, states:], moved[states:, states:] = uncertain, turned
    renewed = uncertain - turned @ uncertain @ turned.T
    sees[states:] = shown
    for i in range(states):
        sees[i] = 1.0 if places[i] == X else 0.0
    for k in range(samples):
        seen = covariance @ sees
        variance = sees @ seen + white[1] ** 2
        gains[k], spread[k] = seen / variance, math.sqrt(variance)
        left = np.eye(count) - np.outer(gains[k], sees)
        covariance = left @ covariance @ left.T + white[1] ** 2 * np.outer(gains[k], gains[k])
        time, before, already = k * sample_time, y.copy(), told.copy()
        _driven(y, told, work, time, force[k], h, p)
        for i in range(states + 1):
            other, history = before.copy(), already.copy()
            size = nudges[i]
            if i < states:
                other[places[i]] += size
                if places[i] == V:
                    history[2] += size
            _driven(other, history, work, time, force[k] + (size if i == states else 0.0), h, p)
            for j in range(states):
                rate = (other[places[j]] - y[places[j]]) / size
                if i < states:
                    moved[j, i] = rate
                else:
                    drives[j] = rate
        for i in range(pushed.size):
            moved[:states, states + i] = -drives[:states] * pushed[i]
        covariance = moved @ covariance @ moved.T + white[0] ** 2 * np.outer(drives, drives)
        covariance[states:, states:] += renewed
        covariance = 0.5 * (covariance + covariance.T)
    return gains, spread


@njit(cache=True, error_model="numpy")
def unforeseen(
    p: Numbers,
    start: np.ndarray,
    force: np.ndarray,
    position: np.ndarray,
    places: np.ndarray,
    gains: np.ndarray,
    pushed: np.ndarray,
    shown: np.ndarray,
    turned: np.ndarray,
    sample_time: float,
    substeps: int,
) -> np.ndarray:
    """What a filter with these gains, and with a drive of these numbers in it, does not foresee of a measured position
    (m) under a measured force (N), shape (samples,); NaN where it diverges. Names as in `gains_along`.
    """
    off, states = np.zeros(force.size), places.size
    y, work, h = start.copy(), np.zeros((5, STATES)), sample_time / substeps
    told, noise = np.array([0.0, 0.0, 0.0, float(substeps)]), np.zeros(pushed.size)
    for k in range(force.size):
        off[k] = position[k] - y[X] - shown @ noise
        for i in range(states):
            y[places[i]] += gains[k, i] * off[k]
            if places[i] == V:
                told[2] += gains[k, i] * off[k]
        noise += gains[k, states:] * off[k]
        _driven(y, told, work, k * sample_time, force[k] - pushed @ noise, h, p)
        noise = turned @ noise
        if not (abs(y[X]) < 1e6 and abs(y[Z]) < 1e6):
            off[k:] = np.nan
            return off
    return off
