"""What no effect explains, offered as a curve: its parameters, their file, and what switching it on does."""

import tomllib
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from command import Answer
from effect_machines import TRUTH

from plants.effects.attach import meant
from plants.effects.curves import NODES, acting, nodes_of
from plants.registry import plants
from workbench.diagnose.report.folder import plant_file
from workbench.diagnose.report.offered import curve_values, offered_entries
from workbench.diagnose.residuals.along import Along
from workbench.diagnose.residuals.motion import motion_of, signals_of
from workbench.diagnose.result import Diagnosis
from workbench.diagnose.selection.unexplained import Dependence, OfferedTerm, Unexplained
from workbench.parameters.sets import NEUTRAL, build, named_sets, read_parameters
from workbench.records.reading import Record
from workbench.simulation.references import Multisine
from workbench.simulation.setup import Feed, Setup
from workbench.simulation.simulate import simulate


def offered(balance: str, signal: str, nodes: np.ndarray, values: np.ndarray, unit: str) -> Unexplained:
    return Unexplained(Dependence(balance, {signal: 0.6}), OfferedTerm(signal, nodes, values, unit))


FORCE = offered("force", "position", np.linspace(-0.02, 0.03, 24), 40.0 * np.linspace(-1.0, 1.0, 24) ** 2, "N")


def test_a_term_becomes_a_curve_that_is_off() -> None:
    values = curve_values("position_force_curve", FORCE.term)
    assert values["position_force_curve_share"] == 0.0
    assert (values["position_force_curve_low"], values["position_force_curve_high"]) == (-0.02, 0.03)
    found = [values[name] for name in nodes_of("position_force_curve")]
    assert found == pytest.approx(np.interp(np.linspace(-0.02, 0.03, NODES), FORCE.term.nodes, FORCE.term.values))


def test_the_switch_says_how_it_is_used_and_that_no_cause_is_known() -> None:
    share, low, *_ = offered_entries(FORCE, plants()["two_chamber"], {}, "workbench diagnose, e.toml")
    assert share.source.startswith(
        "workbench diagnose, e.toml: not understood: what the force balance lacks, over the "
    )
    assert "names no cause. Off; position_force_curve_share = 1, here or in [plant.set], switches it on" in share.source
    assert low.source == "workbench diagnose, e.toml: see position_force_curve_share"
    assert {entry.std for entry in (share, low)} == {None}


def test_nothing_is_offered_of_which_a_plant_has_no_curve() -> None:
    chambers, drive = plants()["two_chamber"], plants()["drive_force"]
    nodes = np.array([0.0, 1.0])
    assert offered_entries(None, chambers, {}, "s") == []
    assert offered_entries(offered("force", "acceleration", nodes, nodes, "N"), chambers, {}, "s") == []
    assert offered_entries(offered("flow", "position", nodes, nodes, "m^3/s"), drive, {}, "s") == []
    assert offered_entries(FORCE, chambers, {"position_force_curve_share": 1.0}, "s") == []
    turning = offered_entries(FORCE, plants()["rotary_torque"], {}, "s")
    assert turning[0].name == "position_torque_curve_share"


def test_the_file_of_the_corrected_plant_has_it_and_a_plant_of_that_file_has_it_not(
    diagnosed: tuple[Answer, Diagnosis],
) -> None:
    text = plant_file(replace(diagnosed[1], unexplained=FORCE))
    reserve = "something is missing that no effect explains, and no deviation here counts what it moves"
    assert reserve in text
    assert reserve not in plant_file(replace(diagnosed[1], unexplained=None))
    values = {name: entry["value"] for name, entry in tomllib.loads(text)["parameters"].items()}
    assert values["position_force_curve_share"] == 0
    assert values["position_force_curve_12"] == "40 N"
    assert "position_force_curve_share" not in plant_file(diagnosed[1])
    numbers = {**TRUTH, **curve_values("position_force_curve", FORCE.term)}
    chambers = plants()["two_chamber"]
    for share, names in ((0.0, []), (1.0, ["position_force_curve"])):
        felt = acting({**numbers, "position_force_curve_share": share})
        given = [name for name, value in felt.items() if value != NEUTRAL.get(name)]
        assert [effect.name for effect in meant(chambers, given)] == names


def test_a_curve_that_is_switched_on_explains_what_the_balance_lacked() -> None:
    """A machine with a force over the position: its residual as a term, the term as a curve, the residual with that."""
    bare = plants()["two_chamber"]
    machine = bare.with_effects(*meant(bare, ["cogging_cosine"]))
    values = {**read_parameters(named_sets()["owen2001_simulation"]), "stribeck": 0.0}
    parameters = build(machine.Parameters, {**values, "cogging_cosine": 60.0, "cogging_pitch": 0.02})
    state, inputs = machine.equilibrium(parameters, 0.0)
    feed = Feed("valve_voltage", Multisine(0.3, 0.2, (1, 2)))
    run = simulate(Setup(machine, parameters, state, inputs, 10.0, feeds=(feed,)))
    channels = {name: run.signals[name] for name in ("position", "pressure_1", "pressure_2")}
    channels["valve_voltage"] = run.command
    known = np.ones(run.time.size, dtype=bool)
    motion = motion_of(Record("made", Path("made"), "fit", 0.0, run.time, channels, known))
    valid = motion.thinned.valid & ~motion.thinned.resting & (np.abs(motion.thinned.velocity) > 5e-3)
    left = Along(bare, "derived").residuals(motion, values, "force")[0][valid]
    places = signals_of(motion.thinned)["position"][valid]
    edges = np.quantile(places, np.linspace(0.0, 1.0, 25))
    bins = np.clip(np.searchsorted(edges, places) - 1, 0, 23)
    nodes, means = (np.array([np.mean(of[bins == each]) for each in range(24)]) for of in (places, left))
    found = curve_values("position_force_curve", OfferedTerm("position", nodes, means, "N"))
    plant = bare.with_effects(*meant(bare, list(found)))
    after = Along(plant, "derived").residuals(motion, {**values, **found, "position_force_curve_share": 1.0}, "force")
    assert np.std(left) > 20.0
    assert np.sqrt(np.mean(after[0][valid] ** 2)) < 0.3 * np.sqrt(np.mean(left**2))
