"""What the scopes show: curves of a run as numbers, thinned for the eye, in the units of a reader."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from workbench.bench.outcome import Outcome
from workbench.linear.margins import grid_about
from workbench.publish.along import SHOWN
from workbench.publish.tables import with_unit
from workbench.publish.thinning import thinned
from workbench.publish.words import plain_name
from workbench.simulation.run import TRUE

BUCKETS = 600
"""Of a curve over time, with two points each: a scope is some 600 pixels wide."""

FREQUENCIES = 240
"""Points of a spectrum."""

LOWEST_SHOWN = 1e-2
"""Hz, of a response."""

POSITIONS = ("reference_position", "recorded_position", "position")
PRESSURES = ("recorded_pressure_1", "pressure_1", "recorded_pressure_2", "pressure_2")
POWERS = ("hydraulic_power", "rotation_power", "total_power")

READERS: dict[str, tuple[str, float]] = {
    "Pa": ("MPa", 1e-6),
    "m^3/s": ("l/min", 6e4),
    "rad/s": ("rpm", 30.0 / np.pi),
}
"""Units in which SI ones are shown, and the factor; those along the axis are `workbench.publish.along`'s."""


@dataclass(frozen=True)
class Curve:
    """A curve of a scope: its name, and its points in the scope's units."""

    name: str
    x: np.ndarray
    y: np.ndarray


@dataclass(frozen=True)
class View:
    """What a scope shows of an outcome: curves, and what its axes are, with their units. `note`: why it shows none."""

    curves: Sequence[Curve]
    x: str
    y: str
    note: str = ""


@dataclass(frozen=True)
class Scope:
    """A scope: what it is called, how its axes are scaled, and what it shows of an outcome."""

    title: str
    view: Callable[[Outcome], View]
    log_x: bool = False
    log_y: bool = False


def _reader(unit: str, axis: str) -> tuple[str, float]:
    """The unit in which an SI one is shown, and the factor."""
    along = SHOWN[axis]
    if unit in along.units:
        return along.units[unit], along.factor
    return READERS.get(unit, (unit, 1.0))


def _over_time(names: Sequence[str], outcome: Outcome, label: str = "") -> View:
    """Those of these signals that a run has, over time."""
    return _drawn("time", names, outcome, label, start=0)


def _against(x: str, names: Sequence[str], outcome: Outcome) -> View:
    """The same over another signal, after the transient."""
    start = int(np.searchsorted(outcome.run.time, outcome.loop.resolved.transient))
    return _drawn(x, names, outcome, "", start)


def _drawn(x: str, names: Sequence[str], outcome: Outcome, label: str, start: int) -> View:
    run = outcome.run
    units, axis, signals = outcome.units, run.plant.axis, outcome.signals
    found = [name for name in dict.fromkeys(names) if name in signals]
    x_unit, x_factor = _reader(units[x], axis)
    below = with_unit(plain_name(x), x_unit)
    if not found:
        return View((), below, plain_name(names[0]), f"{plain_name(run.plant.name)} has none")
    unit, factor = _reader(units[found[0]], axis)
    across = signals[x][start:]
    curves = []
    for name in found:
        values = signals[name][start:]
        kept = thinned(*([values] if x == "time" else [across, values]), buckets=BUCKETS)
        curves.append(Curve(plain_name(name), x_factor * across[kept], factor * values[kept]))
    return View(curves, below, with_unit(label or plain_name(found[-1]), unit))


def _balance(name: str, outcome: Outcome) -> View:
    """What a record leaves of a balance of the plant, rate by rate."""
    left = outcome.balances.get(name)
    words = f"residual of the {name} balance"
    if left is None:
        return View((), "time (s)", words, "no record that tells it")
    unit, factor = _reader(left.unit, outcome.run.plant.axis)
    curves = []
    for number, residual in enumerate(left.residuals, start=1):
        called = f"chamber {number}" if len(left.residuals) > 1 else "residual"
        kept = thinned(residual, buckets=BUCKETS)
        curves.append(Curve(called, left.time[kept], factor * residual[kept]))
    return View(curves, "time (s)", with_unit(words, unit))


def _spectrum(outcome: Outcome) -> View:
    """Amplitude of the error over frequency, after the transient: of a sine of amplitude a a peak of height a where its
    periods are whole in there, and up to 15 % less between (the Hann window's). Of each bucket of frequencies the
    largest is drawn, at its own.
    """
    run = outcome.run
    name = "error" if "error" in outcome.signals else "position"
    start = int(np.searchsorted(run.time, outcome.loop.resolved.transient))
    values = outcome.signals[name][start:]
    unit, factor = _reader(outcome.units[name], run.plant.axis)
    y = with_unit(f"amplitude of the {name}", unit)
    if values.size < 8 or not np.all(np.isfinite(values)):
        return View((), "frequency (Hz)", y, "too short, or diverged")
    window = np.hanning(values.size)
    step = float(run.time[1] - run.time[0])
    amplitudes = 2.0 * np.abs(np.fft.rfft(window * (values - values.mean()))) / window.sum()
    frequencies = np.fft.rfftfreq(values.size, step)
    edges = np.geomspace(frequencies[1], frequencies[-1], FREQUENCIES)
    buckets = np.searchsorted(edges, frequencies[1:], side="right")
    order = np.lexsort((amplitudes[1:], buckets))  # of each bucket the largest comes last
    largest = 1 + order[np.append(np.diff(buckets[order]) > 0, True)]
    return View([Curve(name, frequencies[largest], factor * amplitudes[largest])], "frequency (Hz)", y)


def _response(outcome: Outcome) -> tuple[np.ndarray, np.ndarray] | str:
    """Frequencies (Hz) and L there, about the slide at the reference's largest speed; in words why there is none."""
    gain = outcome.loop_gain
    if isinstance(gain, str):
        return gain
    angular = grid_about(gain.response.poles, gain.sample_time)
    angular = angular[angular >= 2.0 * np.pi * LOWEST_SHOWN]
    return angular / (2.0 * np.pi), gain.response(angular)


def _bode(part: Callable[[np.ndarray], np.ndarray], label: str, outcome: Outcome) -> View:
    found = _response(outcome)
    if isinstance(found, str):
        return View((), "frequency (Hz)", label, found)
    frequencies, values = found
    return View([Curve("loop gain", frequencies, part(values))], "frequency (Hz)", label)


def _decibel(values: np.ndarray) -> np.ndarray:
    return 20.0 * np.log10(np.abs(values))


def _degrees(values: np.ndarray) -> np.ndarray:
    return np.degrees(np.unwrap(np.angle(values)))


NYQUIST_REACH = 4.0
"""Of |L|, up to which the Nyquist plot shows it: what counts is near -1."""


CROSS = 0.08 * np.array([[-1.0, 1.0, np.nan, 0.0, 0.0], [0.0, 0.0, np.nan, -1.0, 1.0]])
"""How -1 is marked."""


def _nyquist(outcome: Outcome) -> View:
    labels = ("real part of L", "imaginary part of L")
    found = _response(outcome)
    if isinstance(found, str):
        return View((), *labels, found)
    values = found[1][np.abs(found[1]) <= NYQUIST_REACH]
    point = Curve("-1", -1.0 + CROSS[0], CROSS[1])
    return View([Curve("loop gain", values.real, values.imag), point], *labels)


SCOPES: dict[str, Scope] = {
    "position": Scope("Position and reference", partial(_over_time, POSITIONS)),
    "error": Scope("Error", partial(_over_time, ("error",))),
    "friction": Scope("Friction against velocity", partial(_against, "velocity", ("controller_friction", TRUE))),
    "command": Scope("Command", lambda outcome: _over_time((outcome.run.plant.command,), outcome)),
    "phase": Scope("Phase portrait", partial(_against, "position", ("velocity",))),
    "spectrum": Scope("Spectrum", _spectrum, log_x=True, log_y=True),
    "pressures": Scope("Pressures", partial(_over_time, PRESSURES, label="pressure")),
    "rotation": Scope("Rod speed", partial(_over_time, ("rotation_speed",))),
    "torque": Scope("Motor current", partial(_over_time, ("motor_current",))),
    "power": Scope("Power", partial(_over_time, POWERS, label="power")),
    "flow_balance": Scope("Residual of the flow balance", partial(_balance, "flow")),
    "force_balance": Scope("Residual of the force balance", partial(_balance, "force")),
    "bode": Scope("Loop gain (Bode)", partial(_bode, _decibel, "gain (dB)"), log_x=True),
    "bode_phase": Scope("Loop phase (Bode)", partial(_bode, _degrees, "phase (deg)"), log_x=True),
    "nyquist": Scope("Nyquist plot", _nyquist),
}
"""By name, in the order in which they are offered."""

FIRST = ("position", "error", "friction", "command")
"""Those that are open to begin with."""
