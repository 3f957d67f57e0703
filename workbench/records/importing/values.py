"""Parameters to begin with where nobody gives a set: what a log tells of them roughly, and what has to be asked."""

import functools
from collections.abc import Callable, Mapping

import numpy as np
from scipy.optimize import nnls

from plants.axis import ROTARY, name_along
from plants.equation import NEGATIVE, fields
from plants.interface import Plant
from workbench.parameters.sets import FLOW_SHARE, axis_of, known_units, named_sets, read_parameters
from workbench.records.channels import unit_of
from workbench.records.importing.channels import Found
from workbench.records.importing.columns import Motion, correlation, rounded_up
from workbench.records.importing.plants import given
from workbench.records.importing.proposal import Line, Question
from workbench.records.schema import FLOWING, FRICTION
from workbench.toml.units import factor

AREA = 1e-3
"""m^2 of a piston that nobody has measured: a bore of 36 mm."""

SUPPLY = 1e7
"""Pa of a supply that nobody has measured: the usual hydraulic one."""

MARGIN = 1.1
"""What a stroke has over the longest way of a log."""

PRESLIDING = 1e-4
"""m, or rad, of a contact before it slips, at most."""

SHARE = 1e-3
"""The same as a share of the way."""

LONGEST_DELAY = 1.0
"""s by which a command may come late."""

SHARE_OF_FASTEST, FEWEST_MOVES, LEAST_BAND = 0.1, 20, 0.01
"""Of the fastest motion, what counts as one; samples of a side that a line is drawn through; of the largest command,
the least dead band to begin with: a fit finds that there is none."""

ZERO = {
    "stribeck": "none to begin with; a diagnosis says whether there is any",
    "bristle_damping": "far below what a log shows",
    "end_stop_stiffness": "no end stop is modelled",
    "end_stop_damping": "no end stop is modelled",
    "load_force": "none to begin with",
    "tank_pressure": "the surroundings'",
}
"""Parameters that are 0 to begin with, and why."""

GUESSED = ("coulomb", "viscous", "bristle_stiffness")
"""Of friction, where no set is there: the rest is 0 to begin with."""


class Rough:
    """A log in SI as a first look has it: way, velocity, and the force that drives, as far as it is known."""

    def __init__(self, plant: Plant, found: Mapping[str, Found], motion: Motion) -> None:
        self.plant, self.found, self.motion = plant, found, motion
        self.command = given(plant, found)
        self.position = self.si("position")
        self.velocity = np.gradient(self.position, motion.step)
        self.drive = self._drive()
        self.mass, self.viscous, self.coulomb = self._friction()

    def si(self, name: str) -> np.ndarray:
        """A channel, smoothed, in SI."""
        if name not in self.found:
            return np.zeros(self.position.size)
        one = self.found[name]
        own = name if name not in ("torque",) else "force"
        scale = factor(one.unit, unit_of(own, self.plant)) if own != "time" else 1.0
        return np.asarray(scale * one.scale * self.motion.smooth(one.column))

    @functools.cached_property
    def delay(self) -> int:
        """Samples by which the velocity comes after the command, up to `LONGEST_DELAY`."""
        most = min(round(LONGEST_DELAY / self.motion.step), self.drive.size // 2)
        return max(
            range(most + 1),
            key=lambda late: correlation(self.velocity[late:], self.drive[: self.drive.size - late]),
        )

    def _drive(self) -> np.ndarray:
        """What drives the axis (N, N m, or the command itself through a gain of 1)."""
        if "pressure_1" in self.found and "pressure_2" in self.found:
            return AREA * (self.si("pressure_1") - self.si("pressure_2"))
        return self.si(self.command) if self.command else np.zeros(self.position.size)

    def _friction(self) -> tuple[float, float, float]:
        """Least squares of the drive on acceleration, velocity and its sign, none of them negative, and a constant."""
        v, force = self.velocity, self.drive
        if v.size != force.size or not np.any(v):
            return 1.0, 1.0, 1.0
        a = np.gradient(v, self.motion.step)
        moving = np.abs(v) > 0.05 * np.max(np.abs(v))
        columns = [each[moving] for each in (a, v, np.sign(v), np.ones(v.size), -np.ones(v.size))]
        size = [max(float(np.std(column)), 1e-12) if k < 3 else 1.0 for k, column in enumerate(columns)]
        found = nnls(np.column_stack([column / s for column, s in zip(columns, size, strict=True)]), force[moving])[0]
        least = 0.02 * max(float(np.std(force[moving])), 1e-9)
        mass, viscous, coulomb = (max(float(value), least) / s for value, s in zip(found[:3], size[:3], strict=True))
        self.inertial = float(found[0]) > 5.0 * least
        return mass, viscous, coulomb

    inertial = False


def values_for(plant: Plant, found: Mapping[str, Found], motion: Motion) -> list[Line]:
    """The parameters that a plant cannot do without, each with a value, its reason, and a question where it is none."""
    rough = Rough(plant, found, motion)
    names = [item.name for item in fields(plant.Parameters) if item.default is None and item.name != FLOW_SHARE]
    apart = {f"{name}_{NEGATIVE}" for name in plant.unknown}  # found for each direction
    return [_line(name, rough) for name in names if name in apart or not name.endswith(f"_{NEGATIVE}")]


def free_for(plant: Plant, found: Mapping[str, Found], motion: Motion, own: Mapping[str, float] | None) -> list[str]:
    """The parameters that a fit may move: what a set (`own`, if there is one) knows of friction, else what is guessed
    of it; the mass where it shows; a constant load where no pressure of two can look like it; what makes the drive out
    of a pump or one pressure; and where both pressures show what the valve lets through, that and how it is compressed.
    """
    names = {item.name for item in fields(plant.Parameters)}
    two = "pressure_1" in found and "pressure_2" in found
    wanted = []
    if Rough(plant, found, motion).inertial and not two:
        wanted += ["mass", "inertia"]
    if "pressure_1" in found and not two:
        wanted.append("piston_area_1")
    wanted += ["pump_displacement"]
    wanted += [] if two else ["load_force", "load_torque"]
    known = own if own is not None else dict.fromkeys(GUESSED, 1.0)
    wanted += [name for name in FRICTION if known.get(name, 0.0) > 0.0]
    wanted += FLOWING if two else []
    return [name for name in wanted if name in names or name == "piston_area_1"]


def _line(name: str, rough: Rough) -> Line:
    """One parameter."""
    axis = rough.plant.axis
    plain = next((known for known in known_units() if name_along(known, axis) == name), name)
    unit = known_units(axis)[name]
    if plain in ZERO:
        return Line(name, {"": _text(0.0, unit)}, ZERO[plain])
    if plain in SEEN:
        value, reason, asked = SEEN[plain](rough)
        questions = (Question(f"{name}: {asked}", ""),) if asked else ()
        return Line(name, {"": _text(value, unit)}, reason, questions)
    for known, path in named_sets().items():
        values = read_parameters(path)
        if axis_of(values) == axis and np.isfinite(values.get(name, np.nan)):
            asked = f"{name}: what is it on your machine?"
            return Line(name, {"": _text(values[name], unit)}, f"that of {known}", (Question(asked, ""),))
    return Line(name, {"": _text(1.0, unit)}, "a guess", (Question(f"{name}: what is it on your machine?", ""),))


def _text(value: float, unit: str) -> str | float:
    return value if unit == "1" else f"{value:.3g} {unit}"


def _stroke(rough: Rough) -> tuple[float, str, str]:
    way = float(np.ptp(rough.position))
    return rounded_up(MARGIN * way), f"a little more than the way of the log, {way:.3g}", "how long is it?"


def _supply(rough: Rough) -> tuple[float, str, str]:
    pressures = [name for name in rough.found if name.startswith(("pressure_", "supply_"))]
    if not pressures:
        return SUPPLY, "a guess", "how high is it?"
    high = max(float(np.max(rough.si(name))) for name in pressures)
    return rounded_up(high), f"the next round number above the highest pressure, {high:.3g} Pa", "how high is it?"


def _displacement(rough: Rough) -> tuple[float, str, str]:
    speed = float(np.std(rough.si("pump_speed"))) or 1.0
    value = AREA * float(np.std(rough.velocity)) / speed
    return value, "the piston's area times what the rod moves in a radian of the pump", ""


def _coulomb(rough: Rough) -> tuple[float, str, str]:
    return rough.coulomb, "least squares of what drives on acceleration, velocity and its sign; the fit finds it", ""


def _stiffness(rough: Rough) -> tuple[float, str, str]:
    bend = min(PRESLIDING, SHARE * float(np.ptp(rough.position)))
    unit = "mrad" if rough.plant.axis == ROTARY else "mm"
    return rough.coulomb / bend, f"the contact slips after {1e3 * bend:.2g} {unit}; the fit finds it", ""


def _of_gain(rough: Rough) -> tuple[float, str, str]:
    return 1.0, "no log tells it: mass and friction are known in proportion to it", "how much drives for each V or A?"


def _straight(x: np.ndarray, y: np.ndarray) -> tuple[float, float] | None:
    """Slope and offset of the line through points; None where their numbers are beyond all measure."""
    try:
        with np.errstate(all="ignore"):
            slope, offset = np.polyfit(x, y, 1)
    except np.linalg.LinAlgError:
        return None
    return float(slope), float(offset)


def _of_valve(name: str, way: float, rough: Rough) -> tuple[float, str, str]:
    """Gain, dead band and delay of a side of a valve, by a line through what a command of that sign makes move."""
    command, delay = rough.drive, rough.delay
    late = command[: command.size - delay]
    velocity = rough.velocity[delay:]
    moves = (way * late > 0.0) & (way * velocity > SHARE_OF_FASTEST * np.max(np.abs(velocity)))
    why = f"a line through the velocities over the command {1e3 * delay * rough.motion.step:.3g} ms before"
    line = _straight(way * late[moves], way * velocity[moves]) if np.sum(moves) >= FEWEST_MOVES else None
    if line is None:
        value = {"velocity_gain": 0.01, "dead_band": 0.2, "command_delay": 0.1}[name]
        return value, "a guess: the log hardly moves that way", f"what is it {'forward' if way > 0.0 else 'backward'}?"
    gain, drift = max(line[0], 1e-9), line[1]
    value = {
        "velocity_gain": gain,
        "dead_band": max(-drift / gain, LEAST_BAND * float(np.max(np.abs(command)))),
        "command_delay": max(delay, 1) * rough.motion.step,
    }[name]
    return value, f"{why}; the fit finds it", ""


SEEN: Mapping[str, Callable[[Rough], tuple[float, str, str]]] = {
    "stroke": _stroke,
    "supply_pressure": _supply,
    "mass": lambda rough: (rough.mass, "least squares, as coulomb", "what moves?"),
    "coulomb": _coulomb,
    "viscous": lambda rough: (rough.viscous, "least squares, as coulomb; the fit finds it", ""),
    "stribeck_velocity": lambda rough: (1e-2, "without effect as long as stribeck is 0", ""),
    "bristle_stiffness": _stiffness,
    "force_gain": _of_gain,
    "force_constant": _of_gain,
    "piston_area_1": lambda rough: (AREA, "a guess", "bore?"),
    "piston_area_2": lambda rough: (AREA, "a guess: equal", "bore and rod?"),
    "hose_volume": lambda rough: (1e-4, "a guess", "oil or air between valve and piston?"),
    "bulk_modulus": lambda rough: (1e9, "oil with some air in it", ""),
    "pump_displacement": _displacement,
    **{
        f"{name}{suffix}": functools.partial(_of_valve, name, way)
        for name in ("velocity_gain", "dead_band", "command_delay")
        for suffix, way in (("", 1.0), (f"_{NEGATIVE}", -1.0))
    },
    "axis_time_constant": lambda rough: (0.1, "a guess; the fit finds it", ""),
    "voltage_limit": lambda rough: (10.0, "the usual amplifier", "the command's limit?"),
}
"""What a log tells of parameters: value (SI), why, and what is to be asked."""
