"""Velocity and friction force that a record shows, and which way it moves, as the thesis takes them (Owen 2001, 4.3).

Positions are averaged to 100 Hz (10 samples at 1 kHz) and differentiated by a non-causal FIR filter of order 16; the
velocity is averaged to 10 Hz. A record that is slower than that is taken as it is.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from controllers.velocity import fir_differentiator
from workbench.errors import UserError
from workbench.records.experiment import Experiment
from workbench.records.reading import Record

AXIAL = ("position", "pressure_1", "pressure_2")
ROTARY = ("rotation_speed", "motor_current")

FINE, COARSE = 100.0, 10.0
"""Hz to which a record is averaged, and its velocity."""

FEWEST_COARSE = 18
"""Samples of the slower data that the thesis's averaging needs."""

ORDER = 16
"""Of the differentiator."""

SLIDING = 0.6e-3
"""m/s. Faster, the contact slides: static parameters; slower, it is the bristle that bends."""


@dataclass(frozen=True)
class Slow:
    """Velocity (m/s) against friction force (N) at one rate, evenly sampled; NaN where nothing is known."""

    time: np.ndarray
    velocity: np.ndarray
    force: np.ndarray

    @property
    def sample_time(self) -> float:
        """Time between samples (s), without bound where there are no two."""
        return _step(self.time)

    def turned(self, direction: int) -> "Slow":
        """The same with motion in `direction` (1 or -1) counted as positive."""
        return Slow(self.time, direction * self.velocity, direction * self.force)


def _step(time: np.ndarray) -> float:
    """s from one to the next, without bound where there are no two."""
    return float(time[1] - time[0]) if time.size > 1 else np.inf


def meant(sample_time: float, rate: float) -> int:
    """Samples of one mean at a `rate` (Hz) that is no faster than the record's."""
    return max(round(1.0 / (rate * sample_time)), 1)


def fewest_samples(sample_time: float) -> int:
    """Samples that a record of this sample time (s) has, at least, where the thesis's averaging can use it."""
    fine = meant(sample_time, FINE)
    return max(fine * meant(fine * sample_time, COARSE) * FEWEST_COARSE, fine * (ORDER + 2))


SHOWING: Mapping[tuple[str, ...], tuple[str, tuple[str, ...]]] = {
    AXIAL: ("friction from pressures", ("piston_area_1", "piston_area_2")),
    ("position", "force"): ("measured friction", ()),
    ROTARY: ("rotary friction", ("torque_constant", "piston_radius")),
}
"""The sets of channels that show friction while the acceleration is negligible: what that is, and by which parameters.
"""


def friction_of(record: Record, experiment: Experiment) -> Slow:
    """Velocity and friction force of a record, averaged to 100 Hz.

    Raises:
        UserError: the channels give neither axial nor rotary friction, or a parameter for it is not declared.
    """
    channels, values, showing = record.channels, experiment.known_values(), _showing(record)
    if showing is None:
        raise UserError(
            f"{record.path}: the thesis's method needs position, pressure_1 and pressure_2, or position and force, or "
            "rotation_speed and motor_current; add the channels, or take method simulation: --method simulation"
        )
    if lacking := _lacking(showing, values):
        raise UserError(f"{record.path}: {lacking}")
    if showing == ROTARY:
        radius = values["piston_radius"]
        force = motor_force(channels["motor_current"], values["torque_constant"], radius)
        return from_speed(record.time, radius * channels["rotation_speed"], force)
    if showing == AXIAL:
        force = pressure_force(
            channels["pressure_1"], channels["pressure_2"], values["piston_area_1"], values["piston_area_2"]
        )
    else:
        force = channels["force"]
    return from_position(record.time, channels["position"], force)


def _showing(record: Record) -> tuple[str, ...] | None:
    """The channels that show friction in a record: the first set that it has."""
    return next((names for names in SHOWING if all(name in record.channels for name in names)), None)


def _lacking(showing: tuple[str, ...], values: Mapping[str, float]) -> str:
    """What has to be declared before these channels show friction; empty where nothing has."""
    what, needed = SHOWING[showing]
    name = next((name for name in needed if name not in values), None)
    return f"{what} needs the parameter {name}; set it in [plant.set]" if name else ""


def shows_friction(record: Record) -> bool:
    """Whether a record has channels of which friction over velocity can be made."""
    return _showing(record) is not None


def why_no_friction(record: Record, experiment: Experiment) -> str:
    """Why a record with such channels gives no friction over velocity; empty where it does."""
    if record.time.size < (fewest := fewest_samples(record.sample_time)):
        return f"{record.time.size} samples are too few for the averaging, expected at least {fewest}"
    showing = _showing(record)
    return "" if showing is None else _lacking(showing, experiment.known_values())


def is_rotary(record: Record) -> bool:
    """Whether a record shows friction around the rod, there being no axial one."""
    return _showing(record) == ROTARY


def directions(record: Record, experiment: Experiment) -> list[int]:
    """The directions (1, -1) in which a record slides for at least a twentieth of its sliding time."""
    if "position" not in record.channels and "rotation_speed" not in record.channels:
        return [1, -1]
    velocity = _velocity(record, experiment)
    counts = {sign: int(np.sum(sign * velocity > SLIDING)) for sign in (1, -1)}
    total = sum(counts.values())
    return [sign for sign, count in counts.items() if count and count >= 0.05 * total]


def _velocity(record: Record, experiment: Experiment) -> np.ndarray:
    if "position" in record.channels:
        zero = np.zeros(record.time.size)
        return slower(from_position(record.time, record.channels["position"], zero)).velocity
    return slower(friction_of(record, experiment)).velocity


def from_position(time: np.ndarray, position: np.ndarray, force: np.ndarray) -> Slow:
    """Position (m) and force (N) averaged to 100 Hz, the position then differentiated (thesis 4.3)."""
    count = meant(float(time[1] - time[0]), FINE)
    time, position, force = (averaged(values, count) for values in (time, position, force))
    return Slow(time, velocity_of(position, _step(time)), force)


def from_speed(time: np.ndarray, speed: np.ndarray, force: np.ndarray) -> Slow:
    """The same of a measured speed (m/s), which needs no differentiation (thesis 4.6)."""
    count = meant(float(time[1] - time[0]), FINE)
    return Slow(*(averaged(values, count) for values in (time, speed, force)))


def slower(data: Slow) -> Slow:
    """Averaged to 10 Hz."""
    count = meant(data.sample_time, COARSE)
    return Slow(*(averaged(values, count) for values in (data.time, data.velocity, data.force)))


def pressure_force(pressure_1: np.ndarray, pressure_2: np.ndarray, area_1: float, area_2: float) -> np.ndarray:
    """F = P1 A1 - P2 A2 (N): what friction is while acceleration is negligible. Thesis 4.2."""
    return np.asarray(pressure_1 * area_1 - pressure_2 * area_2)


def motor_force(current: np.ndarray, torque_constant: float, radius: float) -> np.ndarray:
    """F = K_t i / R (N): rotary friction at the piston's surface, at a steady speed. Thesis 4.2."""
    return np.asarray(torque_constant * current / radius)


def averaged(values: np.ndarray, count: int) -> np.ndarray:
    """Means of `count` samples on end, shape (size // count,); a mean over a gap (NaN) is NaN. The rest is dropped.

    The mean belongs to the middle of its samples: average the time as well.
    """
    whole = values.size // count * count
    return np.asarray(values[:whole].reshape(-1, count).mean(axis=1))


def velocity_of(position: np.ndarray, sample_time: float, order: int = ORDER) -> np.ndarray:
    """Velocity (m/s) of positions (m) by the thesis's non-causal FIR filter; NaN where its window is not whole."""
    if position.size <= order:
        return np.full(position.size, np.nan)
    velocity = fir_differentiator(position, sample_time, order)
    half = order // 2
    velocity[:half] = velocity[velocity.size - half :] = np.nan
    return velocity
