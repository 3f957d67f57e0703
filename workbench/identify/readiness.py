"""Whether an experiment can be identified at all: what its file says, then what its records hold, before any fit."""

from collections.abc import Sequence

from plants.equation import fields
from plants.interface import SENSORS
from workbench.errors import UserError
from workbench.records.experiment import Experiment
from workbench.records.friction import AXIAL, SHOWING, fewest_samples
from workbench.records.reading import Record, by_log
from workbench.records.sliding import check_lasts, check_opposes, check_slides

MARKS = "*?["
"""What makes a file's name a pattern."""


def method_of(experiment: Experiment) -> str:
    """The method that the experiment says, else both, or simulation alone where no channel shows friction."""
    return experiment.method or ("both" if _shows_friction(experiment) else "simulation")


def check_experiment(experiment: Experiment, method: str) -> None:
    """What the file alone shows: nothing to fit, no record for it, channels that do not serve the method.

    Raises:
        UserError: what `identify` could not do.
    """
    fitted = [spec for spec in experiment.records if spec.use == "fit"]
    if not fitted:
        raise UserError(f'{experiment.path}: no record is there for the fit; give one use = "fit"')
    if method in ("thesis", "both"):
        _check_thesis_channels(experiment)
    if method in ("simulation", "both"):
        if experiment.free == ():
            raise UserError(
                f"{experiment.path}: fit.free: is empty: expected at least one parameter; without the key it is "
                "friction in the directions of the records"
            )
        _check_simulation_channels(experiment)
        _check_rotates(experiment, [spec.rpm for spec in fitted if not isinstance(spec.rpm, str)])


def check_records(experiment: Experiment, records: Sequence[Record], method: str) -> None:
    """What the records show: too short a time, rotation that the plant does not know, too few samples, no motion,
    friction that drives.

    Raises:
        UserError: what `identify` could not do.
    """
    for pieces in by_log(records):
        check_lasts(pieces)
    if method in ("simulation", "both"):
        _check_rotates(experiment, [record.rpm for record in records])
    if method in ("thesis", "both"):
        check_slides(records, experiment)
        for pieces in by_log(records):
            longest = max(pieces, key=lambda record: record.time.size)
            if longest.time.size < (fewest := fewest_samples(longest.sample_time)):
                raise UserError(
                    f"{longest.path}: {longest.time.size} samples are too few for the thesis's averaging, expected at "
                    f"least {fewest}; take --method simulation"
                )
    for pieces in by_log(records):
        check_opposes(pieces, experiment)
    speeds = sorted({record.rpm for record in records})
    for spec in experiment.figures:
        if not spec.parameter and spec.rpm not in speeds:
            shown = ", ".join(f"{rpm:g}" for rpm in speeds)
            raise UserError(
                f"{experiment.path}: figures: {spec.name}: no record at {spec.rpm:g} rpm, expected one of {shown}"
            )


def check_pattern(experiment: Experiment) -> None:
    """Whether each pattern of files finds one, where its folder is there and holds anything.

    Raises:
        UserError: a pattern without a file.
    """
    for spec in experiment.records:
        if any(mark in spec.path.name for mark in MARKS) and spec.path.parent.is_dir():
            there = sorted(item.name for item in spec.path.parent.iterdir() if item.is_file())
            held = f"it holds {', '.join(there[:3])}{', ...' if len(there) > 3 else ''}" if there else "it is empty"
            raise UserError(
                f"{experiment.path}: records: no file is called {spec.path.name} in {spec.path.parent}: {held}"
            )


def _check_thesis_channels(experiment: Experiment) -> None:
    if not _shows_friction(experiment):
        lacking = [name for name in AXIAL if name not in experiment.channels]
        raise UserError(
            f"{experiment.path}: the thesis's method needs position, pressure_1 and pressure_2, or position and force, "
            f"or rotation_speed and motor_current; add {' and '.join(lacking)} to [channels], or take method "
            "simulation: --method simulation"
        )


def _shows_friction(experiment: Experiment) -> bool:
    return any(all(name in experiment.channels for name in names) for names in SHOWING)


def _check_simulation_channels(experiment: Experiment) -> None:
    known, plant = experiment.channels, experiment.plant
    driven = [item.name for item in fields(plant.Inputs) if item.name in known]
    if plant.command not in driven and "command" not in known:
        raise UserError(f"{experiment.path}: a simulation needs the measured {plant.command}; add it to [channels]")
    if not any(name in known for name in SENSORS):
        needed = ", ".join(SENSORS)
        raise UserError(f"{experiment.path}: a fit needs one of {needed}; add it to [channels]")


def _check_rotates(experiment: Experiment, speeds: Sequence[float]) -> None:
    turning = sorted({rpm for rpm in speeds if rpm})
    if turning and not experiment.plant.rotary_command:
        raise UserError(
            f"{experiment.path}: plant {experiment.plant.name} does not rotate, and there are records at "
            f"{', '.join(f'{rpm:g}' for rpm in turning)} rpm; take a rotating plant such as "
            "rotating_anisotropic_ideal, or --method thesis"
        )
