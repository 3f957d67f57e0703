"""Correlation of the estimates of a fit by simulation; the fit itself has the numbers."""

from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from workbench.identify.simulation.found import SimulationFit
from workbench.publish.style import WIDTH, figure_style


def draw_correlation(fit: SimulationFit) -> Figure:
    """Correlation of the estimates, as numbers on colours."""
    names = list(fit.estimates)
    with figure_style():
        figure = Figure(figsize=(WIDTH, WIDTH))
        FigureCanvasAgg(figure)
        axes = figure.add_subplot()
        image = axes.imshow(fit.correlation, vmin=-1.0, vmax=1.0, cmap="RdBu_r")
        axes.set_xticks(range(len(names)), names, rotation=90)
        axes.set_yticks(range(len(names)), names)
        axes.grid(visible=False)
        for i, row in enumerate(fit.correlation):
            for j, value in enumerate(row):
                axes.text(
                    j, i, f"{value:.2f}", ha="center", va="center", fontsize=6, color="w" if abs(value) > 0.6 else "k"
                )
        figure.colorbar(image, shrink=0.7, label="correlation")
        figure.suptitle("Correlation of the estimates")
    return figure
