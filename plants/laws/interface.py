"""What a friction law is: one object with its equation, what it remembers, and which parameters count."""

import typing
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple

from plants.bristles import BristleLaw
from plants.equation import Equation, Scalar, equation, retyped
from plants.friction import LuGre

STICK_TIME = 1e-4
"""s. In this time a law without memory brings a contact to rest that is about to stick. The stop is rounded by
a t^2, with a the deceleration: 0.3 um at 30 m/s^2. An explicit method takes steps of up to three times this."""


@equation
def held_force(acceleration: Scalar, velocity: Scalar, mass: Scalar) -> Scalar:
    """Force (N) of a contact that would bring the mass (kg) to rest within `STICK_TIME`: M (a + v / STICK_TIME).

    `acceleration` a (m/s^2) is that without friction.
    """
    return mass * (acceleration + velocity / STICK_TIME)


class Nothing(NamedTuple):
    """The memory of a law that has none, and the parameters of a law that needs no others than the contact's set."""


@dataclass(frozen=True, eq=False)
class FrictionLaw:
    """A friction law of a contact that slides along a line.

    friction(velocity, contact, held, parameters) -> (force, rates)
    steady(velocity, parameters) -> force           after a long time at that velocity

    Velocity in m/s, forces in N; `parameters` are a plant's: `friction` holds the contact's set for both directions
    (`plants.friction.Friction`), of which the law takes those numbers that `uses` names, and `law` what it has beside
    them, as `Extra`. `contact` is what the law remembers, a `Contact`, whose rates it gives. `held` (N) is the force
    that would bring the mass to rest within `STICK_TIME`: what drives it without friction, and m v / STICK_TIME.
    `plane` has the forms of the law for a rod that slides and turns, by the name of the bristle.

    A law with memory ignores `held`; one without has to stick by it.
    """

    name: str
    summary: str
    source: str
    friction: Callable[[Scalar, Any, Scalar, Any], tuple[Scalar, Any]]
    steady: Callable[[Scalar, Any], Scalar]
    uses: tuple[str, ...] = LuGre._fields
    Contact: type[NamedTuple] = Nothing
    Extra: type[NamedTuple] = Nothing
    plane: Mapping[str, BristleLaw] = field(default_factory=dict)


def fitted(law: FrictionLaw, *templates: type[NamedTuple]) -> tuple[type, ...]:
    """The classes of a plant's states, parameters and signals for a law, made from those for LuGre's.

    What the contact remembers is in their field `contact`; what the law has beside the contact's set is in the field
    `law` of the parameters, which have none for a law without such.
    """
    made = []
    for template in templates:
        own = typing.get_type_hints(template).get("contact")
        if own is None:
            nested = {} if law.Extra is Nothing else {"law": law.Extra}
        else:
            nested = {} if own._fields == law.Contact._fields else {"contact": law.Contact}
        made.append(retyped(template, law.name, **nested) if nested else template)
    return tuple(made)


def friction_of(law: FrictionLaw, free_acceleration: Equation) -> Equation:
    """The friction (N) on a mass that slides along a line, and the rates of what its contact remembers.

    Both equations are of (state, inputs, parameters); `free_acceleration` (m/s^2) is that of the mass without friction.
    """
    friction = law.friction

    @equation
    def on_mass(state: Any, inputs: Any, p: Any) -> tuple[Scalar, Any]:
        held = held_force(free_acceleration(state, inputs, p), state.velocity, p.body.mass)
        return friction(state.velocity, state.contact, held, p)

    return on_mass


def at_rest(law: FrictionLaw) -> NamedTuple:
    """What a contact remembers that has rested for long, without a load."""
    return law.Contact._make(0.0 for _ in law.Contact._fields)
