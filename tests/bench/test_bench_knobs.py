"""What can be turned: values that come back from their sliders, ranges that hold them, and only names that serve."""

from dataclasses import replace

import pytest
from benches import SHORT, controls, knob_of, of_name, short
from command import STUDIES
from hypothesis import given
from hypothesis import strategies as st

import workbench as wb
from workbench.bench.groups import chosen, controls_of
from workbench.bench.knobs import Choice, Knob, Switch
from workbench.bench.loop import loop_of
from workbench.bench.opened import opened
from workbench.bench.outcome import Outcome, outcome_of
from workbench.bench.stable import stable_range
from workbench.bench.sweep import places, swept
from workbench.study.unfold import unfold
from workbench.toml.units import QuantityError

LOOPS = {
    "thesis": {"name": "thesis_chapter3", "rpm": 120},
    "rig behind hoses": {
        "name": "comparison",
        "machine": "thesis_rig_hoses",
        "rpm": 125,
        "controller": "lugre_adaptive",
    },
    "joint": {"name": "rotary_drive", "controller": "lugre"},
    "air": {"name": "pneumatic_cylinder", "scenario": "industrial_sensors", "rpm": 100},
}


@pytest.fixture(scope="module", params=[*LOOPS])
def outcome(request: pytest.FixtureRequest) -> Outcome:
    return outcome_of(short(**LOOPS[request.param]))


def test_everything_that_can_be_turned_serves(outcome: Outcome) -> None:
    found = controls(outcome)
    assert len(found) > 30
    assert len({control.key for control in found}) == len(found)
    for control in found:
        if isinstance(control, Knob):
            assert control.low < control.high
            assert control.low <= control.value <= control.high or control.may_be_off, control
            further = control.at(min(control.place + 0.05, 1.0))
            assert outcome.loop.changed(control.change(further)).serves, control
        elif isinstance(control, Switch):
            assert outcome.loop.changed(control.off if control.value else control.on).serves, control
        else:
            for name, _ in control.options:
                assert name == control.value or chosen(outcome.loop, control.key, name) is not None


def test_a_slider_has_its_knob_s_value(outcome: Outcome) -> None:
    for control in controls(outcome):
        if isinstance(control, Knob) and control.low <= control.value <= control.high:
            again = replace(control, value=control.at(control.place))
            assert again.place == pytest.approx(control.place, abs=6e-4), control
            assert control.read(control.text) == pytest.approx(control.value, rel=1e-5)


@given(
    value=st.floats(1e-9, 1e9),
    decades=st.floats(0.1, 6.0),
    place=st.floats(0.0, 1.0),
    logarithmic=st.booleans(),
)
def test_places_and_values_are_each_other_s(value: float, decades: float, place: float, logarithmic: bool) -> None:
    knob = Knob("key", "label", value, "1", value, value * 10.0**decades, logarithmic)
    found = Knob("key", "label", knob.at(place), "1", knob.low, knob.high, logarithmic)
    assert found.place == pytest.approx(place, abs=6e-4)  # half a step, and rounding


def test_units_that_are_typed() -> None:
    knob = Knob("key", "stroke", 0.06, "m", shown="mm")
    assert knob.text == "60 mm"
    assert knob.read("70") == pytest.approx(0.07)
    assert knob.read("2 cm") == pytest.approx(0.02)
    with pytest.raises(QuantityError, match='got "3 s"'):
        knob.read("3 s")


def test_a_direction_that_differs_keeps_its_value() -> None:
    outcome = outcome_of(short(**LOOPS["rig behind hoses"]))
    knob = knob_of(outcome, "plant.set.coulomb")
    turned = outcome.loop.changed(knob.change(400.0)).resolved.setup.parameters
    before = outcome.loop.resolved.setup.parameters
    assert of_name(turned, "coulomb") == 400.0
    assert of_name(turned, "coulomb_negative") == of_name(before, "coulomb_negative")


def test_what_a_scenario_multiplies_is_shown_and_turned_as_it_is() -> None:
    outcome = outcome_of(short("comparison", case="slow_sine", machine="thesis_simulation", scenario="friction_up"))
    true = of_name(outcome.loop.resolved.setup.parameters, "coulomb")
    knob = knob_of(outcome, "plant.set.coulomb")
    assert knob.value == pytest.approx(true)
    turned = outcome.loop.changed(knob.change(400.0))
    assert of_name(turned.resolved.setup.parameters, "coulomb") == pytest.approx(400.0)
    assert knob.turned(knob.change(400.0)).value == pytest.approx(400.0)


@pytest.mark.parametrize("name", ["thesis_chapter4", "lugre_reference", "observers", "thesis_chapter5", "hunting"])
def test_references_of_any_input_and_kind_are_offered(name: str) -> None:
    study = wb.Study(STUDIES / f"{name}.toml").content
    for case in unfold(study)[:12]:
        outcome = outcome_of(loop_of(study, case).changed(SHORT))
        found = [one for one in controls_of("reference", outcome) if isinstance(one, Knob)]
        for knob in found:
            assert outcome.loop.changed(knob.change(knob.at(min(knob.place + 0.01, 1.0)))).serves, knob


def test_effects_are_turned_on_and_off() -> None:
    outcome = outcome_of(short(rpm=0))
    switches = [one for one in controls_of("effects", outcome) if isinstance(one, Switch)]
    assert len(switches) > 15
    for switch in switches:
        loop = outcome.loop.changed(switch.on)
        shown = controls_of("effects", replace(outcome, loop=loop))  # the run tells scales alone
        assert [one.key for one in shown if isinstance(one, Switch) and one.value] == [switch.key]
        knobs = {one.key: one for one in shown if isinstance(one, Knob)}
        assert knobs.keys() == switch.on.keys()
        assert all(knobs[key].value == value for key, value in switch.on.items())
        assert loop.changed(switch.off) == outcome.loop
    offset = next(one for one in switches if one.label == "pressure sensor offset")
    supply = of_name(outcome.loop.resolved.setup.parameters, "supply_pressure")
    assert next(iter(offset.on.values())) > 1e-3 * supply  # in the machine's scale


def test_marks_end_where_the_gain_margin_says() -> None:
    outcome = outcome_of(short(rpm=120))
    assert not isinstance(outcome.loop_gain, str)
    knob = knob_of(outcome, "controllers.p.kp")
    found = stable_range(outcome, knob, lambda: False)
    assert found is not None
    assert found[0] == 0.0
    ends = knob.value * 10.0 ** (outcome.loop_gain.margins.gain_dB / 20.0)  # a P loop's gain is K_p's
    assert knob.at(found[1]) == pytest.approx(ends, rel=0.02)
    assert stable_range(outcome, knob, lambda: True) is None


def test_a_sweep_has_the_figures_of_its_points() -> None:
    loop = short(rpm=0)
    outcome = outcome_of(loop)
    for key, column in (
        ("controllers.p.kp", "rms_error_m"),
        ("rpm", "total_power_W"),
        ("plant.set.mass", "rms_error_m"),
    ):
        knob = knob_of(outcome, key)
        values = [knob.at(place) for place in places(5)]
        for value, figure in swept(loop, knob, values, column, lambda: False):
            assert figure == outcome_of(loop.changed(knob.change(value))).figures[column], (key, value)


def test_a_speed_of_rotation_is_no_choice_of_a_gain_file() -> None:
    """Gains that a study takes from a file for each speed stay what they were when it was opened."""
    loop = short(**LOOPS["rig behind hoses"])
    turned = loop.changed({"rpm": 90.0})
    assert turned.resolved.settings == loop.resolved.settings
    assert turned.case.rpm == 90.0


def test_names_that_do_not_serve_are_not_offered() -> None:
    outcome = outcome_of(opened(None))
    offered = next(one for one in controls_of("friction", outcome) if isinstance(one, Choice))
    assert [name for name, _ in offered.options] == ["lugre"]  # alone has a form for the helical bristle
