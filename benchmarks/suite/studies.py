"""The studies that are run: one loop of the thesis's non-rotating actuator, as many times as is asked for."""

import json
from collections.abc import Sequence
from pathlib import Path

KP = (300.0, 700.0)
"""V/m. Cases differ in their gain, evenly between these."""

LOOP = """\
title = "Cases of {seconds:g} s"
{head}

[plant]
model = "{plant}"
parameters = "owen2001_simulation"

[references]
motion = {{ {motion} }}

[controllers.p]
type = "pid"
kp = "500 V/m"

[simulation]
duration = "{seconds:g} s"
seed = 1
"""

SINE = 'kind = "sine", amplitude = "5 mm", frequency = "2 Hz"'
SWEEP = 'kind = "multisine", amplitude = "15 mm", frequency = "0.1 Hz", harmonics = [3, 7, 13]'
"""Motions: of cases, and of a rig whose record shall tell much."""

TABLE_AND_FIGURE = """
[[tables]]
name = "errors"
title = "Errors"
rows = [{ result = "rms_error_m", label = "rms error", unit = "mm" }]

[[figures]]
name = "position"
title = "Position"

[[figures.panels]]
x_label = "time"
x_unit = "s"
y_label = "position"
y_unit = "mm"
curves = [
    { y = "reference_position", label = "reference", style = "reference" },
    { y = "position", label = "position" },
]
"""

SENSORS = """
[sensors]
position = { noise = "5 um" }
pressure_1 = { noise = "2 kPa" }
pressure_2 = { noise = "2 kPa" }
"""

EXPERIMENT = """\
title = "A record of {seconds:g} s"

[plant]
model = "non_rotating"
parameters = "owen2001_simulation"
scale = {{ coulomb = 0.8, viscous = 1.2 }}

[fit]
method = "simulation"
free = ["coulomb", "viscous"]

[channels]
time = {{ column = "time", unit = "s" }}
valve_voltage = {{ column = "valve_voltage", unit = "V" }}
position = {{ column = "measured_position", unit = "m" }}
pressure_1 = {{ column = "measured_pressure_1", unit = "Pa" }}
pressure_2 = {{ column = "measured_pressure_2", unit = "Pa" }}

[[records]]
file = "{record}"
"""


def write_small(path: Path) -> Path:
    """One case, one table, one figure: the least that a user runs."""
    path.write_text(
        LOOP.format(seconds=3.0, head="", plant="non_rotating", motion=SINE) + TABLE_AND_FIGURE, encoding="utf-8"
    )
    return path


def write_cases(path: Path, cases: int, seconds: float = 1.0) -> Path:
    """A study of so many cases of so many seconds, which are all different; neither tables nor figures."""
    text = LOOP.format(seconds=seconds, head="", plant="non_rotating", motion=SINE)
    if cases > 1:
        low, high = KP
        gains = [f"{low + (high - low) * i / (cases - 1):.9g} V/m" for i in range(cases)]
        text += f'\n[axes]\n"controllers.p.kp" = {json.dumps(gains)}\n'
    path.write_text(text, encoding="utf-8")
    return path


def write_rig(path: Path, seconds: float) -> Path:
    """A study whose only case writes down a record, as a rig would, sampled at 1 kHz."""
    signals: Sequence[str] = ("valve_voltage", "measured_position", "measured_pressure_1", "measured_pressure_2")
    head = f"records = {json.dumps(signals)}"
    path.write_text(
        LOOP.format(seconds=seconds, head=head, plant="two_chamber", motion=SWEEP) + SENSORS, encoding="utf-8"
    )
    return path


def write_experiment(path: Path, seconds: float, record: Path) -> Path:
    """What `identify` and `diagnose` are asked of that record."""
    path.write_text(EXPERIMENT.format(seconds=seconds, record=record.as_posix()), encoding="utf-8")
    return path
