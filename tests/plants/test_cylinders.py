"""Cylinders on machines drawn over decades: against the thesis's plant, equations written down again, and energy."""

from collections.abc import Callable, Mapping

import numpy as np
import pytest
from drawn_machines import hydraulic, pneumatic
from scipy.integrate import solve_ivp

from plants.authority import authority, velocity_gains
from plants.effects.attach import meant
from plants.equation import to_array
from plants.interface import Plant
from plants.registry import plants
from workbench.parameters.sets import build
from workbench.simulation.references import Sine
from workbench.simulation.setup import Feed, Integrator, Setup
from workbench.simulation.simulate import simulate, solver_error
from workbench.study.checks.load import unheld

Values = Mapping[str, float]


def machine(name: str, values: Values) -> Plant:
    plant = plants()[name]
    return plant.with_effects(*meant(plant, [*values]))


def driven(plant: Plant, values: Values, volts: float, hertz: float, duration: float) -> Setup:
    parameters = build(plant.Parameters, values)
    state, inputs = plant.equilibrium(parameters, 0.0)
    inputs = inputs._replace(**{plant.command: 0.0})
    return Setup(plant, parameters, state, inputs, duration, feeds=(Feed(plant.command, Sine(volts, hertz)),))


# --- the thesis's plant ---------------------------------------------------------------------------------------


@pytest.mark.parametrize("seed", range(6))
def test_with_equal_areas_and_frozen_volumes_it_is_the_thesis_s_plant(seed: int) -> None:
    """Whole trajectories, to the two solvers' errors."""
    values = hydraulic(seed, equal=True)
    gain, _ = velocity_gains(authority(build(plants()["non_rotating"].Parameters, values)))
    hertz = 3.0 * gain / (0.3 * np.pi * values["stroke"])  # 0.3 of the stroke, if nothing but the valve counts
    setups = [driven(plants()[name], values, 3.0, hertz, 2.0 / hertz) for name in ("non_rotating", "two_chamber")]
    runs = [simulate(setup) for setup in setups]
    errors = [solver_error(setup, run) for setup, run in zip(setups, runs, strict=True)]
    assert [run.outcome for run in runs] == ["completed"] * 2
    apart = np.max(np.abs(runs[0].signals["position"] - runs[1].signals["position"]))
    moved = np.ptp(runs[0].signals["position"])
    assert moved > 0.05 * values["stroke"]
    assert apart < 3.0 * sum(error for error in errors if error is not None) + 1e-9 * moved


def test_volumes_that_follow_make_the_oil_stiff_near_an_end() -> None:
    values = hydraulic(1)
    plant = plants()["cylinder"]
    parameters = build(plant.Parameters, values)
    state, inputs = plant.equilibrium(parameters, 0.0)
    moving = state._replace(velocity=0.1)
    rates = [
        float(plant.derivatives(0.0, moving._replace(position=share * values["stroke"]), inputs, parameters).pressure_2)
        for share in (-0.45, 0.0, 0.45)
    ]
    dead = values["hose_volume"] + values["dead_volume_2"]
    swept = values["piston_area_2"] * values["stroke"]
    assert rates[2] / rates[0] == pytest.approx((dead + 0.95 * swept) / (dead + 0.05 * swept), rel=1e-12)


@pytest.mark.parametrize("seed", [2, 6, 8])
def test_a_spool_that_swings_keeps_to_its_slew_and_its_motion_is_solved(seed: int) -> None:
    """Drawn machines whose sine at full voltage asks for 1.1 times the slew and more."""
    values, draw = rich(seed), np.random.default_rng([seed, 9])
    values["valve_natural_frequency"] = float(10.0 ** draw.uniform(1.3, 2.5))
    values["valve_slew"] = 0.9 * 2.0 * np.pi * 4.0 * values["spool_limit"]
    setup = driven(machine("cylinder", values), values, values["voltage_limit"], 4.0, 0.6)
    run, tight = (simulate(Setup(**{**vars(setup), "integrator": Integrator(tolerance=t)})) for t in (1e-8, 1e-10))
    fastest = np.max(np.abs(run.state("spool_velocity"))) / values["valve_slew"]
    assert 0.99 < fastest < 1.0 + 1e-6
    assert run.time.size == tight.time.size
    assert np.max(np.abs(run.state("position") - tight.state("position"))) < 1e-5 * np.ptp(tight.state("position"))


def test_oil_that_is_pulled_below_vacuum_is_told() -> None:
    """A heavy mass that the valve stops at once pulls at the oil behind it."""
    light = hydraulic(1)
    runs = [
        simulate(driven(machine("cylinder", values), values, 0.5 * values["voltage_limit"], 5.0, 0.6))
        for values in (light, {**light, "mass": 20.0 * light["mass"]})
    ]
    assert [run.outcome for run in runs] == ["completed", "cavitates"]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("name", ["cylinder", "pneumatic_cylinder"])
def test_a_load_is_held_between_tank_and_supply_or_said_to_be_too_much(name: str, seed: int) -> None:
    values = {"cylinder": hydraulic, "pneumatic_cylinder": pneumatic}[name](seed)
    plant, most = machine(name, values), values["supply_pressure"] * values["piston_area_1"]
    for share in (-1.1, -0.6, -0.1, 0.1, 0.6, 0.95, 1.1):
        parameters = build(plant.Parameters, {**values, "load_force": share * most})
        state, inputs = plant.equilibrium(parameters, 0.0)
        for pressure in (state.pressure_1, state.pressure_2):
            assert values.get("tank_pressure", 0.0) - 1.0 <= pressure <= values["supply_pressure"] + 1.0
        left = values["mass"] * plant.derivatives(0.0, state, inputs, parameters).velocity
        told = unheld(plant, parameters)
        assert (told is not None) == (abs(left) > 1e-6 * most)
        assert told is not None if share == 1.1 else True
        assert told is None if abs(share) == 0.1 else True


def test_edges_that_are_open_at_rest_one_way_and_closed_the_other_hold_an_equilibrium() -> None:
    """To the tank they are open, to the pump covered: the spool stands where the loaded chamber's edge closes."""
    values = hydraulic(2) | {"tank_pressure": 0.0, "load_force": 0.0}
    way = 0.05 * values["spool_limit"]
    values |= {f"edge_overlap_{edge}": sign * way for edge, sign in (("pa", 1), ("pb", 1), ("at", -1), ("bt", -1))}
    plant = machine("cylinder", values)
    for share, spool in ((-0.5, -way), (0.0, 0.0), (0.5, way)):
        load = share * values["supply_pressure"] * values["piston_area_2"]
        parameters = build(plant.Parameters, {**values, "load_force": load})
        state, inputs = plant.equilibrium(parameters, 0.0)
        rates = plant.derivatives(0.0, state, inputs, parameters)
        assert state.spool_position == pytest.approx(spool, abs=1e-9 * values["spool_limit"])
        assert max(abs(rates.pressure_1), abs(rates.pressure_2)) < 1e-3
        assert unheld(plant, parameters) is None


def test_a_leak_beyond_what_the_valve_gives_is_told() -> None:
    values = hydraulic(3, equal=True)
    passed = values["valve_flow_gain"] * values["spool_limit"] / np.sqrt(values["supply_pressure"])
    load = 0.8 * values["supply_pressure"] * values["piston_area_1"]
    for share, words in ((0.01, None), (1.0, "does not make good what leaks")):
        plant, more = plants()["two_chamber"], {"leakage_coefficient": share * passed, "load_force": load}
        told = unheld(plant, build(plant.Parameters, {**values, **more}))
        assert (told is None) == (words is None)
        assert words is None or words in str(told)
    weak = {**values, "leakage_coefficient": 0.05 * passed, "load_force": load, "voltage_limit": 0.2}
    assert "beyond its limit of 0.2" in str(unheld(plant, build(plant.Parameters, weak)))


# --- equations written down again ------------------------------------------------------------------------------


def lugre(v: float, z: float, q: Values) -> tuple[float, float]:
    level = q["coulomb"] + q["stribeck"] * np.exp(-((v / q["stribeck_velocity"]) ** 2))
    rate = v - q["bristle_stiffness"] * abs(v) * z / level
    return q["bristle_stiffness"] * z + q["bristle_damping"] * rate + q["viscous"] * v, rate


def stop(x: float, v: float, q: Values) -> float:
    depth, side = abs(x) - 0.5 * q["stroke"], np.sign(x)
    return 0.0 if depth <= 0.0 else -side * q["end_stop_stiffness"] * depth * max(1.0 + 5.0 * side * v, 0.0)


def oil(t: float, y: np.ndarray, q: Values, volts: Callable[[float], float]) -> list[float]:
    """x, v, P1, P2, spool, z, spool speed: a differential cylinder on a valve of second order."""
    x, v, p1, p2, s, z, w = y
    target = np.clip(q["valve_position_gain"] * volts(t), -q["spool_limit"], q["spool_limit"])
    omega = 2.0 * np.pi * q["valve_natural_frequency"]

    def edge(name: str, way: float, drop: float) -> float:
        opened = max(way - q.get("valve_overlap", 0.0) - q[f"edge_overlap_{name}"], 0.0)
        if abs(drop) > 1e4:
            root = np.sign(drop) * np.sqrt(abs(drop))
        else:
            root = np.sqrt(1e4) * (1.25 * (drop / 1e4) - 0.25 * (drop / 1e4) ** 3)
        return q[f"edge_gain_{name}"] * q["valve_flow_gain"] * opened * root

    supply, tank = q["supply_pressure"], q["tank_pressure"]
    leak = q["leakage_coefficient"] * (p1 - p2)
    q1 = edge("pa", s, supply - p1) - edge("at", -s, p1 - tank) - leak
    q2 = edge("pb", -s, supply - p2) - edge("bt", s, p2 - tank) + leak
    v1 = q["hose_volume"] + q["dead_volume_1"] + q["piston_area_1"] * (0.5 * q["stroke"] + x)
    v2 = q["hose_volume"] + q["dead_volume_2"] + q["piston_area_2"] * (0.5 * q["stroke"] - x)
    friction, bending = lugre(v, z, q)
    push = p1 * q["piston_area_1"] - p2 * q["piston_area_2"]
    return [
        v,
        (push - friction - q["load_force"] + stop(x, v, q)) / q["mass"],
        q["bulk_modulus"] / v1 * (q1 - q["piston_area_1"] * v),
        q["bulk_modulus"] / v2 * (q2 + q["piston_area_2"] * v),
        w,
        bending,
        omega**2 * (target - s) - 2.0 * q["valve_damping_ratio"] * omega * w,
    ]


def air(t: float, y: np.ndarray, q: Values, volts: Callable[[float], float]) -> list[float]:
    """x, v, P1, P2, spool, z: a pneumatic cylinder by ISO 6358 and polytropes, pressures absolute inside."""
    x, v, g1, g2, s, z = y
    ambient, temperature, density = 101325.0, 293.15, 1.185
    p1, p2, ps = g1 + ambient, g2 + ambient, q["supply_pressure"] + ambient
    energy = 287.05 * temperature

    def flow(conductance: float, up: float, down: float) -> float:
        if up < down:
            return -flow(conductance, down, up)
        ratio, b = down / up, q["critical_pressure_ratio"]
        within = min(max(min(ratio, 0.999) - b, 0.0) / (1.0 - b), 1.0)
        share = np.sqrt(1.0 - within**2) * min((1.0 - ratio) / 0.001, 1.0)
        return conductance * density * up * share

    forward = q["sonic_conductance"] * max(s, 0.0) / q["spool_limit"]
    backward = q["sonic_conductance"] * max(-s, 0.0) / q["spool_limit"]
    leak = flow(q["leakage_conductance"], p1, p2)
    m1 = flow(forward, ps, p1) - flow(q["exhaust_gain"] * backward, p1, ambient) - leak
    m2 = flow(backward, ps, p2) - flow(q["exhaust_gain"] * forward, p2, ambient) + leak
    v1 = q["dead_volume_1"] + q["piston_area_1"] * (0.5 * q["stroke"] + x)
    v2 = q["dead_volume_2"] + q["piston_area_2"] * (0.5 * q["stroke"] - x)
    friction, bending = lugre(v, z, q)
    push = p1 * q["piston_area_1"] - p2 * q["piston_area_2"] - ambient * (q["piston_area_1"] - q["piston_area_2"])
    n = q["polytropic_exponent"]
    target = np.clip(q["valve_position_gain"] * volts(t), -q["spool_limit"], q["spool_limit"])
    return [
        v,
        (push - friction - q["load_force"] + stop(x, v, q)) / q["mass"],
        n / v1 * (energy * m1 - p1 * q["piston_area_1"] * v),
        n / v2 * (energy * m2 + p2 * q["piston_area_2"] * v),
        (target - s) / q["valve_time_constant"],
        bending,
    ]


def rich(seed: int) -> dict[str, float]:
    """A drawn hydraulic cylinder whose edges differ, are open at rest, and whose spool swings."""
    values, draw = hydraulic(seed), np.random.default_rng([seed, 3])
    edges = ("pa", "at", "pb", "bt")
    spool = values["spool_limit"]
    return {
        **values,
        **{f"edge_gain_{edge}": float(draw.uniform(0.5, 1.5)) for edge in edges},
        **{f"edge_overlap_{edge}": float(draw.uniform(-0.02, 0.02)) * spool for edge in edges},
        "valve_overlap": 0.005 * spool,
        "leakage_coefficient": 1e-4 * values["valve_flow_gain"] * spool / float(np.sqrt(values["supply_pressure"])),
        "valve_natural_frequency": 1.0 / (2.0 * np.pi * values["valve_time_constant"]),
        "valve_damping_ratio": 0.6,
    }


CASES = [("cylinder", rich(seed), oil) for seed in range(3)] + [
    ("pneumatic_cylinder", pneumatic(seed), air) for seed in range(3)
]


@pytest.mark.parametrize(("name", "values", "again"), CASES, ids=lambda item: item if isinstance(item, str) else "")
def test_trajectories_are_those_of_an_independent_integration(name: str, values: Values, again: Callable) -> None:
    """LSODA, to 1e-9 m: slow motion through reversals, in which the rod sticks and slips."""
    plant, volts, hertz, duration = machine(name, values), 0.04 * values["voltage_limit"], 2.0, 0.6
    setup = driven(plant, values, volts, hertz, duration)
    tight = simulate(Setup(**{**vars(setup), "integrator": Integrator(tolerance=1e-10)}))
    assert tight.outcome in ("completed", "hardly moves")
    start = np.array([float(x) for x in to_array(setup.state)])
    exact = solve_ivp(
        lambda t, y: again(t, y, values, lambda t: tight_sine(t, volts, hertz, setup.sample_time)),
        (0.0, duration),
        start,
        "LSODA",
        rtol=1e-11,
        atol=1e-12 * np.maximum(np.abs(start), 1e-3),
        t_eval=tight.time,
        max_step=setup.sample_time,
    )
    assert np.max(np.abs(exact.y[0] - tight.signals["position"])) < 1e-9


def tight_sine(t: float, volts: float, hertz: float, sample: float) -> float:
    """The sine as the engine has it between samples: a line."""
    before = np.floor(t / sample + 1e-9) * sample
    a, b = (volts * np.sin(2.0 * np.pi * hertz * instant) for instant in (before, before + sample))
    return float(a + (b - a) * (t - before) / sample)
