"""Signals over time as a notebook has them: their units, and pictures of them."""

from collections.abc import Sequence
from typing import TYPE_CHECKING

import pandas as pd

from workbench.errors import UserError, nearest
from workbench.publish.tables import with_unit
from workbench.simulation.run import Run
from workbench.study.names import units_of

if TYPE_CHECKING:
    from workbench.publish.notebook import NotebookFigure

UNITS = "units"
"""Where a frame's units are: in its `attrs`, by column."""


def frame_of(run: Run) -> pd.DataFrame:
    """All signals of a run, a row a sample, with their units in `attrs["units"]`."""
    frame = pd.DataFrame({"time": run.time, **run.signals})
    units = units_of(run)
    frame.attrs[UNITS] = {str(name): units.get(str(name), "1") for name in frame.columns}
    return frame


def plot_signals(frame: pd.DataFrame, names: Sequence[str], against: str, title: str) -> "NotebookFigure":
    """Signals of a frame over another one, a panel for each unit; in the units of the frame.

    Raises:
        UserError: no such signal, or none asked for.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg

    from workbench.publish.notebook import NotebookFigure
    from workbench.publish.style import PANEL_HEIGHT, WIDTH, figure_style, line_style

    units, known = frame.attrs[UNITS], [str(name) for name in frame.columns]
    for name in (*names, against):
        if name not in known:
            raise UserError(f'there is no signal "{name}"; {nearest(name, known)}')
    if not names:
        raise UserError("plot: no signal is named; expected one such as position")
    alike: dict[str, list[str]] = {}
    for name in dict.fromkeys(names):
        alike.setdefault(units[name], []).append(name)
    with figure_style():
        figure = NotebookFigure(figsize=(WIDTH, PANEL_HEIGHT * len(alike)))
        FigureCanvasAgg(figure)
        figure.suptitle(title)
        panels = figure.subplots(len(alike), sharex=True, squeeze=False)[:, 0]
        for axes, (unit, shown) in zip(panels, alike.items(), strict=True):
            for number, name in enumerate(shown):
                axes.plot(frame[against], frame[name], label=_words(name), **line_style(number))
            axes.set_ylabel(with_unit(", ".join(map(_words, shown)), unit))
            if len(shown) > 1:
                axes.legend()
        panels[-1].set_xlabel(with_unit(_words(against), units[against]))
    return figure


def _words(name: str) -> str:
    return name.replace("_", " ")
