"""Records of a rig: driven in a closed or an open loop or by hand, then what its sensors showed."""

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .by_hand import Filter, filter_along
from .machines import HAND, INTEGRATING, OPEN, Rig, resting, stream, substeps
from .parameters import Machine
from .physics import DAMPING, FILTER, INTEGRAL, OPEN_GAIN, PLACE, SPEED, numbers, run
from .reference import make_reference

CHANNELS = ("position", "pressure_1", "pressure_2")

FIT, HELD_OUT = USES = ("fit", "held_out")


SOLVED, FINEST = 0.3, 16
"""Distance, in the sense of `limits`, by which the integrator may be off over a whole record, and its largest share of
steps more than stability asks for."""


class ImplausibleError(ValueError):
    """A record that no rig would give, or that nobody would take: another machine is drawn."""


@dataclass(frozen=True, eq=False)
class Record:
    """One record: the held command, shape (samples,), and what `physics.run` gives without noise, (samples, 5)."""

    rig: Rig
    machine: Machine
    use: str
    command: np.ndarray
    clean: np.ndarray

    @cached_property
    def filter(self) -> Filter:
        """That of a record by hand, which knows its machine."""
        return filter_along(self.rig, self.machine, self.command)

    @cached_property
    def channels(self) -> dict[str, np.ndarray]:
        """What is logged (SI), by channel."""
        rig = self.rig
        time = np.arange(self.command.size) * rig.sample_time
        logged = {"time": time}
        for name, noise in rig.noises.items():
            clean = self.command if name == "force" else self.clean[:, CHANNELS.index(name)]
            logged[name] = noise.measured(clean, scatter(rig, self.use, name))
        if rig.is_fluid:
            logged["valve_voltage"] = self.command
        elif rig.motion != HAND:
            logged["command"] = self.command
        return logged


def scatter(rig: Rig, use: str, channel: str) -> np.ndarray:
    """Noise of a channel of a record, the same whatever the machine's effects."""
    return rig.noises[channel].drawn(rig.samples, rig.sample_time, stream(rig.seed, f"noise {use} {channel}"))


def record(rig: Rig, machine: Machine, use: str, wanted: np.ndarray | None = None, scattered: str = "") -> Record:
    """The record of a machine on its rig: the same reference and noise whatever its effects; of what is `wanted` (m),
    of `rig.samples`, or else of a motion of the seed. Noise is that of `use`, or of another name (`scattered`).

    A loop sees the position's noise; the open one is designed on the machine without noise: the speed that is wanted,
    a weak hold to the middle, and steps of the command. A hand pulls towards where it wants the mass.
    """
    draw = stream(rig.seed, f"motion {use}")
    if wanted is None:
        wanted = make_reference(rig.samples, rig.sample_time, rig.travel, rig.speed, draw)
    loop, added = _loop(rig, wanted, stream(rig.seed, "loop"), draw)
    sees = rig.motion not in (OPEN, HAND)
    noise = rig.noises["position"]
    seen = scatter(rig, scattered or use, "position") if sees else np.zeros(rig.samples)
    command = added.copy()
    count = substeps(rig)
    quantum = noise.quantum if sees else 0.0
    p, start = numbers(machine), resting(rig.machine)
    clean = run(p, start, command, True, loop, wanted, seen, quantum, rig.sample_time, count)
    return Record(rig, machine, scattered or use, command, clean)


def loop_of(rig: Rig) -> np.ndarray:
    """Gains of the rig's loop, by places in `physics`."""
    return _loop(rig, np.zeros(rig.samples), stream(rig.seed, "loop"), stream(rig.seed, "motion"))[0]


def _loop(
    rig: Rig, wanted: np.ndarray, tuning: np.random.Generator, draw: np.random.Generator
) -> tuple[np.ndarray, np.ndarray]:
    """Gains of the loop, by places in `physics`, and what is added to the controller's command."""
    machine, loop = rig.machine, np.zeros(4)
    loop[FILTER] = 0.0
    share = tuning.uniform(0.6, 1.0)
    slope = np.gradient(wanted, rig.sample_time)
    if rig.is_fluid:
        freest = _freest(machine)
        loop[OPEN_GAIN] = share * rig.bandwidth / freest
        if rig.motion == INTEGRATING:
            loop[INTEGRAL] = loop[OPEN_GAIN] * share * 0.2 * rig.bandwidth
        if rig.motion != OPEN:
            return loop, np.zeros(wanted.size)
        loop[OPEN_GAIN] *= 0.15
        return loop, np.clip(slope, -rig.speed, rig.speed) / freest + 0.03 * _steps(rig, draw) * machine.command_limit
    width = share * min(rig.bandwidth, 4.0 * rig.pace if rig.motion in (OPEN, HAND) else rig.bandwidth)
    loop[OPEN_GAIN] = machine.mass * width**2 / machine.command_gain
    loop[DAMPING] = 1.6 * machine.mass * width / machine.command_gain
    loop[FILTER] = 0.1 / width
    if rig.motion == INTEGRATING:
        loop[INTEGRAL] = 0.3 * width * loop[OPEN_GAIN]
    added = loop[DAMPING] * np.clip(slope, -rig.speed, rig.speed)
    if rig.motion in (OPEN, HAND):
        added += (0.5 * rig.level + 0.1 * rig.force) * _steps(rig, draw) / machine.command_gain
    return loop, added


def _freest(machine: Machine) -> float:
    """Speed without load (m/s) of an actuator a unit of its command."""
    if machine.flow_gain * machine.bulk_modulus and machine.actuator == 0.0:
        full = machine.flow_gain * np.sqrt(0.5 * machine.supply_pressure) / machine.area_1
    else:
        full = machine.flow_gain * 1e5 / 0.7 / machine.area_1
    return float(full * machine.spool_gain)


def _steps(rig: Rig, draw: np.random.Generator) -> np.ndarray:
    """Levels of -1 to 1 that hold for a while, shape (samples,)."""
    length = max(int(1.5 / (rig.pace * rig.sample_time)), 1)
    levels = draw.uniform(-1.0, 1.0, rig.samples // length + 1)
    return np.repeat(levels, length)[: rig.samples]


def replayed(of: Record, machine: Machine, start: np.ndarray | None = None) -> np.ndarray:
    """What the sensors of a machine would have shown under a record's command, shape (samples, 5)."""
    rig, nothing = of.rig, np.zeros(of.command.size)
    p, begins = numbers(machine), resting(rig.machine) if start is None else start
    count = substeps(rig)
    return run(p, begins, of.command.copy(), False, np.zeros(4), nothing, nothing, 0.0, rig.sample_time, count)


def whitened(of: Record, shown: np.ndarray) -> np.ndarray:
    """Outputs of all channels in independent standard deviations of their noise, one behind the other."""
    rig = of.rig
    parts = [rig.noises[name].whitened(shown[:, CHANNELS.index(name)], rig.sample_time) for name in rig.noises]
    return np.concatenate(parts)


def outputs(of: Record, machine: Machine, start: np.ndarray | None = None) -> np.ndarray:
    """What a machine shows on a record's command, `whitened`; by hand what it does not foresee, in standard deviations
    of what noise leaves open of it.
    """
    rig = of.rig
    if rig.motion == HAND:
        return of.filter.off(rig, machine, start, of.command, of.clean[:, PLACE])
    return whitened(of, replayed(of, machine, start))


def unsolved(of: Record) -> float:
    """By how much a record moves where the integrator's steps are halved, as a distance in the sense of `limits`."""
    finer = replace(of, rig=replace(of.rig, fineness=2 * of.rig.fineness))
    return float(np.linalg.norm(outputs(finer, of.machine) - outputs(of, of.machine)))


def refined(rig: Rig) -> Rig:
    """The rig with so many steps that halving them changes its record, without effects, by less than `SOLVED`.

    Raises:
        ImplausibleError: `FINEST` does not serve, or the record is not physical.
    """
    made = record(rig, rig.machine, FIT)
    check_physical(made)
    while rig.fineness <= FINEST:
        if unsolved(replace(made, rig=rig)) < SOLVED:
            return rig
        rig = replace(rig, fineness=2 * rig.fineness)
    raise ImplausibleError("no fixed step follows this machine to the accuracy of its sensors")


def check_physical(of: Record) -> None:
    """Whether somebody could have taken this record, and would have kept it.

    Raises:
        ImplausibleError: it diverges, reaches an end or a limit, or hardly moves.
    """
    rig, clean = of.rig, of.clean
    if not np.all(np.isfinite(clean)):
        raise ImplausibleError("the record diverges")
    place = clean[:, PLACE]
    if np.max(np.abs(place)) > 0.485 * rig.machine.stroke:
        raise ImplausibleError("an end of the stroke is reached")
    if np.mean(np.abs(of.command) >= rig.machine.command_limit) > 0.03:
        raise ImplausibleError("the command is at its limit")
    if np.ptp(place) < max(0.4 * rig.travel, 30.0 * rig.noises["position"].std):
        raise ImplausibleError("hardly any motion")
    if np.quantile(np.abs(clean[:, SPEED]), 0.95) < max(0.1 * rig.speed, 2e-3):
        raise ImplausibleError("hardly any speed")
    if rig.is_fluid:
        pressures, supply = clean[:, 1:3], rig.machine.supply_pressure
        if np.min(pressures) < 0.01 * supply or np.max(pressures) > 0.99 * supply:
            raise ImplausibleError("a chamber is at the pressure of tank or supply")
