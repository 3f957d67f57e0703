"""Small plants with known solutions, defined as another package would define its own, and how tests start them."""

from collections.abc import Callable
from dataclasses import replace
from typing import Annotated, Any, NamedTuple

import numpy as np

from controllers.interface import Reference
from controllers.pid import PID
from plants.equation import Scalar, equation
from plants.hydraulics import Mass, end_stop_force
from plants.interface import Measurement, Plant
from plants.motor import LIMITS
from plants.registry import plants
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation.simulate import Loop, Setup


class State(NamedTuple):
    position: Annotated[float, "m", 1.0]
    velocity: Annotated[float, "m/s", 1.0]


class Inputs(NamedTuple):
    force: Annotated[float, "N"]
    pull: Annotated[float, "N"]


class Parameters(NamedTuple):
    body: Mass
    stiffness: Annotated[float, "N/m"]
    damping: Annotated[float, "N s/m"]
    stroke: Annotated[float, "m"] = np.inf
    force_limit: Annotated[float, "N"] = np.inf


@equation
def oscillator_derivatives(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> State:
    """M dv/dt = force + pull - k x - c v + end stops: linear inside the stroke."""
    stop = end_stop_force(state.position, state.velocity, p.stroke, p.body)
    force = inputs.force + inputs.pull + stop - p.stiffness * state.position - p.damping * state.velocity
    return State(state.velocity, force / p.body.mass)


@equation
def pendulum_derivatives(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> State:
    """M dv/dt = -k sin(x): swings of any height, solved by Jacobi's elliptic functions."""
    return State(state.velocity, -p.stiffness * np.sin(state.position) / p.body.mass)


@equation
def explosion_derivatives(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> State:
    """dx/dt = x^2, solved by x0 / (1 - x0 t): infinite at t = 1 / x0."""
    return State(state.position**2, 0.0)


@equation
def collapse_derivatives(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> State:
    """dx/dt = -1 / (2 x), solved by sqrt(x0^2 - t): the slope is infinite at t = x0^2, the state is not."""
    return State(-0.5 / state.position, 0.0)


@equation
def signals(time: Scalar, state: State, inputs: Inputs, p: Parameters) -> State:
    """The states."""
    return state


@equation
def measure(state: State, p: Parameters) -> Measurement:
    """Position, and the velocity in the place of a pressure."""
    return Measurement(state.position, state.velocity, np.nan, np.nan)


def equilibrium(p: Parameters, surface_speed: float) -> tuple[State, Inputs]:
    """At rest at the origin."""
    return State(0.0, 0.0), Inputs(0.0, 0.0)


def force_limit(p: Parameters) -> float:
    """Limit of the force (N)."""
    return p.force_limit


def _plant(name: str, derivatives: Callable[..., State]) -> Plant:
    summary, balances = f"{name}, for tests", {"force": "velocity"}
    classes = (State, Inputs, Parameters, State)
    return Plant(name, summary, *classes, derivatives, signals, measure, equilibrium, force_limit, "force", balances)


OSCILLATOR = _plant("oscillator", oscillator_derivatives)
PENDULUM = _plant("pendulum", pendulum_derivatives)
EXPLOSION = _plant("explosion", explosion_derivatives)
COLLAPSE = _plant("collapse", collapse_derivatives)


def start(
    plant: Plant,
    position: float = 0.0,
    velocity: float = 0.0,
    *,
    stiffness: float = 0.0,
    damping: float = 0.0,
    limit: float = np.inf,
    duration: float = 1.0,
    **options: Any,
) -> Setup:
    """A run of one of the plants above with a mass of 1 kg."""
    parameters = Parameters(Mass(1.0, 0.0, 0.0, 0.0), stiffness, damping, np.inf, limit)
    return Setup(plant, parameters, State(position, velocity), Inputs(0.0, 0.0), duration, **options)


def registered(
    name: str,
    values: str = "owen2001_simulation",
    *,
    rpm: float = 0.0,
    flow: str = "derived",
    motor_limits: bool = True,
    **options: Any,
) -> Setup:
    """A run of a registered plant with a named parameter set, at rest in mid-stroke."""
    plant, numbers = plants()[name], dict(read_parameters(named_sets()[values]))
    if not motor_limits:
        numbers |= dict.fromkeys(LIMITS, np.inf)
    parameters = build(plant.Parameters, numbers, flow)
    state, inputs = plant.equilibrium(parameters, rpm * 2.0 * np.pi / 60.0 * numbers.get("piston_radius", 0.0))
    return Setup(plant, parameters, state, inputs, **options)


def hydraulic(loop_gain: float = 500.0, duration: float = 2.0, friction: bool = True, **changes: Any) -> Setup:
    """The non-rotating actuator under P control, with changes of its hydraulics and of its load force."""
    setup = registered("non_rotating", duration=duration)
    p = setup.parameters
    body = p.body._replace(load_force=changes.pop("load_force", 0.0))
    contact = p.friction
    if not friction:
        none = contact.positive._replace(coulomb=0.0, stribeck=0.0, bristle_stiffness=0.0)
        contact = contact._replace(positive=none, negative=none)
    truth = p._replace(hydraulics=p.hydraulics._replace(**changes), body=body, friction=contact)
    gains = PID.design(PID.Settings(kp=loop_gain), p, setup.sample_time)
    return replace(setup, parameters=truth, loop=Loop(PID, gains))


def replayed_commands(
    loop: Loop, readings: list[Measurement], wanted: list[tuple[float, float, float]], sample_time: float
) -> np.ndarray:
    """Commands of a loop's plain equations over readings and what is wanted, as asked for and all realised."""
    controller, gains = loop.controller, loop.gains
    state, commands = controller.start(readings[0], gains), []
    for reading, point in zip(readings, wanted, strict=True):
        command, state = controller.step(Reference(*point), reading, state, gains, sample_time)
        state = controller.commit(float(command), state, gains, sample_time)
        commands.append(float(command))
    return np.array(commands)
