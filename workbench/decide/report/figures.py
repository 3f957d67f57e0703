"""The figures that a decision has."""

from pathlib import Path

from workbench.decide.report.axes import is_known
from workbench.decide.report.map_figure import map_figure
from workbench.decide.report.speed_figure import speed_figure
from workbench.decide.report.trade_figure import trade_figure
from workbench.decide.result import Decision
from workbench.publish.pictures import Picture, save
from workbench.publish.style import figure_style


def write_figures(decision: Decision, folder: Path) -> dict[str, Picture]:
    """Write the figures that the decision has: none of points without an error, of one cell, of a single speed."""
    plan, drawn = decision.plan, dict[str, Picture]()
    known = any(is_known(row) for row in decision.asked.ordered)
    with figure_style():
        if known:
            drawn["error_against_power"] = Picture(*trade_figure(decision))
        if len(plan.speeds) * len(plan.spreads) > 1:
            drawn["map"] = Picture(*map_figure(decision))
        if known and len(plan.speeds) > 1:
            drawn["error_against_speed"] = Picture(*speed_figure(decision))
    for name, picture in drawn.items():
        save(picture.figure, name, folder, caption=picture.caption)
    return drawn
