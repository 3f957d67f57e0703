"""The controller by which a rig follows a reference: the one at hand, or the quickest plain one that does not swing."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from controllers import pid
from controllers.pid import PID
from plants.interface import Plant
from workbench.design.asked import Asked
from workbench.design.hypotheses import Hypothesis
from workbench.design.rig import Rig, Steering
from workbench.diagnose.residuals.null import tracking
from workbench.errors import UserError
from workbench.records.experiment import Experiment
from workbench.study.controller_tables import parse_controller
from workbench.study.schema import CaseTables
from workbench.toml import reading as files

NAME = "rig"
"""What the controller is called in a study."""

CROSSOVERS = (60.0, 30.0, 15.0, 8.0, 4.0, 2.0, 1.0)
"""rad/s, of a loop that nobody has described, the quickest first."""

QUICKEST = 0.1
"""Of one over the sample time, up to which a crossover is tried."""

STEP, OVERSHOOT = 0.05, 0.2
"""Of the range, after which a loop is judged; share of it by which a loop may go beyond."""

SETTLES = 20.0
"""Times one over the crossover in which it is."""


def described(table: Mapping[str, Any], plant: Plant, folder: Path) -> Steering:
    """The controller that a table describes as one of a study.

    Raises:
        SchemaError: a mistake in the table.
    """
    tables = files.conform(
        CaseTables,
        {
            "plant": {"model": plant.name, "parameters": ""},
            "simulation": {"duration": 1.0},
            "controllers": {NAME: dict(table)},
        },
    )
    try:
        found = parse_controller(tables, plant, folder)
    except files.SchemaError as mistake:
        raise files.together(
            [files.SchemaError(("controller", *each.key[2:]), str(each)) for each in (mistake, *mistake.others)]
        ) from None
    return Steering(found.controller, found.settings, dict(table))


def steering_of(experiment: Experiment, asked: Asked) -> Steering | None:
    """The controller that an experiment describes for its rig; None where it describes none.

    Raises:
        UserError: a mistake in [design.controller], with its place.
    """
    if asked.controller is None:
        return None
    try:
        return described(asked.controller, experiment.plant, experiment.path.parent)
    except files.SchemaError as mistake:
        text = files.read_text(experiment.path)
        raise files.at(experiment.path, text, ("design", *mistake.key), mistake.message) from None


def plain(rig: Rig, hypotheses: Sequence[Hypothesis]) -> Steering:
    """A loop with a gain, of a mass also with a damping, that does not swing under any hypothesis.

    Raises:
        UserError: every one does; or the plant's command sets neither a speed nor a force.
    """
    condition, values = rig.conditions[0], hypotheses[0].values
    start = rig.setup(values, condition, 2, whole=True)
    for crossover in CROSSOVERS:
        if crossover > QUICKEST / rig.sample_time:
            continue
        try:
            settings = tracking(rig.along, start.parameters, start.state, start.inputs, crossover)
        except ValueError as error:
            raise UserError(f'{error}; describe the controller in [design.controller], or set loop = "open"') from None
        settings = settings._replace(velocity_time_constant=max(0.1 / crossover, rig.sample_time))
        steering = Steering(PID, settings, _table(settings, rig))
        trial = replace(rig, steering=steering)
        if all(_settles(trial, one, crossover) for one in hypotheses):
            return steering
    raise UserError(
        f"no plain loop of {CROSSOVERS[-1]:g} to {CROSSOVERS[0]:g} rad/s keeps from swinging; describe the rig's in "
        "[design.controller]"
    )


def _table(settings: pid.Settings, rig: Rig) -> dict[str, object]:
    unit, axis = rig.along.plant.command_unit, rig.axis
    table: dict[str, object] = {"type": "pid", "kp": f"{settings.kp:.10g} {unit}/{axis}"}
    if settings.kd:
        table |= {
            "kd": f"{settings.kd:.10g} {unit} s/{axis}",
            "velocity_time_constant": f"{settings.velocity_time_constant:.10g} s",
        }
    return table


def _settles(rig: Rig, hypothesis: Hypothesis, crossover: float) -> bool:
    """Whether a step is followed without going far beyond it, and is rested at in the end."""
    step = STEP * 2.0 * rig.reach.half
    count = max(int(SETTLES / crossover / rig.sample_time), 50)
    reference = np.full(count, rig.reach.middle + step)
    reference[: count // 20] = rig.reach.middle
    run = rig.driven(hypothesis.values, reference, rig.conditions[0])
    if run.diverged:
        return False
    way = run.state("position") - rig.reach.middle
    return bool(np.max(way) < (1.0 + OVERSHOOT) * step and np.ptp(way[-count // 5 :]) < OVERSHOOT * step)
