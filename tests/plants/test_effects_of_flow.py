"""Effects on the flow against numbers found without them: valve, leaks, supply, volumes, areas."""

import numpy as np
import pytest
from effect_machines import TRUTH, at_rest, having

from plants.effects.registry import effects
from plants.hydraulics import oil_volumes
from plants.pneumatics import GAS_CONSTANT, NORMAL_DENSITY
from plants.registry import plants
from workbench.parameters.sets import build
from workbench.simulation.simulate import Setup, simulate

VALVED = ("non_rotating", "cylinder", "two_chamber", "pneumatic_cylinder")
LIMIT = TRUTH["spool_limit"]


def pressure_rates(name: str, values: dict[str, float], spool: float, time: float = 0.0, **states: float) -> np.ndarray:
    """Rates (Pa/s) of a plant's pressures with a spool (m) elsewhere than at rest."""
    plant, p = having(name, values)
    state, inputs = at_rest(plant, p, spool_position=spool, **states)
    rates = plant.derivatives(time, state, inputs, p)._asdict()
    names = ("load_pressure",) if "load_pressure" in rates else ("pressure_1", "pressure_2")
    return np.array([float(rates[each]) for each in names])


@pytest.mark.parametrize("name", VALVED)
@pytest.mark.parametrize(("way", "overlap"), [(1.0, 3e-5), (-1.0, 5e-5)])
def test_either_direction_of_a_valve_has_its_own_overlap(name: str, way: float, overlap: float) -> None:
    """The flow is that of a spool which is nearer to the middle by the overlap of its side; 0 within it."""
    values = {"valve_overlap": 3e-5, "valve_overlap_negative": 5e-5}
    covered = pressure_rates(name, values, way * 2e-4)
    assert covered == pytest.approx(pressure_rates(name, {}, way * (2e-4 - overlap)), rel=1e-12)
    assert not np.any(pressure_rates(name, values, way * 0.9 * overlap))
    alike = pressure_rates(name, {"valve_overlap": overlap}, way * 2e-4)
    assert covered == pytest.approx(alike, rel=1e-12), "one number is that of both directions"


@pytest.mark.parametrize("name", VALVED)
@pytest.mark.parametrize("spool", [1e-4, -0.4 * LIMIT])
def test_the_gain_changes_with_the_opening(name: str, spool: float) -> None:
    """Flow times 1 + c |x| / x_max."""
    ratio = pressure_rates(name, {"valve_gain_curvature": 0.7}, spool) / pressure_rates(name, {}, spool)
    assert ratio == pytest.approx(1.0 + 0.7 * abs(spool) / LIMIT, rel=1e-12)


@pytest.mark.parametrize("name", VALVED)
def test_the_gain_of_negative_openings_is_another(name: str) -> None:
    for spool, expected in ((1e-4, 1.0), (-1e-4, 0.8)):
        ratio = pressure_rates(name, {"valve_gain_ratio": 0.8}, spool) / pressure_rates(name, {}, spool)
        assert ratio == pytest.approx(expected, rel=1e-12)


# --- leaks ----------------------------------------------------------------------------------------------------


def left_alone(name: str, values: dict[str, float], duration: float) -> tuple[np.ndarray, np.ndarray]:
    """Pressure 1 (Pa) over time (s) of a machine at rest whose closed valve is left alone, leaks opened at 0."""
    plant, p = having(name, values)
    tight, sealed = having(name, {})
    start, inputs = at_rest(tight, sealed)
    run = simulate(Setup(plant, p, start, inputs, duration))
    assert run.outcome == "completed"
    return run.time, run.state("pressure_1")


@pytest.mark.parametrize("name", ["cylinder", "two_chamber"])
def test_chambers_that_leak_alike_lose_their_pressure_with_one_time_constant(name: str) -> None:
    """P = P_0 exp(-beta C t / V): nothing moves, since areas are equal."""
    leak, h = 2e-12, TRUTH
    volume = h["hose_volume"] + h["dead_volume_1"] + 0.5 * h["piston_area_1"] * h["stroke"]
    time, pressure = left_alone(name, {"external_leakage_1": leak, "external_leakage_2": leak}, 0.1)
    expected = 0.5 * h["supply_pressure"] * np.exp(-h["bulk_modulus"] * leak * time / volume)
    assert pressure[-1] < 0.5 * pressure[0]
    assert np.max(np.abs(pressure - expected)) < 1e-5 * pressure[0]


def test_air_that_leaks_at_the_speed_of_sound_decays_exponentially() -> None:
    """dP/dt = -n R T C rho_0 P / V, P absolute, while that is above the atmosphere's over the critical ratio."""
    leak, air = 3e-9, TRUTH
    volume = air["dead_volume_1"] + 0.5 * air["piston_area_1"] * air["stroke"]
    time, pressure = left_alone("pneumatic_cylinder", {"external_leakage_1": leak, "external_leakage_2": leak}, 0.3)
    absolute = pressure + 101325.0
    rate = air["polytropic_exponent"] * GAS_CONSTANT * 293.15 * leak * NORMAL_DENSITY / volume
    assert absolute[-1] > 101325.0 / air["critical_pressure_ratio"], "the speed of sound all the time"
    assert rate * time[-1] > 0.05
    assert absolute == pytest.approx(absolute[0] * np.exp(-rate * time), rel=1e-5)


def test_air_that_leaks_past_the_piston_goes_with_the_higher_pressure() -> None:
    """n R T C rho_0 P_1 / V each way at the speed of sound, pressures absolute."""
    plant, p = having("pneumatic_cylinder", {"leakage_conductance": 1e-10})
    state, inputs = at_rest(plant, p, pressure_1=1.5e6, pressure_2=1e5, spool_position=0.0)
    rates = plant.derivatives(0.0, state, inputs, p)
    volume = TRUTH["dead_volume_1"] + 0.5 * TRUTH["piston_area_1"] * TRUTH["stroke"]
    mass_flow = 1e-10 * NORMAL_DENSITY * (1.5e6 + 101325.0)
    expected = TRUTH["polytropic_exponent"] * GAS_CONSTANT * 293.15 * mass_flow / volume
    assert (float(rates.pressure_1), float(rates.pressure_2)) == pytest.approx((-expected, expected), rel=1e-9)


@pytest.mark.parametrize("name", ["non_rotating", "cylinder", "pneumatic_cylinder"])
@pytest.mark.parametrize("load_force", [0.0, 150.0])
def test_a_machine_with_a_leak_rests_where_its_valve_makes_it_good(name: str, load_force: float) -> None:
    plant, p = having(name, {"external_leakage_1": 2e-13, "load_force": load_force})
    state, inputs = plant.equilibrium(p, 0.0)
    rates = plant.derivatives(0.0, state, inputs, p)
    assert abs(float(rates.velocity)) * TRUTH["mass"] < 1e-6
    assert abs(float(rates[2])) < 1e-6 * TRUTH["supply_pressure"]


# --- supply ---------------------------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["cylinder", "two_chamber"])
def test_a_supply_that_pulsates_feeds_by_its_root(name: str) -> None:
    """Q_1 = K x sqrt(P_s + a cos(2 pi f t) + b sin(2 pi f t) - P_1)."""
    ripple = {"ripple_cosine": 2e5, "ripple_sine": -1e5, "ripple_frequency": 4.0}
    angle = 2.0 * np.pi * 4.0 * 0.37
    supply = TRUTH["supply_pressure"] + 2e5 * np.cos(angle) - 1e5 * np.sin(angle)
    volume = TRUTH["hose_volume"] + TRUTH["dead_volume_1"] + 0.5 * TRUTH["piston_area_1"] * TRUTH["stroke"]
    flow = TRUTH["valve_flow_gain"] * 1e-4 * np.sqrt(supply - 1e6)
    rates = pressure_rates(name, ripple, 1e-4, time=0.37, pressure_1=1e6)
    assert rates[0] == pytest.approx(flow * TRUTH["bulk_modulus"] / volume, rel=1e-9)


# --- volumes and areas ----------------------------------------------------------------------------------------


@pytest.mark.parametrize("position", [-0.03, 0.05])
def test_volumes_that_follow_are_those_of_the_cylinder(position: float) -> None:
    states = {"position": position, "velocity": 0.02, "pressure_1": 1e6, "pressure_2": 8e5}
    followed = pressure_rates("two_chamber", {"volume_share": 1.0}, 1e-4, **states)
    assert followed == pytest.approx(pressure_rates("cylinder", {}, 1e-4, **states), rel=1e-12)
    assert followed != pytest.approx(pressure_rates("two_chamber", {}, 1e-4, **states), rel=0.05)


def test_volumes_of_one_load_pressure_follow_by_their_mean_stiffness() -> None:
    """beta (1/V_1 + 1/V_2) in the place of 4 beta / V_t."""
    _, p = having("non_rotating", {"volume_share": 0.5})
    position, h = 0.04, p.hydraulics
    volume_1, volume_2 = oil_volumes(0.5 * position, h, plants()["cylinder"].Parameters._field_defaults["cylinder"])
    total = 2.0 * h.hose_volume + h.piston_area_1 * h.stroke
    expected = total / 4.0 * (1.0 / volume_1 + 1.0 / volume_2)
    states = {"position": position, "velocity": 0.02}
    ratio = pressure_rates("non_rotating", {"volume_share": 0.5}, 1e-4, **states) / pressure_rates(
        "non_rotating", {}, 1e-4, **states
    )
    assert ratio == pytest.approx(expected, rel=1e-12)


def test_only_frozen_volumes_can_be_told_to_follow() -> None:
    with pytest.raises(ValueError, match="it has no frozen volumes"):
        plants()["cylinder"].with_effects(effects()["position_dependent_volume"])


@pytest.mark.parametrize("name", ["two_chamber", "pneumatic_cylinder"])
def test_a_linkage_changes_force_and_swept_flow_alike(name: str) -> None:
    """(P1 A1 - P2 A2) f on the mass, and A v f into the chambers, with f = 1 + g 2 x / L: no power is lost in it."""
    gradient, position = 0.2, 0.3 * TRUTH["stroke"]
    share = 1.0 + gradient * 2.0 * position / TRUTH["stroke"]
    plant, p = having(name, {"area_gradient": gradient})
    bare, q = having(name, {})
    wide = build(bare.Parameters, {**TRUTH, **{key: TRUTH[key] * share for key in ("piston_area_1", "piston_area_2")}})
    states = {"position": position, "velocity": 0.05, "pressure_1": 1.4e6, "pressure_2": 9e5, "spool_position": 1e-4}
    state, inputs = at_rest(plant, p, **states)
    levered, widened, declared = (
        machine.derivatives(0.0, state, inputs, numbers) for machine, numbers in ((plant, p), (bare, wide), (bare, q))
    )
    force = TRUTH["mass"] * float(levered.velocity - declared.velocity)
    assert force == pytest.approx((share - 1.0) * (1.4e6 - 9e5) * TRUTH["piston_area_1"], rel=1e-9)
    assert [float(levered[i]) for i in (2, 3)] == pytest.approx([float(widened[i]) for i in (2, 3)], rel=1e-12)
