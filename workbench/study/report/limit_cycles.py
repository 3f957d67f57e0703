"""Limit cycles of a study's results, each beside what the describing function predicts for its loop."""

import math
from pathlib import Path

import pandas as pd

from controllers.pid import PID
from plants.equation import fields
from plants.friction import friction_in
from workbench.linear.describing_function import Prediction, predict
from workbench.metrics.registry import names_along
from workbench.publish.along import SHOWN
from workbench.publish.tables import Table, shown_number, write_frame
from workbench.simulation.setup import Setup
from workbench.study.plan import Plan
from workbench.study.report.select import with_cycles
from workbench.study.study import DRAW

NAME = "limit_cycles"
TITLE = "Limit cycles: simulated against describing function"
NOTE = (
    "Peak to peak and period of each simulated cycle, sustained, decaying or too short to tell, and of the describing "
    "function for a PID with friction as a static function of velocity; error: predicted less simulated, for sustained "
    "cycles. It knows neither sticking nor presliding: the simulation decides. It does not apply to other controllers "
    "than a PID."
)
DRAWS = "draws with a cycle"
FOUND, NOT_FOUND, NOT_ASKED = "predicted", "none predicted", "does not apply"
DIGITS = 4


def limit_cycle_table(planned: Plan, frame: pd.DataFrame) -> pd.DataFrame:
    """One row for each case of `frame` with a limit cycle, as text; empty without any. Of the draws of a case the first
    that has one stands for all, beside how many have.

    `frame` holds the results of `planned`, its index that of the cases.
    """
    shown, size = SHOWN[planned.axis], names_along(planned.axis)["limit_cycle_amplitude_m"]
    apart = [name for name in planned.axes if name != DRAW]
    found = with_cycles(frame, planned.axis)
    repeats = planned.cases.repeats
    groups = found.groupby(found.index // repeats)
    cycling = groups.size() if DRAW in found else None
    lines = []
    for index, row in groups.head(1).iterrows():
        number = int(str(index))
        setup = planned.resolved[number].setup
        asked = _applies(setup)
        prediction, lasting = _predicted(setup) if asked else None, row["limit_cycle"] == "sustained"
        of_draws = "" if cycling is None else f"{cycling[number // repeats]} of {repeats}"
        drawn = {DRAW: _cell(row[DRAW]), DRAWS: of_draws} if of_draws else {}
        lines.append(
            {
                **{name: _cell(row[name]) for name in apart},
                **drawn,
                "verdict": row["limit_cycle"],
                "describing function": FOUND if prediction else NOT_FOUND if asked else NOT_ASKED,
                **_beside(
                    "peak to peak", shown.unit, row[size] * shown.factor, prediction, "amplitude", shown.factor, lasting
                ),
                **_beside("period", "s", row["limit_cycle_period_s"], prediction, "period", 1.0, lasting),
            }
        )
    return pd.DataFrame(lines)


def _applies(setup: Setup) -> bool:
    """Whether a PID holds a mass with a contact that follows the LuGre law."""
    pushed = setup.plant.disturbance in [item.name for item in fields(setup.plant.Inputs)]
    return setup.loop.controller is PID and friction_in(setup.parameters) is not None and pushed


def _predicted(setup: Setup) -> Prediction | None:
    """The prediction for a run under a PID, the rod turning at its wanted speed."""
    motor = getattr(setup.parameters, "motor", None)
    surface_speed = setup.rotation_speed * motor.piston_radius if motor is not None else 0.0
    return predict(setup.plant, setup.parameters, setup.loop.gains, surface_speed)


def _cell(value: object) -> str:
    if value is None or (isinstance(value, float) and math.isnan(value)):
        return ""
    return f"{value:g}" if isinstance(value, float) else str(value)


def _beside(
    label: str, unit: str, simulated: float, prediction: Prediction | None, name: str, factor: float, lasting: bool
) -> dict[str, str]:
    """A figure of the cycle as simulated and as predicted, with the error of the prediction for a `lasting` one."""
    number = None if prediction is None else getattr(prediction, name) * factor
    return {
        f"{label} ({unit}), simulated": shown_number(simulated, DIGITS),
        f"{label} ({unit}), predicted": "" if number is None else shown_number(number, DIGITS),
        f"{label}, error (%)": ""
        if number is None or not lasting
        else f"{100.0 * (number - simulated) / simulated:+.1f}",
    }


def write_limit_cycles(planned: Plan, frame: pd.DataFrame, folder: Path) -> Path:
    """Write the table of results that hold limit cycles to the folder `tables`; returns its Markdown."""
    return write_frame(NAME, Table(TITLE, limit_cycle_table(planned, frame), [NOTE]), folder / "tables")[1]
