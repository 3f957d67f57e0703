"""One parameter of friction over the speed of rotation: found with error bars, published as crosses."""

from collections.abc import Sequence
from dataclasses import dataclass

from matplotlib.figure import Figure

from workbench.identify.report.figures.frame import panels_of
from workbench.identify.report.published import scale_shown, unit_shown
from workbench.identify.result import Identification
from workbench.publish.style import COLOURS, figure_style, marker
from workbench.records.schema import SUFFIXES

SHIFT = 0.8
"""rpm by which the points of the two directions stand apart."""


@dataclass(frozen=True, eq=False)
class Points:
    """Values, in the unit that is shown, each with one standard deviation (0: unknown), over speeds (rpm)."""

    rpm: Sequence[float]
    values: Sequence[float]
    stds: Sequence[float]


@dataclass(frozen=True, eq=False)
class DirectionPoints:
    """Of one direction of motion: what was found, and what tables print."""

    direction: str
    found: Points
    published: Sequence[Points]


@dataclass(frozen=True, eq=False)
class OverRpm:
    """A parameter by its canonical name, forward and backward."""

    parameter: str
    unit: str
    directions: Sequence[DirectionPoints]


def over_rpm_data(identification: Identification, parameter: str) -> OverRpm:
    """The numbers of the figure, by the thesis's method; without it nothing was found at any speed."""
    scale, fit = scale_shown(parameter, identification.experiment.plant.axis), identification.thesis
    directions = []
    for direction in ("forward", "backward"):
        name = parameter + SUFFIXES[direction]
        own = {rpm: group[name] for rpm, group in fit.groups.items() if name in group} if fit is not None else {}
        values = [scale * estimate.value for estimate in own.values()]
        found = Points([*own], values, [scale * (estimate.std_of_repeats or 0.0) for estimate in own.values()])
        published = []
        for table in identification.experiment.published:
            if table.direction == direction and parameter in table.values:
                printed = [scale * value for value in table.values[parameter]]
                published.append(Points(table.rpm, printed, [0.0] * len(printed)))
        directions.append(DirectionPoints(direction, found, published))
    return OverRpm(parameter, unit_shown(parameter, identification.experiment.plant.axis), directions)


def draw_over_rpm(data: OverRpm, title: str) -> Figure:
    """The figure; without the thesis's method there is nothing but the axes."""
    with figure_style():
        figure, (axes,) = panels_of(1, title)
        for number, part in enumerate(data.directions):
            shift, colour = SHIFT * (2 * number - 1), COLOURS[number]
            found = part.found
            axes.errorbar(
                [rpm + shift for rpm in found.rpm],
                found.values,
                found.stds,
                fmt=marker(number),
                color=colour,
                capsize=2.0,
                clip_on=False,
                label=f"{part.direction}, found",
            )
            for table in part.published:
                label = f"{part.direction}, published"
                shifted = [rpm + shift for rpm in table.rpm]
                axes.plot(shifted, table.values, "x+"[number], color=colour, markersize=8.0, clip_on=False, label=label)
        axes.set_xlabel("rotation (rpm)")
        axes.set_ylabel(f"{_in_words(data.parameter)} ({data.unit})")
        axes.set_ylim(bottom=0.0)
        axes.legend(loc="best")
    return figure


def _in_words(parameter: str) -> str:
    what = parameter.replace("_", " ")
    return what if parameter == "stribeck_velocity" or "bristle" in parameter else f"{what} friction"
