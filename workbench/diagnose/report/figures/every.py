"""All figures of a diagnosis by name."""

from workbench.diagnose.report.figures.evidence import draw_evidence, evidence_data
from workbench.diagnose.report.figures.over_signals import draw_over_signals, over_signals_data
from workbench.diagnose.report.figures.over_time import draw_over_time, over_time_data
from workbench.diagnose.report.figures.parameters import draw_parameters, parameters_data
from workbench.diagnose.report.figures.residuals import residuals_of
from workbench.diagnose.report.figures.simulation import draw_simulation, simulation_data
from workbench.diagnose.report.figures.whiteness import draw_whiteness, whiteness_data
from workbench.diagnose.report.series import words_of
from workbench.diagnose.result import Diagnosis
from workbench.publish.pictures import Picture


def pictures_of(diagnosis: Diagnosis) -> dict[str, Picture]:
    """Of each balance its residuals and its candidates, the simulated plant beside the records, the parameters."""
    pictures: dict[str, Picture] = {}
    for result in diagnosis.results:
        name, residuals = words_of(result.balance), residuals_of(diagnosis, result)
        if residuals.is_known:
            pictures[f"{name}_time"] = draw_over_time(over_time_data(residuals))
            pictures[f"{name}_signals"] = draw_over_signals(over_signals_data(residuals))
        if any(step.candidates for step in result.steps):
            pictures[f"{name}_evidence"] = draw_evidence(evidence_data(result))
        if residuals.is_known:
            pictures[f"{name}_whiteness"] = draw_whiteness(whiteness_data(residuals))
    if diagnosis.simulation is not None:
        pictures["simulation"] = draw_simulation(simulation_data(diagnosis, diagnosis.simulation))
        if any(step.candidates for step in diagnosis.simulation.steps):
            pictures["simulation_evidence"] = draw_evidence(evidence_data(diagnosis.simulation.result))
    if (parameters := parameters_data(diagnosis)) is not None:
        pictures["parameters"] = draw_parameters(parameters)
    return pictures
