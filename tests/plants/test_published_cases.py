"""Cylinders of other authors, rebuilt from what they print, held against the numbers that they print.

No measured step or stick-slip record of a differential or of a pneumatic cylinder could be had whose source also states
the whole machine. What could be read is calculation by others, independent of this program:

- D. Lipsker, Hyper-Pneumatics and Hyper-Hydraulics, interactive courses with their simulations (public repository,
  commit a97e47ce): a stroke of a cylinder of 32 mm with throttled exhaust in ms, the speed from which on it no longer
  sticks, the frequency of a single-rod cylinder on its oil at four places, the speed of a double-rod cylinder on a
  servo valve. Digits as printed; a fixed air temperature and an exponent of 1.4, as here.
- A. Esposito, Fluid Power with Applications, example 9-4 (inputs and formula as in FOSSEE's Scilab companion): the
  speed of a cylinder behind a metering valve, 14.5 in/s.
"""

from typing import Any

import numpy as np
import pytest

from plants.registry import plants
from workbench.parameters.sets import build
from workbench.simulation.references import Steps
from workbench.simulation.simulate import Feed, Run, Setup, simulate

Values = dict[str, float]

QUARTER = 0.25 * np.pi
ATMOSPHERE = 1.013e5
BORE, ROD = QUARTER * 0.032**2, QUARTER * 0.012**2
STOPS = {"end_stop_stiffness": 1e7, "end_stop_damping": 5.0}
PORTS = {"valve_position_gain": 1e-3, "valve_time_constant": 1e-4, "spool_limit": 1e-3, "voltage_limit": 1.0}
"""A valve that is wide open at 1 V, at once."""

FREE = {"coulomb": 0.0, "stribeck": 0.0, "stribeck_velocity": 0.01, "bristle_stiffness": 0.0, "bristle_damping": 0.0}


def in_series(*conductances: float) -> float:
    """Of throttles one behind the other."""
    return 1.0 / float(np.sqrt(sum(1.0 / each**2 for each in conductances)))


def run_of(model: str, values: Values, volts: Any, duration: float, sample_time: float = 1e-3, **start: float) -> Run:
    """A machine that begins in a state of its own."""
    plant = plants()[model]
    parameters = build(plant.Parameters, values)
    state, inputs = plant.equilibrium(parameters, 0.0)
    feeds = (Feed(plant.command, volts),)
    inputs = inputs._replace(**{plant.command: 0.0})
    return simulate(
        Setup(plant, parameters, state._replace(**start), inputs, duration, feeds=feeds, sample_time=sample_time)
    )


# --- air --------------------------------------------------------------------------------------------------------


def of_air(supply: float, intake: float, exhaust: float, static: float, coulomb: float, viscous: float) -> Values:
    """The cylinder of 32 and 12 mm with 2 kg; conductances in m^3/(s Pa), friction as shares of the largest force."""
    largest, stiffness = supply * BORE, 1e6
    return {
        "piston_area_1": BORE,
        "piston_area_2": BORE - ROD,
        "supply_pressure": supply,
        "ambient_pressure": ATMOSPHERE,
        "sonic_conductance": intake,
        "exhaust_gain": exhaust / intake,
        "critical_pressure_ratio": 0.3,
        "polytropic_exponent": 1.4,
        "mass": 2.0,
        "coulomb": coulomb * largest,
        "stribeck": (static - coulomb) * largest,
        "viscous": viscous,
        "bristle_stiffness": stiffness,
        "bristle_damping": float(np.sqrt(2.0 * stiffness)),
        **STOPS,
        **PORTS,
    }


@pytest.mark.parametrize(
    ("supply", "load", "begins", "cushion"),
    [(6e5, 0.2, 0.056, 0.418), (6e5, 0.0, 0.023, None), (4e5, 0.2, None, None)],
)
def test_a_stroke_of_a_pneumatic_cylinder_begins_and_ends_when_it_should(
    supply: float, load: float, begins: float | None, cushion: float | None
) -> None:
    """Out from the end against 0.2 of its force: it starts after 56 ms and is at its cushion after 418 ms.

    Without load it starts after 23 ms. Throttled at its exhaust it goes at 0.55 m/s (formula) or 0.54 m/s (simulation)
    whatever the supply.
    """
    hoses = 2e-6 + QUARTER * 0.004**2 * 0.8
    share = 0.03 + 8.0 / (supply * BORE)
    values = of_air(supply, 1.2e-8, in_series(1.2e-8, 0.4e-8), share, share, 60.0) | {
        "stroke": 0.2,
        "dead_volume_1": hoses,
        "dead_volume_2": hoses,
        "load_force": load * supply * BORE,
        "stribeck_velocity": 0.01,
    }
    switched = Steps((-1.0, *[1.0] * 60), 0.012)  # the valve takes 12 ms
    start = {"position": -0.1, "pressure_1": 0.0, "pressure_2": supply, "spool_position": -1e-3}
    run = run_of("pneumatic_cylinder", values, switched, 0.5, 1e-4, **start)
    way = run.state("position") + 0.1

    def after(distance: float) -> float:
        return float(run.time[np.argmax(way > distance)])

    if begins is not None:
        assert after(way[0] + 2e-4) == pytest.approx(begins, abs=1e-3)
    if cushion is not None:
        assert after(0.2 - 0.0172) == pytest.approx(cushion, abs=1e-3)
    assert 0.08 / (after(0.18) - after(0.1)) == pytest.approx(0.545, abs=0.01)


@pytest.mark.parametrize(
    ("speed", "seals", "sticks"),
    [(0.05, "standard", False), (0.02, "standard", False), (0.01, "standard", True), (0.005, "low friction", False)],
)
def test_a_pneumatic_cylinder_sticks_below_the_speed_that_its_seals_allow(
    speed: float, seals: str, sticks: bool
) -> None:
    """Standard seals go "smooth down to about 15-20 mm/s", those of low friction to 3 to 5 mm/s."""
    static, coulomb, stribeck_velocity, viscous = {
        "standard": (0.10, 0.055, 8e-3, 150.0),
        "low friction": (0.032, 0.029, 2e-3, 80.0),
    }[seals]
    throttle = (BORE - ROD) * speed / 1e5  # sonic, it passes this volume
    values = of_air(6e5, 0.8e-8, in_series(0.8e-8, throttle), static, coulomb, viscous) | {
        "stroke": 0.4,
        "dead_volume_1": 1.2e-5,
        "dead_volume_2": 1.2e-5,
        "load_force": 0.0,
        "stribeck_velocity": stribeck_velocity,
    }
    duration = min(0.3 / speed, 10.0)
    start = {"position": -0.18, "pressure_1": 6e5, "pressure_2": 6e5, "spool_position": 1e-3}
    run = run_of("pneumatic_cylinder", values, Steps((1.0,), duration), duration, **start)
    late = run.state("velocity")[run.time.size // 2 :]
    assert np.mean(late) == pytest.approx(speed, rel=0.2 if sticks else 0.01)  # of whole strokes, or of some jumps
    assert (np.min(late) < 0.02 * speed) == sticks


# --- oil --------------------------------------------------------------------------------------------------------


def of_oil(area_1: float, area_2: float, stroke: float, supply: float, flow_gain: float, mass: float) -> Values:
    """A cylinder without friction; the flow gain (m^3/(s Pa^0.5)) is that of an edge that is wide open."""
    return {
        "piston_area_1": area_1,
        "piston_area_2": area_2,
        "stroke": stroke,
        "hose_volume": 0.3e-3,
        "bulk_modulus": 1.4e9,
        "supply_pressure": supply,
        "tank_pressure": 0.0,
        "valve_flow_gain": flow_gain / PORTS["spool_limit"],
        "mass": mass,
        "load_force": 0.0,
        "viscous": 0.0,
        **FREE,
        **STOPS,
        **PORTS,
    }


@pytest.mark.parametrize(("share", "hertz"), [(0.1, 29.7), (0.5, 22.6), (0.62, 22.3), (0.9, 24.3)])
def test_a_single_rod_cylinder_swings_on_its_oil_at_the_published_frequency(share: float, hertz: float) -> None:
    """63 and 36 mm, 500 mm of stroke, 0.3 l of line each side, 1.4 GPa, 1000 kg, ports blocked."""
    area = QUARTER * 0.063**2
    values = of_oil(area, area - QUARTER * 0.036**2, 0.5, 2e7, 0.0, 1000.0)
    kicked = {"position": 0.5 * (share - 0.5), "velocity": 1e-3}
    run = run_of("cylinder", values, Steps((0.0,), 1.0), 1.0, 2e-4, **kicked)
    velocity = run.state("velocity")
    rising = np.flatnonzero((velocity[:-1] < 0.0) & (velocity[1:] >= 0.0))
    instants = run.time[rising] - velocity[rising] * 2e-4 / (velocity[rising + 1] - velocity[rising])
    assert 1.0 / np.mean(np.diff(instants)) == pytest.approx(hertz, abs=0.06)


def test_a_double_rod_cylinder_on_a_servo_valve_moves_as_published() -> None:
    """84 l/min at 70 bar, 80 and 45 mm, 140 bar against 17.46 kN: 0.46 m/s at a load pressure of 50.8 bar."""
    area, load = QUARTER * (0.080**2 - 0.045**2), 800.0 * 3.08 + 15e3
    values = of_oil(area, area, 2.0, 140e5, 84e-3 / 60.0 / np.sqrt(35e5), 800.0) | {"load_force": load}
    run = run_of("cylinder", values | {"viscous": 2e3}, Steps((1.0,), 1.5), 1.5, position=-0.9)
    assert run.state("velocity")[-1] == pytest.approx(0.46, rel=0.02)
    assert run.state("pressure_1")[-1] - run.state("pressure_2")[-1] == pytest.approx(50.8e5, rel=0.06)


def test_a_metered_cylinder_moves_as_the_textbook_says() -> None:
    """Cv of 1 gpm/psi^0.5, 3.14 in^2, 4000 lb, oil of 0.9, 1400 psi: 14.5 in/s, nothing in the way of the return."""
    psi, inch = 6894.757, 0.0254
    metering = 231.0 * inch**3 / 60.0 / np.sqrt(0.9 * psi)
    values = of_oil(3.14 * inch**2, 2.35 * inch**2, 1.0, 1400.0 * psi, metering, 100.0)
    values |= {"load_force": 4000.0 * 4.448222, "edge_gain_bt": 1e3, "viscous": 20.0}
    run = run_of("cylinder", values, Steps((1.0,), 1.0), 1.0, position=-0.4)
    assert run.state("velocity")[-1] / inch == pytest.approx(14.5, rel=0.02)
