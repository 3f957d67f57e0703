"""The thesis's method on records: which channels give velocity and force, which way each record moves, the repeats."""

from collections import Counter
from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from plants.equation import fields, to_array
from workbench.errors import UserError
from workbench.identify import thesis_method as method
from workbench.identify.experiment import Experiment
from workbench.identify.records import Record
from workbench.identify.schema import STATIC, SUFFIXES
from workbench.identify.thesis_method import Estimate, Slow

AXIAL = ("position", "pressure_1", "pressure_2")
ROTARY = ("rotation_speed", "motor_current")

DOUBTFUL = 10.0
"""Ratio of the bristle's fitted damping to the thesis's rule for it from which it is told."""


@dataclass(frozen=True)
class ThesisFit:
    """What the thesis's method finds, by speed of rotation (rpm) and canonical name; what it cannot do.

    `curves` are the 10 Hz data of each record by its path. `static` is among the names, for tables.
    """

    groups: Mapping[float, Mapping[str, Estimate]]
    curves: dict[str, Slow]
    notes: tuple[str, ...]

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Parameters by canonical name, where all records have one speed of rotation; else none: each has its own."""
        if len(self.groups) > 1:
            return {}
        (group,) = self.groups.values()
        return {name: one for name, one in group.items() if not name.startswith(STATIC)}

    @property
    def unidentified(self) -> dict[str, str]:
        """Those of `estimates` that the records do not give, and why."""
        return {name: why for name, one in self.estimates.items() if (why := method.doubt(one))}


def friction_of(record: Record, experiment: Experiment) -> Slow:
    """Velocity and friction force of a record, averaged over 10 samples (100 Hz at 1 kHz).

    Raises:
        UserError: the channels give neither axial nor rotary friction.
    """
    channels = record.channels
    values = parameter_values(experiment)
    if all(name in channels for name in AXIAL):
        force = method.pressure_force(
            channels["pressure_1"], channels["pressure_2"], values["piston_area_1"], values["piston_area_2"]
        )
        return method.from_position(record.time, channels["position"], force)
    if "position" in channels and "force" in channels:
        return method.from_position(record.time, channels["position"], channels["force"])
    if all(name in channels for name in ROTARY):
        return _rotary(record, values)
    raise UserError(
        f"{record.path}: the thesis's method needs position, pressure_1 and pressure_2, or position and force, or "
        "rotation_speed and motor_current; add the channels, or take --method simulation"
    )


def _rotary(record: Record, values: dict[str, float]) -> Slow:
    for name in ("torque_constant", "piston_radius"):
        if name not in values:
            raise UserError(f"{record.path}: rotary friction needs the parameter {name}; set it in [plant.set]")
    radius = values["piston_radius"]
    force = method.motor_force(record.channels["motor_current"], values["torque_constant"], radius)
    return method.from_speed(record.time, radius * record.channels["rotation_speed"], force)


def is_rotary(record: Record) -> bool:
    """Whether a record shows friction around the rod, there being no axial one."""
    return "position" not in record.channels and all(name in record.channels for name in ROTARY)


def parameter_values(experiment: Experiment) -> dict[str, float]:
    """Every parameter of the declared plant by canonical name, and those declared that the plant lacks."""
    parameters = experiment.parameters()
    names = [item.name for item in fields(experiment.plant.Parameters)]
    return {**experiment.values, **dict(zip(names, to_array(parameters).tolist(), strict=True))}


def directions(record: Record, experiment: Experiment) -> list[int]:
    """The directions (1, -1) in which a record slides for at least a twentieth of its sliding time."""
    if "position" not in record.channels and "rotation_speed" not in record.channels:
        return [1, -1]
    velocity = _velocity(record, experiment)
    counts = {sign: int(np.sum(sign * velocity > method.SLIDING)) for sign in (1, -1)}
    total = sum(counts.values())
    return [sign for sign, count in counts.items() if count and count >= 0.05 * total]


def _velocity(record: Record, experiment: Experiment) -> np.ndarray:
    if "position" in record.channels:
        zero = np.zeros(record.time.size)
        return method.slower(method.from_position(record.time, record.channels["position"], zero)).velocity
    return method.slower(friction_of(record, experiment)).velocity


def identify_by_thesis(
    experiment: Experiment, records: list[Record], progress: Callable[[str], None] | None = None
) -> ThesisFit:
    """The thesis's method on each record, and mean and standard deviation over those of a direction and speed.

    `progress` is told in words which record is taken.

    Raises:
        UserError: the channels do not serve, or no record gives anything.
    """
    found: dict[float, list[dict[str, float]]] = {}
    curves: dict[str, Slow] = {}
    failed: Counter[tuple[str, str, float]] = Counter()
    mass = parameter_values(experiment)["mass"]
    for place, record in enumerate(sorted(records, key=lambda record: record.rpm)):
        if progress is not None:
            progress(f"the thesis's method: record {place + 1} of {len(records)}")
        fine = friction_of(record, experiment)
        coarse = method.slower(fine)
        curves[str(record.path)] = coarse
        moved = directions(record, experiment)
        if not moved:
            failed["nothing slides", record.path.name, record.rpm] += 1
        for sign in moved:
            direction = "rotary" if is_rotary(record) else "forward" if sign > 0 else "backward"
            values: dict[str, float] = {}
            try:
                values |= method.static_parameters(coarse.turned(sign))
                values[STATIC] = values["coulomb"] + values["stribeck"]
                if np.isnan(values["stribeck_velocity"]):
                    said = "no Stribeck friction is seen, and a line is fitted"
                    failed[said, direction, record.rpm] += 1
                if _starts(fine) == sign:
                    values |= method.dynamic_parameters(fine.turned(sign), values[STATIC], mass)
                    if values["bristle_damping"] > DOUBTFUL * method.damping_rule(values["bristle_stiffness"], mass):
                        said = f"bristle_damping is over {DOUBTFUL:g} times what (4.14) gives: slow runs hardly show it"
                        failed[said, direction, record.rpm] += 1
            except UserError as error:
                failed[str(error), direction, record.rpm] += 1
            if values:
                named = {f"{name}{SUFFIXES[direction]}": value for name, value in values.items()}
                found.setdefault(record.rpm, []).append(named)
    notes = tuple(_merged(failed))
    if not found:
        raise UserError(f"the thesis's method finds nothing: {notes[0] if notes else 'no record slides'}")
    return ThesisFit({rpm: method.over_repeats(found[rpm]) for rpm in sorted(found)}, curves, notes)


def _merged(failed: Mapping[tuple[str, str, float], int]) -> list[str]:
    """What failed, by (why, direction, rpm) with its number of records: a sentence for each reason and direction."""
    together: dict[tuple[str, str], list[tuple[float, int]]] = {}
    for (why, direction, rpm), count in sorted(failed.items(), key=lambda item: item[0][2]):
        together.setdefault((why, direction), []).append((rpm, count))
    lines = []
    for (why, direction), places in together.items():
        speeds, count = ", ".join(f"{rpm:g}" for rpm, _ in places), sum(count for _, count in places)
        lines.append(f"{speeds} rpm, {direction}: {why} ({count} record{'s' * (count > 1)})")
    return lines


def _starts(data: Slow) -> int:
    """The direction in which a record slides first; 0 if it never does."""
    sliding = np.abs(np.nan_to_num(data.velocity)) > method.SLIDING
    return int(np.sign(data.velocity[np.argmax(sliding)])) if np.any(sliding) else 0
