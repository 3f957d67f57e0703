"""What a study unfolds into, and what each of its cases runs."""

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from command import DRIVE, FIGURE, STUDY, changed, write

from workbench.errors import UserError
from workbench.study.names import matches
from workbench.study.plan import Plan, needed_trajectories, plan
from workbench.study.reading import read_study
from workbench.study.resolve import Resolved


def planned(folder: Path, text: str) -> Plan:
    """The plan of a study."""
    return plan(read_study(write(folder, text)))


def resolved(folder: Path, text: str) -> list[Resolved]:
    """What the cases of a study run."""
    return planned(folder, text).resolved


def points(folder: Path, text: str) -> list[dict[str, Any]]:
    """The columns of each case."""
    return [case.columns for case in planned(folder, text).cases]


TWO_CONTROLLERS = changed("rpm = [0, 460]", 'rpm = [0, 460]\ncontroller = ["p", "pd"]') + (
    '[controllers.pd]\ntype = "pid"\nkp = "100 V/m"\nkd = "5 V s/m"\n'
)


def test_the_last_axis_changes_fastest(tmp_path: Path) -> None:
    assert points(tmp_path, TWO_CONTROLLERS) == [
        {"rpm": 0, "controller": "p"},
        {"rpm": 0, "controller": "pd"},
        {"rpm": 460, "controller": "p"},
        {"rpm": 460, "controller": "pd"},
    ]


def test_cases_come_first_and_may_have_axes_of_their_own(tmp_path: Path) -> None:
    text = STUDY + '[cases.a.plant.set]\nmass = "30 kg"\n[cases.b]\naxes = { rpm = [120] }\n'
    assert points(tmp_path, text) == [
        {"case": "a", "rpm": 0},
        {"case": "a", "rpm": 460},
        {"case": "b", "rpm": 120},
    ]
    assert planned(tmp_path, text).columns[:3] == ["case", "rpm", "outcome"]


def test_no_axis_is_one_case(tmp_path: Path) -> None:
    study = planned(tmp_path, changed("[axes]\nrpm = [0, 460]\n", ""))
    assert [case.label for case in study.cases] == ["the only case"]
    assert study.columns[0] == "outcome"


def test_columns_are_axes_then_figures_then_probes(tmp_path: Path) -> None:
    study = planned(tmp_path, TWO_CONTROLLERS + '[probes.top_m]\nsignal = "position"\ntake = "maximum"\n')
    assert (study.columns[:3], study.columns[-2:]) == (
        ["rpm", "controller", "outcome"],
        ["solver_rms_error_m", "top_m"],
    )


def test_a_case_overrides_the_study_table_by_table(tmp_path: Path) -> None:
    """What the case does not name stays: the bulk modulus set for all, the controller's type, the duration."""
    text = STUDY + (
        '[plant.set]\nbulk_modulus = "100 MPa"\nmass = "20 kg"\n'
        '[cases.a]\n[cases.b]\nplant = { set = { mass = "30 kg" } }\ncontrollers = { p = { kp = "100 V/m" } }\n'
    )
    a, _, b, _ = (item.setup for item in resolved(tmp_path, text))
    assert (a.parameters.body.mass, b.parameters.body.mass) == (20.0, 30.0)
    assert a.parameters.hydraulics.bulk_modulus == b.parameters.hydraulics.bulk_modulus == 1e8
    assert (a.loop.gains.proportional, b.loop.gains.proportional) == (500.0, 100.0)
    assert a.duration == b.duration == 1.0


SCENARIOS = changed("[0, 460]", '[0]\nscenario = ["nominal", "worn"]') + (
    '[plant.set]\nmass = "30 kg"\n[scenarios.nominal]\n'
    '[scenarios.worn.plant]\nset = { mass = "40 kg" }\nscale = { coulomb = 2.0 }\n'
)
FEEDFORWARD = 'kp = "500 V/m"\nfeedforward = 1.0'


def test_a_scenario_changes_the_truth(tmp_path: Path) -> None:
    nominal, worn = (item.setup.parameters for item in resolved(tmp_path, SCENARIOS))
    assert (nominal.body.mass, worn.body.mass) == (30.0, 40.0)
    assert (nominal.friction.positive.coulomb, worn.friction.positive.coulomb) == (370.0, 740.0)
    assert worn.friction.negative.coulomb == 740.0


def test_scale_changes_both_directions_of_a_set_that_has_them(tmp_path: Path) -> None:
    text = changed("owen2001_simulation", "owen2001_experiment") + "[plant.scale]\ncoulomb = 0.5\n"
    friction = resolved(tmp_path, text)[0].setup.parameters.friction
    assert (friction.positive.coulomb, friction.negative.coulomb) == (165.0, 145.0)


def velocity_gain(supply_pressure: float) -> float:
    """K K_sv sqrt(P_s / 2) / A of the simulation plant, m/s per V: 0.0678 at 2.94 MPa."""
    return float(5.9e-4 * 6e-5 * np.sqrt(supply_pressure / 2.0) / 6.33e-4)


@pytest.mark.parametrize(
    ("change", "believed"),
    [
        ("", 2.94e6),
        ("[plant.scale]\nsupply_pressure = 0.5\n", 2.94e6),
        ('[scenarios.weak.plant.set]\nsupply_pressure = "1 MPa"\n', 2.94e6),
        ('[scenarios.weak.plant.scale]\nsupply_pressure = 0.5\n[belief.set]\nsupply_pressure = "2 MPa"\n', 2e6),
        ('[plant.set]\nsupply_pressure = "1 MPa"\n', 1e6),
        ('[plant.set]\nsupply_pressure = "1 MPa"\n[belief]\nparameters = "owen2001_simulation"\n', 2.94e6),
    ],
    ids=["declared", "scale", "scenario", "told", "declared set", "told the set"],
)
def test_a_controller_believes_what_is_declared_never_the_truth(tmp_path: Path, change: str, believed: float) -> None:
    """Velocity feed-forward is 1 / K_q of the belief: of the declared plant, or of [belief]."""
    axis = '\nscenario = ["weak"]' if "scenarios" in change else ""
    text = changed("[0, 460]", f"[0]{axis}").replace('kp = "500 V/m"', FEEDFORWARD) + change
    gains = resolved(tmp_path, text)[0].setup.loop.gains
    assert gains.feedforward == pytest.approx(1.0 / velocity_gain(believed), rel=1e-9)


def test_a_dotted_axis_is_truth_too(tmp_path: Path) -> None:
    text = changed("rpm = [0, 460]", '"plant.set.supply_pressure" = ["2.94 MPa", "1 MPa"]')
    first, second = (item.setup for item in resolved(tmp_path, text.replace('kp = "500 V/m"', FEEDFORWARD)))
    assert (first.parameters.hydraulics.supply_pressure, second.parameters.hydraulics.supply_pressure) == (2.94e6, 1e6)
    assert first.loop.gains.feedforward == second.loop.gains.feedforward


def test_the_flow_law_believed_is_that_declared(tmp_path: Path) -> None:
    text = changed('"by_rpm"', '"by_rpm"\nflow = "chapter3"').replace('kp = "500 V/m"', FEEDFORWARD)
    gains = resolved(tmp_path, text)[0].setup.loop.gains
    assert gains.feedforward == pytest.approx(1.0 / (velocity_gain(2.94e6) * np.sqrt(2.0)), rel=1e-9)
    told = resolved(tmp_path, text + '[belief]\nflow = "derived"\n')[0].setup.loop.gains
    assert told.feedforward == pytest.approx(1.0 / velocity_gain(2.94e6), rel=1e-9)


def test_dotted_axes_reach_any_key(tmp_path: Path) -> None:
    axes = '"controllers.p.kp" = ["100 V/m", 200]\n"simulation.seed" = [1, 2]\n"sensors.delay" = ["1 ms"]'
    study = planned(tmp_path, changed("rpm = [0, 460]", axes))
    setups = [item.setup for item in study.resolved]
    assert [(setup.loop.gains.proportional, setup.seed) for setup in setups] == [
        (100.0, 1),
        (100.0, 2),
        (200.0, 1),
        (200.0, 2),
    ]
    assert setups[0].sensors.delay == 1e-3
    assert study.columns[:3] == ["controllers.p.kp", "simulation.seed", "sensors.delay"]


@pytest.mark.parametrize(
    ("model", "rpm", "name"),
    [
        ('"by_rpm"', 0, "non_rotating"),
        ('"by_rpm"', 460, "rotating_helical"),
        ('"by_rpm"\nbristle = "isotropic"', 460, "rotating_isotropic"),
        ('"by_rpm"\nrotation = "ideal"', 460, "rotating_helical_ideal"),
        ('"rotating"\nbristle = "isotropic"', 0, "rotating_isotropic"),
        ('"non_rotating"', 0, "non_rotating"),
        ('"rotating_isotropic_ideal"', 460, "rotating_isotropic_ideal"),
    ],
)
def test_the_plant_by_its_model(tmp_path: Path, model: str, rpm: int, name: str) -> None:
    text = changed('"by_rpm"', model).replace("[0, 460]", f"[{rpm}]")
    setup = resolved(tmp_path, text)[0].setup
    assert setup.plant.name == name
    assert setup.rotation_speed == pytest.approx(rpm * 2.0 * np.pi / 60.0, rel=1e-12)


def test_rotation_speed_is_that_asked_for(tmp_path: Path) -> None:
    """460 rpm at a radius of 19 mm: 0.915 m/s of surface speed, from the first instant or from standstill."""
    turning, standstill = (
        resolved(tmp_path, changed('"by_rpm"', f'"by_rpm"\nrotation = "voltage"\nstart = "{start}"'))[1].setup
        for start in ("turning", "standstill")
    )
    assert turning.state.surface_speed == pytest.approx(460.0 * 2.0 * np.pi / 60.0 * 0.019, rel=1e-12)
    assert standstill.state.surface_speed == 0.0
    assert turning.inputs.motor_voltage == standstill.inputs.motor_voltage > 0.0


def test_a_speed_servo_starts_from_the_believed_current(tmp_path: Path) -> None:
    """By default the speed is held by the servo; the friction of the truth is 30 % above that believed."""
    free = changed('model = "by_rpm"', 'model = "by_rpm"\nmotor_limits = false', changed("[0, 460]", "[460]"))
    text = free + "[plant.scale]\ncoulomb = 1.3\nviscous = 1.3\n"
    setup = resolved(tmp_path, free + "[scenarios.up.plant.scale]\ncoulomb = 1.3\n")[0].setup
    current = setup.plant.equilibrium(setup.parameters, setup.state.surface_speed)[0].motor_current
    setup = resolved(tmp_path, text)[0].setup
    assert setup.rotary is not None
    assert setup.inputs.motor_voltage == 0.0
    assert setup.rotary.gains.bias == pytest.approx(current, rel=1e-12)
    assert setup.state.motor_current > 1.2 * current


@pytest.mark.parametrize(
    ("model", "rotation", "drives", "by"),
    [
        ("rotating_helical_ideal", "servo", "motor_voltage", "surface_speed"),
        ("rotating_isotropic", "ideal", "surface_speed", "motor_voltage"),
    ],
)
def test_a_rotation_that_the_plant_does_not_have(
    tmp_path: Path, model: str, rotation: str, drives: str, by: str
) -> None:
    """A registered plant may be named itself; how it is rotated is then decided."""
    text = changed('"by_rpm"', f'"{model}"\nrotation = "{rotation}"').replace("[0, 460]", "[460]")
    with pytest.raises(UserError) as caught:
        resolved(tmp_path, text)
    assert str(caught.value) == (
        f'{tmp_path}/study.toml:4: plant.rotation: "{rotation}" drives {drives}, and {model} is rotated by its {by}; '
        "expected another rotation, or another model"
    )


def test_an_open_loop_command_is_fed_to_its_input(tmp_path: Path) -> None:
    drive = changed('kp = "3 N/m"', 'input = "spring_end"\nhold = "zero"', DRIVE).replace('"pid"', '"open_loop"')
    item = resolved(tmp_path, drive)[0]
    (feed,) = item.setup.feeds
    assert (feed.input, feed.linear, item.setup.reference) == ("spring_end", False, None)
    assert item.signal is feed.signal
    force = changed('kp = "3 N/m"', "", DRIVE).replace('"pid"', '"open_loop"').replace("1 m", "1 N")
    assert resolved(tmp_path, force)[0].setup.feeds[0].input == "drive_force"


def test_sensors_in_si(tmp_path: Path) -> None:
    text = STUDY + (
        '[sensors]\ndelay = "2 ms"\n[sensors.position]\nnoise = "13 um"\nrange = "204.8 mm"\nbits = 12\n'
        'anti_alias = "194 Hz"\n[sensors.pressure_1]\nresolution = "2 kPa"\n'
    )
    item = resolved(tmp_path, text)[0]
    channels = item.setup.sensors.channels
    assert channels["position"].resolution == pytest.approx(50e-6, rel=1e-12)
    assert (channels["position"].noise, channels["position"].anti_alias) == (13e-6, 194.0)
    assert (channels["pressure_1"].resolution, channels["pressure_2"].resolution) == (2000.0, 0.0)
    assert item.setup.sensors.delay == 2e-3
    assert item.band == pytest.approx(50e-6, rel=1e-12), "the larger of 3 sigma, 39 um, and the converter's step"


def test_a_recorded_reference(tmp_path: Path) -> None:
    """Through the file's units; a spline through four points of a cubic is that cubic."""
    rows = "".join(f"{1000 * t:g};{1000 * t**3:g}\n" for t in (0.0, 0.2, 0.5, 1.0))
    write(tmp_path, "time of day;x\n" + rows, "rig.csv")
    recorded = 'kind = "recorded"\nfile = "rig.csv"\ntime = "time of day"\nvalue = "x"\ntime_unit = "ms"\nunit = "mm"'
    text = changed('kind = "sine"\namplitude = "5 mm"\nfrequency = "2 Hz"', recorded)
    reference = resolved(tmp_path, text)[0].setup.reference
    assert reference is not None
    position, velocity, _ = reference(np.array([0.3, 0.7]))
    np.testing.assert_allclose(position, [0.027, 0.343], rtol=1e-9)
    np.testing.assert_allclose(velocity, [0.27, 1.47], rtol=1e-9)


def test_a_triangle_by_its_speed(tmp_path: Path) -> None:
    """5 mm at 20 mm/s: a period of 4 * 5 / 20 = 1 s."""
    text = changed(
        'kind = "sine"\namplitude = "5 mm"\nfrequency = "2 Hz"',
        'kind = "triangle"\namplitude = "5 mm"\nspeed = "20 mm/s"',
    )
    reference = resolved(tmp_path, text)[0].setup.reference
    assert reference is not None
    assert reference.period == pytest.approx(1.0, rel=1e-12)


def test_a_setting_that_one_case_uses_is_no_mistake(tmp_path: Path) -> None:
    """A study that compares plants may set what only one of them has."""
    text = changed("rpm = [0, 460]", '"plant.model" = ["non_rotating", "drive_force"]').replace('"500 V/m"', "500")
    text += '[plant.set]\nvalve_time_constant = "6 ms"\n'
    with pytest.raises(UserError, match=r"study\.toml:24: plant\.set\.force_limi"):
        planned(tmp_path, text + 'force_limit = "1 kN"\nforce_limi = 1.0\n')
    hydraulic, drive = resolved(tmp_path, text + 'force_limit = "1 kN"\n')
    assert hydraulic.setup.parameters.hydraulics.valve_time_constant == 6e-3
    assert drive.setup.parameters.source.force_limit == 1000.0


def test_a_setting_of_a_controller_that_one_case_uses_is_no_mistake(tmp_path: Path) -> None:
    axis = changed("rpm = [0, 460]", '"controllers.p.law" = ["acceleration_feedback", "valve_inversion"]')
    text = axis.replace('"pid"\nkp = "500 V/m"', '"lugre"\nkp = "500 V/m"\nlead = 1')
    assert [item.settings.lead for item in resolved(tmp_path, text)] == [1.0, 1.0]


def test_a_signal_that_one_case_of_a_probe_has_is_no_mistake(tmp_path: Path) -> None:
    probe = '[probes.theta]\nsignal = "controller_theta"\ntake = "final"\n'
    both = TWO_CONTROLLERS.replace('"pid"\nkp = "100 V/m"\nkd = "5 V s/m"', '"lugre"') + probe
    assert planned(tmp_path, both).columns[-1] == "theta"


def test_a_scenario_comes_from_the_study_then_from_beside_it_then_from_the_program(tmp_path: Path) -> None:
    """`friction_up` and `nominal` are shipped; here the study has one of its own, the folder beside it another."""
    (tmp_path / "scenarios").mkdir()
    head = 'title = "t"\nsource = "s"\n[plant.set]\nmass = '
    write(tmp_path / "scenarios", head + '"41 kg"\n', "nominal.toml")
    write(tmp_path / "scenarios", head + '"42 kg"\n', "friction_up.toml")
    text = changed("[0, 460]", '[0]\nscenario = ["friction_up", "nominal", "payload"]')
    text += '[scenarios.friction_up.plant.set]\nmass = "40 kg"\n'
    masses = [item.setup.parameters.body.mass for item in resolved(tmp_path, text)]
    assert masses == [40.0, 41.0, 68.0]


def test_identity_follows_the_numbers_and_not_the_words(tmp_path: Path) -> None:
    """Titles and tables change nothing that is computed; a value of a parameter file does."""
    parameters = 'title = "a"\nsource = "b"\n' + "".join(
        f'[parameters.{name}]\nvalue = {value}\nsource = "rig log"\n'
        for name, value in (
            ("mass", 1.0),
            ("coulomb", 1.0),
            ("stribeck", 0.5),
            ("viscous", 0.4),
            ("stribeck_velocity", 1e-3),
            ("bristle_stiffness", 1e5),
            ("bristle_damping", 300.0),
            ("load_force", 0.0),
            ("end_stop_stiffness", 0.0),
            ("end_stop_damping", 0.0),
        )
    )
    write(tmp_path, parameters, "mine.toml")
    text = changed("canudas1995", "mine.toml", DRIVE)
    first = planned(tmp_path, text).identity
    assert planned(tmp_path, text.replace("for tests", "with another title")).identity == first
    other = planned(tmp_path, text.replace('"3 N/m"', '"4 N/m"')).identity
    assert {name for name in first if first[name] != other[name]} == {"study", "parameters"}
    write(tmp_path, parameters.replace("value = 0.4", "value = 0.5"), "mine.toml")
    other = planned(tmp_path, text).identity
    assert {name for name in first if first[name] != other[name]} == {"parameters"}


def test_conditions_compare_numbers_as_numbers() -> None:
    assert matches({"rpm": 460.0, "controller": "p"}, {"rpm": "460", "controller": "p"})
    assert matches({"rpm": 460}, {"rpm": 460.0})
    assert matches({"levels": '["1 m"]'}, {"levels": ["1 m"]})
    assert not matches({"rpm": 460}, {"rpm": 46})
    assert not matches({"controller": "p"}, {"controller": "pd"})
    assert not matches({}, {"rpm": 0})


def test_only_the_trajectories_that_figures_draw_are_needed(tmp_path: Path) -> None:
    drawn = TWO_CONTROLLERS + FIGURE + 'curves = [{ y = "position", where = { rpm = 460, controller = "pd" } }]\n'
    assert needed_trajectories(planned(tmp_path, drawn)) == {3}
    over_axis = TWO_CONTROLLERS + FIGURE + 'x = "rpm"\ncurves = [{ y = "rms_error_m" }]\n'
    assert needed_trajectories(planned(tmp_path, over_axis)) == set()


@pytest.mark.parametrize(("own", "backward"), [("", 900.0), ('\ncoulomb_negative = "400 N"', 400.0)])
def test_a_plain_name_sets_both_directions(tmp_path: Path, own: str, backward: float) -> None:
    text = changed('parameters = "owen2001_simulation"', 'parameters = "owen2001_experiment"')
    for item in resolved(tmp_path, text + f'[plant.set]\ncoulomb = "900 N"{own}\n'):
        friction = item.setup.parameters.friction
        assert (friction.positive.coulomb, friction.negative.coulomb) == (900.0, backward)
        assert item.belief.friction == friction
