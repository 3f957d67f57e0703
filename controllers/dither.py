"""Dither: a fast periodic voltage on top of PID, so that the valve's spool and the contact never come to rest."""

from typing import Annotated, NamedTuple

import numpy as np

from controllers import pid
from controllers.interface import Controller, Reference
from controllers.pid import (
    DeadBandShare,
    DeadBandSmoothing,
    DerivativeGain,
    Feedforward,
    FeedforwardLead,
    IntegralGain,
    ProportionalGain,
    TrackingTime,
)
from controllers.settings import About, Needs, Tuned
from controllers.velocity import JerkDensity, PositionNoise, TimeConstant, VelocityKind
from plants.equation import Scalar, equation, select
from plants.interface import Measurement

TURN = 2.0 * np.pi

LEAST_SAMPLES = 4
"""Samples of a period: with fewer, the sampled wave is no longer the one that was asked for."""


class Settings(NamedTuple):
    """PID as in `controllers.pid`, and the dither, with defaults for the simulation plant.

    50 Hz is ten times the position loop's bandwidth (K_p K_q = 34 1/s, 5.4 Hz), so that the loop hardly answers it, and
    a quarter of the hydraulic resonance (192 Hz). It is above the corner of the valve's lag (12 ms, 13 Hz): of the
    amplitude at the amplifier, 1 / sqrt(1 + (2 pi f tau)^2) = 0.256 reaches the spool. The default of 2.5 V thus
    moves the spool by 38 um and the piston, at K_q 0.64 V less what friction takes of the pressure, by 0.12 mm: just
    more than the 0.10 mm by which the bristles bend before the contact breaks away. Less only bends them to and fro.
    """

    kp: ProportionalGain = 500.0
    ki: IntegralGain = 0.0
    kd: DerivativeGain = 0.0
    feedforward: Feedforward = 0.0
    amplitude: Annotated[float, "command", About("height of the dither"), Tuned(0.1, 4.0, by_factor=True)] = 2.5
    frequency: Annotated[
        float, "Hz", About("frequency of the dither", above=True), Tuned(20.0, 200.0), Needs("amplitude")
    ] = 50.0
    shape: Annotated[str, "sine", "square", About("its shape"), Needs("amplitude")] = "sine"
    tracking_time: TrackingTime = 0.0
    velocity: Annotated[VelocityKind, Needs("kd")] = "filter"
    velocity_time_constant: TimeConstant = 2e-3
    position_noise: PositionNoise = 13e-6
    jerk_density: JerkDensity = 10.0
    lead: FeedforwardLead = 0.0
    dead_band: DeadBandShare = 0.0
    dead_band_smoothing: DeadBandSmoothing = 0.1


class Gains(NamedTuple):
    """Of the PID; amplitude, angular frequency, and 1 for a square wave, 0 for a sine."""

    pid: pid.Gains
    amplitude: Annotated[float, "command"]
    angular_frequency: Annotated[float, "rad/s"]
    square: Annotated[float, "1"]


class State(NamedTuple):
    """Of the PID; the phase (0 to 2 pi) of the next sample; the dither of this one."""

    pid: pid.State
    phase: Annotated[float, "rad"]
    dither: Annotated[float, "command"]


@equation
def step(
    reference: Reference, measurement: Measurement, state: State, gains: Gains, sample_time: Scalar
) -> tuple[Scalar, State]:
    """u = u_pid + a sin(phi), or +a for the first half of each turn and -a for the second; phi += 2 pi f h."""
    linear, following = pid.step(reference, measurement, state.pid, gains.pid, sample_time)
    square = select(state.phase < np.pi, 1.0, -1.0)
    dither = gains.amplitude * select(gains.square > 0.0, square, np.sin(state.phase))
    turned = state.phase + gains.angular_frequency * sample_time
    phase = turned - select(turned >= TURN, TURN, 0.0)
    return linear + dither, State(following, phase, dither)


@equation
def commit(realised: Scalar, state: State, gains: Gains, sample_time: Scalar) -> State:
    """The PID learns what was realised without the dither, so that only a limited command moves its integral."""
    following = pid.commit(realised - state.dither, state.pid, gains.pid, sample_time)
    return State(following, state.phase, state.dither)


def start(measurement: Measurement, gains: Gains) -> State:
    """The PID at rest, the dither at phase 0."""
    return State(pid.start(measurement, gains.pid), 0.0, 0.0)


def design(settings: Settings, belief: object, sample_time: float) -> Gains:
    """Gains from settings.

    Raises:
        ValueError: a frequency that the samples cannot carry, or a setting of the PID.
    """
    fastest = 1.0 / (LEAST_SAMPLES * sample_time)
    if not 0.0 < settings.frequency <= fastest:
        raise ValueError(
            f"frequency is {settings.frequency:g} Hz, expected more than 0 and at most {fastest:g} Hz "
            f"({LEAST_SAMPLES} samples a period)"
        )
    shared = {name: getattr(settings, name) for name in pid.Settings._fields}
    linear = pid.design(pid.Settings(**shared), belief, sample_time)
    return Gains(linear, settings.amplitude, TURN * settings.frequency, float(settings.shape == "square"))


def forcing(gains: Gains) -> float:
    """Frequency (Hz) of the dither."""
    return gains.angular_frequency / TURN


SUMMARY = "PID with a fast sine or square wave on the command"

DITHER = Controller("dither", SUMMARY, Settings, Gains, State, design, step, commit, start, forcing=forcing)
