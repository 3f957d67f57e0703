"""Setups that are simulated together: the same bits as one by one, whatever they differ in."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from support import COLLAPSE, OSCILLATOR, start

from controllers.pid import PID, Settings
from plants.registry import THESIS
from workbench.fitting.replay import Sampled
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.simulation import simulate as simulate_module
from workbench.simulation.references import Multisine, Sine
from workbench.simulation.sensors import Channel, Sensors
from workbench.simulation.simulate import Feed, Integrator, Loop, Run, Setup, simulate, simulate_together

VALUES = read_parameters(named_sets()["owen2001_simulation"])
FILTERED = Sensors({"position": Channel(noise=1e-6, resolution=1e-6, anti_alias=200.0)}, delay=2.3e-3)


def setups(count: int, **common: Any) -> list[Setup]:
    """The thesis's actuator in a loop of its own each, from elsewhere, with other friction."""
    made = []
    for i in range(count):
        parameters = build(THESIS.Parameters, {**VALUES, "coulomb": (0.5 + 0.2 * i) * VALUES["coulomb"]})
        state, inputs = THESIS.equilibrium(parameters, 0.0)
        state = state._replace(position=1e-3 * i)
        gains = PID.design(Settings(kp=300.0 + 40.0 * i), parameters, 1e-3)
        pull = Feed(THESIS.disturbance, Multisine(20.0 * i, 3.0, (1, 2)))
        given = {"reference": Sine(5e-3, 2.0), "feeds": (pull,), **common}
        made.append(Setup(THESIS, parameters, state, inputs, 0.3, Loop(PID, gains), **given))
    reference = made[0].reference
    return [replace(one, reference=reference) for one in made]


def is_same(run: Run, other: Run) -> bool:
    arrays = zip(
        (run.time, run.states, run.inputs, run.measurements, run.memory),
        (other.time, other.states, other.inputs, other.measurements, other.memory),
        strict=True,
    )
    return (
        run.outcome == other.outcome
        and run.steps == other.steps
        and all(np.array_equal(a, b, equal_nan=True) for a, b in arrays)
    )


@pytest.mark.parametrize(
    "common",
    [
        {},
        {"sensors": FILTERED},
        {"integrator": Integrator("bogacki_shampine", tolerance=1e-4)},
        {"integrator": Integrator("ros34pw2", tolerance=1e-4)},
        {"sensors": FILTERED, "integrator": Integrator("ros34pw2", tolerance=1e-3)},
        {"integrator": Integrator("rk4", 5e-5)},
        {"sensors": FILTERED, "integrator": Integrator("heun", 2e-5)},
        {"integrator": Integrator(tolerance=1e-4, fewest=3)},
    ],
)
def test_several_at_once_are_the_same_bits_as_one_by_one(common: dict[str, Any]) -> None:
    asked = setups(6, **common)  # four and two
    together = simulate_together(asked)
    assert all(is_same(run, simulate(one)) for run, one in zip(together, asked, strict=True))
    assert len({run.states.tobytes() for run in together}) == 6


def test_one_that_ends_early_leaves_the_others_as_they_are() -> None:
    """Masses on springs, one of which pushes; roots that fall into 0, at which no step is short enough; and one that
    swings so fast that it takes more steps than are allowed.
    """
    masses = [start(OSCILLATOR, 1.0, stiffness=stiffness, duration=2.0) for stiffness in (10.0, -4000.0, 20.0)]
    roots = [start(COLLAPSE, np.sqrt(end), duration=1.5) for end in (0.9995, 2.0, 0.4, 3.0, 1.2)]
    quick = [start(OSCILLATOR, 1.0, stiffness=k, duration=2.0, most_steps=4000.0) for k in (10.0, 1e10, 20.0)]
    for asked, early in (
        (masses, {1: "diverged"}),
        (roots, dict.fromkeys((0, 2, 4), "step too small")),
        (quick, {1: "too many steps"}),
    ):
        together = simulate_together(asked)
        assert {i: run.outcome for i, run in enumerate(together) if run.diverged} == early
        assert all(is_same(run, simulate(one)) for run, one in zip(together, asked, strict=True))


def test_commands_that_come_late_by_different_times_go_side_by_side() -> None:
    times, force = 1e-3 * np.arange(300), np.random.default_rng(7).normal(size=300)

    def late(delay: float) -> Setup:
        feed = Feed("force", Sampled(times, force), linear=False, delay=delay)
        return start(OSCILLATOR, duration=times[-1], feeds=(feed,))

    asked = [late(delay) for delay in (0.3e-3, 1.7e-3, 0.0, 2.2e-3, 1e-3)]
    together = simulate_together(asked)
    assert all(is_same(run, simulate(one)) for run, one in zip(together, asked, strict=True))


def test_those_that_are_not_alike_are_simulated_each_with_its_kin(monkeypatch: pytest.MonkeyPatch) -> None:
    sizes = list[int]()

    def counted(several: list[Setup], *given: Any) -> Any:
        sizes.append(len(several))
        return solved(several, *given)

    solved = simulate_module._solved
    monkeypatch.setattr(simulate_module, "_solved", counted)
    masses = [start(OSCILLATOR, 1.0, stiffness=10.0 + i, duration=0.5) for i in range(3)]
    asked = [masses[0], *setups(2), masses[1], start(OSCILLATOR, 1.0, duration=0.4), masses[2]]
    together = simulate_together(asked)
    assert sizes == [simulate_module.LANES, simulate_module.LANES, 1]
    assert all(is_same(run, simulate(one)) for run, one in zip(together, asked, strict=True))


def test_nothing_is_simulated_where_nothing_is_asked_for() -> None:
    assert simulate_together([]) == []
