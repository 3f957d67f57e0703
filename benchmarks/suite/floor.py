"""What a first result takes of libraries, and nothing of this program: arrays, a compiled function that is kept from
the last time, and a figure as PNG, SVG and PDF.

    python floor.py FOLDER
"""

import sys
from pathlib import Path

import numba
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


@numba.njit(cache=True)
def decay(values: np.ndarray) -> float:
    """The least of loops."""
    for i in range(1, values.size):
        values[i] = 0.9 * values[i - 1]
    return values[-1]


figure = Figure()
FigureCanvasAgg(figure)
line = np.ones(1000)
decay(line)
axes = figure.subplots()
axes.plot(line, label="line")
axes.set_xlabel("sample")
axes.legend()
for ending in ("png", "svg", "pdf"):
    figure.savefig(Path(sys.argv[1]) / f"floor.{ending}")
