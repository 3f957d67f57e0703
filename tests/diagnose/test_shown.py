"""On what the rates of a plant depend, by its recorded equations."""

import pytest

from plants.effects.registry import effects
from plants.interface import Plant
from plants.registry import PLANTS
from workbench.diagnose.residuals.shown import dependences
from workbench.linear.linearise import symbolic

IN_TIME = {"viscous_drift", "warming_share", "warming_time"}
"""Of effects that do nothing at the time for which a plant is linearised."""


def plant_of(name: str, *added: str) -> Plant:
    plant = PLANTS.working()[name]
    return (plant.bare or plant).with_effects(*(effects(plant.axis)[effect] for effect in added))


@pytest.mark.parametrize("name", ["non_rotating", "rotating_anisotropic", "pneumatic_cylinder", "two_mass_force"])
def test_rates_depend_on_what_their_derivatives_do(name: str) -> None:
    plant = plant_of(name, "backlash", "viscous_drift", "viscous_warming", "maxwell_slip")
    found, rates = dependences(plant), symbolic(plant)
    for argument, table in enumerate(found):
        pattern = rates.jac_sparsity(0, argument)
        asked = {state: len(on - IN_TIME) for state, on in table.items()}
        counted = dict.fromkeys(asked, 0)
        for row in pattern.row():
            counted[list(asked)[row]] += 1
        assert counted == asked


def test_a_rate_depends_on_parameters_of_what_acts_in_time() -> None:
    assert dependences(plant_of("non_rotating", "viscous_drift", "viscous_warming")).parameters["velocity"] >= IN_TIME
    assert not dependences(plant_of("non_rotating")).parameters["velocity"] & IN_TIME
