"""Integrators against problems with known solutions: a pendulum, a linear plant under held inputs, blow-ups."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.linalg import expm
from scipy.special import ellipj, ellipk
from support import COLLAPSE, EXPLOSION, OSCILLATOR, PENDULUM, start

from workbench.simulation.integrators.interface import check
from workbench.simulation.integrators.ros34pw2 import ROS34PW2
from workbench.simulation.references import Recorded
from workbench.simulation.sensors import Sensors
from workbench.simulation.simulate import Feed, Integrator, Run, Setup, simulate, solver_error

HEIGHT = 2.0
"""rad: high enough for the pendulum to be far from a sine."""

SWING = start(PENDULUM, HEIGHT, stiffness=1.0, duration=8.0, sample_time=0.4)


def swing(time: np.ndarray) -> np.ndarray:
    """Angle of a pendulum let go at `HEIGHT`: sin(x/2) = k cn(t, k)/dn(t, k), k = sin(HEIGHT/2). Whittaker 1904."""
    modulus = np.sin(HEIGHT / 2.0)
    _, cn, dn, _ = ellipj(time, modulus**2)
    return 2.0 * np.arcsin(modulus * cn / dn)


def true_error(setup: Setup) -> tuple[Run, float]:
    """A run of the pendulum and how far its angle is off."""
    run = simulate(setup)
    assert run.outcome == "completed"
    return run, float(np.max(np.abs(run.state("position") - swing(run.time))))


def test_pendulum_solution_has_the_period_of_the_elliptic_integral() -> None:
    quarter = ellipk(np.sin(HEIGHT / 2.0) ** 2)
    assert swing(np.array([0.0, quarter, 4.0 * quarter])) == pytest.approx([HEIGHT, 0.0, HEIGHT], abs=1e-12)


@pytest.mark.parametrize(
    ("method", "order", "steps"),
    [("euler", 1, (4e-4, 2e-4, 1e-4)), ("heun", 2, (8e-3, 4e-3, 2e-3)), ("rk4", 4, (4e-2, 2e-2, 1e-2))],
)
def test_order_of_convergence_of_fixed_steps(method: str, order: int, steps: tuple[float, ...]) -> None:
    errors = [true_error(replace(SWING, integrator=Integrator(method, step)))[1] for step in steps]
    observed = np.log2(np.divide(errors[:-1], errors[1:]))
    assert observed == pytest.approx([order, order], abs=0.1)


def test_order_of_convergence_of_error_control() -> None:
    """With a tolerance that accepts everything each sample is one step: order 5 in the sample time."""
    setups = [replace(SWING, sample_time=h, integrator=Integrator(tolerance=1e3)) for h in (0.05, 0.025, 0.0125)]
    runs, errors = zip(*map(true_error, setups), strict=True)
    assert [run.steps for run in runs] == [160, 320, 640]
    observed = np.log2(np.divide(errors[:-1], errors[1:]))
    assert observed == pytest.approx([5.0, 5.0], abs=0.1)


def test_order_of_convergence_of_a_method_by_its_tableau() -> None:
    """As above, of the pair of order 3."""
    method = Integrator("bogacki_shampine", tolerance=1e3)
    setups = [replace(SWING, sample_time=h, integrator=method) for h in (0.02, 0.01, 0.005)]
    errors = [true_error(setup)[1] for setup in setups]
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx([3.0, 3.0], abs=0.1)


def test_order_of_convergence_of_an_implicit_method_by_its_tableau() -> None:
    """As above, of a pair of order 3: that of a swing, and of one that ramps push, which its steps see as df/dt."""
    method = Integrator("ros34pw2", tolerance=1e3)
    setups = [replace(SWING, sample_time=h, integrator=method) for h in (0.025, 0.0125, 0.00625)]
    errors = [true_error(setup)[1] for setup in setups]
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx([3.0, 3.0], abs=0.1)
    errors = []
    for h in (0.02, 0.01, 0.005):
        ramp = Feed("force", Recorded(np.array([0.0, 4.0]), np.array([0.0, 4.0])))
        pushed = start(OSCILLATOR, stiffness=4.0, duration=4.0, sample_time=h, feeds=(ramp,), integrator=method)
        run = simulate(pushed)
        errors.append(np.max(np.abs(run.state("position") - (run.time / 4.0 - np.sin(2.0 * run.time) / 8.0))))
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx([3.0, 3.0], abs=0.1)


def test_an_implicit_method_keeps_its_order_whatever_its_jacobian_is() -> None:
    """The order conditions of W-methods for the trees of up to three nodes (Hairer, Wanner 1996, section IV.7)."""
    method, count = ROS34PW2, ROS34PW2.count
    a, g = np.zeros((count, count)), np.zeros((count, count))
    for i, row in enumerate(method.stages, start=1):
        a[i, : len(row)] = row
    for i, row in enumerate(method.implicit):
        g[i, : len(row)] = row
    b, one = np.array(method.weights), np.ones(count)
    assert [b @ one, b @ a @ one, b @ g @ one] == pytest.approx([1.0, 0.5, 0.0], abs=1e-14)
    assert b @ (a @ one) ** 2 == pytest.approx(1.0 / 3.0, abs=1e-14)
    assert [b @ x @ y @ one for x in (a, g) for y in (a, g)] == pytest.approx([1.0 / 6.0, 0.0, 0.0, 0.0], abs=1e-14)
    embedded = b - np.array(method.errors)
    assert [embedded @ one, embedded @ (a + g) @ one] == pytest.approx([1.0, 0.5], abs=1e-14)


def test_an_implicit_method_takes_few_steps_of_a_stiff_plant() -> None:
    """k = 1e6 N/m and c = 1e6 N s/m: after a layer of 1e-6 s the mass creeps back by exp(-t). Explicit steps are as
    short as the layer for good.
    """
    stiff = start(OSCILLATOR, 1.0, stiffness=1e6, damping=1e6, duration=1.0, sample_time=0.01)
    explicit = simulate(stiff)
    implicit = simulate(replace(stiff, integrator=Integrator("ros34pw2")))
    assert implicit.steps < 3e-3 * explicit.steps
    rate = 0.5e6 * (1.0 - np.sqrt(1.0 - 4e-6))
    assert implicit.state("position") == pytest.approx(np.exp(-rate * implicit.time), abs=1e-5)


def test_a_tableau_that_is_none_is_told() -> None:
    for implicit in (ROS34PW2.implicit[:-1], ((0.4,), *ROS34PW2.implicit[1:])):
        with pytest.raises(ValueError, match="implicit: expected a row of i numbers"):
            check(replace(ROS34PW2, implicit=implicit))


@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-7, 1e-9])
def test_error_follows_the_tolerance(tolerance: float) -> None:
    """Each step errs by at most tolerance (1 + |x|); the pendulum adds them up to less than 10 times that."""
    _, error = true_error(replace(SWING, integrator=Integrator(tolerance=tolerance)))
    assert 1e-2 * tolerance < error < 10.0 * tolerance


@pytest.mark.parametrize(
    ("integrator", "ratio"),
    [
        (Integrator("euler", 1e-4), 1.0 / 2.0),
        (Integrator("heun", 2e-3), 3.0 / 4.0),
        (Integrator("rk4", 2e-2), 15.0 / 16.0),
        (Integrator("bogacki_shampine", tolerance=1e-6), 1.0),
        (Integrator("ros34pw2", tolerance=1e-6), 1.0),
        (Integrator(tolerance=1e-6), 0.88),
    ],
)
def test_own_error_estimate_is_close_to_the_true_error(integrator: Integrator, ratio: float) -> None:
    """Half the step of order p leaves 1/2^p of the error; the estimate is the rest, 1 - 1/2^p. A tolerance eight times
    smaller leaves 0.12 of it here, one a hundred times smaller next to nothing.
    """
    setup = replace(SWING, integrator=integrator)
    run, error = true_error(setup)
    assert solver_error(setup, run) == pytest.approx(ratio * error, rel=0.05)


@pytest.mark.parametrize("delay", [0.2, 0.5, 1.3])
def test_own_error_estimate_beside_a_delayed_sensor(delay: float) -> None:
    """A run stops where a delay ends: the run beside it takes two steps up to there too, wherever in a sample it is."""
    setup = replace(SWING, integrator=Integrator(tolerance=1.0), sensors=Sensors(delay=delay * SWING.sample_time))
    run, error = true_error(setup)
    assert 0.5 * error < solver_error(setup, run) < 1.5 * error


def test_fixed_step_is_shortened_to_fit_the_sample() -> None:
    run = simulate(replace(SWING, integrator=Integrator("rk4", 0.3)))
    assert run.steps == 2 * 20
    assert np.array_equal(run.states, simulate(replace(SWING, integrator=Integrator("rk4", 0.2))).states)


@pytest.mark.parametrize("integrator", [Integrator("rk4", 1e-4), Integrator(tolerance=1e-12)])
def test_held_input_at_sample_instants_is_the_zero_order_hold(integrator: Integrator) -> None:
    """A linear plant under held inputs is x(k+1) = Phi x(k) + Gamma u(k) with both from the matrix exponential."""
    k, c, h, samples = 900.0, 6.0, 1e-3, 400
    force = np.random.default_rng(3).normal(size=samples)
    time = h * np.arange(samples)
    run = simulate(
        start(
            OSCILLATOR,
            0.01,
            -0.2,
            stiffness=k,
            damping=c,
            duration=time[-1],
            feeds=(Feed("force", Recorded(time, force), linear=False),),
            integrator=integrator,
        )
    )
    transition = expm(h * np.array([[0.0, 1.0, 0.0], [-k, -c, 1.0], [0.0, 0.0, 0.0]]))
    expected = np.empty((samples, 2))
    expected[0] = 0.01, -0.2
    for i in range(samples - 1):
        expected[i + 1] = (transition @ [*expected[i], force[i]])[:2]
    assert run.inputs[:, 0] == pytest.approx(force, abs=1e-12)
    assert np.max(np.abs(run.states - expected)) < 1e-11


def test_growing_oscillation_is_outcome_diverged() -> None:
    """With c = -20 N s/m and k = 0 the speed is e^(20 t) times its start: beyond 1e6 (1 + 1) after 0.725 s."""
    setup = start(OSCILLATOR, 0.0, 1.0, damping=-20.0, duration=5.0)
    run = simulate(setup)
    assert run.outcome == "diverged"
    assert run.diverged
    assert run.time[-1] == pytest.approx(np.log(2e6) / 20.0, abs=1e-3)
    assert run.state("velocity") == pytest.approx(np.exp(20.0 * run.time), rel=1e-4)
    assert run.signals["position"].size == run.time.size
    assert solver_error(setup, run) is None


@pytest.mark.parametrize("method", ["euler", "heun", "rk4"])
def test_fixed_steps_through_infinity_diverge(method: str) -> None:
    """dx/dt = x^2 from 2 m is infinite at 0.5 s; explicit steps lag behind and overflow soon after."""
    run = simulate(start(EXPLOSION, 2.0, duration=5.0, integrator=Integrator(method, 1e-4)))
    assert run.outcome == "diverged"
    assert 0.49 < run.time[-1] < 0.51
    assert np.all(np.isfinite(run.states))


def test_error_control_stops_at_infinity() -> None:
    run = simulate(start(EXPLOSION, 2.0, duration=5.0))
    assert run.diverged
    assert run.time[-1] == pytest.approx(0.5, abs=1.5e-3)
    early = run.time < 0.45
    assert run.state("position")[early] == pytest.approx(2.0 / (1.0 - 2.0 * run.time[early]), rel=1e-5)


def test_infinite_slope_is_outcome_step_too_small() -> None:
    """sqrt(0.9995 - t) falls into 0 with an infinite slope in mid-sample, at which no step is short enough."""
    setup = start(COLLAPSE, np.sqrt(0.9995), duration=5.0)
    run = simulate(setup)
    assert run.outcome == "step too small"
    assert run.diverged
    assert run.time[-1] == pytest.approx(0.999, abs=1e-9)
    assert run.state("position") == pytest.approx(np.sqrt(0.9995 - run.time), abs=1e-4)
    assert solver_error(setup, run) is None
