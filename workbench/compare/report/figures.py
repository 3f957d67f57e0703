"""The figures that a comparison has: error against real rpm and against paid power by scenario, and who hunts."""

from pathlib import Path

from workbench.compare.candidates import MM
from workbench.compare.report.hunting_figure import hunting_picture
from workbench.compare.report.panels import HIGHEST, candidates_of
from workbench.compare.report.power_figure import power_figure
from workbench.compare.report.speed_figure import speed_figure
from workbench.compare.result import Comparison
from workbench.publish.pictures import Picture, save
from workbench.publish.style import figure_style
from workbench.publish.words import plain_name
from workbench.toml.file_names import file_name

FORMATS = ("pdf", "png")
"""In which a comparison has its figures."""


def write_figures(comparison: Comparison, folder: Path) -> dict[str, Picture]:
    """Write all figures: errors on the plant samples that all have met; who hunts on any sample."""
    with figure_style():
        drawn = pictures_of(comparison)
    for name, picture in drawn.items():
        save(picture.figure, name, folder, FORMATS, caption=picture.caption)
    return drawn


def pictures_of(comparison: Comparison) -> dict[str, Picture]:
    """The figures by name."""
    drawn: dict[str, Picture] = {}
    cells = candidates_of(comparison)
    for scenario in dict.fromkeys(cell.scenario for cell in cells):
        own = {cell: candidates for cell, candidates in cells.items() if cell.scenario == scenario}
        name = plain_name(scenario).capitalize()
        figure = speed_figure(comparison.table, own, f"{name}: error against real speed of rotation")
        drawn[f"error_against_rpm_{file_name(scenario)}"] = Picture(figure, _speed_caption(comparison, name))
        figure = power_figure(comparison.table, own, comparison.verdicts, f"{name}: error against paid power")
        drawn[f"error_against_power_{file_name(scenario)}"] = Picture(figure, _power_caption(comparison, name))
    hunting = hunting_picture(comparison)
    return drawn if hunting is None else {**drawn, "hunting_map": hunting}


def _speed_caption(comparison: Comparison, name: str) -> str:
    return (
        f"{name}: error against the rod's real mean speed. In colour: of each family the controller with the "
        f"least error that holds; grey: all others; crosses: hunts or does not complete on any draw. "
        f"{_bars(comparison)} Errors above {HIGHEST:g} times the least are cut off."
    )


def _power_caption(comparison: Comparison, name: str) -> str:
    return (
        f"{name}: error against what pump and motor terminals pay together. In colour: who stands for each "
        f"class; grey: all others that hold. {_bars(comparison)}"
    )


def _bars(comparison: Comparison) -> str:
    table = comparison.table
    return (
        f"Means over the draws that all have met; bars: their {100 * table.probability:g} % interval. Shaded: below "
        f"{table.negligible * MM:g} mm, not told apart, and drawn in the middle of it."
    )
