"""The case of a study that is exported: the only one, or the one that axes choose, on the machine as declared."""

from collections.abc import Mapping

import numpy as np

from workbench.errors import UserError, few_of, nearest
from workbench.study.cases import Cases
from workbench.study.names import in_words
from workbench.study.resolve import Resolved, resolve
from workbench.study.study import Case, Study, named
from workbench.study.unfold import unfold


def chosen_case(study: Study, where: Mapping[str, object], controller: str | None = None) -> tuple[Case, Resolved]:
    """The case that has these values of axes, and this controller, and what it runs.

    Raises:
        UserError: no such axis or controller, none or several such cases, or a mistake in it.
    """
    cases = unfold(study)
    for axis in where:
        if axis not in cases.axes:
            raise UserError(f"{study.path}: no axis {axis}; {nearest(axis, cases.axes)}")
    if controller is not None and controller not in study.file.controllers:
        raise UserError(f'{study.path}: no controller "{controller}"; {nearest(controller, study.file.controllers)}')
    if controller is not None and "controller" in cases.axes:
        where = {**where, "controller": controller}
    places = cases.where(where)
    if controller is not None:
        places = np.array([place for place in places if named(cases[int(place)], "controller") == controller], int)
    if places.size != 1:
        raise UserError(f"{study.path}: {_several(cases, places, where)}")
    case = cases[int(places[0])]
    return case, resolve(study, case)


def _several(cases: Cases, places: np.ndarray, where: Mapping[str, object]) -> str:
    """That there is not one case, and which axes would tell them apart."""
    if not places.size:
        return f"no case with {in_words(where)}; the axes are {_axes(cases.axes)}"
    values: dict[str, dict[str, object]] = {}
    for place in places.tolist():
        for axis, value in cases.columns(place).items():
            values.setdefault(axis, {})[str(value)] = value
    open_ones = {axis: [*found.values()] for axis, found in values.items() if len(found) > 1}
    return f"{places.size} cases, expected one; choose with --case AXIS=VALUE, of {_axes(open_ones)}"


def _axes(axes: Mapping[str, list[object]]) -> str:
    """Axes with their values."""
    return "; ".join(f"{axis}: {few_of(map(str, values), 80)}" for axis, values in axes.items()) or "none"
