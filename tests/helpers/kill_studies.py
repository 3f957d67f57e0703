"""Commands that are stopped and go on, each with a small study of its own that takes it a few seconds."""

from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path

from command import PIPED, changed, write
from deadband import make_experiment
from tuned_study import STUDY as TUNED

RUN = changed("rpm = [0, 460]", 'rpm = [0, 460]\n"controllers.p.kp" = [100, 200, 300, 400]\n"simulation.seed" = [1, 2]')

TUNE = TUNED.replace("trials = 20", "trials = 16").replace("seeds = 1", "seeds = 2")

DECIDE = """\
title = "a decision, for tests"
[plant]
model = "by_rpm"
bristle = "isotropic"
parameters = "owen2001_simulation"
motor_limits = false
[simulation]
seed = 1
[controllers.feed]
type = "pid"
kp = "500 V/m"
feedforward = 1
[controllers.lugre]
type = "lugre"
law = "valve_inversion"
[uncertainty]
scale.mass = { min = 0.8, max = 1.5 }
noise.position = { max = "2 um" }
[decide]
accuracy = "1 mm"
speed = "20 mm/s"
amplitude = "1 mm"
power = "2 kW"
draws = 3
rpm = [0, 125]
plain = ["feed"]
fresh_draws = 60
hold_duration = "1 s"
"""


@dataclass(frozen=True)
class Command:
    """What is run on what `make` puts into a folder; what it is given to go on.

    It keeps what it has finished in a `table` of a `database`, if it does, and tells of each piece in a line
    of progress that begins as `finished` says. `code` is what Python runs.
    """

    words: tuple[str, ...]
    make: Callable[[Path], object]
    again: list[str] = field(default_factory=list)
    database: str = ""
    table: str = ""
    finished: str = r".+"
    jobs: bool = True
    code: str = PIPED.format(interval="0.0")

    def arguments(self, folder: Path, jobs: int) -> list[str]:
        """The command on what lies in a folder, without where its results go."""
        name, file, *options = self.words
        return [name, str(folder / file), *options, *(["--jobs", str(jobs)] if self.jobs else [])]


COMMANDS = {
    "run": Command(
        ("run", "study.toml"),
        partial(write, text=RUN),
        ["--resume"],
        "results.sqlite",
        "results",
        r"\d+ of \d+ cases",
    ),
    "tune": Command(
        ("tune", "study.toml", "--controller", "p"),
        partial(write, text=TUNE),
        ["--resume"],
        "results.sqlite",
        "trials",
        r"p, about|p$",
    ),
    "decide": Command(
        ("decide", "study.toml"),
        partial(write, text=DECIDE),
        ["--resume"],
        "runs.sqlite",
        "runs",
        r".*\d+ of \d+ runs",
    ),
    "diagnose": Command(
        ("diagnose", "experiment.toml"), make_experiment, finished=r"(?!error|stopped|Traceback)\S", jobs=False
    ),
}
"""By name."""
