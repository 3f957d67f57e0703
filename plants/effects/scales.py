"""What is large on a machine: the units in which an effect's parameters are bounded, and by which a search steps."""

from typing import NamedTuple


class Scales(NamedTuple):
    """What is large on a machine (SI): by these a search knows which size of an effect is felt.

    The `force` is that of friction at rest, `drive` the largest that drives the mass; `travel` the stroke, or where
    that is not known the way of a record; `turn` a whole turn of an axis that turns, infinite of one that goes
    straight. `pressure` is the supply's, `flow` that of the largest speed; `spool` the valve's travel, `voltage` its
    amplifier's limit, `conductance` what it lets through at full travel a supply pressure (m^3/(s Pa)). `duration` is
    the longest record's, `sample_time` theirs.
    """

    force: float
    drive: float
    travel: float
    turn: float
    speed: float
    pressure: float
    flow: float
    spool: float
    voltage: float
    conductance: float
    duration: float
    sample_time: float


def plain(scales: Scales) -> float:
    """The scale of what is the same on every machine: shares, and times of a contact or of a converter."""
    return 1.0


def force(scales: Scales) -> float:
    """N, of friction."""
    return scales.force


def drive(scales: Scales) -> float:
    """N: a load beyond it the machine does not move."""
    return scales.drive


def drive_by_travel(scales: Scales) -> float:
    """N/m: of a spring that takes all that drives over the whole travel."""
    return scales.drive / scales.travel


def force_by_travel(scales: Scales) -> float:
    """N/m: of an element that carries friction over the whole travel."""
    return scales.force / scales.travel


def drive_by_speed_squared(scales: Scales) -> float:
    """N s^2/m^2: of a drag that takes all that drives at the largest speed."""
    return scales.drive / scales.speed**2


def drive_by_pressure(scales: Scales) -> float:
    """N/Pa: of friction that takes all that drives."""
    return scales.drive / scales.pressure


def travel(scales: Scales) -> float:
    """m."""
    return scales.travel


def pitch(scales: Scales) -> float:
    """m: the travel, or on an axis that turns one turn."""
    return min(scales.travel, scales.turn)


PITCHES = (0.01, 0.03, 0.1, 0.3, 1.0)
"""Multiples of `pitch` from which the search of a way begins after which something repeats."""


def spool(scales: Scales) -> float:
    """m."""
    return scales.spool


def voltage(scales: Scales) -> float:
    """V."""
    return scales.voltage


def pressure(scales: Scales) -> float:
    """Pa."""
    return scales.pressure


def conductance(scales: Scales) -> float:
    """m^3/(s Pa): of a leak that lets through at supply pressure what the valve lets through."""
    return scales.conductance


def pressure_by_flow(scales: Scales) -> float:
    """Pa s/m^3: of a line in which the supply pressure is lost at the largest speed."""
    return scales.pressure / scales.flow


def duration(scales: Scales) -> float:
    """s."""
    return scales.duration


def per_duration(scales: Scales) -> float:
    """1/s: by 1 until the end of the record."""
    return 1.0 / scales.duration


def sampling(scales: Scales) -> float:
    """Hz: of the samples; half of it a record can show."""
    return 1.0 / scales.sample_time
