"""Simulation error: what a plant that is driven by the measured input alone shows, beside the record.

Nothing is smoothed here, so that nothing is blurred, and where the plant lacks nothing the sensors' noise is all that
is left. One simulation from end to end tells most. What runs away before the end starts anew from the record every few
seconds (multiple shooting).
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from plants.equation import fields
from plants.interface import Measurement, Plant
from plants.two_chamber import TWO_CHAMBER
from workbench.diagnose.residuals.fitting import Balance
from workbench.diagnose.residuals.flow import spool_of
from workbench.diagnose.residuals.force import driving_force
from workbench.diagnose.residuals.motion import Motion, with_backlash, with_slack
from workbench.diagnose.residuals.unknowns import Values
from workbench.errors import UserError
from workbench.fitting.replay import Sampled, observe
from workbench.parameters.sets import build
from workbench.records.experiment import Experiment
from workbench.simulation.simulate import Feed, Run, Setup, simulate

SIMULATION = "simulation"
"""What the simulation error is called among the balances."""

SEGMENT = 2.0
"""s between new starts."""

ASTRAY = 0.1
"""Share of the measured position's standard deviation by which a simulation may be off and not start anew."""

SOLVER = 1e-5
"""Share of a channel's largest value that counts as its noise at least: no simulation is nearer than its solver."""

SETTLED = 20
"""Samples at the beginning that a free run's error leaves out."""

BY_ANGLE = ("cosine_force", "sine_force")
"""Parameters of a force over the rod's angle; the simulated plant gets it as a disturbance that is known."""

VALVE, ARRIVES = "valve_voltage", "command_delay"
"""Input, and parameter of it, which is shifted as a whole here: the plant itself has a lag in its place."""


def simulated_by(plant: Plant) -> Plant:
    """The plant that holds the effects of a declared one: the one with two chambers for a valve's actuator."""
    return TWO_CHAMBER if plant.name == "non_rotating" else plant


@dataclass(frozen=True, eq=False)
class Shooting:
    """How a plant is simulated along records: its setup by record's id, what it is compared by, and how often (s) it
    starts anew.

    The valve's voltage is `held` from sample to sample or a straight line, as any other input. The plant starts with
    what is measured, smoothed, and with a bristle that carries what the balance of forces leaves to it.
    """

    plant: Plant
    flow: str
    setups: Mapping[int, Setup]
    channels: tuple[str, ...]
    held: bool
    length: float = np.inf

    def errors(self, motion: Motion, values: Values) -> list[np.ndarray]:
        """Measured less simulated, a row a channel, in standard deviations of the sensor's noise: means over the times
        between a fit's instants. A position starts where one sample says, and keeps that error: a mean of up to one
        standard deviation, and half a backlash, from start to start is taken off. NaN where the plant diverges.
        """
        record = motion.record
        shown = self.simulated(motion, values)
        edges = np.arange(0, record.time.size, motion.thinning)
        sizes = np.diff(np.append(edges, record.time.size))
        out = []
        for name in self.channels:
            error = motion.measured[name] - shown[name]
            if name == "position":
                most = motion.noise[name] + 0.5 * values.get("backlash_width", 0.0)
                for k in self.starts(motion):
                    piece = error[k : k + self.samples(motion)]
                    piece -= np.clip(np.mean(piece), -most, most)
            noise = max(motion.noise[name], SOLVER * float(np.max(np.abs(motion.measured[name]))), 1e-30)
            out.append(np.add.reduceat(error, edges) / np.sqrt(sizes) / noise)
        return out

    def samples(self, motion: Motion) -> int:
        """Samples from start to start."""
        record = motion.record
        return record.time.size if np.isinf(self.length) else max(round(self.length / record.sample_time), 1)

    def starts(self, motion: Motion) -> range:
        """Samples at which a simulation starts."""
        return range(0, motion.record.time.size, self.samples(motion))

    def simulated(self, motion: Motion, values: Values) -> dict[str, np.ndarray]:
        """What the sensors would have shown, at every sample; NaN where the plant diverges."""
        shown = np.full((motion.record.time.size, len(Measurement._fields)), np.nan)
        for k, run in self._runs(motion, values):
            if not run.diverged:
                shown[k : k + run.time.size] = run.measurements
        return {name: shown[:, Measurement._fields.index(name)] for name in self.channels}

    def with_backlash_of(self, motion: Motion, values: Values) -> Motion:
        """The motion with the side of the backlash on which the simulated rod is; as it is without a backlash."""
        width, names = values.get("backlash_width", 0.0), [item.name for item in fields(self.plant.State)]
        if width == 0.0 or "sensor_gap" not in names:
            return motion
        gap = np.zeros(motion.record.time.size)
        for k, run in self._runs(motion, values):
            gap[k : k + run.time.size] = run.states[:, names.index("sensor_gap")]
        return with_slack(motion, -np.clip(gap / width, -0.5, 0.5))

    def _runs(self, motion: Motion, values: Values) -> Iterator[tuple[int, Run]]:
        """The simulations along a record, each with the sample at which it starts."""
        record, thin = motion.record, motion.thinned
        setup = self.setups[id(record)]
        still = dict.fromkeys([name for name in (*BY_ANGLE, ARRIVES) if name in values], 0.0)
        parameters = build(self.plant.Parameters, {**values, **still}, self.flow)
        feeds = [_delayed(feed, values.get(ARRIVES, 0.0)) for feed in setup.feeds]
        if any(values.get(name) for name in BY_ANGLE):
            angle = motion.measured["rotation_angle"]
            swing = values.get("cosine_force", 0.0) * np.cos(angle) + values.get("sine_force", 0.0) * np.sin(angle)
            feeds.append(Feed("disturbance_force", Sampled(record.time, swing)))
        inputs = setup.inputs._replace(**{feed.input: 0.0 for feed in feeds})
        size, per, starts = record.time.size, self.samples(motion), self.starts(motion)
        states = _states(self.plant, parameters, thin, values, [k // motion.thinning for k in starts])
        for k, state in zip(starts, states, strict=True):
            yield (
                k,
                simulate(
                    replace(
                        setup,
                        parameters=parameters,
                        state=state,
                        inputs=inputs,
                        duration=record.sample_time * (min(per, size - k) - 1),
                        feeds=tuple(_from(feed, k * record.sample_time) for feed in feeds),
                    )
                ),
            )


def _delayed(feed: Feed, delay: float) -> Feed:
    """The valve's voltage as it arrives."""
    if not delay or feed.input != VALVE or not isinstance(feed.signal, Sampled):
        return feed
    return replace(feed, signal=Sampled(feed.signal.times + delay, feed.signal.values))


def _from(feed: Feed, time: float) -> Feed:
    """A feed from a time (s) on."""
    if not isinstance(feed.signal, Sampled):
        return feed
    return replace(feed, signal=Sampled(feed.signal.times - time, feed.signal.values))


def _states(plant: Plant, parameters: Any, motion: Motion, values: Values, places: Sequence[int]) -> list[Any]:
    """The plant's states at instants of a motion: what is measured, and of the rest what goes with it."""
    rest, _ = plant.equilibrium(parameters, 0.0)
    moving = np.abs(motion.velocity) > motion.creep
    behind = with_backlash(motion, values.get("backlash_width", 0.0))
    known = {
        "position": behind.position,
        "velocity": np.where(moving, motion.velocity, 0.0),
        "lagged_velocity": np.where(moving, motion.velocity, 0.0),
        "rested": np.where(moving, 0.0, 1.0),
        "sensor_gap": motion.position - behind.position,
    }
    for name, offset in (("pressure_1", values.get("pressure_1_offset", 0.0)), ("pressure_2", 0.0)):
        if name in motion.channels:
            known[name] = motion.channels[name] - offset
    if motion.has("pressure_1", "pressure_2"):
        known["load_pressure"] = known["pressure_1"] - known["pressure_2"]
    if motion.voltage is not None:
        known["spool_position"] = spool_of(motion, values)[:: motion.thinning]
    driving = driving_force(motion, values)
    if driving is not None:
        held = driving - values["mass"] * motion.acceleration - values.get("load_force", 0.0)
        held = held - values.get("viscous", 0.0) * known["velocity"]
        most = values["coulomb"] + values.get("stribeck", 0.0)
        known["bristle_deflection"] = np.clip(held, -most, most) / values["bristle_stiffness"]
    names = [name for name in rest._fields if name in known]
    return [rest._replace(**{name: float(known[name][k]) for name in names}) for k in places]


def set_up(experiment: Experiment, motions: Sequence[Motion], *, held: bool = True) -> Shooting | None:
    """How to simulate `experiment`'s plant along motions from end to end; None where they hold no input of it.

    `held`: the valve's voltage holds from sample to sample, as a computer gives it, and is no straight line between.
    """
    plant = simulated_by(experiment.plant)
    believed = replace(experiment, plant=plant)
    setups, channels = dict[int, Setup](), tuple[str, ...]()
    for motion in motions:
        try:
            observed = observe(motion.record, believed)
        except UserError:
            return None
        feeds = tuple(replace(feed, linear=not (held and feed.input == VALVE)) for feed in observed.setup.feeds)
        setups[id(motion.record)] = replace(observed.setup, feeds=feeds)
        channels = tuple(observed.measured)
    return Shooting(plant, experiment.flow, setups, channels, held) if "position" in channels else None


def as_far_as_it_follows(whole: Shooting, motions: Sequence[Motion], values: Values) -> Shooting:
    """End to end where the plant with `values` stays near what was measured on every record, else piece by piece."""
    if all(_off(whole, motion, values) < ASTRAY for motion in motions):
        return whole
    return replace(whole, length=SEGMENT)


def _off(whole: Shooting, motion: Motion, values: Values) -> float:
    """Rms of the position's error over the position's standard deviation; infinite where the plant diverges."""
    position = motion.measured["position"]
    error = position - whole.simulated(motion, values)["position"]
    return float(np.nan_to_num(np.sqrt(np.mean(error**2)) / np.std(position), nan=np.inf))


def simulation_balance(how: Shooting, motions: Sequence[Motion], free: Sequence[str]) -> Balance:
    """The simulation error of records as a balance to which parameters are fitted; its floor is the sensors' noise."""
    return Balance(
        SIMULATION,
        motions,
        how.errors,
        1.0,
        "1",
        tuple(free),
        parts=len(how.channels),
        simulated=True,
    )


def free_run(whole: Shooting | None, motions: Sequence[Motion], values: Values) -> dict[str, float]:
    """Rms (SI) over records of measured less simulated position, and load pressure where both pressures are measured.

    From end to end, driven by the measured input alone. Empty where the plant cannot be simulated, or diverges.
    """
    squares: dict[str, list[np.ndarray]] = {}
    for motion in motions if whole is not None else ():
        assert whole is not None
        shown = whole.simulated(motion, values)
        errors = {
            name: np.where(motion.record.valid, motion.measured[name] - one, 0.0)[SETTLED:]
            for name, one in shown.items()
        }
        squares.setdefault("position_rms_m", []).append(errors["position"] ** 2)
        if "pressure_1" in errors and "pressure_2" in errors:
            squares.setdefault("load_pressure_rms_Pa", []).append((errors["pressure_1"] - errors["pressure_2"]) ** 2)
    found = {name: float(np.sqrt(np.mean(np.concatenate(parts)))) for name, parts in squares.items()}
    return found if np.all(np.isfinite(list(found.values()))) else {}
