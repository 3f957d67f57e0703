"""What a diagnosis makes of each parameter: declared, fitted without and with effects, and whether that is sure."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from plants.equation import fields
from plants.registry import PLANTS
from workbench.diagnose.diagnose import Diagnosis
from workbench.diagnose.result import IDENTIFIED
from workbench.parameters.sets import FLOW_SHARE

HYDRAULIC = "non_rotating"
RICHER = "two_chamber"
"""The plant that holds what a diagnosis of a hydraulic actuator may find."""


ENDED = "the fit ran to the end of its range"
VAGUE = "its standard deviation exceeds half its value"
"""Why a parameter is not identified."""


@dataclass(frozen=True)
class Fitted:
    """A fitted value with its standard deviation (SI); `doubt` says why it is not identified, and is empty if it is."""

    value: float
    std: float
    doubt: str


@dataclass(frozen=True)
class Row:
    """One parameter (SI): as declared, and as fitted without effects (`baseline`) and with what was found (`final`)."""

    declared: float | None
    baseline: Fitted | None
    final: Fitted


def parameter_rows(found: Diagnosis) -> dict[str, Row]:
    """Every parameter that was fitted, by name."""
    baseline, final = (_fitted(found.report[key]) for key in ("baseline", "fitted"))
    for one in found.found:
        for name, (value, std) in one.numbers.items():
            final.setdefault(name, Fitted(value, std, _doubt(value, std, sure=std < IDENTIFIED * abs(value))))
    return {name: Row(found.declared.get(name), baseline.get(name), fitted) for name, fitted in final.items()}


def _fitted(data: Mapping[str, Mapping[str, Any]]) -> dict[str, Fitted]:
    return {
        name: Fitted(one["value"], one["std"], _doubt(one["value"], one["std"], sure=one["identified"]))
        for name, one in data.items()
    }


def _doubt(value: float, std: float, *, sure: bool) -> str:
    if sure:
        return ""
    return ENDED if std < IDENTIFIED * abs(value) else VAGUE


def plant_of(found: Diagnosis) -> str:
    """The model that the corrected plant is for."""
    return RICHER if found.experiment.plant.name == HYDRAULIC else found.experiment.plant.name


def parameters_of(model: str) -> set[str]:
    """The parameters that a model holds."""
    return {item.name for item in fields(PLANTS.working()[model].Parameters)} - {FLOW_SHARE}


def not_held(found: Diagnosis) -> list[str]:
    """The effects that were found and that the plant's model cannot hold."""
    known = parameters_of(plant_of(found))
    return [one.name for one in found.found if not set(one.numbers) <= known]
