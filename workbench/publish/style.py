"""How figures look: colours that a colour-blind reader and a grey printer can tell apart, text that fits a page."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from typing import Any, TypedDict

import matplotlib as mpl
from matplotlib.axis import Axis
from matplotlib.ticker import FuncFormatter, Locator, LogLocator, MaxNLocator, NullFormatter

SHORT = 8.0
"""Ratio of the ends of a logarithmic axis up to which three labels a decade are too few."""

LONG = 2e4
"""Ratio of the ends of a logarithmic axis from which three labels a decade are too many."""


class LineStyle(TypedDict, total=False):
    """How a line is drawn, in matplotlib's words."""

    color: str
    label: str
    linestyle: str | tuple[int, tuple[int, ...]]
    linewidth: float
    marker: str
    zorder: float


# Okabe and Ito's palette, without its yellow, which print loses, and a wine red; each with a dash of its own.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#56B4E9", "#E69F00", "#000000", "#882255")
DASHES: Sequence[str | tuple[int, tuple[int, ...]]] = (
    "-",
    "--",
    "-.",
    ":",
    (0, (5, 1)),
    (0, (3, 1, 1, 1)),
    (0, (1, 1)),
    (0, (8, 2, 2, 2)),
)
MARKERS = ("o", "s", "^", "D", "v", "P", "x", "*")
REFERENCE: LineStyle = {"color": "#bbbbbb", "linestyle": "-", "linewidth": 3.5, "zorder": 1.5}
"""What others are held against: light and thick, under the curves, so that none that lies on it hides it."""

WIDTH = 6.4
PANEL_HEIGHT = 3.2
"""Inches."""

BASE_POINTS = 9.0
"""Size of text."""

_SETTINGS: Any = {
    "axes.grid": True,
    "axes.spines.right": False,
    "axes.spines.top": False,
    "axes.titlesize": "medium",
    "figure.constrained_layout.use": True,
    "figure.titlesize": "large",
    "font.size": BASE_POINTS,
    "grid.alpha": 0.3,
    "legend.fontsize": "small",
    "legend.framealpha": 0.9,
    "lines.linewidth": 1.4,
    "lines.markersize": 4.5,
    "pdf.fonttype": 42,
    "savefig.dpi": 160,
    "svg.hashsalt": "friction-workbench",
}


def line_style(number: int, first_dash: int = 0) -> LineStyle:
    """Colour and dash of the curve of this number; a colour comes back only with another dash."""
    colours = len(COLOURS)
    return {
        "color": COLOURS[number % colours],
        "linestyle": DASHES[(number + number // colours + first_dash) % len(DASHES)],
    }


def marker(number: int) -> str:
    """Marker of the points of this number, another one when its colour comes back."""
    return MARKERS[(number + number // len(COLOURS)) % len(MARKERS)]


class PlainTicks(Locator):
    """Ticks of a logarithmic axis: 1, 2, 5 of a decade; decades alone of a long one, round numbers of a short one."""

    def __call__(self) -> Sequence[float]:
        """Within the axis as it is."""
        low, high = (0.0, 0.0) if self.axis is None else sorted(self.axis.get_view_interval())
        return self.tick_values(float(low), float(high))

    def tick_values(self, vmin: float, vmax: float) -> Sequence[float]:
        """Those between `vmin` and `vmax`."""
        if vmax > LONG * vmin:
            way: Locator = LogLocator(subs=(1.0,))
        elif vmax > SHORT * vmin:
            way = LogLocator(subs=(1.0, 2.0, 5.0))
        else:
            way = MaxNLocator(5)
        return [float(tick) for tick in way.tick_values(vmin, vmax) if vmin <= tick <= vmax]


def plain_numbers(axis: Axis) -> None:
    """Label a logarithmic axis with plain numbers."""
    axis.set_major_locator(PlainTicks())
    axis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axis.set_minor_formatter(NullFormatter())


@contextmanager
def figure_style() -> Iterator[None]:
    """Within this context figures look as ours do; nothing outside is changed, and no screen is needed."""
    with mpl.rc_context(_SETTINGS):
        yield
