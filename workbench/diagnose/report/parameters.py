"""What a diagnosis makes of each parameter: declared, fitted without and with effects, and whether that is sure."""

from dataclasses import dataclass

from plants.effects.attach import possible
from plants.equation import fields
from plants.interface import Plant
from workbench.diagnose.residuals.balances import richest
from workbench.diagnose.result import Diagnosis, FittedParameter
from workbench.parameters.sets import FLOW_SHARE


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
            final.setdefault(name, FittedParameter.of(number))
    return {name: Row(diagnosis.declared.get(name), baseline.get(name), fitted) for name, fitted in final.items()}


def plant_of(diagnosis: Diagnosis) -> Plant:
    """The plant that the corrected parameters are for."""
    return richest(diagnosis.experiment.plant)


def parameters_of(plant: Plant) -> set[str]:
    """The parameters that a plant can have, with its effects."""
    return {item.name for item in fields(plant.with_effects(*possible(plant)).Parameters)} - {FLOW_SHARE}


def not_held(diagnosis: Diagnosis) -> list[str]:
    """The effects that were found and that the plant cannot have."""
    known = parameters_of(plant_of(diagnosis))
    return [effect.name for effect in diagnosis.effects if not set(effect.parameters) <= known]
