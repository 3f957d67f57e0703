"""What effects say of their parameters to a search: bounds, sizes, and from where to look for what shapes an effect."""

import numpy as np
import pytest
from effect_machines import TRUTH, at_rest, having
from thesis_actuator import along

from plants.effects.attach import acts_by_itself, possible
from plants.effects.interface import FREE, Effect
from plants.effects.registry import effects
from plants.effects.scales import Scales
from plants.equation import fields, leaves, replaced
from plants.registry import plants
from workbench.parameters.sets import build

SCALES = Scales(
    force=400.0,
    drive=2e3,
    travel=0.1,
    turn=np.inf,
    speed=0.1,
    pressure=3e6,
    flow=6e-5,
    spool=6e-4,
    voltage=10.0,
    conductance=1.5e-10,
    duration=40.0,
    sample_time=1e-3,
)

EVERY = list(effects().values())
SHAPING = {
    **{"static_rise_time": "", "static_rise_distance": "", "warming_time": "", "slip_stiffness": ""},
    **{"compliant_frequency": "time", "compliant_damping": "", "cushion_start": ""},
    **{"cogging_pitch": "position", "position_ripple_pitch": "position", "ripple_frequency": "time"},
}
"""Every parameter that shapes an effect, and the signal over which it is a period or a frequency."""


def test_what_shapes_an_effect_is_marked() -> None:
    found = {
        name: number.period_of or number.frequency_of
        for effect in EVERY
        for name, number in effect.numbers.items()
        if number.shapes
    }
    assert found == SHAPING
    assert effects()["supply_ripple"].numbers["ripple_frequency"].frequency_of == "time"


@pytest.mark.parametrize("effect", EVERY, ids=lambda effect: effect.name)
def test_numbers_of_an_effect_fit_together(effect: Effect) -> None:
    """A size within its bounds, a neutral value among them, a grid that ascends from within; sets of known names."""
    for name, number in effect.numbers.items():
        assert number.low < number.high
        assert 0.0 < number.scale(SCALES) < np.inf
        neutral = effect.neutral.get(name, 0.0) / number.scale(SCALES)
        assert number.low < neutral + number.size <= number.high or number.size == 0.0
        if number.shapes:
            assert number.size == 0.0
            assert number.low <= number.grid[0] < number.grid[-1] <= number.high
            assert all(number.low <= value <= number.high for value in number.grid)
            assert effect.neutral[name] > 0.0
        elif name in effect.neutral:
            assert number.low <= effect.neutral[name] / number.scale(SCALES) <= number.high
        if number.size == 0.0 and not number.shapes:
            assert (effect.name, number.high) == ("direction_asymmetry", FREE), "it starts from the other direction"
    assert {name for variant in effect.variants for name in variant} == set(effect.numbers)
    assert all(any(not effect.numbers[name].shapes for name in variant) for variant in effect.variants)


@pytest.mark.parametrize("name", ["two_chamber", "pneumatic_cylinder", "rotary_torque"])
def test_what_shapes_an_effect_does_nothing_alone(name: str) -> None:
    plant = plants()[name]
    for effect in possible(plant):
        shaping = [each for each, number in effect.numbers.items() if number.shapes]
        if acts_by_itself(plant, effect) or not shaping:
            continue
        one = plant.with_effects(effect)
        parameters = build(one.Parameters, along(plant, TRUTH))
        state, inputs = at_rest(one, parameters, position=0.01, velocity=0.02)
        remembering = {item.name: 0.1 * item.scale for item in fields(effect.Memory)}
        state = replaced(state, remembering)
        bare = plant.State._make(list(state)[: len(plant.State._fields)])
        before = [*leaves(plant.derivatives(0.4, bare, inputs, parameters))]
        for each in shaping:
            number = effect.numbers[each]
            for value in number.grid:
                other = replaced(parameters, {each: value * number.scale(SCALES)})
                after = [*leaves(one.derivatives(0.4, state, inputs, other))][: len(before)]
                assert np.array(after, dtype=float) == pytest.approx(np.array(before, dtype=float), rel=1e-12)


def test_a_leak_at_its_bound_takes_what_the_valve_gives() -> None:
    """The rated flow at supply pressure: K x_max sqrt(P_s / 2) of both edges."""
    number = effects()["internal_leakage"].numbers["leakage_coefficient"]
    _, p = having("non_rotating", {})
    h = p.hydraulics
    rated = h.valve_flow_gain * h.spool_limit * np.sqrt(0.5 * h.supply_pressure)
    scales = SCALES._replace(conductance=rated / h.supply_pressure)
    assert number.high * number.scale(scales) * h.supply_pressure == pytest.approx(rated)


def test_a_pitch_is_a_turn_at_most_on_an_axis_that_turns() -> None:
    number = effects("rad")["cogging"].numbers["cogging_pitch"]
    turning = SCALES._replace(travel=50.0, turn=2.0 * np.pi)
    assert max(number.grid) * number.scale(turning) == pytest.approx(2.0 * np.pi)
