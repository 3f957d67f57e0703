"""Curves over a signal for what nobody understands: their shape, what they add to a balance, and what they cost."""

from pathlib import Path

import numpy as np
import pytest
from effect_machines import CURVE_SIZES, MAP, NODES, RANGES, TRUTH, at_rest, curve_of, having, map_of
from scipy.interpolate import PchipInterpolator, RegularGridInterpolator
from thesis_actuator import along

from plants.effects.attach import lacks
from plants.effects.curves import CURVES, acting, curve, nodes_of
from plants.effects.maps import FORCE_MAP, surface
from plants.equation import leaves
from plants.interface import Plant
from plants.registry import plants
from workbench.parameters.corrected import Entry, parameter_file
from workbench.parameters.sets import build, known_units, named_sets, read_parameters
from workbench.records.experiment import read_experiment

PLACES = np.linspace(2.0, 5.0, NODES.size)
OWN = (1.0, 2.0, 5.0, *NODES)


# --- the shape ---


def test_a_curve_goes_through_its_nodes_and_is_constant_beyond() -> None:
    np.testing.assert_allclose(curve(PLACES, OWN), NODES, rtol=1e-12)
    np.testing.assert_allclose(curve(np.array([-10.0, 1.99, 5.01, 1e3]), OWN), NODES[[0, 0, -1, -1]], rtol=1e-12)


def test_a_curve_is_that_of_another_program_but_for_its_flat_ends() -> None:
    """SciPy's monotone cubic; it chooses other slopes at the first and at the last node."""
    inside = np.linspace(PLACES[1], PLACES[-2], 501)
    np.testing.assert_allclose(curve(inside, OWN), PchipInterpolator(PLACES, NODES)(inside), atol=1e-12)


def test_a_curve_stays_between_its_nodes_and_has_no_kink() -> None:
    fine = np.linspace(1.9, 5.1, 32_001)
    values = curve(fine, OWN)
    steps = np.clip(np.searchsorted(PLACES, fine) - 1, 0, NODES.size - 2)
    low, high = np.minimum(NODES[:-1], NODES[1:])[steps], np.maximum(NODES[:-1], NODES[1:])[steps]
    assert np.all((values >= low - 1e-12) & (values <= high + 1e-12))
    slope = np.diff(values) / np.diff(fine)
    assert np.max(np.abs(np.diff(slope))) < 1e-2 * np.max(np.abs(slope))


def test_a_range_without_width_is_no_division_by_zero() -> None:
    assert curve(3.0, (1.0, 3.0, 3.0, *NODES)) == NODES[0]


# --- on a plant ---

SIGNALS = {
    "position": 0.011,
    "velocity": 0.043,
    "time": 0.37,
    "load_pressure": 0.6e6,
    "pressure_1": 1.8e6,
    "pressure_2": 1.2e6,
    "valve_voltage": 0.21,
}


def moved(plant: Plant, parameters: object) -> tuple[object, object]:
    """A state where the signals are as above, and inputs."""
    _, p = having(plant.bare.name if plant.bare else plant.name, {})
    valve = getattr(p, "hydraulics", None) or getattr(p, "pneumatics", None)
    spool = SIGNALS["valve_voltage"] * valve.valve_position_gain if valve else 0.0
    states = {**SIGNALS, "spool_position": spool}
    known = plant.State._fields
    return at_rest(plant, parameters, **{name: value for name, value in states.items() if name in known})


def pressures_of(plant: Plant, state: object, parameters: object) -> dict[str, float]:
    """The pressures that the sensors of a hydraulic plant show there."""
    shown = plant.measure(state, parameters)
    return {"pressure_1": float(shown.pressure_1), "pressure_2": float(shown.pressure_2)}


@pytest.mark.parametrize(
    "name", ["non_rotating", "rotating_helical", "two_chamber", "pneumatic_cylinder", "drive_force", "rotary_torque"]
)
@pytest.mark.parametrize("balance", ["force", "flow"])
def test_a_curve_adds_its_value_to_the_residual_of_its_balance(name: str, balance: str) -> None:
    """The rate that it adds, in the scale of the balance, is the curve where the signal is."""
    bare = plants()[name]
    for (kind, signal), effect in CURVES.items():
        if effect.balance != balance or lacks(bare, effect.along(bare.axis)):
            continue
        plant = bare.with_effects(effect)
        parameters = build(plant.Parameters, along(plant, {**TRUTH, **curve_of(kind, signal)}))
        without = build(plant.Parameters, along(plant, {**TRUTH, **curve_of(kind, signal, share=0.0)}))
        state, inputs = moved(plant, parameters)
        place = plant.State._fields.index(plant.balances[balance].states[0])
        rates, before = (plant.derivatives(SIGNALS["time"], state, inputs, p)[place] for p in (parameters, without))
        scale, *_ = plant.balances[balance].scale(parameters)
        signals = SIGNALS
        if np.isfinite(plant.measure(state, parameters).pressure_1):
            pressures = pressures_of(plant, state, parameters)
            signals = {**SIGNALS, **pressures, "load_pressure": pressures["pressure_1"] - pressures["pressure_2"]}
        low, high = RANGES[signal]
        expected = CURVE_SIZES[kind] * PchipInterpolator(np.linspace(low, high, NODES.size), NODES)(signals[signal])
        assert scale * (rates - before) == pytest.approx(expected, rel=1e-6), (name, signal)


@pytest.mark.parametrize("name", ["two_chamber", "rotary_torque"])
def test_a_curve_that_is_off_changes_nothing_at_all(name: str) -> None:
    bare = plants()[name]
    for (balance, signal), effect in CURVES.items():
        if lacks(bare, effect.along(bare.axis)):
            continue
        plant = bare.with_effects(effect)
        parameters = build(plant.Parameters, along(plant, {**TRUTH, **curve_of(balance, signal, share=0.0)}))
        known = build(bare.Parameters, along(bare, TRUTH))
        state, inputs = moved(plant, parameters)
        rates = [*leaves(plant.derivatives(0.3, state, inputs, parameters))]
        assert rates == [*leaves(bare.derivatives(0.3, state, inputs, known))]
        assert [*leaves(plant.measure(state, parameters))][:2] == [*leaves(bare.measure(state, known))][:2]


def test_curves_of_a_turning_axis_have_its_names_and_units() -> None:
    units = known_units("rad")
    assert (units["position_torque_curve_low"], units["position_torque_curve_01"]) == ("rad", "N m")
    assert known_units("m")["position_force_curve_01"] == "N"


# --- over two signals ---


def test_a_map_is_bilinear_between_its_nodes_and_constant_beyond() -> None:
    places, speeds = np.linspace(-1.0, 3.0, 6), np.linspace(0.0, 0.5, 6)
    own = (1.0, -1.0, 3.0, 0.0, 0.5, *MAP.ravel())
    other = RegularGridInterpolator((places, speeds), MAP)
    draw = np.random.default_rng(3)
    first, second = draw.uniform(-1.5, 3.5, 400), draw.uniform(-0.1, 0.6, 400)
    expected = other(np.column_stack([np.clip(first, -1.0, 3.0), np.clip(second, 0.0, 0.5)]))
    np.testing.assert_allclose(surface(first, second, own), expected, atol=1e-12)
    assert surface(7.0, 0.1, (1.0, 7.0, 7.0, 0.1, 0.1, *MAP.ravel())) == MAP[0, 0]


@pytest.mark.parametrize("name", ["two_chamber", "rotary_torque"])
def test_a_map_adds_its_value_to_the_force_and_nothing_where_it_is_off(name: str) -> None:
    bare = plants()[name]
    plant = bare.with_effects(FORCE_MAP)
    on, off = (build(plant.Parameters, along(plant, {**TRUTH, **map_of(share)})) for share in (1.0, 0.0))
    known = build(bare.Parameters, along(bare, TRUTH))
    state, inputs = moved(plant, on)
    place = plant.State._fields.index("velocity")
    with_it, without, never = (
        [*leaves(one.derivatives(0.3, state, inputs, p))] for one, p in ((plant, on), (plant, off), (bare, known))
    )
    assert without == never
    scale, *_ = plant.balances["force"].scale(on)
    expected = surface(SIGNALS["position"], SIGNALS["velocity"], [*map_of().values()])
    assert abs(expected) > 1.0
    assert scale * (with_it[place] - without[place]) == pytest.approx(expected, rel=1e-6)
    assert acting(map_of(share=0.0)) == {}


# --- only where it is asked for ---

EXPERIMENT = """\
title = "t"
[plant]
model = "two_chamber"
parameters = "plant.toml"
[channels]
time = { column = "time", unit = "s" }
valve_voltage = { column = "valve_voltage", unit = "V" }
position = { column = "position", unit = "m" }
[[records]]
file = "record.parquet"
"""


@pytest.mark.parametrize(("share", "effects"), [(0.0, ()), (1.0, ("position_force_curve",))])
def test_a_plant_has_a_curve_only_where_it_is_on(tmp_path: Path, share: float, effects: tuple[str, ...]) -> None:
    values = {**read_parameters(named_sets()["owen2001_experiment"]), **curve_of("force", "position", share)}
    entries = [Entry(name, value, None, "test") for name, value in values.items()]
    (tmp_path / "plant.toml").write_text(parameter_file("t", "s", entries, "m"))
    (tmp_path / "record.parquet").touch()
    (tmp_path / "experiment.toml").write_text(EXPERIMENT)
    assert read_experiment(tmp_path / "experiment.toml").plant.effects == effects


def test_parameters_of_curves_that_are_off_are_left_out() -> None:
    on, off = curve_of("force", "time"), curve_of("flow", "position", share=0.0)
    assert acting({"mass": 0.0, **on, **off}) == {"mass": 0.0, **on}
    assert acting(dict.fromkeys(nodes_of("time_force_curve"), 3.0)) == {}
