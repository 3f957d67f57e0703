"""A small study that is tuned, as tests of tuning write it."""

from collections.abc import Sequence
from pathlib import Path

from command import write

from workbench.study.reading import read_study
from workbench.study.study import Study
from workbench.tune.prepare import prepared
from workbench.tune.result import Tuning
from workbench.tune.run import tune_all

STUDY = """\
title = "a study that is tuned"
[plant]
model = "non_rotating"
parameters = "owen2001_simulation"
[controllers]
p = { type = "pid", kp = "500 V/m" }
pd = { type = "pid", kp = "500 V/m", kd = "2 V s/m" }
lugre = { type = "lugre", law = "valve_inversion" }
[references.sine]
kind = "sine"
amplitude = "5 mm"
frequency = "2 Hz"
[simulation]
duration = "1 s"
transient = "0.4 s"
hold_limit = "4 s"
[axes]
controller = ["p", "pd", "lugre"]
[tune]
trials = 20
seeds = 1
[tune.objective]
rms_error = 1
"""

DRAWN = """\
[uncertainty]
friction = 1
[uncertainty.scale]
mass = { min = 0.8, max = 1.5 }
bulk_modulus = { min = 0.3, max = 1.0, scale = "log" }
"""

HUNTING = """\
title = "soft hoses"
[plant]
model = "non_rotating"
parameters = "owen2001_simulation"
set = { bulk_modulus = "30 MPa" }
[controllers]
pi = { type = "pid", kp = "100 V/m", ki = "500 V/(m s)" }
[references.sine]
kind = "sine"
amplitude = "2 mm"
frequency = "0.2 Hz"
[simulation]
duration = "10 s"
transient = "5 s"
[tune]
trials = 16
seeds = 1
[tune.objective]
rms_error = 1
[tune.constraints]
gain_margin_dB = 0
phase_margin_deg = 0
hold_level = "10 mm"
hold_duration = "20 s"
[tune.gains.pi]
ki = { min = "100 V/(m s)", max = "2000 V/(m s)" }
"""
"""The fastest integral has the least error, and a limit cycle at rest."""


def robust(text: str = STUDY, draws: int = 8) -> str:
    """A study that is tuned on drawn machines."""
    return text.replace("[tune]\n", f"[tune]\ndraws = {draws}\nfresh_draws = 12\n") + DRAWN


def ready(folder: Path, text: str, name: str | Sequence[str], trials: int | None = None) -> tuple[Study, list[str]]:
    """A study file of this text in `folder`, and the controllers that are tuned."""
    folder.mkdir(exist_ok=True)
    return prepared(read_study(write(folder, text)), [name] if isinstance(name, str) else name, trials)


def tuned(folder: Path, text: str, name: str, *, trials: int | None = None, jobs: int = 1) -> Tuning:
    """A study, tuned; its trials stay in `folder`."""
    study, names = ready(folder, text, name, trials)
    return tune_all(study, names, folder / "results.sqlite", jobs)
