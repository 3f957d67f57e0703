"""The relay experiment (Astrom and Hagglund, Automatica 20(5), 1984) on the simulated rig: ultimate gain and period."""

import itertools
from dataclasses import dataclass, replace

import numpy as np

from controllers import relay
from controllers.relay import RELAY
from workbench.errors import UserError
from workbench.linear.operating_point import USED_TRAVEL, along_ramp, without_end_stops
from workbench.simulation.references import Steps
from workbench.simulation.simulate import Feed, Loop, Run, Setup, simulate

DURATION = 2.0
"""s. Of one run; its second half is judged, so that it finds periods up to 0.2 s."""

ROUNDS = 12
"""Runs in which the bias is sought; each goes up to one amplitude further."""

LEAST_CYCLES = 6
PERIOD_SPREAD, HEIGHT_SPREAD = 0.15, 0.3
"""Standard deviation over mean up to which periods and heights are those of one oscillation: a sampled relay rounds
each switch to a sample, of which a period may hold no more than ten."""

EVEN = 0.05
"""Mean of the relay's command, in shares of its amplitude, up to which its two halves are even."""


@dataclass(frozen=True)
class RelayResult:
    """What the experiment gave, SI; `note` says in words why it gave nothing, "" where it did.

    `amplitude` (m) is half the oscillation's height, `bias` (command) what carried the slide. Without an oscillation
    gain, period and amplitude are NaN.
    """

    ultimate_gain: float
    ultimate_period: float
    amplitude: float
    bias: float
    note: str = ""


def relay_test(setup: Setup, amplitude: float, speed: float, hysteresis: float = 0.0) -> RelayResult:
    """Relay feedback on the plant of `setup`, its rod sliding on average at `speed` (m/s).

        K_u = 4 d / (pi sqrt(a^2 - eps^2)),   T_u the period of the oscillation

    with d the relay's amplitude, eps its hysteresis, a half the height of the error's swing: the describing function of
    a relay, right where the plant passes the fundamental of its square wave alone. It gives 8/pi^2 = 0.81 of the true
    gain for an integrator with a delay, and comes within some 5 % where several lags smooth the wave. The sampled relay
    switches up to one sample late, which lengthens the period by up to two samples and lowers the gain accordingly.

    The reference is a ramp, not the textbook's standing one. About rest friction spoils the experiment: a small
    amplitude only bends the bristles, so that the loop of a spring is measured, a larger one breaks away and sticks in
    each cycle. On a ramp faster than the oscillation's own velocity, a 2 pi / T_u, the rod never reverses, friction
    keeps its side, and the loop measured is the sliding one of `workbench.linear.open_loop`. The slide needs a constant
    command of its own, without which the halves of the oscillation are uneven: a bias, found by repeating the run with
    the mean of the relay's command added. A speed of 0 gives the textbook's experiment, with what friction makes of it.

    Sensors are those of `setup`; end stops do not act; the controller and reference of `setup` are not used.

    Args:
        amplitude: d, in the command's unit, above 0.
        speed: of the ramp (m/s).
        hysteresis: eps (m); above the noise of the position sensor, or the relay chatters.

    Raises:
        UserError: an amplitude or a hysteresis that the relay cannot have.
    """
    try:
        gains = RELAY.design(relay.Settings(amplitude, hysteresis), setup.parameters, setup.sample_time)
    except ValueError as error:
        raise UserError(f"relay: {error}") from None
    setup = without_end_stops(replace(setup, loop=Loop(RELAY, gains), feeds=()))
    travel = float(setup.plant.travel(setup.parameters))
    duration = min(DURATION, USED_TRAVEL * travel / abs(speed)) if speed else DURATION
    setup, bias = along_ramp(setup, speed, duration), 0.0
    for _ in range(ROUNDS):
        run = simulate(replace(setup, feeds=(Feed(setup.plant.command, Steps((bias,), duration), linear=False),)))
        uneven = _mean_of_relay(run, bias)
        if run.diverged or abs(uneven) <= EVEN * amplitude:
            break
        bias += uneven
    return _read(run, gains, bias, uneven)


def _cycles(run: Run) -> list[slice]:
    """Samples of each period of the second half, from one switch forward to the next."""
    half = run.time.size // 2
    rises = half + 1 + np.flatnonzero(np.diff(run.command[half:]) > 0.0)
    return [slice(a, b) for a, b in itertools.pairwise(rises)]


def _mean_of_relay(run: Run, bias: float) -> float:
    """Mean of the relay's command over the periods; over the second half where there are none."""
    cycles = _cycles(run)
    whole = slice(cycles[0].start, cycles[-1].stop) if cycles else slice(run.time.size // 2, None)
    return float(np.mean(run.command[whole]) - bias)


def _read(run: Run, gains: relay.Gains, bias: float, uneven: float) -> RelayResult:
    """The result of the last run, or in words why there is none."""
    cycles, error = _cycles(run), run.signals["error"]
    periods = np.array([run.time[cycle.stop] - run.time[cycle.start] for cycle in cycles])
    halves = np.array([0.5 * np.ptp(error[cycle]) for cycle in cycles])
    note = _missing(run, gains, uneven, (periods, halves))
    if note:
        return RelayResult(np.nan, np.nan, np.nan, bias, note)
    half = float(np.mean(halves))
    gain = 4.0 * gains.amplitude / (np.pi * np.sqrt(half**2 - gains.hysteresis**2))
    return RelayResult(float(gain), float(np.mean(periods)), half, bias)


def _missing(run: Run, gains: relay.Gains, uneven: float, cycles: tuple[np.ndarray, np.ndarray]) -> str:
    """Why there is no oscillation to read from its periods (s) and half heights (m); "" where there is one."""
    height = f"{gains.amplitude:g} {run.plant.command_unit}"
    periods, halves = cycles
    if run.diverged:
        return f"no oscillation: the run ended as {run.outcome}"
    if abs(uneven) > (1.0 - EVEN) * gains.amplitude:
        return f"no oscillation: the relay stays on one side with {height}; take a larger amplitude"
    if periods.size < LEAST_CYCLES:
        return f"no oscillation: {periods.size} periods in {0.5 * run.time[-1]:.3g} s with {height}"
    if np.std(periods) > PERIOD_SPREAD * np.mean(periods) or np.std(halves) > HEIGHT_SPREAD * np.mean(halves):
        return f"no regular oscillation with {height}: it sticks or decays; take a larger amplitude or a faster ramp"
    if np.mean(halves) <= gains.hysteresis:
        return (
            f"the oscillation stays within the hysteresis of {gains.hysteresis:g} {run.plant.axis}; take a smaller one"
        )
    return ""
