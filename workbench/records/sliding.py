"""How a record moves, judged before anything is fitted: does it slide at all, and does friction oppose it?"""

from collections.abc import Sequence

import numpy as np

from plants.axis import name_along
from workbench.errors import UserError
from workbench.publish.along import SHOWN
from workbench.records.experiment import Experiment
from workbench.records.friction import AXIAL, FINE, SLIDING, directions, friction_of, from_position, meant, slower
from workbench.records.reading import Record

SLOW_SAMPLES = 0.1
"""s. Samples further apart than this are mostly a wrong unit of time."""

TAKEN = 0.1
"""Share of the work between a drive's command and its motion that the command may take on the whole: a mass that is
slower at a record's end gives some back."""

SHORT_WAY = 0.02
"""Share of the stroke below which a travel is mostly a wrong unit of position."""

OFF = 300.0
"""Times that friction is larger or smaller than as it is declared, from which the unit of a force is mostly wrong."""


def check_slides(records: Sequence[Record], experiment: Experiment) -> None:
    """Whether any of the records slides.

    Raises:
        UserError: none does: the largest velocity of the first one, and a likely mistake of its units.
    """
    if not records or any(directions(record, experiment) for record in records):
        return
    record = records[0]
    others = f" (nor in the other {len(records) - 1})" if len(records) > 1 else ""
    raise UserError(
        f"nothing slides in {record.path}{others}: {_slowness(record, experiment)}{_unit_mistake(record, experiment)}"
    )


def _slowness(record: Record, experiment: Experiment) -> str:
    shown = SHOWN[experiment.plant.axis]
    zero = np.zeros(record.time.size)
    if "position" not in record.channels:
        fastest = float(np.nanmax(np.abs(record.channels["rotation_speed"])))
        return f"its largest speed of rotation is {fastest:.3g} rad/s"
    velocity = np.abs(slower(from_position(record.time, record.channels["position"], zero)).velocity)
    if not np.any(np.isfinite(velocity)):
        return f"{record.time[-1]:.3g} s are too short to see a velocity; take a longer record"
    fastest = float(np.nanmax(velocity))
    return f"its largest velocity is {shown.speed(fastest, 3)}, expected more than {shown.speed(SLIDING)}"


def _unit_mistake(record: Record, experiment: Experiment) -> str:
    if record.sample_time >= SLOW_SAMPLES:
        return f"; samples are {record.sample_time:.3g} s apart: is the unit of channel time right (ms)?"
    stroke = experiment.values.get("stroke", np.inf)
    if "position" in record.channels and np.isfinite(stroke):
        way = float(np.nanmax(record.channels["position"]) - np.nanmin(record.channels["position"]))
        if way < SHORT_WAY * stroke:
            shown = SHOWN[experiment.plant.axis]
            travel = f"{shown.plain(way, 3)} of a stroke of {shown.plain(stroke, 3)}"
            return f"; it travels {travel}: is the unit of channel position right?"
    return ""


def check_lasts(pieces: Sequence[Record]) -> None:
    """Whether a piece of a record lasts as long as two of the means of which a velocity is made.

    Raises:
        UserError: none does.
    """
    record = max(pieces, key=lambda piece: piece.time.size)
    if record.time.size < 2 * meant(record.sample_time, FINE):
        raise UserError(
            f"{record.path}: {record.time[-1]:.3g} s are too short to see a velocity; take a longer record, or is the "
            "unit of channel time right?"
        )


def check_opposes(pieces: Sequence[Record], experiment: Experiment) -> None:
    """Whether the force that pressures or a load cell show opposes the motion, on the average over the way of a record
    in its pieces, and a load cell's is of the size of friction; or a drive's command gives work to the motion.

    What the pressure sensors may be off by, as [sensors] has it, is allowed for, and a declared load; a plant under a
    load that nobody knows, or on a spring, is not judged, nor a drive that carries a load.

    Raises:
        UserError: it drives the rod instead, or is hundreds of times off.
    """
    record = pieces[0]
    channels, values = record.channels, experiment.known_values()
    pressures = all(name in channels for name in AXIAL)
    free = experiment.free or ()
    load = name_along("load_force", experiment.plant.axis)
    if load in free or values.get("spring_stiffness") or "spring_stiffness" in free:
        return
    if not pressures and not ("position" in channels and "force" in channels):
        if not values.get(load):
            _check_command_works(pieces)
        return
    data = [friction_of(piece, experiment) for piece in pieces]
    velocity, force = (
        np.concatenate(parts) for parts in zip(*((one.velocity, one.force) for one in data), strict=True)
    )
    sliding = np.isfinite(force) & (np.abs(np.nan_to_num(velocity)) > SLIDING)
    if not np.any(sliding):
        return
    velocity, force = velocity[sliding], force[sliding]
    opposing = float(np.sum(velocity * force) / np.sum(np.abs(velocity)))
    areas = [values.get(f"piston_area_{side}", 0.0) for side in (1, 2)]
    offsets = [experiment.accuracies.get(f"pressure_{side}_offset", 0.0) for side in (1, 2)]
    allowed = float(np.linalg.norm(np.multiply(areas, offsets))) + abs(values.get(load, 0.0))
    unit = SHOWN[experiment.plant.axis].force_unit
    if opposing < -allowed:
        cause = "are the columns of pressure_1 and pressure_2 swapped, or is" if pressures else "is"
        raise UserError(
            f"{record.path}: friction does not oppose the motion ({opposing:.3g} {unit} on the average): {cause} "
            f"the sign of {'position' if pressures else 'position or force'} wrong?"
        )
    level = values.get("coulomb", 0.0) + values.get("viscous", 0.0) * float(np.mean(np.abs(velocity)))
    if not pressures and min(opposing, level) > 0.0 and max(opposing, level) > OFF * min(opposing, level):
        raise UserError(
            f"{record.path}: the force overcomes {opposing:.3g} {unit} of friction on the average, and as declared "
            f"that is {level:.3g} {unit}: is the unit of channel force right, or are coulomb and viscous?"
        )


def _check_command_works(pieces: Sequence[Record]) -> None:
    """Whether a drive's command, which its force goes with, gives work to a motion: what it gives friction takes, and
    masses and springs give it back.
    """
    works = list[np.ndarray]()
    for piece in pieces:
        if "command" not in piece.channels or "position" not in piece.channels:
            return
        moved = from_position(piece.time, piece.channels["position"], piece.channels["command"])
        works.append(moved.velocity * moved.force)
    work = np.nan_to_num(np.concatenate(works))
    if np.sum(work) < -TAKEN * np.sum(np.abs(work)):
        raise UserError(
            f"{pieces[0].path}: the command takes work from the motion instead of giving it: is the sign of command or "
            "position wrong?"
        )
