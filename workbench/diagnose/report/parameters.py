"""What a diagnosis makes of each parameter: declared, fitted without and with effects, and whether that is sure."""

from dataclasses import dataclass

from plants.equation import fields
from plants.registry import PLANTS
from workbench.diagnose.result import Diagnosis, FittedParameter
from workbench.parameters.sets import FLOW_SHARE

HYDRAULIC = "non_rotating"
RICHER = "two_chamber"
"""The plant that holds what a diagnosis of a hydraulic actuator may find."""


@dataclass(frozen=True)
class Row:
    """One parameter (SI): as declared, and as fitted without effects (`baseline`) and with what was found (`final`)."""

    declared: float | None
    baseline: FittedParameter | None
    final: FittedParameter


def parameter_rows(diagnosis: Diagnosis) -> dict[str, Row]:
    """Every parameter that was fitted, by name."""
    baseline, final = diagnosis.baseline_parameters, dict(diagnosis.fitted_parameters)
    for effect in diagnosis.effects:
        for name, number in effect.parameters.items():
            final.setdefault(name, FittedParameter(number.value, number.std, number.is_known))
    return {name: Row(diagnosis.declared.get(name), baseline.get(name), fitted) for name, fitted in final.items()}


def plant_of(diagnosis: Diagnosis) -> str:
    """The model that the corrected plant is for."""
    return RICHER if diagnosis.experiment.plant.name == HYDRAULIC else diagnosis.experiment.plant.name


def parameters_of(model: str) -> set[str]:
    """The parameters that a model holds."""
    return {item.name for item in fields(PLANTS.working()[model].Parameters)} - {FLOW_SHARE}


def not_held(diagnosis: Diagnosis) -> list[str]:
    """The effects that were found and that the plant's model cannot hold."""
    known = parameters_of(plant_of(diagnosis))
    return [effect.name for effect in diagnosis.effects if not set(effect.parameters) <= known]
