"""Whether an experiment can be diagnosed at all: what its file says, then what its records hold, before any fit."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from workbench.diagnose.residuals.balances import Diagnosed, allowed, own_parameters
from workbench.diagnose.residuals.motion import Motion, motion_of
from workbench.diagnose.residuals.unknowns import Values
from workbench.errors import UserError
from workbench.parameters.sets import EITHER_SIGN
from workbench.records.experiment import Experiment
from workbench.records.reading import Record, by_log, check_differ
from workbench.records.sliding import check_opposes

SHORTEST, MOVES = 2.0, 6.0
"""s of a record, and noise deviations of the position's range, from which it can be used."""


def declared_values(experiment: Experiment) -> dict[str, float]:
    """The declared parameters (SI); a direction that is not declared apart has no value of its own."""
    declared: dict[str, float] = {**experiment.known_values(), **experiment.values}
    for name in [key for key in declared if key.endswith("_negative") and key not in experiment.values]:
        del declared[name]
    return declared


def check_experiment(experiment: Experiment) -> None:
    """What the file alone shows: no record for the fit, channels that allow no balance, parameters no fit can move.

    Raises:
        UserError: what `diagnose` could not do.
    """
    if not any(spec.use == "fit" for spec in experiment.records):
        raise UserError(f'{experiment.path}: no record is there for the fit; give one use = "fit"')
    if not experiment.plant.balances:
        raise UserError(
            f"{experiment.path}: plant {experiment.plant.name} has no balance that records could show; declare it "
            "without its compliance, as one that drive_ or rotary_ names begin with, or take identify"
        )
    declared = declared_values(experiment)
    balances = allowed(experiment.plant, experiment.flow, experiment.channels)
    if not balances:
        raise UserError(
            f"{experiment.path}: its channels allow no balance: a flow needs position, both pressures and the valve's "
            "voltage, a force needs position and pressures, a force or a command"
        )
    _check_free(experiment, declared, balances)


def motions_of(experiment: Experiment, records: Sequence[Record]) -> list[Motion]:
    """Records smoothed and differentiated; labels that several have are numbered.

    A piece of a record that says nothing is left out, and the record's first piece that stays says so.

    Raises:
        UserError: a record of which every piece is too short, on which nothing moves, or whose friction drives the rod;
            one that is a copy of another.
    """
    check_differ(records)
    taken: list[str] = []
    motions = []
    for pieces in by_log(records):
        made = [_motion_or_lack(piece) for piece in pieces]
        lacks = [one for one in made if isinstance(one, str)]
        if len(lacks) == len(made):
            raise UserError(f"{pieces[0].path}: {max(lacks, key=len)}")
        check_opposes(pieces, experiment)
        notes = [note for piece, one in zip(pieces, made, strict=True) if isinstance(one, str) for note in piece.notes]
        notes += [f"{len(lacks)} of {len(pieces)} pieces are not diagnosed: they say nothing"] * bool(lacks)
        for motion in made:
            if isinstance(motion, Motion):
                taken.append(_unique(motion.record.name, taken))
                told, notes = (*motion.record.notes, *notes), []
                motions.append(replace(motion, record=replace(motion.record, label=taken[-1], piece=0, notes=told)))
    return motions


def _unique(label: str, taken: Sequence[str]) -> str:
    """The label, numbered where another record has it: two parts of one file are two curves."""
    numbered = (f"{label} ({number})" for number in range(2, len(taken) + 2))
    return next(name for name in (label, *numbered) if name not in taken)


def _motion_or_lack(piece: Record) -> Motion | str:
    """The motion of a piece of a record, or why that says nothing: it is too short for smoothing, which of milliseconds
    would be over many samples, or nothing moves on it.
    """
    if short := _too_short(piece.valid, piece.sample_time):
        return short
    motion = motion_of(piece)
    if short := _too_short(motion.valid, piece.sample_time):
        return short
    if motion.has("position") and np.ptp(motion.position[motion.valid]) < MOVES * motion.noise["position"]:
        return "nothing moves beyond the position's noise; expected a record in which the rod slides"
    return motion


def _too_short(valid: np.ndarray, sample_time: float) -> str:
    """Why so many samples are too few, empty where they are not."""
    known = float(np.sum(valid)) * sample_time
    if known >= SHORTEST:
        return ""
    return (
        f"{known:.3g} s without ends and gaps are too little for a diagnosis; expected at least {SHORTEST:g} s, "
        "and better 40 s"
    )


def _check_free(experiment: Experiment, declared: Values, balances: Sequence[Diagnosed]) -> None:
    """What an experiment asks to be free has to be in a balance, and off 0 where a fit moves it by factors."""
    free = experiment.free or ()
    known = {name for own in own_parameters(balances, free, declared).values() for name in own}
    known_as = [item.name for item in balances]
    for name in free:
        if name in known:
            continue
        if declared.get(name) == 0.0 and name not in EITHER_SIGN:
            reason = (
                f"is declared 0, and a fit moves it by factors; give it a start in [plant.set], or leave {name} out"
            )
        else:
            reason = f"is in no balance that the records' channels allow ({' and '.join(known_as)}); leave it out"
        raise UserError(f'{experiment.path}: [fit] free: "{name}" {reason}')
