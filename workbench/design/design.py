"""The whole of a design: hypotheses, the rig, the search for a motion, and how surely that tells them apart."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from plants.interface import SENSORS
from workbench.design import declared, diagnosed, open_questions
from workbench.design.asked import Asked, asked_of, limits_of
from workbench.design.contrast import Tried, pairs_of
from workbench.design.hypotheses import Hypothesis, truths_of
from workbench.design.pieces import Condition, Reach, sampled
from workbench.design.power import Simulated, distances, told_apart
from workbench.design.refit import Leg
from workbench.design.result import Design, Known
from workbench.design.rig import Limits, Rig
from workbench.design.search import Wanted, search
from workbench.design.steering import plain, steering_of
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.balances import diagnosed_plant
from workbench.diagnose.residuals.motion import THINNED, Motion
from workbench.diagnose.residuals.unknowns import Values
from workbench.diagnose.residuals.weighing import Whitening
from workbench.errors import UserError
from workbench.fitting.covariance import inverse
from workbench.fitting.threads import side_by_side
from workbench.progress import Progress, part_of, silent
from workbench.publish.words import listed
from workbench.records.experiment import Experiment, read_experiment
from workbench.records.reading import read_records

OF_STROKE = 0.9
"""Share of the stroke in which a motion stays."""

FAST = 1.2
"""Times the largest speed that a reference asks for, or that records have, which the mass may reach."""

SPARE = 0.95
"""Share of a limit of positions that a reference asks for."""

COMPARED = 5e6
"""Steps of the solver after which no further motion is compared as a whole: some ten seconds on each of two cores."""

SAMPLE_TIME = 1e-3
"""s, where neither records nor [design] say another."""


@dataclass(frozen=True)
class Seen:
    """How a rig has moved: between which positions, how fast (SI), sampled how often (s)."""

    low: float
    high: float
    speed: float
    sample_time: float


def design(
    source: Path,
    *,
    between: Sequence[str] = (),
    identify: Sequence[str] = (),
    duration: float | None = None,
    progress: Progress = silent,
) -> Design:
    """The motion to record next, by an experiment file or by the folder of a diagnosis.

    Args:
        source: the file, or the folder.
        between: hypotheses that it is to tell apart, names of effects or "none"; by default those that a diagnosis
        left. identify: parameters that it is to show; by default those that a diagnosis left without a deviation.
        duration: s, at most; by default what [design] says, else 60 s. progress: told what is being done.

    Raises:
        UserError: a file or folder that cannot be used, impossible limits, or hypotheses that no motion tells apart.
    """
    made = _of_diagnosis if source.is_dir() else _of_experiment
    experiment, asked, rig, hypotheses = made(source, between, identify, duration, progress)
    rig = _steered(experiment, asked, rig, hypotheses)
    wanted = Wanted(hypotheses, [_place(hypotheses[0], name) for name in asked.identify])
    if len(hypotheses) < 2 and not wanted.parameters:
        missing = f"{asked.between[0]} is told from nothing" if asked.between else "nothing is asked of a motion"
        raise UserError(
            f"{source}: {missing}; name hypotheses with --between, such as none,backlash, or parameters with --identify"
        )
    found = search(rig, wanted, asked.duration, part_of(progress, 0.2, 0.4))
    best = _best(rig, wanted, found, part_of(progress, 0.6, 0.2))
    progress("how often a record of it decides", 0.8)
    told = told_apart(best.motion) if len(hypotheses) > 1 else []
    pieces, known = [one.piece for one in best.chosen], _known(wanted, best.motion)
    runs = best.motion.runs[: len(hypotheses)]
    return Design(experiment, str(source), rig, hypotheses, pieces, best.motion.legs, runs, told, known)


def _of_experiment(
    path: Path, between: Sequence[str], identify: Sequence[str], duration: float | None, progress: Progress
) -> tuple[Experiment, Asked, Rig, list[Hypothesis]]:
    """The declared plant on the rig that an experiment describes."""
    progress("reading the experiment", 0.0)
    experiment = read_experiment(path)
    asked = asked_of(experiment, between, identify, duration)
    motions = _motions(experiment)
    noise = asked.noise or {
        name: max(one.sensed[name] for one in motions)
        for name in SENSORS
        if motions and name in motions[0].sensed and name in experiment.plant.channels
    }
    _check_noise(path, noise)
    channels = [
        *noise,
        "time",
        experiment.plant.command,
        *(["valve_voltage"] if "valve_voltage" in experiment.channels else []),
    ]
    sample_time = asked.sample_time or (motions[0].record.sample_time if motions else SAMPLE_TIME)
    seen = _seen(motions, sample_time) if motions else None
    values = declared_values(experiment)
    rig = _rig(experiment, asked, channels, noise, {}, _room(experiment, asked, seen, sample_time), values)
    moved = 2.0 * rig.reach.half, rig.reach.speed, sample_time
    return experiment, asked, rig, declared.hypotheses_of(experiment, asked, channels, moved)


def missing_before_records(experiment: Experiment, asked: Asked) -> str:
    """What keeps a motion from being designed before there is a record, in words; empty where nothing does."""
    if _has_records(experiment):
        return ""
    try:
        _check_noise(experiment.path, asked.noise)
        _room(experiment, asked, None, asked.sample_time or SAMPLE_TIME)
    except UserError as error:
        return str(error).removeprefix(f"{experiment.path}: ")
    return ""


def _check_noise(path: Path, noise: Mapping[str, float]) -> None:
    if "position" not in noise:
        raise UserError(
            f"{path}: no record is there to tell the sensors' noise; give it in [design.noise], position at least"
        )


def _has_records(experiment: Experiment) -> bool:
    """Whether the records for the fit are there."""
    return all(spec.is_there for spec in experiment.records if spec.use == "fit")


def _motions(experiment: Experiment) -> list[Motion]:
    """Those records for the fit that are there."""
    if not _has_records(experiment):
        return []
    return motions_of(experiment, read_records(experiment, "fit"))


def _of_diagnosis(
    folder: Path, between: Sequence[str], identify: Sequence[str], duration: float | None, progress: Progress
) -> tuple[Experiment, Asked, Rig, list[Hypothesis]]:
    """The plant that was diagnosed, on the rig that made its records."""
    reported = diagnosed.read_diagnosis(folder)
    experiment = reported.experiment
    asked = asked_of(experiment, between, identify, duration)
    evidence = diagnosed.evidence_of(reported, progress)
    sets = [] if asked.identify and not asked.between else asked.between
    hypotheses = open_questions.hypotheses_of(reported, evidence, sets, progress)
    if not asked.identify and not asked.between:
        names = {u.name for u in hypotheses[0].unknowns}
        asked = replace(asked, identify=[name for name in reported.vague if name in names])
    motions = evidence.motions
    seen = _seen(motions, motions[0].record.sample_time)
    room = _room(experiment, asked, seen, seen.sample_time)
    channels, noise = list(motions[0].channels), {**evidence.noise, **asked.noise}
    rig = _rig(experiment, asked, channels, noise, evidence.whitening, room, hypotheses[0].values)
    how, grain = evidence.how, motions[0].thinning
    rig = replace(rig, held=how.held, grain=grain, tolerance=min(rig.tolerance, how.tolerance))
    return experiment, asked, rig, hypotheses


def _seen(motions: Sequence[Motion], sample_time: float) -> Seen:
    """How a rig has moved in its records."""
    return Seen(
        min(float(np.min(one.position[one.valid])) for one in motions),
        max(float(np.max(one.position[one.valid])) for one in motions),
        max(one.top_speed for one in motions),
        sample_time,
    )


def _room(experiment: Experiment, asked: Asked, seen: Seen | None, sample_time: float) -> tuple[Limits, Reach]:
    """The rig's limits, and what a reference may ask for.

    Raises:
        UserError: nothing tells how far or how fast it may move, or the limits leave no room.
    """
    plant, parameters = experiment.plant, experiment.parameters()
    half = 0.5 * float(plant.travel(parameters))
    low, high = (-OF_STROKE * half, OF_STROKE * half) if np.isfinite(half) else (-np.inf, np.inf)
    if seen is not None and not np.isfinite(half):
        low, high = seen.low, seen.high
    low, high = (asked.limits.get(name, value) for name, value in (("low", low), ("high", high)))
    if not np.isfinite(low) or not np.isfinite(high):
        raise UserError(
            f"{experiment.path}: nothing tells how far the mass may move; give [design.limits] low and high"
        )
    speed = asked.limits.get("speed", np.inf if seen is None else FAST * seen.speed)
    if not np.isfinite(speed):
        raise UserError(f"{experiment.path}: nothing tells how fast the mass may move; give [design.limits] speed")
    end = half if np.isfinite(half) else np.inf
    limits = limits_of(asked, max(low, -end), min(high, end), speed)
    if not asked.closed:
        command = min(limits.command, float(plant.command_limit(parameters)))
        if not np.isfinite(command):
            raise UserError(f"{experiment.path}: an open loop needs [design.limits] command")
        fastest = 2.0 * np.pi * command / (20.0 * sample_time)
        return limits, Reach(-command, command, fastest, sample_time)
    middle, room = 0.5 * (limits.low + limits.high), 0.5 * SPARE * (limits.high - limits.low)
    return limits, Reach(middle - room, middle + room, limits.speed / FAST, sample_time)


def _rig(
    experiment: Experiment,
    asked: Asked,
    channels: Sequence[str],
    noise: Mapping[str, float],
    whitening: Mapping[str, Whitening],
    room: tuple[Limits, Reach],
    believed: Values,
) -> Rig:
    limits, reach = room
    return Rig(
        along=diagnosed_plant(experiment.plant, experiment.flow, channels),
        steering=None,
        believed=believed,
        sample_time=reach.sample_time,
        grain=max(round(THINNED / reach.sample_time), 1),
        noise=noise,
        whitening={name: whitening.get(name, Whitening.of(1.0)) for name in noise},
        limits=limits,
        reach=reach,
        conditions=asked.conditions,
    )


def _steered(experiment: Experiment, asked: Asked, rig: Rig, hypotheses: Sequence[Hypothesis]) -> Rig:
    """The rig with the controller that closes its loop."""
    if not asked.closed:
        return rig
    return replace(rig, steering=steering_of(experiment, asked) or plain(rig, hypotheses))


def _place(hypothesis: Hypothesis, name: str) -> int:
    """The place of a parameter among the unknowns.

    Raises:
        UserError: it is none of them.
    """
    names = [u.name for u in hypothesis.unknowns]
    if name not in names:
        raise UserError(f'--identify "{name}": no fit moves it; name it in [fit] free, or take {listed(names, "or")}')
    return names.index(name)


@dataclass(frozen=True, eq=False)
class Whole:
    """The pieces that were chosen, and the motion as a whole of them."""

    chosen: Sequence[Tried]
    motion: Simulated


def _best(rig: Rig, wanted: Wanted, found: Sequence[Sequence[Tried]], progress: Progress) -> Whole:
    """Of motions the one that does most as a whole, once every rival has been fitted to it; but no more than by first
    order: a rival's fit that ends short of its best leaves what looks like a difference.
    """
    best, most, steps = None, -np.inf, 0
    for i, chosen in enumerate(found if pairs_of(wanted.hypotheses) else found[:1]):
        if steps > COMPARED:
            break
        progress("the whole motion under every hypothesis", i / len(found))
        motion = _simulated(rig, wanted, chosen)
        whole, taken = distances(motion)
        steps += taken
        score = wanted.score_of({pair: min(whole[pair], one) for pair, one in wanted.left(chosen).items()}, chosen)
        if best is None or score > most:
            best, most = Whole(chosen, motion), score
    assert best is not None
    return best


def _simulated(rig: Rig, wanted: Wanted, chosen: Sequence[Tried]) -> Simulated:
    pieces = [one.piece for one in chosen]
    conditions = list(dict.fromkeys(piece.condition for piece in pieces))
    legs = [
        _leg(rig, condition, [sampled(p, rig.reach) for p in pieces if p.condition == condition])
        for condition in conditions
    ]
    runs = [
        side_by_side(lambda leg, of=one: rig.driven(of.values, leg.reference, leg.condition), legs)
        for one in truths_of(wanted.hypotheses)
    ]
    return Simulated(rig, wanted.hypotheses, legs, runs)


def _leg(rig: Rig, condition: Condition, references: Sequence[np.ndarray]) -> Leg:
    """Pieces that follow each other, and the middle once more at their end."""
    return Leg(np.append(np.concatenate(references), rig.reach.middle), condition)


def _known(wanted: Wanted, motion: Simulated) -> list[Known]:
    """Deviations of the parameters that were asked for, before and after the motion as a whole."""
    first, shown = wanted.hypotheses[0], motion.shown(0, 0) if wanted.parameters else None
    after = first.covariance
    if shown is not None:
        columns = np.column_stack([shown.columns, shown.starts])
        after = inverse(columns.T @ columns + first.precision_with(shown.starts.shape[1]))
    found = []
    for k in wanted.parameters:
        unknown = first.unknowns[k]
        slope = abs(unknown.slope(float(first.places[k])))
        before, later = (slope * float(np.sqrt(max(of[k, k], 0.0))) for of in (first.covariance, after))
        found.append(Known(unknown.name, first.values[unknown.name], before, later))
    return found
