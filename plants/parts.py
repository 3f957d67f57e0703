"""What machines are put together from beside their actuator: what all of them have, and how it is joined."""

import typing
from collections.abc import Mapping, Sequence
from typing import Annotated, Any, NamedTuple

from plants.actuators.interface import Actuator
from plants.equation import Equation, Scalar, equation, members, named_tuple
from plants.friction import Friction
from plants.hydraulics import Mass, end_stop_force
from plants.laws.interface import FrictionLaw, Nothing

HYDRAULIC_POWER = "hydraulic_power"


class Disturbed(NamedTuple):
    """The input of every machine behind its own."""

    disturbance_force: Annotated[float, "N"]


class Body(NamedTuple):
    """Parameters of every machine."""

    body: Mass
    friction: Friction


class MotionSignals(NamedTuple):
    position: Annotated[float, "m"]
    velocity: Annotated[float, "m/s"]
    acceleration: Annotated[float, "m/s^2"]


class FrictionSignals(NamedTuple):
    axial_friction: Annotated[float, "N"]


class PowerSignals(NamedTuple):
    """Of a machine that fluid drives: hydraulic, and with rotation the rotary power too (thesis 4.19)."""

    total_power: Annotated[float, "W"]


def joined(name: str, *parts: type[NamedTuple] | Mapping[str, type]) -> type:
    """A NamedTuple class with the members of several, or such as are named here, one behind another.

    Those with a default stand last, as a NamedTuple wants it.
    """
    members: dict[str, type] = {}
    defaults: dict[str, Any] = {}
    for part in parts:
        if isinstance(part, type):
            members |= typing.get_type_hints(part, include_extras=True)
            defaults |= part._field_defaults
        else:
            members |= part
    order = [*(key for key in members if key not in defaults), *defaults]
    return named_tuple(name, __name__, {key: members[key] for key in order}, defaults, f"Of the machine {name}.")


def own_of(law: FrictionLaw) -> dict[str, type]:
    """The parameters that a law has beside the contact's set, as a member of a machine's."""
    return {} if law.Extra is Nothing else {"law": law.Extra}


def given(cls: type, actuator: Actuator, own: Sequence[float], **rotary: float) -> NamedTuple:
    """Inputs of a machine that nothing disturbs: the actuator's own, and the rotary one, if there is such."""
    return cls(**dict(zip(members(actuator.Inputs), own, strict=True)), **rotary, disturbance_force=0.0)


def free_force_of(actuator: Actuator) -> Equation:
    """The force (N) on the mass less a friction: an equation (state, inputs, parameters, friction) -> force."""
    push, stroke = actuator.force, actuator.stroke

    @equation
    def free_force(state: Any, inputs: Any, p: Any, friction: Scalar) -> Scalar:
        stop = end_stop_force(state.position, state.velocity, stroke(p), p.body)
        return push(state, inputs, p) - friction - p.body.load_force - inputs.disturbance_force + stop

    return free_force
