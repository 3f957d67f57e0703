"""All figures of an identification by name."""

from matplotlib.figure import Figure

from workbench.errors import UserError
from workbench.identify.report.figures.correlation import draw_correlation
from workbench.identify.report.figures.friction import draw_friction, friction_data
from workbench.identify.report.figures.over_rpm import draw_over_rpm, over_rpm_data
from workbench.identify.report.figures.simulated import draw_simulated, simulated_data
from workbench.identify.result import Identification
from workbench.records.friction import shows_friction


def figures_of(identification: Identification) -> dict[str, Figure]:
    """Those that the experiment names, records against their simulation, and the correlation of several estimates.

    One of friction is left out where no record shows friction and no curve is known.

    Raises:
        UserError: a figure at a speed of rotation that no record has.
    """
    figures = {**_requested(identification), **record_figures(identification)}
    if identification.simulation is not None and len(identification.simulation.estimates) > 1:
        figures["correlation"] = draw_correlation(identification.simulation)
    return figures


def _requested(identification: Identification) -> dict[str, Figure]:
    """The figures that the experiment names; without any, friction over velocity of all records, if they show it."""
    specs = identification.experiment.figures
    if not specs and not any(shows_friction(record) for record in identification.records):
        return {}
    if not specs:
        if not all(map(shows_friction, identification.records)):
            return {}
        data = friction_data(identification, None)
        return {"friction_velocity": draw_friction(data, "Friction over velocity")} if data.measured else {}
    figures = {}
    for spec in specs:
        if spec.parameter:
            figures[spec.name] = draw_over_rpm(over_rpm_data(identification, spec.parameter), spec.title)
            continue
        speeds = sorted({record.rpm for record in identification.records})
        if spec.rpm not in speeds:
            shown = ", ".join(f"{rpm:g}" for rpm in speeds)
            raise UserError(
                f"{identification.experiment.path}: figures: {spec.name}: no record at {spec.rpm:g} rpm, "
                f"expected one of {shown}"
            )
        data = friction_data(identification, spec.rpm)
        if data.measured or data.curves:
            figures[spec.name] = draw_friction(data, spec.title)
    return figures


def record_figures(identification: Identification) -> dict[str, Figure]:
    """Of the first record of each label: each output simulated against measured, with the residual below."""
    fit = identification.simulation
    return {} if fit is None else {data.name: draw_simulated(data) for data in simulated_data(identification, fit)}
