"""What a page takes as given: records that stand for a reader's own."""

from pathlib import Path

import numpy as np
import pandas as pd


def given(page: Path, folder: Path) -> None:
    """Write into the folder what the page says is there."""
    for name, period in RECORDS.get(page.stem, {}).items():
        save_run(folder / name, period)


RECORDS = {
    "diagnosis": {"run_a.csv": 4.0, "run_b.csv": 3.0},
}
"""By page: names of logs, and the period (s) of each motion."""


def save_run(path: Path, period: float) -> None:
    """10 s as a logger writes them: ms, mV, mm from one end, bar, and counts of a sixteenth of a bar."""
    time = 1e-3 * np.arange(10_000)
    noise = np.random.default_rng(2).standard_normal((2, time.size))
    turn = 2.0 * np.pi / period
    forward = 5.0 * np.tanh(10.0 * np.cos(turn * time))
    columns = {
        "Time [ms]": 1e3 * time,
        "Valve [mV]": 500.0 * np.cos(turn * time),
        "Rod [mm]": 30.0 + 15.0 * np.sin(turn * time),
        "pA [bar]": 14.7 + forward + 0.02 * noise[0],
        "Counts B": (14.7 - forward + 0.02 * noise[1] + 0.625) / 0.0625,
    }
    pd.DataFrame(columns).to_csv(path, index=False)
