"""What effects know of an instant of a plant, found in its own states, inputs and parameters."""

import typing
from typing import Any, NamedTuple

import numpy as np

from plants.effects.interface import Moment
from plants.equation import Equation, Scalar, equation, members, select
from plants.friction import helical_speed, length
from plants.interface import Plant
from plants.laws.interface import Nothing


def moment_of(plant: Plant) -> Equation:
    """What effects know of an instant of a plant, from time, state, inputs and parameters."""
    surface_speed = _surface_speed_of(plant)
    radius = _path(plant.Parameters, "motor", "piston_radius", otherwise=1.0)
    spool = _path(plant.State, "spool_position", otherwise=0.0)
    pressures_of, bend_of = _pressures_of(plant), _bend_of(plant)
    fluid = next((name for name in ("hydraulics", "pneumatics") if name in members(plant.Parameters)), "")
    gain = _path(plant.Parameters, fluid, "valve_position_gain", otherwise=0.0)
    limit = _path(plant.Parameters, fluid, "spool_limit", otherwise=0.0)
    stroke = _path(plant.Parameters, fluid, "stroke", otherwise=np.inf)
    if "stroke" in members(plant.Parameters):
        stroke = _path(plant.Parameters, "stroke", otherwise=np.inf)

    @equation
    def moment(time: Scalar, state: Any, inputs: Any, p: Any) -> Moment:
        surface, pressures = surface_speed(state, inputs), pressures_of(state, inputs, p)
        return Moment(
            time,
            state.position,
            state.velocity,
            surface,
            surface / radius(p),
            pressures[0],
            pressures[1],
            spool(state),
            stroke(p),
            gain(p),
            limit(p),
            bend_of(state, surface),
        )

    return moment


def _path(cls: type[NamedTuple], *names: str, otherwise: float) -> Equation:
    """What stands in a tuple of a class at a field, or at a field of a field; `otherwise` where it has none."""
    places = []
    for name in names:
        if name not in getattr(cls, "_fields", ()):
            return _constant(otherwise)
        places.append(cls._fields.index(name))
        cls = typing.get_type_hints(cls)[name]
    if len(places) == 1:
        (place,) = places

        @equation
        def member(value: Any) -> Any:
            return value[place]

        return member
    outer, inner = places

    @equation
    def nested_member(value: Any) -> Any:
        return value[outer][inner]

    return nested_member


def _constant(number: float) -> Equation:
    @equation
    def constant(value: Any) -> float:
        return number

    return constant


def _surface_speed_of(plant: Plant) -> Equation:
    """The speed (m/s) of the rod's surface, a state or an input; 0 of a rod that does not turn."""
    name = "surface_speed"
    by_state, by_input = _path(plant.State, name, otherwise=0.0), _path(plant.Inputs, name, otherwise=0.0)
    is_input = name in members(plant.Inputs)

    @equation
    def of_state(state: Any, inputs: Any) -> Any:
        return by_state(state)

    @equation
    def of_input(state: Any, inputs: Any) -> Any:
        return by_input(inputs)

    return of_input if is_input else of_state


def _pressures_of(plant: Plant) -> Equation:
    """Both pressures (Pa): inputs, or what the sensors of a plant show; NaN of one that has none."""
    shown = plant.measure

    @equation
    def of_input(state: Any, inputs: Any, p: Any) -> tuple[Scalar, Scalar]:
        return inputs.pressure_1, inputs.pressure_2

    @equation
    def of_sensors(state: Any, inputs: Any, p: Any) -> tuple[Scalar, Scalar]:
        readings = shown(state, p)
        return readings.pressure_1, readings.pressure_2

    return of_input if "pressure_1" in members(plant.Inputs) else of_sensors


def has_bristle(plant: Plant) -> bool:
    """Whether its contact is LuGre's, of one level along and around the rod."""
    return plant.friction == LUGRE and _contact_fields(plant) in (_ALONG, _PLANE)


LUGRE = "lugre"
_ALONG, _PLANE = ("bristle_deflection",), ("bristle_axial", "bristle_rotary")


def _contact_fields(plant: Plant) -> tuple[str, ...]:
    contact = typing.get_type_hints(plant.State).get(plant.contact)
    return getattr(contact, "_fields", ())


def _bend_of(plant: Plant) -> Equation:
    """The deflection (m) of LuGre's bristles in the direction of the motion; 0 of other contacts."""
    scalar = _path(plant.State, plant.contact, "bristle_deflection", otherwise=0.0)
    axial = _path(plant.State, plant.contact, "bristle_axial", otherwise=0.0)
    rotary = _path(plant.State, plant.contact, "bristle_rotary", otherwise=0.0)
    in_plane = _contact_fields(plant) == _PLANE
    turns = {"surface_speed"} & {*members(plant.State), *members(plant.Inputs)}

    @equation
    def along(state: Any, surface: Scalar) -> Any:
        return select(state.velocity >= 0.0, scalar(state), -scalar(state))

    @equation
    def helical(state: Any, surface: Scalar) -> Any:
        return scalar(state)

    @equation
    def plane(state: Any, surface: Scalar) -> Any:
        speed = helical_speed(state.velocity, surface)
        return (axial(state) * state.velocity + rotary(state) * surface) / speed

    @equation
    def none(state: Any, surface: Scalar) -> Any:
        return 0.0

    if not has_bristle(plant):
        return none
    if in_plane:
        return plane
    return helical if turns else along


def slip_of(plant: Plant) -> Equation:
    """The velocity (m/s) at which the contact slides: that of the surfaces less the rate at which bristles bend."""
    contact = typing.get_type_hints(plant.State).get(plant.contact)
    axial = _path(plant.State, plant.contact, "bristle_axial", otherwise=0.0)
    rotary = _path(plant.State, plant.contact, "bristle_rotary", otherwise=0.0)
    scalar = _path(plant.State, plant.contact, "bristle_deflection", otherwise=0.0)
    in_plane = "bristle_axial" in getattr(contact, "_fields", ())
    turns = {"surface_speed"} & {*members(plant.State), *members(plant.Inputs)}

    @equation
    def along(moment: Moment, rates: Any) -> Any:
        return moment.velocity - scalar(rates)

    @equation
    def helical(moment: Moment, rates: Any) -> Any:
        return length(moment.velocity, moment.surface_speed) - scalar(rates)

    @equation
    def plane(moment: Moment, rates: Any) -> Any:
        return length(moment.velocity - axial(rates), moment.surface_speed - rotary(rates))

    if in_plane:
        return plane
    return helical if turns else along


def memory_of(remembers: bool) -> Equation:
    """What all effects remember, out of the states of the plant that has them."""

    @equation
    def nothing(state: Any) -> Any:
        return Nothing()

    @equation
    def memory(state: Any) -> Any:
        return state.effects

    return memory if remembers else nothing
