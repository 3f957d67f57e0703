"""A plant with an observer's corrections: of its motion and of what its contact remembers, by one innovation.

    dx_i/dt = f_i(t, x, u, p) + l_i e        i: position, velocity, and each state of the contact

The innovation e and the gains l_i (its state's unit per m s) are inputs, so that gains may go with time.
"""

import functools
from dataclasses import replace
from typing import Annotated, Any

from plants.equation import Scalar, equation, fields, from_array, gathered, leaves, named_tuple
from plants.interface import Plant

INNOVATION = "innovation"
"""The input that a measured position less the foreseen one drives."""

MOTION = ("position", "velocity")


def corrected(plant: Plant) -> tuple[str, ...]:
    """The states that are corrected."""
    remembered = fields(plant.State.__annotations__[plant.contact]) if plant.contact else ()
    return (*MOTION, *(item.name for item in remembered))


def gain_of(state: str) -> str:
    """The input that is a state's gain."""
    return f"gain_of_{state}"


@functools.cache
def observed(plant: Plant) -> Plant:
    """The plant with the innovation and the gains as further inputs, all of them 0 at rest."""
    own, names = len(plant.Inputs._fields), corrected(plant)
    state, units = plant.State, {item.name: item.unit for item in fields(plant.State)}
    places = [[item.name for item in fields(state)].index(name) for name in names]
    further: dict[str, Any] = {INNOVATION: Annotated[float, units["position"]]}
    further |= {gain_of(name): Annotated[float, f"{units[name]}/({units['position']} s)"] for name in names}
    bare_inputs, bare_rates, bare_signals, bare_rest = plant.Inputs, plant.derivatives, plant.signals, plant.equilibrium
    inputs_class = named_tuple(
        f"{bare_inputs.__name__}_{'_'.join(names)}",
        __name__,
        {**bare_inputs.__annotations__, **further},
        {**bare_inputs._field_defaults, **dict.fromkeys(further, 0.0)},
        "The plant's inputs, and what corrects its states.",
    )

    @equation
    def derivatives(time: Scalar, state_now: Any, inputs: Any, p: Any) -> Any:
        """Rates of the plant with its corrections."""
        rates = list(leaves(bare_rates(time, state_now, gathered(bare_inputs, inputs[:own]), p)))
        for place, gain in zip(places, inputs[own + 1 :], strict=True):
            rates[place] = rates[place] + gain * inputs[own]
        return from_array(state, rates)

    @equation
    def signals(time: Scalar, state_now: Any, inputs: Any, p: Any) -> Any:
        """The plant's signals."""
        return bare_signals(time, state_now, gathered(bare_inputs, inputs[:own]), p)

    def equilibrium(p: Any, surface_speed: float) -> tuple[Any, Any]:
        """At rest, where nothing is corrected."""
        at_rest, inputs = bare_rest(p, surface_speed)
        return at_rest, inputs_class(*inputs)

    return replace(plant, Inputs=inputs_class, derivatives=derivatives, signals=signals, equilibrium=equilibrium)
