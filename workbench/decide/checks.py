"""What a [decide] can get wrong beyond its keys: motions that cannot be, rods that do not rotate, figures not there."""

from collections.abc import Mapping, Sequence

from plants.equation import fields
from plants.interface import Plant
from workbench.decide.schema import HYDRAULIC, POWERS, DecideTable
from workbench.study.resolve import Resolved
from workbench.study.schema import MOST_SAMPLES
from workbench.study.study import Study
from workbench.toml.reading import Key

LEAST_SAMPLES = 20
"""Samples of a period below which a sampled controller no longer sees a sine."""

Candidate = tuple[str, float]
"""A controller by name, and a speed of rotation (rpm)."""


def check_motions(study: Study, table: DecideTable, speeds: Sequence[float], sample_time: float) -> None:
    """Whether the sines are slow enough for the sample time (s), and not too slow to be simulated.

    Raises:
        UserError: a speed (m/s) that is neither.
    """
    for speed in speeds:
        key: Key = ("decide", "speed" if speed == table.speed else "speeds")
        period = table.period(speed)
        motion = f"{speed:g} m/s over {table.amplitude:g} m is a period of {period:.3g} s"
        if period < LEAST_SAMPLES * sample_time:
            most = table.period(1.0) / (LEAST_SAMPLES * sample_time)
            raise study.error(
                key, f"{motion}, under {LEAST_SAMPLES} samples of {sample_time:g} s: at most {most:.3g} m/s"
            )
        if table.cycles * period > MOST_SAMPLES * sample_time:
            least = table.cycles * table.period(1.0) / (MOST_SAMPLES * sample_time)
            raise study.error(key, f"{motion}, which takes too many samples: expected at least {least:.3g} m/s")


def check_still(study: Study, table: DecideTable, still: Resolved) -> None:
    """Whether the plant has what is asked of it; `still` is the first candidate without rotation.

    Raises:
        UserError: an amplitude beyond the stroke, no hydraulic power, rpm of a rod that does not rotate.
    """
    plant, end = still.setup.plant, 0.5 * still.setup.plant.travel(still.setup.parameters)
    if table.amplitude > end:
        raise study.error(("decide", "amplitude"), f"got {table.amplitude:g} m, the stroke ends at +-{end:g} m")
    if not _has(plant, HYDRAULIC):
        raise study.error(("plant", "model"), f"{plant.name} has no hydraulic power: expected a hydraulic actuator")
    turned = study.file.plant.get("model") == "by_rpm" or study.file.plant.get("turned")
    if any(table.rpm) and not plant.rotary_command and not turned:
        message = f'plant "{plant.name}" does not rotate: expected rpm = [0] (or turned = "rod")'
        raise study.error(("decide", "rpm"), message)


def check_candidates(study: Study, table: DecideTable, resolved: Mapping[Candidate, Resolved]) -> None:
    """Whether every candidate follows the motion and has the power that counts.

    Raises:
        UserError: a controller in open loop, or a rotation whose motor is not modelled.
    """
    for (name, rpm), case in resolved.items():
        if case.setup.reference is None:
            raise study.error(("controllers", name), "follows no reference: leave it out of [decide] controllers")
        if rpm and not _has(case.setup.plant, POWERS[table.power_figure][1]):
            message = f'{case.setup.plant.name} has no motor: expected power_figure = "total", or another rotation'
            raise study.error(("decide", "power_figure"), message)


def _has(plant: Plant, column: str) -> bool:
    """Whether a plant has the signal of a power, by the column of its mean."""
    return column.removesuffix("_W") in {item.name for item in fields(plant.Signals)}
