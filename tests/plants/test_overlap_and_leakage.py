"""Overlap of the valve and leakage past the seal: by formula, and in the loop."""

from dataclasses import replace

import numpy as np
import pytest
from support import hydraulic, registered

from plants.equation import fields, from_array
from plants.hydraulics import valve_opening
from plants.interface import Plant
from plants.registry import plants
from workbench.parameters.sets import named_sets, read_parameters
from workbench.simulation.references import Steps
from workbench.simulation.simulate import Integrator, simulate

HYDRAULIC = [item for item in plants().values() if item.command == "valve_voltage"]
TRUTH = read_parameters(named_sets()["owen2001_simulation"])
GAIN = 500.0
ONE_PRESSURE = [item for item in HYDRAULIC if "load_pressure" in item.State._fields]


@pytest.mark.parametrize("plant", ONE_PRESSURE, ids=lambda plant: plant.name)
def test_ideal_valve_and_seal_change_no_bit(plant: Plant) -> None:
    """At 0 overlap and leakage the flow and pressure equations are those of the thesis, (3.22) and (3.28), exactly."""
    p = registered(plant.name, duration=1.0).parameters
    h = p.hydraulics
    assert (h.valve_overlap, h.leakage_coefficient) == (0.0, 0.0)
    random = np.random.default_rng(4)
    scales = np.array([item.scale for item in fields(plant.State)])
    inputs = from_array(plant.Inputs, np.zeros(len(fields(plant.Inputs))))
    area = 0.5 * (h.piston_area_1 + h.piston_area_2)
    for _ in range(100):
        state = from_array(plant.State, scales * random.normal(size=scales.size))
        spool, pressure = state.spool_position, state.load_pressure
        drop = h.supply_pressure - h.tank_pressure - np.sign(spool) * pressure
        flow = h.valve_flow_gain * spool * np.sqrt(max(h.flow_pressure_share * drop, 0.0))
        rate = 4.0 * h.bulk_modulus / (2.0 * h.hose_volume + area * h.stroke) * (flow - area * state.velocity)
        if abs(pressure) < h.supply_pressure:
            assert plant.derivatives(0.0, state, inputs, p).load_pressure == rate


def test_opening_of_an_overlapped_valve() -> None:
    h = registered("non_rotating", duration=1.0).parameters.hydraulics
    h = h._replace(valve_overlap=6e-6, valve_overlap_negative=6e-6)
    spool = np.array([-1e-4, -6e-6, -5.9e-6, 0.0, 6e-6, 7e-6, 6e-4])
    assert valve_opening(spool, h) == pytest.approx([-9.4e-5, 0.0, 0.0, 0.0, 0.0, 1e-6, 5.94e-4], abs=1e-18)


@pytest.mark.parametrize("load_force", [-600.0, 300.0])
def test_leakage_under_load_leaves_the_error_of_its_flow(load_force: float) -> None:
    """P_L = F / A leaks C P_L, which the valve must feed: e = C P_L / (K K_sv K_p sqrt((P_s - |P_L|) / 2))."""
    leak = 5e-12
    setup = hydraulic(load_force=load_force, leakage_coefficient=leak, friction=False, duration=3.0)
    run = simulate(replace(setup, reference=Steps((0.0,), 3.0)))
    pressure = load_force / TRUTH["piston_area_1"]
    root = np.sqrt((TRUTH["supply_pressure"] - abs(pressure)) / 2.0)
    expected = leak * pressure / (TRUTH["valve_flow_gain"] * TRUTH["valve_position_gain"] * GAIN * root)
    assert abs(expected) > 5e-5
    assert run.signals["error"][-1] == pytest.approx(expected, rel=1e-4)
    tight = simulate(replace(setup, parameters=hydraulic(load_force=load_force, friction=False).parameters))
    assert abs(tight.state("position")[-1]) < 1e-3 * abs(expected)


@pytest.mark.parametrize("gain", [200.0, 400.0])
def test_overlap_leaves_a_band_of_its_width_over_the_gain(gain: float) -> None:
    """Inside |e| < overlap / (K_sv K_p) the loop does nothing; from outside it comes to rest at the edge."""
    overlap = 6e-6
    edge = overlap / (TRUTH["valve_position_gain"] * gain)
    setup = hydraulic(gain, valve_overlap=overlap, duration=3.0)
    inside = simulate(replace(setup, reference=Steps((0.95 * edge,), 3.0)))
    assert np.max(np.abs(inside.state("position"))) == 0.0
    outside = simulate(replace(setup, reference=Steps((5e-3,), 3.0)))
    assert outside.signals["error"][-1] == pytest.approx(edge, rel=0.02)
    ideal = simulate(replace(hydraulic(gain, duration=3.0), reference=Steps((5e-3,), 3.0)))
    assert abs(ideal.signals["error"][-1]) < 0.02 * edge


def test_overlap_is_no_trouble_for_error_control() -> None:
    """The flow has kinks, no jumps: the solver takes no more than half as many steps again, and its error is small."""
    runs = []
    for overlap in (0.0, 18e-6):
        setup = replace(hydraulic(valve_overlap=overlap), reference=Steps((3e-3, -3e-3), 0.5))
        run, fine = simulate(setup), simulate(replace(setup, integrator=Integrator(tolerance=1e-9)))
        assert np.max(np.abs(run.state("position") - fine.state("position"))) < 1e-7
        runs.append(run)
    assert runs[1].steps < 1.5 * runs[0].steps
