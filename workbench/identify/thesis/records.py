"""The thesis's method on records: each direction of each one, and mean and deviation over the repeats."""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from plants.axis import name_along
from workbench.errors import UserError
from workbench.identify.thesis import method
from workbench.identify.thesis.method import Estimate
from workbench.progress import Progress, silent
from workbench.records.experiment import Experiment
from workbench.records.friction import SLIDING, Slow, directions, fewest_samples, friction_of, is_rotary, slower
from workbench.records.reading import Record
from workbench.records.schema import STATIC, SUFFIXES

DOUBTFUL = 10.0
"""Ratio of the bristle's fitted damping to the thesis's rule for it from which it is told."""


@dataclass(frozen=True)
class ThesisFit:
    """What the thesis's method finds, by speed of rotation (rpm) and canonical name; what it cannot do.

    `curves` are the 10 Hz data of each record. `static` is among the names, for tables.
    """

    groups: Mapping[float, Mapping[str, Estimate]]
    curves: dict[Record, Slow]
    notes: tuple[str, ...]

    @property
    def estimates(self) -> dict[str, Estimate]:
        """Parameters by canonical name, where all records have one speed of rotation; else none: each has its own."""
        if len(self.groups) > 1:
            return {}
        (group,) = self.groups.values()
        return {name: estimate for name, estimate in group.items() if not name.startswith(STATIC)}

    def to_json(self) -> dict[str, object]:
        """As identified.json holds it."""
        by_rpm = {
            f"{rpm:g}": {name: estimate.to_json() for name, estimate in group.items()}
            for rpm, group in self.groups.items()
        }
        return {"notes": list(self.notes), "unidentified": self.unidentified, "by_rpm": by_rpm}

    @property
    def unidentified(self) -> dict[str, str]:
        """Those of `estimates` that the records do not give, and why."""
        return {name: why for name, estimate in self.estimates.items() if (why := method.doubt(estimate))}


def identify_by_thesis(experiment: Experiment, records: Sequence[Record], progress: Progress = silent) -> ThesisFit:
    """The thesis's method on each record, and mean and standard deviation over those of a direction and speed.

    `progress` is told in words which record is taken.

    Raises:
        UserError: the channels do not serve, or no record gives anything.
    """
    by_rpm: dict[float, list[dict[str, float]]] = {}
    curves: dict[Record, Slow] = {}
    failed: Counter[tuple[str, str, float]] = Counter()
    mass = experiment.known_values()[name_along("mass", experiment.plant.axis)]
    for place, record in enumerate(sorted(records, key=lambda record: record.rpm)):
        progress(f"the thesis's method: record {place + 1} of {len(records)}")
        if record.time.size < fewest_samples(record.sample_time):
            failed["too short for the averaging", "piece", record.rpm] += 1
            continue
        fine = friction_of(record, experiment)
        coarse = slower(fine)
        curves[record] = coarse
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
                    why = "no Stribeck friction is seen, and a line is fitted"
                    failed[why, direction, record.rpm] += 1
                if _starts(fine) == sign:
                    values |= method.dynamic_parameters(fine.turned(sign), values[STATIC], mass)
                    if values["bristle_damping"] > DOUBTFUL * method.damping_rule(values["bristle_stiffness"], mass):
                        why = f"bristle_damping is over {DOUBTFUL:g} times what (4.14) gives: slow runs hardly show it"
                        failed[why, direction, record.rpm] += 1
            except UserError as error:
                failed[str(error), direction, record.rpm] += 1
            if values:
                named = {f"{name}{SUFFIXES[direction]}": value for name, value in values.items()}
                by_rpm.setdefault(record.rpm, []).append(named)
    notes = tuple(_merged(failed))
    if not by_rpm:
        raise UserError(f"the thesis's method finds nothing: {notes[0] if notes else 'no record slides'}")
    return ThesisFit({rpm: method.over_repeats(by_rpm[rpm]) for rpm in sorted(by_rpm)}, curves, notes)


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
    sliding = np.abs(np.nan_to_num(data.velocity)) > SLIDING
    return int(np.sign(data.velocity[np.argmax(sliding)])) if np.any(sliding) else 0
