"""What a balance's residual would be if nothing were missing: the fitted plant simulated along the record, its
sensors' noise added, and judged as the record is. Where the plant follows its records to the end, what it leaves of
them has the noise's colour, too.

Smoothing, a bristle that follows a noisy velocity, contacts that break away between samples: all of it leaves a
residual on records without any effect, and more of it than the sensors' noise alone.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from controllers import pid
from controllers.belief import velocity_gain
from controllers.pid import PID
from plants.equation import fields, replaced
from plants.interface import Measurement
from workbench.diagnose.residuals.along import Along, input_along
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.fit import QUICK, fit
from workbench.diagnose.residuals.motion import UNIFORM, Motion, converter_step, motion_of
from workbench.diagnose.residuals.shown import given_by
from workbench.diagnose.residuals.unknowns import Bounds, Values
from workbench.fitting.replay import Sampled
from workbench.fitting.threads import side_by_side
from workbench.simulation.setup import Feed, Loop, Setup
from workbench.simulation.simulate import Run, simulate

VALVE, FLOW = "valve_voltage", "flow"

LEAST_FLOOR = 1e-3
"""Of the floor that sensors give a balance, below which a simulated one is the solver's."""

SENSED = ("force",)
"""Channels of a command that a sensor shows, with noise; others are what a computer gave."""

TRACKING = (20.0, 60.0, 200.0, 600.0)
"""rad/s. Crossovers of the loop that keeps the simulation beside the record, until one does: by its own command it
drifts away, and friction holds it where the loop is weak."""

QUICKEST = 0.3
"""Of one over the sample time, up to which a crossover is tried."""

BESIDE, ASTRAY = 0.05, 0.3
"""Of the position's standard deviation, by which the simulation is off (rms) where it is beside the record, and at most
where no quicker loop can be had."""

SEED = 20
"""Of the generator of the noise that is added: the same experiment gives the same floors."""


def null_motion(along: Along, motion: Motion, values: Values, seed: int) -> Motion | None:
    """The motion of the plant with `values` in the place of the recorded one; None where the plant does not stay beside
    the record.
    """
    record = motion.record
    known = np.isfinite(record.channels["position"])
    position = Sampled(record.time[known], motion.position[known])
    quickest = max(QUICKEST / record.sample_time, TRACKING[0])
    run, off = None, np.inf
    for crossover in (each for each in TRACKING if each <= quickest):
        other = _tracked(along, motion, values, position, crossover)
        if other is not None and (left := _off(other, position)) < off:
            run, off = other, left
        if off <= BESIDE * np.std(motion.position):
            break
    if run is None or off > ASTRAY * np.std(motion.position):
        return None
    noise = np.random.default_rng([SEED, seed])
    (command,) = given_by(record.channels, along.plant.command)
    stds = motion.sensed if command in SENSED else {**motion.noise, command: 0.0}
    channels = {
        name: run.measurements[:, place] + stds[name] * noise.standard_normal(run.time.size)
        for place, name in enumerate(Measurement._fields)
        if name in record.channels and name in along.plant.channels
    }
    channels[command] = run.command + stds[command] * noise.standard_normal(run.time.size)
    for name, values_of in record.channels.items():
        channels.setdefault(name, values_of)
    return motion_of(replace(record, channels=channels))


def _tracked(along: Along, motion: Motion, values: Values, position: Sampled, crossover: float) -> Run | None:
    """The plant along a record, in a loop with that crossover; None where it diverges."""
    record, plant = motion.record, along.plant
    parameters = along.parameters(values)
    state, inputs = along.at_rest(motion, values)
    feeds = [
        Feed(name, Sampled(record.time, input_along(name, motion, values, raw=True)), linear=name != plant.command)
        for name in (item.name for item in fields(plant.Inputs))
        if given_by(record.channels, name)
    ]
    inputs = replaced(inputs, dict.fromkeys((feed.input for feed in feeds), 0.0))  # they add to what is held
    settings = tracking(along, parameters, state, inputs, crossover)
    run = simulate(
        Setup(
            plant=plant,
            parameters=parameters,
            state=state._replace(position=float(motion.position[0])),
            inputs=inputs,
            duration=float(record.time[-1]),
            loop=Loop(PID, PID.design(settings, parameters, record.sample_time)),
            reference=position,
            feeds=tuple(feeds),
            sample_time=record.sample_time,
        )
    )
    return None if run.diverged or run.time.size != record.time.size else run


def _off(run: Run, position: Sampled) -> float:
    """By how much (rms, m) it is off the position."""
    off = run.measurements[:, Measurement._fields.index("position")] - position(run.time)[0]
    return float(np.sqrt(np.mean(off**2)))


def tracking(along: Along, parameters: Any, state: Any, inputs: Any, crossover: float) -> pid.Settings:
    """A loop that tracks a position: of a flow, which sets a velocity, or of a force, which sets an acceleration."""
    plant = along.plant
    if plant.command == VALVE and FLOW in plant.balances:
        known = velocity_gain(parameters, "a loop that tracks a record")
        return pid.Settings(kp=crossover / max(known.forward, known.backward))
    push = accelerated(along, parameters, state, inputs, plant.command)
    return pid.Settings(kp=crossover**2 / push, kd=2.0 * crossover / push)


def accelerated(along: Along, parameters: Any, state: Any, inputs: Any, name: str) -> float:
    """By how much the acceleration is another where an input is 1."""
    pushed = replaced(inputs, {name: 1.0})
    rates = (along.plant.derivatives(0.0, state, given, parameters).velocity for given in (pushed, inputs))
    return float(next(rates)) - float(next(rates))


def surrogate(motion: Motion, simulated: Mapping[str, np.ndarray], seed: int) -> Motion:
    """The motion that a plant `simulated` (channels at every sample), with noise of the spectrum of what it leaves of
    the record, at random phases: none of it has to do with the motion (Theiler et al. 1992). A converter counts
    in steps, as it did in the record: where a rod rests it shows no noise.
    """
    draw, record = np.random.default_rng([SEED, seed]), motion.record
    channels = dict(record.channels)
    for name, values in simulated.items():
        left, step = motion.measured[name] - values, converter_step(record.channels[name])
        noise = _turned(left, draw)
        random = max(1.0 - (step * UNIFORM) ** 2 / max(float(np.mean(noise**2)), 1e-300), 0.0)  # the rest is the steps'
        shown = values + np.sqrt(random) * noise
        counted = step * np.rint(shown / step) if step > 0.0 else shown
        channels[name] = np.where(np.isfinite(record.channels[name]), counted, np.nan)
    # it is judged where the record is: what is blurred hangs on a threshold, and either side leaves another rms
    return replace(motion_of(replace(record, channels=channels)), valid=motion.valid, blurred=motion.blurred)


def _turned(left: np.ndarray, draw: np.random.Generator) -> np.ndarray:
    """Noise of the spectrum of a series, at random phases: that of its tapered middle, since a jump from its end to its
    beginning would be noise at all frequencies.
    """
    taper = np.hanning(left.size)
    spectrum = np.fft.rfft((left - np.mean(left)) * taper / np.sqrt(np.mean(taper**2)))
    turned = np.abs(spectrum) * np.exp(2j * np.pi * draw.random(spectrum.size))
    return np.fft.irfft(turned, left.size)


def with_floor(balance: Balance, motions: Sequence[Motion], values: Values) -> Balance:
    """The balance with the residual of motions on which nothing is missing as its floor, at these values, and no less
    than its own.
    """
    return _over(balance, motions, max(float(np.sqrt(np.mean(_null(balance, motions).stacked(values) ** 2))), 1.0))


def with_fitted_floor(balance: Balance, draws: Sequence[Sequence[Motion]], values: Values, bounds: Bounds) -> Balance:
    """The same by several draws of such motions and parameters that are fitted to each as they are to the records: they
    make good a part of what smoothing takes. A few moments make much of what a balance leaves, and one draw of their
    noise another floor than the next.
    """
    fits = side_by_side(lambda motions: fit(_null(balance, motions), values, balance.free, bounds, QUICK), draws)
    left = np.array([fitted.rms for fitted in fits])
    floor = max(float(np.sqrt(np.mean(left**2))), LEAST_FLOOR)
    spread = float(np.std(left, ddof=1)) / floor if left.size > 1 else None
    return _over(balance, draws[0], floor, spread)


def _null(balance: Balance, motions: Sequence[Motion]) -> Balance:
    return replace(balance, motions=motions, null=())


def _over(balance: Balance, null: Sequence[Motion], floors: float, spread: float | None = None) -> Balance:
    """The balance with so many of its floors as its floor, of which draws differ by so large a share."""
    return replace(balance, floor=balance.floor * floors, simulated=True, null=null, spread=spread)


def floored(along: Along, balances: Sequence[Balance], values: Values) -> list[Balance]:
    """All balances with such floors, where the records show all that a simulation is held against, and drives it: of an
    actuator with a valve both pressures; of a mass under a force no pressure beside it. Others are left as they are.
    """
    motions, plant = balances[0].motions, along.plant
    pressures = [motions[0].has(name) for name in ("pressure_1", "pressure_2")]
    beside = all(pressures) if plant.command == VALVE else FLOW not in plant.balances and not any(pressures)
    if not (beside and motions[0].has("position") and given_by(motions[0].channels, plant.command)):
        return list(balances)
    null = [null_motion(along, motion, values, i) for i, motion in enumerate(motions)]
    complete = [motion for motion in null if motion is not None]
    return [with_floor(balance, complete, values) if complete else balance for balance in balances]
