"""What a PLC's log at 19 Hz has of the runs of rig.toml: a clock that jitters, gaps, repeated stamps.

    python studies/valve_axis/slow_log.py [results/valve_axis_rig]

Writes slow_closed.csv and slow_open.csv beside the results. A value is the controller's last one before the stamp, so
it is up to a sample of the controller (10 ms) old.
"""

import sys
from pathlib import Path

import numpy as np
import pandas as pd

STEP, JITTER = 0.053, 0.010
"""s between stamps, and by how much they are off at most."""

GAPS_EVERY, GAPS = 20.0, (0.06, 0.5)
"""s between gaps, in the middle, and s that they last."""

REPEATED = 500
"""Rows for each stamp that is that of the row before."""

SEED = 19


def slow(table: pd.DataFrame, generator: np.random.Generator) -> pd.DataFrame:
    """The rows that the log has, with its stamps."""
    time = table["time"].to_numpy()
    stamps = np.arange(JITTER, time[-1] - JITTER, STEP)
    stamps = stamps + generator.uniform(-JITTER, JITTER, stamps.size)
    for start in generator.uniform(0.0, time[-1], round(time[-1] / GAPS_EVERY)):
        stamps = stamps[(stamps < start) | (stamps > start + generator.uniform(*GAPS))]
    rows = np.searchsorted(time, stamps, side="right") - 1
    shown = stamps.copy()
    repeated = generator.choice(np.arange(1, stamps.size), stamps.size // REPEATED, replace=False)
    shown[repeated] = shown[repeated - 1]
    command, position = (table[name].to_numpy()[rows] for name in ("valve_voltage", "measured_position"))
    return pd.DataFrame({"time_s": shown.round(3), "command_V": command.round(4), "position_mm": 1e3 * position})


def main() -> None:
    folder = Path(sys.argv[1] if len(sys.argv) > 1 else "results/valve_axis_rig")
    generator = np.random.default_rng(SEED)
    for name in ("closed", "open"):
        (record,) = (folder / "records").glob(f"{name}_*.parquet")
        slow(pd.read_parquet(record), generator).to_csv(folder / f"slow_{name}.csv", index=False, float_format="%.6g")


if __name__ == "__main__":
    main()
