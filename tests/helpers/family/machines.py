"""Whole machines drawn over decades, each coherent: areas from force, flow gain from speed, volumes from the stroke."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from zlib import crc32

import numpy as np

from .noise import Noise, draw_noise
from .parameters import DRIVE, HYDRAULIC, PNEUMATIC, Machine
from .physics import ATMOSPHERE, P1, P2, RESTED, STATES, air_flow

EQUAL, DIFFERENTIAL, AIR, LINEAR, ROTARY = KINDS = ("equal", "differential", "pneumatic", "linear", "rotary")

PROPORTIONAL, INTEGRATING, OPEN, HAND = "proportional", "integrating", "open", "hand"

MOTIONS: Mapping[str, tuple[str, ...]] = {
    **dict.fromkeys((EQUAL, DIFFERENTIAL, AIR), (PROPORTIONAL, INTEGRATING, OPEN)),
    **dict.fromkeys((LINEAR, ROTARY), (PROPORTIONAL, INTEGRATING, OPEN, HAND)),
}
"""How the motion of each kind of machine may be made."""

FASTEST_RATE = 1.2e4
"""1/s. No contact is renewed faster, so that fixed steps serve."""

RATE = (100.0, 2500.0)
"""Samples a second, log-uniform; by hand half more at least."""

SAMPLES, DURATION = (4000.0, 16000.0), (8.0, 60.0)
"""Of a record, and s. Short ones serve, since an effect's size is in units of what its record can show."""

SWEPT = 64.0
"""rad, through which the slowest motion goes in a record."""


@dataclass(frozen=True)
class Rig:
    """A machine in its laboratory: what it is declared as, how it is sampled, moved and measured.

    `speed` (m/s) and `travel` (m) are the largest wanted, `pace` (1/s) their ratio; `force` (N) is what is
    available, `bandwidth` (1/s) that of a position loop that it stands. `noises` are by channel; `fineness`
    multiplies the steps of the integrator.
    """

    kind: str
    plant: str
    machine: Machine
    motion: str
    sample_time: float
    duration: float
    speed: float
    travel: float
    force: float
    bandwidth: float
    noises: Mapping[str, Noise]
    seed: int
    fineness: int = 1

    @property
    def pace(self) -> float:
        """1/s."""
        return self.speed / self.travel

    @property
    def samples(self) -> int:
        """Of a record."""
        return round(self.duration / self.sample_time)

    @property
    def is_fluid(self) -> bool:
        """Whether oil or air drives it."""
        return self.machine.actuator != DRIVE

    @property
    def level(self) -> float:
        """Friction (N) at rest."""
        return self.machine.coulomb + self.machine.stribeck

    @property
    def presliding(self) -> float:
        """Deflection (m) at which the contact gives way."""
        return self.level / self.machine.bristle_stiffness


def stream(seed: int, purpose: str) -> np.random.Generator:
    """A random stream of its own for each purpose, so that one choice does not change another."""
    return np.random.default_rng([seed, crc32(purpose.encode())])


def between(draw: np.random.Generator, low: float, high: float) -> float:
    """Log-uniform."""
    return float(np.exp(draw.uniform(np.log(low), np.log(high))))


def draw_rig(kind: str, motion: str, noise: str, seed: int) -> Rig:
    """A machine of a kind, with the way in which it is moved and the kind of noise of its sensors."""
    draw = stream(seed, "machine")
    slowest, fastest = RATE
    rate = between(draw, 1.5 * slowest if motion == HAND else slowest, fastest)
    (fewest, most), (shortest, longest) = SAMPLES, DURATION
    duration = round(between(draw, max(shortest, fewest / rate), min(longest, max(most / rate, 1.05 * shortest))), 1)
    sample_time = float(f"{1.0 / rate:.2g}")
    make = {EQUAL: _hydraulic, DIFFERENTIAL: _hydraulic, AIR: _pneumatic, LINEAR: _drive, ROTARY: _drive}[kind]
    rig = make(kind, motion, sample_time, duration, draw)
    return replace(rig, noises=_noises(rig, noise, stream(seed, "sensors")), seed=seed)


def _paced(bandwidth: float, duration: float, draw: np.random.Generator) -> float:
    """A pace (1/s) that a loop follows, and that shows enough in a record."""
    low = max(1.5, SWEPT / duration)
    return between(draw, low, max(1.2 * low, min(12.0, bandwidth)))


def _contact(
    force: float, mass: float, speed: float, slip: tuple[float, float], draw: np.random.Generator
) -> dict[str, float]:
    """Friction from the available force (N), and from the largest speed; `slip` are presliding distances (m)."""
    coulomb = force * between(draw, 0.01, 0.25)
    stribeck = coulomb * draw.uniform(0.1, 0.8)
    shortest = max(slip[0], 2.0 * speed / FASTEST_RATE)
    presliding = between(draw, shortest, max(slip[1], 1.5 * shortest))
    stiffness = (coulomb + stribeck) / presliding
    viscous = force * between(draw, 0.01, 0.15) / speed
    damping = 2.0 * draw.uniform(0.1, 0.7) * np.sqrt(stiffness * mass)
    return {
        "coulomb": coulomb,
        "stribeck": stribeck,
        "viscous": viscous,
        "stribeck_velocity": speed * between(draw, 0.01, 0.3),
        "bristle_stiffness": stiffness,
        "bristle_damping": float(min(damping, 0.5 * FASTEST_RATE * mass)),
    }


def _hydraulic(kind: str, motion: str, sample_time: float, duration: float, draw: np.random.Generator) -> Rig:
    mass = between(draw, 1.0, 5000.0)
    supply = between(draw, 2e6, 30e6)
    stroke = between(draw, 0.03, 1.2)
    force = mass * between(draw, 8.0, 200.0)
    bulk = between(draw, 0.5e9, 1.8e9)
    lag = between(draw, 0.8e-3, 30e-3)
    area_1 = force / supply
    area_2 = area_1 * (draw.uniform(0.5, 0.85) if kind == DIFFERENTIAL else 1.0)
    dead = area_1 * stroke * between(draw, 0.03, 0.6)
    natural = np.sqrt(4.0 * bulk * area_2**2 / ((2.0 * dead + area_1 * stroke) * mass))
    bandwidth = float(min(0.25 / lag, 0.12 * natural, 0.12 / sample_time, 40.0))
    pace = _paced(bandwidth, duration, draw)
    travel = stroke * draw.uniform(0.25, 0.36)
    speed = min(pace * travel, 1.2)
    limit, way = 10.0, between(draw, 0.2e-3, 2e-3)
    freest = speed * draw.uniform(1.5, 3.5)
    machine = Machine(
        HYDRAULIC,
        mass,
        **_contact(force, mass, speed, (2e-6, 200e-6), draw),
        command_limit=limit,
        stroke=stroke,
        area_1=area_1,
        area_2=area_2,
        dead_volume_1=dead,
        dead_volume_2=dead,
        following=0.0 if kind == EQUAL else 1.0,
        supply_pressure=supply,
        flow_gain=float(area_1 * freest / (way * np.sqrt(0.5 * supply))),
        bulk_modulus=bulk,
        spool_gain=way / limit,
        spool_time=lag,
        spool_limit=way,
    )
    plant = "non_rotating" if kind == EQUAL else "cylinder"
    return Rig(kind, plant, machine, motion, sample_time, duration, speed, travel, force, bandwidth, {}, 0)


def _pneumatic(kind: str, motion: str, sample_time: float, duration: float, draw: np.random.Generator) -> Rig:
    mass = between(draw, 0.1, 60.0)
    supply = between(draw, 0.4e6, 1.0e6)
    stroke = between(draw, 0.05, 1.0)
    force = mass * between(draw, 20.0, 300.0)
    lag = between(draw, 0.8e-3, 15e-3)
    area_1 = force / supply
    area_2 = area_1 * draw.uniform(0.75, 1.0)
    dead_1, dead_2 = (area_1 * stroke * between(draw, 0.03, 0.2) for _ in range(2))
    natural = np.sqrt(4.0 * 1.2 * (0.5 * supply + ATMOSPHERE) * area_1 / (1.2 * stroke * mass))
    bandwidth = float(min(0.25 / lag, 0.25 * natural, 0.12 / sample_time, 20.0))
    pace = _paced(bandwidth, duration, draw)
    travel = stroke * draw.uniform(0.25, 0.34)
    speed = min(pace * travel, 1.5)
    limit, way = 5.0, 1e-3
    freest = speed * draw.uniform(1.5, 3.5)
    conductance = area_1 * freest * 0.7 / 1e5
    machine = Machine(
        PNEUMATIC,
        mass,
        **_contact(force, mass, speed, (20e-6, 400e-6), draw),
        command_limit=limit,
        stroke=stroke,
        area_1=area_1,
        area_2=area_2,
        dead_volume_1=dead_1,
        dead_volume_2=dead_2,
        supply_pressure=supply,
        flow_gain=conductance / way,
        critical_ratio=draw.uniform(0.2, 0.45),
        polytropic=draw.uniform(1.05, 1.4),
        spool_gain=way / limit,
        spool_time=lag,
        spool_limit=way,
    )
    return Rig(
        kind, "pneumatic_cylinder", machine, motion, sample_time, duration, speed, travel, force, bandwidth, {}, 0
    )


def _drive(kind: str, motion: str, sample_time: float, duration: float, draw: np.random.Generator) -> Rig:
    turns, by_hand = kind == ROTARY, motion == HAND
    bandwidth = float(min(0.04 / sample_time, between(draw, 8.0, 60.0)))
    pace = _paced(0.3 * bandwidth, duration, draw)
    spare = draw.uniform(4.0, 12.0)
    if turns:
        travel = between(draw, 0.5, 15.0)
        force = between(draw, 0.01, 30.0 if by_hand else 1000.0)
        speed = pace * travel
        mass = force / (pace * speed * spare)
        slip = (1e-5 * travel, 3e-3 * travel)
    else:
        travel = between(draw, 0.02, 0.7)
        speed = min(pace * travel, 3.0)
        mass = between(draw, 0.05, 30.0 if by_hand else 2000.0)
        force = mass * speed**2 / travel * spare
        slip = (2e-6, min(200e-6, 0.005 * travel))
    volts = not by_hand and draw.random() < 0.6
    limit = 10.0 if volts else force
    machine = Machine(
        DRIVE,
        mass,
        **_contact(force, mass, speed, slip, draw),
        command_gain=force / limit,
        command_limit=limit,
        stroke=travel / 0.35,
    )
    plant = f"{'rotary' if turns else 'drive'}_{'voltage' if volts else ('torque' if turns else 'force')}"
    return Rig(kind, plant, machine, motion, sample_time, duration, speed, travel, force, bandwidth, {}, 0)


def _noises(rig: Rig, noise: str, draw: np.random.Generator) -> dict[str, Noise]:
    """Of each channel that is measured; a drive of which the command is known shows its position alone."""
    stroke = rig.machine.stroke
    noises = {"position": draw_noise(noise, stroke * between(draw, 1e-6, 1e-3), draw)}
    if rig.is_fluid:
        for name in ("pressure_1", "pressure_2"):
            noises[name] = draw_noise(noise, rig.machine.supply_pressure * between(draw, 1e-5, 1e-3), draw)
    elif rig.motion == HAND:
        noises["force"] = draw_noise(noise, rig.force * between(draw, 1e-4, 1e-2), draw)
    return noises


def substeps(rig: Rig) -> int:
    """Integration steps a sample at which the fastest rate (1/s) of the machine stays well within RK4's reach."""
    machine = rig.machine
    rates = [
        1.5 * rig.speed * machine.bristle_stiffness / machine.coulomb,
        (machine.bristle_damping + machine.viscous) / machine.mass,
        float(np.sqrt(3.0 * machine.bristle_stiffness / machine.mass)),
        100.0,
    ]
    if rig.is_fluid:
        rates.append(1.0 / machine.spool_time)
    return rig.fineness * max(int(np.ceil(rig.sample_time * max(rates) / 0.6)), 1)


def resting(machine: Machine) -> np.ndarray:
    """The state at rest in mid-stroke: both chambers in balance; their sum is what a closed valve leaks it to."""
    state = np.zeros(STATES)
    state[RESTED] = 1.0
    if machine.actuator == DRIVE:
        return state
    total = machine.supply_pressure + machine.tank_pressure
    if machine.actuator == PNEUMATIC:
        total = 2.0 * _leaked(machine)
    state[P1] = total * machine.area_2 / (machine.area_1 + machine.area_2)
    state[P2] = total - state[P1]
    return state


def _leaked(machine: Machine) -> float:
    """Pressure (Pa) of a chamber whose edges to supply and atmosphere are open alike (bisection)."""
    low, high = 0.0, machine.supply_pressure
    for _ in range(60):
        middle = 0.5 * (low + high)
        fed = air_flow(1.0, machine.supply_pressure, middle, machine.critical_ratio)
        low, high = (middle, high) if fed > air_flow(1.0, middle, 0.0, machine.critical_ratio) else (low, middle)
    return 0.5 * (low + high)
