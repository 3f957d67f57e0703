"""Balances of every plant: what a record of it leaves of its own equations, with no code for that plant."""

from pathlib import Path

import numpy as np
import pytest
from thesis_actuator import OF_OTHERS
from thesis_actuator import along as numbers_along

from plants.effects.attach import meant
from plants.effects.chambers import stiffness
from plants.effects.interface import Scales
from plants.effects.registry import effects
from plants.interface import Plant
from plants.laws.elasto_plastic import ELASTO_PLASTIC
from plants.laws.interface import FrictionLaw
from plants.laws.maxwell_slip import GMS
from plants.registry import plants
from workbench.diagnose.residuals.along import Along
from workbench.diagnose.residuals.balances import allowed, diagnosed_plant, own_parameters
from workbench.diagnose.residuals.motion import Motion, motion_of
from workbench.diagnose.residuals.null import null_motion
from workbench.diagnose.residuals.shown import balances_shown
from workbench.diagnose.residuals.unknowns import unknown
from workbench.diagnose.residuals.walk import _step
from workbench.parameters.sets import build, named_sets, read_parameters
from workbench.records.reading import Record
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate

VALUES = {
    **read_parameters(named_sets()["owen2001_simulation"]),
    "pump_displacement": 2.5e-7,
    **OF_OTHERS,
    "stribeck": 0.0,
}
"""Without the fall of friction at low speed: nothing then breaks away faster than a smoothed record shows."""

SPEED = 10.0
"""rad/s of a rod that can turn."""

AIR = 0.5 * VALUES["supply_pressure"] / (287.05 * 293.15)
"""kg/m^3: a flow of air is a mass, at about half the supply's pressure."""

SLIDES = 5e-3
"""m/s. Slower, a reversal is near: the smoothing of a record blurs what friction does there."""

AMPLITUDES = {
    "valve_voltage": 0.3,
    "pump_speed": 40.0,
    "drive_force": 900.0,
    "drive_voltage": 9.0,
    "drive_current": 18.0,
}


def values_of(plant: Plant) -> dict[str, float]:
    """The parameters; a drive has a spring, so that a force moves it to and fro."""
    return numbers_along(plant, {**VALUES, "spring_stiffness": 2e4} if plant.command.startswith("drive") else VALUES)


def motion_along(
    plant: Plant,
    flow: str = "derived",
    values: dict[str, float] | None = None,
    lines: tuple[int, ...] = (1, 2),
    sample_time: float = 1e-3,
) -> Motion:
    """10 s of a plant under a command, `lines` times 0.2 Hz, as its sensors show them without noise."""
    parameters = build(plant.Parameters, values or values_of(plant), flow)
    state, inputs = plant.equilibrium(parameters, SPEED * VALUES["piston_radius"])
    feed = Feed(plant.command, Multisine(numbers_along(plant, AMPLITUDES)[plant.command], 0.2, lines))
    run = simulate(Setup(plant, parameters, state, inputs, 10.0, sample_time=sample_time, feeds=(feed,)))
    assert run.outcome == "completed"
    channels = {name: run.measurements[:, place] for place, name in enumerate(plant.channels)}
    channels[plant.command] = run.inputs[:, plant.input_index(plant.command)]
    if plant.rotary_command is not None:
        channels["rotation_speed"] = channels.get("rotation_speed", np.full(run.time.size, SPEED))
    if plant.rotary_command == "motor_voltage":
        channels["motor_voltage"] = run.inputs[:, plant.input_index("motor_voltage")]
    return motion_of(Record("made", Path("made"), "fit", 0.0, run.time, channels, np.ones(run.time.size, dtype=bool)))


def left(along: Along, motion: Motion, balance: str, values: dict[str, float] | None = None) -> float:
    """Rms of a balance where the rod slides, as a share of what is large in it."""
    sliding = (motion.valid & (np.abs(motion.velocity) > SLIDES))[:: motion.thinning]
    density = AIR if "pneumatics" in along.plant.Parameters._fields else 1.0
    large = {
        "force": VALUES["coulomb"],
        "flow": density * VALUES["piston_area_1"] * float(np.std(motion.velocity)),
        "rotation": VALUES["coulomb"] * VALUES["piston_radius"],
        "motor": 1.0,
        "velocity": float(np.std(motion.velocity)),
    }
    residuals = along.residuals(motion, values or values_of(along.plant), balance)
    return max(float(np.sqrt(np.mean(residual[sliding] ** 2))) for residual in residuals) / large[balance]


DIAGNOSED = [plant for plant in plants().values() if plant.balances]


@pytest.mark.parametrize("plant", DIAGNOSED, ids=lambda plant: plant.name)
def test_every_plant_leaves_next_to_nothing_of_its_own_balances(plant: Plant) -> None:
    motion = motion_along(plant)
    along = Along(plant, "derived")
    balances = list(balances_shown(plant, motion.channels))
    assert ("velocity" in balances) == bool(plant.delayed)
    assert ("force" in balances) == (not plant.delayed)
    assert ("flow" in balances) == (plant.command in ("valve_voltage", "pump_speed") and not plant.delayed)
    assert ("rotation" in balances) == (plant.rotary_command == "motor_voltage")
    for name in balances:
        assert left(along, motion, name) < 0.01, name


def test_the_flow_law_of_an_experiment_holds_for_its_balances() -> None:
    plant = plants()["non_rotating"]
    motion = motion_along(plant, "chapter3")
    shares = {flow: left(Along(plant, flow), motion, "flow") for flow in ("derived", "chapter3")}
    assert shares["chapter3"] < 0.01
    assert shares["derived"] > 0.2


@pytest.mark.parametrize("sample_time", [1e-3, 1e-2])
def test_bristles_that_relax_within_a_sample_leave_next_to_nothing(sample_time: float) -> None:
    """Their damping shows a bend that lags: half a sample of lag is 7 % of friction at 100 Hz."""
    plant, stiff = plants()["rotating_isotropic_ideal"], {**VALUES, "bristle_stiffness": 5e7, "bristle_damping": 2e5}
    motion = motion_along(plant, values=stiff, sample_time=sample_time)
    assert left(Along(plant, "derived"), motion, "force", stiff) < 1e-4


@pytest.mark.parametrize("law", [GMS, ELASTO_PLASTIC], ids=lambda law: law.name)
@pytest.mark.parametrize(("sample_time", "share"), [(1e-3, 0.005), (1e-2, 0.02)])
def test_a_contact_that_sticks_and_slips_within_a_sample_is_followed(
    law: FrictionLaw, sample_time: float, share: float
) -> None:
    """As if its rates went on as they were, it would run away: by 0.7 of friction at 1 kHz."""
    refit = plants()["drive_force"].refit
    assert refit is not None
    plant = refit(law)
    assert left(Along(plant, "derived"), motion_along(plant, sample_time=sample_time), "force") < share


@pytest.mark.parametrize("decay", [0.0, 1e-3, 1.8, 40.0])
@pytest.mark.parametrize("ahead", [0.0, 1e-3, 1.8, 1e4])
def test_a_bristle_does_not_overshoot_at_a_reversal(decay: float, ahead: float) -> None:
    """Fully bent one way, it is drawn to either side, as fast as may be, and stays between the two."""
    for settles in ((-1.0, -1.0), (1.0, -1.0), (-1.0, 1.0)):
        moved = 1.0 + _step(decay, ahead, decay * (settles[0] - 1.0), ahead * (settles[1] - 1.0))
        assert -1.0 - 1e-12 <= moved <= 1.0 + 1e-12


def test_a_linear_balance_holds_for_a_motion_that_is_sampled_coarsely() -> None:
    """A position differentiated twice is as sharp at 5 Hz in a record of 100 Hz as pressures are. What is left comes
    of the command, which is held from sample to sample and makes faster motions than samples show.
    """
    smooth = {"coulomb": 1e-3, "bristle_stiffness": 1.0, "bristle_damping": 0.0}
    plant, heavy = plants()["pump_cylinder"], {**VALUES, "mass": 500.0, **smooth}
    motion = motion_along(plant, values=heavy, lines=(5, 25), sample_time=1e-2)
    inertia = heavy["mass"] * float(np.std(motion.acceleration[motion.valid]))
    assert left(Along(plant, "derived"), motion, "force", heavy) * VALUES["coulomb"] < 5e-3 * inertia


@pytest.mark.parametrize("name", ["rotating_isotropic", "rotating_isotropic_ideal"])
def test_a_simulation_that_lacks_nothing_turns_as_the_record_does(name: str) -> None:
    """The voltage that holds the rod's speed at rest is not added to the recorded one."""
    plant = plants()[name]
    motion, along = motion_along(plant), Along(plant, "derived")
    null = null_motion(along, motion, VALUES, 0)
    assert null is not None
    assert np.mean(null.channels["rotation_speed"]) == pytest.approx(SPEED, rel=1e-2)
    for balance in balances_shown(plant, null.channels):
        assert left(along, null, balance) < 0.02, balance


def test_a_plant_that_delays_its_command_is_not_given_a_late_one() -> None:
    plant = plants()["non_rotating"].with_effects(effects()["command_delay"])
    late = {**values_of(plant), "command_delay": 0.03}
    motion = motion_along(plant, values=late)
    assert left(Along(plant, "derived"), motion, "flow", late) < 0.005  # 0.067 of a command that is late twice


def test_air_counts_in_the_measure_of_a_flow() -> None:
    """C = V / (4 beta) in stiff oil, more by what is soft: or a residual was made small by air and ever stiffer oil."""
    bare = plants()["non_rotating"]
    plant = bare.with_effects(effects()["entrained_air"])

    def scale(values: dict[str, float]) -> float:
        return plant.balances["flow"].scale(build(plant.Parameters, values))[0]

    (capacity,) = bare.balances["flow"].scale(build(bare.Parameters, VALUES))
    softer = stiffness(0.5 * VALUES["supply_pressure"], VALUES["bulk_modulus"], 0.05)
    assert scale({**VALUES, "air_fraction": 0.05}) == pytest.approx(capacity / softer)
    assert capacity / softer > 2.0 * capacity
    assert scale(VALUES) == pytest.approx(capacity)


def test_a_balance_needs_the_channels_that_its_equations_depend_on() -> None:
    plant = plants()["rotating_isotropic"]
    assert list(balances_shown(plant, ["position", "pressure_1", "pressure_2"])) == []
    turning = ["position", "pressure_1", "pressure_2", "rotation_speed"]
    assert list(balances_shown(plant, turning)) == ["force"]
    assert list(balances_shown(plant, [*turning, "valve_voltage"])) == ["flow", "force"]
    assert list(balances_shown(plant, [*turning, "motor_current"])) == ["force", "rotation"]


def test_what_cannot_be_negative_is_not_fitted_below_0() -> None:
    scales = Scales(
        **{"force": 500.0, "drive": 2e3, "travel": 0.1, "turn": np.inf, "speed": 0.1, "pressure": 1e6, "flow": 1e-4},
        **{"spool": 1e-3, "voltage": 10.0, "conductance": 1e-10, "duration": 10.0, "sample_time": 1e-3},
    )
    assert unknown("stribeck_negative", {"stribeck": 0.0}, {}, scales).low == 0.0


@pytest.mark.parametrize(("sample_time", "share"), [(1e-3, 0.002), (1e-2, 0.02)])
def test_a_spool_that_swings_behind_a_play_is_followed(sample_time: float, share: float) -> None:
    """Nobody looks for them, but a plant that is declared with them has them in its diagnosis."""
    given = {"valve_hysteresis": 0.05, "valve_natural_frequency": 60.0}
    values, bare = {**VALUES, **given}, plants()["cylinder"]
    plant = bare.with_effects(*meant(bare, [*given]))
    motion = motion_along(plant, values=values, sample_time=sample_time)
    along = diagnosed_plant(plant, "derived", motion.channels)
    assert {"valve_hysteresis", "valve_dynamics"} <= set(along.plant.effects)
    assert left(along, motion, "flow", values) < share
    assert left(Along(bare, "derived"), motion, "flow") > 0.1


def test_friction_of_either_direction_is_fitted_where_it_has_a_value_of_its_own() -> None:
    """A machine that is declared to differ with direction lacks no asymmetry: its baseline has it."""
    channels = ("valve_voltage", "position", "pressure_1", "pressure_2")
    balances = allowed(plants()["cylinder"], "derived", channels)
    alike = own_parameters(balances, None, VALUES)["force"]
    apart = own_parameters(balances, None, {**VALUES, "viscous_negative": 0.7 * VALUES["viscous"]})["force"]
    assert {"coulomb", "viscous"} <= set(alike)
    assert set(apart) - set(alike) == {"viscous_negative"}
