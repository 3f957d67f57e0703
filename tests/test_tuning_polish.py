"""The closed loop's exact gradient against the simulation and finite differences, and the polish along it."""

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support import registered

from controllers.interface import Controller
from controllers.pid import PID
from controllers.registry import controllers
from controllers.settings import usable
from controllers.speed_servo import SPEED_SERVO
from plants.equation import equation, fields, from_array, to_array
from workbench.errors import UserError
from workbench.simulation.references import ReferenceSignal, Sine, Steps
from workbench.simulation.sensors import Channel, Sensors
from workbench.simulation.simulate import Feed, Integrator, Loop, Setup, simulate
from workbench.tune.polish import Bound, PolishCase, PolishProblem, polish
from workbench.tune.sensitivity import ClosedLoop, closed_loop, not_served

H = 1e-3
SINE = Sine(20e-3, 0.5)

BOTH_LAWS = [
    (name, law)
    for name in ("static_map", "tafazoli", "friedland_park", "lugre", "lugre_adaptive", "ekf")
    for law in ("acceleration_feedback", "valve_inversion")
]
ALL = [("pid", None), ("nonlinear_pi", None), ("disturbance_observer", None), ("dither", None), *BOTH_LAWS]


def tracking(
    name: str,
    duration: float,
    plant: str = "non_rotating",
    reference: ReferenceSignal = SINE,
    rpm: float = 0.0,
    **chosen: Any,
) -> tuple[Setup, Controller, Any]:
    """A run of a controller that believes the plant to be as it is; the controller of its settings; the settings."""
    setup = registered(plant, duration=duration, reference=reference, rpm=rpm)
    controller = controllers()[name]
    settings = controller.Settings(**({"kp": 500.0, "ki": 200.0, "kd": 1.0} if name == "pid" else {}) | chosen)
    if controller.choose is not None:
        controller = controller.choose(settings, setup.parameters)
    gains = controller.design(settings, setup.parameters, H)
    return replace(setup, loop=Loop(controller, gains)), controller, settings


def deviations(loop: ClosedLoop, integrator: Integrator | None = None) -> float:
    """Largest distance (m) between the positions of the differentiated and the simulated loop."""
    run = simulate(replace(loop.setup, integrator=integrator or loop.setup.integrator))
    return float(np.max(np.abs(loop.positions(to_array(loop.setup.loop.gains)) - run.state("position"))))


@pytest.mark.parametrize(("name", "chosen"), [("pid", {}), ("lugre", {"law": "valve_inversion"})])
def test_positions_are_those_of_the_simulation(name: str, chosen: dict[str, str]) -> None:
    setup, _, _ = tracking(name, 2.0, **chosen)
    assert deviations(closed_loop(setup, 0, 2000)) < 1e-7


@pytest.mark.parametrize(
    ("plant", "rpm", "substeps"),
    [("rotating_helical", 230.0, 6), ("rotating_anisotropic", 230.0, 6), ("two_chamber", 0.0, 4)],
)
def test_other_plants_agree_with_steps_as_fine_as_their_bristles_need(plant: str, rpm: float, substeps: int) -> None:
    setup, _, _ = tracking("pid", 0.4, plant, rpm=rpm)
    loop = closed_loop(setup, 0, 400)
    assert loop.substeps == substeps
    assert deviations(loop) < 1e-7


def test_saturated_steps_and_a_held_load_are_those_of_the_simulation() -> None:
    """A step of 25 mm saturates the voltage; the drive's force holds a load beside what the controller adds."""
    setup, _, _ = tracking("pid", 0.5, reference=Steps((25e-3,), 1.0, start=0.1))
    assert np.max(simulate(setup).command) == 10.0
    assert deviations(closed_loop(setup, 0, 500)) < 1e-6
    setup, _, _ = tracking("pid", 0.5, "drive_force", kp=1e5, kd=2e3)
    parameters = setup.parameters._replace(body=setup.parameters.body._replace(load_force=300.0))
    state, inputs = setup.plant.equilibrium(parameters, 0.0)
    loaded = replace(setup, parameters=parameters, state=state, inputs=inputs)
    loop = closed_loop(loaded, 0, 500)
    assert deviations(loop, Integrator("rk4", H / loop.substeps)) < 1e-12


@pytest.mark.parametrize(("name", "law"), ALL)
def test_every_controller_is_differentiated_exactly(name: str, law: str | None) -> None:
    """By each setting that moves the error: positions to rounding, central differences to 1e-6 of the largest effect.

    The effect is that of a change by the setting's own size; kinks and rounding leave the small ones less exact. The
    frequency of a dither and a Kalman filter's noise bend the error too much for differences that rounding spares.
    """
    chosen = {"law": law} if law else {}
    setup, controller, settings = tracking(name, 0.3, **chosen)
    loop = closed_loop(setup, 50, 300, substeps=2)
    assert deviations(loop, Integrator("rk4", H / 2.0)) < 1e-12
    gains = to_array(setup.loop.gains)
    _, gradient = loop.value_and_gradient(gains)
    assert np.all(np.isfinite(gradient))
    exact, differences = [], []
    for item in usable(controller).values():
        value = getattr(settings, item.name)
        if not item.unit or not value or item.name == "frequency" or item.name.endswith("_noise"):
            continue
        step = 1e-5 * value
        above, below = (
            to_array(controller.design(settings._replace(**{item.name: value + side}), setup.parameters, H))
            for side in (step, -step)
        )
        exact.append(gradient @ (above - below) * value / (2.0 * step))
        differences.append((loop.value(above) - loop.value(below)) * value / (2.0 * step))
    assert np.max(np.abs(exact)) > 0.0
    np.testing.assert_allclose(exact, differences, rtol=0.0, atol=1e-6 * np.max(np.abs(exact)))


@pytest.mark.parametrize(
    ("name", "chosen", "moved"), [("pid", {}, "proportional"), ("lugre", {"law": "valve_inversion"}, "position_rate")]
)
def test_gradient_is_that_of_the_simulation(name: str, chosen: dict[str, str], moved: str) -> None:
    """By a gain on the position's error: K_p, k_p. The exact solver's mean square moves as the gradient says."""
    setup, controller, _ = tracking(name, 2.0, **chosen)
    loop = closed_loop(setup, 500, 2000)
    gains = to_array(setup.loop.gains)
    gain = [item.name for item in fields(controller.Gains)].index(moved)
    _, gradient = loop.value_and_gradient(gains)

    def simulated(factor: float) -> float:
        changed = gains.copy()
        changed[gain] *= factor
        fine = replace(
            setup, loop=Loop(controller, from_array(controller.Gains, changed)), integrator=Integrator(tolerance=1e-9)
        )
        return float(np.mean(simulate(fine).signals["error"][500:] ** 2))

    slope = (simulated(1.001) - simulated(0.999)) / (0.002 * gains[gain])
    assert gradient[gain] == pytest.approx(slope, rel=1e-3)


def test_roots_have_slope_zero_at_rest() -> None:
    """Tafazoli's map holds |v|^(1/2), whose slope at the standing start of every run is infinite."""
    setup, _, _ = tracking("tafazoli", 0.3, reference=Steps((5e-3,), 1.0, start=0.1))
    value, gradient = closed_loop(setup, 0, 300).value_and_gradient(to_array(setup.loop.gains))
    assert value > 0.0
    assert np.all(np.isfinite(gradient))


def test_a_loop_that_diverges_has_an_infinite_value() -> None:
    setup, _, _ = tracking("pid", 0.3, "drive_force", ki=0.0)
    loop = closed_loop(setup, 0, 300)
    wild = setup.loop.gains._replace(proportional=-1e12)
    value, gradient = loop.value_and_gradient(to_array(wild))
    assert value == np.inf
    assert np.all(np.isnan(gradient))


def test_polish_raises_the_gain_of_p_control() -> None:
    """Lag falls as 1 / K_p: the best K_p within the bounds is the upper one, with 3/5 of the start's error."""
    setup, _, _ = tracking("pid", 2.0, ki=0.0, kd=0.0)
    problem = PolishProblem(
        (PolishCase(setup, 500, 2000, 1e3),),
        PID,
        PID.Settings(kp=300.0),
        setup.parameters,
        {"kp": Bound(100.0, 500.0, logarithmic=True)},
    )
    polished = polish(problem)

    def exact(settings: Any) -> float:
        gains = PID.design(settings, setup.parameters, H)
        return float(
            1e3 * np.sqrt(np.mean(simulate(replace(setup, loop=Loop(PID, gains))).signals["error"][500:] ** 2))
        )

    assert polished.settings.kp == pytest.approx(500.0, rel=1e-9)
    assert polished.start_value == pytest.approx(exact(problem.settings), rel=1e-4)
    assert polished.value == pytest.approx(exact(polished.settings), rel=1e-4)
    assert polished.value == pytest.approx(0.6 * polished.start_value, rel=0.03)
    assert polished.reason == "a further step gains next to nothing"
    assert polished.gradient_evaluations < 15


def test_polish_finds_an_optimum_within_the_bounds_and_keeps_to_its_allowance() -> None:
    """The feed-forward of P control over two sines: its optimum makes up for the lag of the valve as well."""
    cases = []
    for amplitude in (10e-3, 20e-3):
        setup, _, _ = tracking("pid", 1.5, reference=Sine(amplitude, 1.0))
        cases.append(PolishCase(setup, 500, 1500, 0.5 / amplitude))
    settings = PID.Settings(kp=300.0)
    bounds = {"feedforward": Bound(0.0, 2.0, logarithmic=False), "kp": Bound(250.0, 400.0, logarithmic=True)}
    problem = PolishProblem(tuple(cases), PID, settings, cases[0].setup.parameters, bounds)
    polished = polish(problem)
    assert polished.value < 0.2 * polished.start_value
    assert 0.9 < polished.settings.feedforward < 1.4
    short = polish(problem, evaluations=2)
    assert short.gradient_evaluations == 2
    assert short.reason == "stopped after 2 evaluations, as asked"
    assert polished.value <= short.value <= short.start_value
    again = polish(replace(problem, settings=polished.settings))
    assert again.value <= again.start_value


def test_settings_without_effect_are_given_back() -> None:
    setup, _, _ = tracking("pid", 0.3)
    problem = PolishProblem(
        (PolishCase(setup, 0, 300, 1.0),),
        PID,
        PID.Settings(kp=500.0),
        setup.parameters,
        {"velocity_time_constant": Bound(1e-3, 1e-2, logarithmic=True)},
    )
    polished = polish(problem)
    assert polished.settings == problem.settings
    assert polished.value == polished.start_value
    assert polished.reason == "no setting moves the objective"


def branching(reference: Any, measurement: Any, state: Any, gains: Any, sample_time: Any) -> Any:
    """P control with an `if`."""
    error = reference.position - measurement.position
    return (gains.proportional * error if error > 0.0 else 0.0), state


def losing(reference: Any, measurement: Any, state: Any, gains: Any, sample_time: Any) -> Any:
    """P control with a sign that a symbol does not survive: it becomes a plain 1."""
    error = reference.position - measurement.position
    return gains.proportional * abs(error) * math.copysign(1.0, error), state


def test_equations_that_lose_a_symbol_are_found_out() -> None:
    setup, _, _ = tracking("pid", 1.5, ki=0.0, kd=0.0)
    lost = Loop(replace(PID, step=equation(losing)), setup.loop.gains)
    with pytest.raises(UserError, match=r"^no gradient for this run: by fixed steps and symbols its error is .* m rms"):
        closed_loop(replace(setup, loop=lost), 0, 1500)


def test_what_is_not_served_says_why() -> None:
    setup, _, _ = tracking("pid", 0.3)
    assert not_served(setup) is None
    servo = Loop(SPEED_SERVO, None)
    branched = replace(PID, step=branching)
    reasons = {
        "it has no reference: the loop is open": replace(setup, reference=None),
        "its rotation is controlled": replace(setup, rotary=servo),
        "an input of its plant is fed with a signal": replace(setup, feeds=(Feed("disturbance_force", SINE),)),
        "its sensors are delayed": replace(setup, sensors=Sensors(delay=1e-3)),
        "its sensor of position is not ideal": replace(setup, sensors=Sensors({"position": Channel(resolution=1e-5)})),
        "the equations of pid on non_rotating take no symbols": replace(setup, loop=Loop(branched, setup.loop.gains)),
    }
    for reason, changed in reasons.items():
        assert str(not_served(changed)).startswith(reason)
        with pytest.raises(UserError, match=f"^no gradient for this run: {reason}"):
            closed_loop(changed, 0, 300)


def test_mistakes_are_named() -> None:
    setup, _, _ = tracking("pid", 0.3)
    case = PolishCase(setup, 0, 300, 1.0)
    problem = PolishProblem(
        (case,), PID, PID.Settings(kp=500.0), setup.parameters, {"kp": Bound(100.0, 400.0, logarithmic=True)}
    )
    with pytest.raises(UserError, match=r"^kp is 500, expected a value within its bounds 100 to 400$"):
        polish(problem)
    with pytest.raises(UserError, match=r'^pid has no numeric setting "feedforwad"; did you mean "feedforward"\?$'):
        polish(replace(problem, bounds={"feedforwad": Bound(0.0, 1.0, logarithmic=False)}))
    with pytest.raises(UserError, match=r"^ki: bounds from 0 have no logarithm; expected a lower one above 0$"):
        polish(replace(problem, bounds={"ki": Bound(0.0, 1.0, logarithmic=True)}))
    with pytest.raises(UserError, match=r"^case 1: window of samples 0 to 301, expected one within 0 to 300$"):
        polish(replace(problem, cases=(replace(case, last=301),), bounds={"kp": Bound(100.0, 600.0, logarithmic=True)}))
    refused = replace(problem, settings=PID.Settings(kp=200.0, velocity_time_constant=0.0))
    with pytest.raises(UserError, match=r"^pid: velocity_time_constant is 0, expected a value above 0$"):
        polish(refused)
    with pytest.raises(UserError, match=r"^0 evaluations, expected at least 1$"):
        polish(refused, evaluations=0)
    with pytest.raises(UserError, match=r"^nothing to polish"):
        polish(replace(problem, cases=()))
