"""What the figures of an identification share: panels above one another."""

from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.publish.style import PANEL_HEIGHT, WIDTH


def panels_of(count: int, title: str, height: float = 1.0) -> tuple[Figure, list[Axes]]:
    """A figure of panels above one another, each of `height` times the usual one."""
    figure = Figure(figsize=(WIDTH, height * PANEL_HEIGHT * count + 0.4))
    FigureCanvasAgg(figure)
    figure.suptitle(title)
    return figure, list(figure.subplots(count, squeeze=False)[:, 0])
