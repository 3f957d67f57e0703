"""How far simulated friction is off measured curves: every signal in a figure's panel that draws measured friction."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd

from workbench.friction_curves.measured import DIRECTIONS, Curve
from workbench.publish.tables import shown_number
from workbench.study.report.select import trajectory
from workbench.study.study import Study

LEAST_SHARE = 0.05
"""Share of a run's time that it has to spend at measured velocities in a direction."""

NAME, TITLE = "validation", "Simulated against measured friction-velocity curves"
NOTE = (
    "Root mean square of measured less simulated axial friction over the measured velocities, as the runs of the "
    "figures pass them, and as a share of the measured friction's."
)


def validation_table(study: Study, frame: pd.DataFrame, folder: Path, measured: Sequence[Curve]) -> pd.DataFrame:
    """rpm | model | direction | error (N) | (%), as text; empty where no panel draws measured friction."""
    lines = []
    for figure in study.file.figures:
        for panel in figure.panels:
            if panel.measured_rpm is None:
                continue
            label = ""
            for drawn in panel.curves:
                label = drawn.label or label
                run = trajectory(folder, frame, drawn.where, f"figure {figure.name}")
                for curve in (one for one in measured if one.rpm == panel.measured_rpm):
                    speed = DIRECTIONS[curve.direction] * run["velocity"].to_numpy()
                    friction = DIRECTIONS[curve.direction] * run[drawn.y].to_numpy()
                    inside = (speed >= curve.speed[0]) & (speed <= curve.speed[-1])
                    if np.mean(inside) < LEAST_SHARE:
                        continue
                    known = np.interp(speed[inside], curve.speed, curve.friction)
                    error = float(np.sqrt(np.mean((known - friction[inside]) ** 2)))
                    lines.append(
                        {
                            "rpm": f"{panel.measured_rpm:g}",
                            "model": label,
                            "direction": curve.direction,
                            "error (N)": shown_number(error, 3),
                            "error (%)": shown_number(100.0 * error / float(np.sqrt(np.mean(known**2))), 3),
                        }
                    )
    return pd.DataFrame(lines)
