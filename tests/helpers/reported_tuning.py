"""A small tuning with its report, as tests write and read it."""

import html
from pathlib import Path

import pandas as pd
from command import Answer, workbench, write
from page_numbers import text_of

STUDY = """\
title = "two controllers, tuned"
question = "Which is better?"
[plant]
model = "non_rotating"
parameters = "owen2001_simulation"

[references.fast]
kind = "sine"
amplitude = "5 mm"
frequency = "2 Hz"

[references.slow]
kind = "sine"
amplitude = "5 mm"
frequency = "1 Hz"

[axes]
reference = ["fast", "slow"]
controller = ["p", "pd"]

[controllers.p]
type = "pid"
kp = "600 V/m"

[controllers.pd]
type = "pid"
kp = "500 V/m"
kd = "2 V s/m"

[simulation]
duration = "1.5 s"
transient = "0.5 s"

[tune]
trials = 16
seeds = 2

[tune.objective]
rms_error = 1

[tune.constraints]
hold_duration = "1 s"

[tune.gains.p]
kp = { min = "100 V/m", max = "600 V/m" }
"""
"""The P controller is best at the end of its range, where the study has it."""


def reported(folder: Path, text: str, *options: str) -> Answer:
    """The command on a study of this text."""
    return workbench("tune", write(folder, text), "--out", folder / "out", *options)


def results(out: Path) -> pd.DataFrame:
    """results.csv, by controller."""
    return pd.read_csv(out / "results.csv").set_index("controller")


def table(out: Path, name: str) -> pd.DataFrame:
    """A table, as it is printed."""
    return pd.read_csv(out / "tables" / f"{name}.csv", dtype=str, keep_default_na=False)


def page(out: Path) -> str:
    """The text of the page."""
    return html.unescape(text_of((out / "tuning.html").read_text(encoding="utf-8")))
