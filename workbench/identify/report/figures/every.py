"""All figures of an identification by name."""

from matplotlib.figure import Figure

from workbench.identify.report.figures.correlation import draw_correlation
from workbench.identify.report.figures.friction import draw_friction, friction_data
from workbench.identify.report.figures.over_rpm import draw_over_rpm, over_rpm_data
from workbench.identify.report.figures.simulated import draw_simulated, simulated_data
from workbench.identify.result import Identification
from workbench.records.friction import shows_friction
from workbench.records.schema import FigureTable

DEFAULT = FigureTable(name="friction_velocity", title="Friction over velocity")
"""The figure of all records where the experiment names none."""


def figures_of(identification: Identification) -> tuple[dict[str, Figure], dict[str, str]]:
    """Those that the experiment names, records against their simulation, and the correlation of several estimates; and
    why others are left out, by their names.
    """
    requested, left_out = _requested(identification)
    figures = {**requested, **record_figures(identification)}
    if identification.simulation is not None and len(identification.simulation.estimates) > 1:
        figures["correlation"] = draw_correlation(identification.simulation)
    return figures, left_out


def _requested(identification: Identification) -> tuple[dict[str, Figure], dict[str, str]]:
    """The figures that the experiment names; without any, friction over velocity of all records, if they have channels
    that show it. Of friction that no record gives, the reason.
    """
    specs = identification.experiment.figures
    figures, left_out = dict[str, Figure](), dict[str, str]()
    if not specs and not any(shows_friction(record) for record in identification.records):
        return figures, left_out
    for spec in specs or (DEFAULT,):
        if spec.parameter:
            figures[spec.name] = draw_over_rpm(over_rpm_data(identification, spec.parameter), spec.title)
            continue
        data = friction_data(identification, spec.rpm if specs else None)
        if data.lacking:
            left_out[spec.name] = data.lacking
        else:
            figures[spec.name] = draw_friction(data, spec.title)
    return figures, left_out


def record_figures(identification: Identification) -> dict[str, Figure]:
    """Of the first record of each label: each output simulated against measured, with the residual below."""
    fit = identification.simulation
    return {} if fit is None else {data.name: draw_simulated(data) for data in simulated_data(identification, fit)}
