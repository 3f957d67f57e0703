"""Small changes of a simulation by the variational equation along it: as simulations of their own have them."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from diagnosis.generator import make_experiment
from driven import driven_shooting
from family.cases import NONE, make_cases
from family.making import make
from numpy.typing import ArrayLike

from plants.effects.attach import possible
from plants.effects.curves import CURVES
from plants.effects.interface import Effect
from plants.effects.registry import effects
from workbench.diagnose.readiness import declared_values, motions_of
from workbench.diagnose.residuals.along import Along
from workbench.diagnose.residuals.motion import Motion
from workbench.diagnose.simulation import to_first_order, variations
from workbench.diagnose.simulation.setup import shooting_of
from workbench.diagnose.simulation.shooting import Shooting
from workbench.diagnose.simulation.to_first_order import errors_near
from workbench.diagnose.simulation.together import Asked, Push, errors_of
from workbench.diagnose.simulation.variations import Varied
from workbench.records.experiment import read_experiment
from workbench.records.reading import read_records

Made = tuple[Shooting, Motion, dict[str, float]]

NEARLY = 0.03
"""Share of a change by which first order may be off: its second order, and the solver's error."""


@pytest.fixture(scope="module", params=[True, False], ids=["held", "lines"])
def made(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Made:
    """A cylinder of the thesis along 6 s, whose command is held from sample to sample, or a straight line."""
    folder = tmp_path_factory.mktemp("cylinder")
    path = make_experiment(folder, {}, 5)
    pd.read_parquet(folder / "fit.parquet").iloc[:6000].to_parquet(folder / "fit.parquet")
    experiment = read_experiment(path)
    (motion,) = motions_of(experiment, read_records(experiment))
    how, values = shooting_of(experiment, [motion], held=request.param), declared_values(experiment)
    assert how is not None
    return how.with_tolerance(1e-9), motion, values


def answering(how: Shooting, motion: Motion, values: dict[str, float]) -> Varied:
    varied = Varied.of(Asked(how, motion, values))
    assert varied is not None
    return varied


def off(errors: ArrayLike, told: ArrayLike) -> float:
    return float(np.linalg.norm(np.subtract(errors, told)) / np.linalg.norm(errors))


@pytest.mark.parametrize("on_command", [False, True])
def test_pushes_make_what_simulations_of_their_own_show(made: Made, on_command: bool) -> None:
    how, motion, values = made
    varied = answering(*made)
    time = motion.record.time
    pushes = [np.ones(time.size), np.sin(8.0 * time), (time > 2.0) * 1.0]
    told = varied.pushed(pushes, on_command)
    (base,) = errors_of([Asked(how, motion, values)])
    for push, changed in zip(pushes, told, strict=True):
        size = 1.0 / np.linalg.norm(changed)  # larger waves shake the contact loose
        pushed = replace(how, push=Push(on_command, {motion.record: size * push}))
        (there,) = errors_of([Asked(pushed, motion, values)])
        assert off(np.subtract(there, base), size * np.array(changed)) < NEARLY


@pytest.mark.parametrize(
    ("effect", "changed"),
    [
        (effects("m")["cogging"], {"cogging_cosine": 0.4, "cogging_sine": -0.2, "cogging_pitch": 0.004}),
        (effects("m")["cushion"], {"cushion_stiffness": 100.0, "cushion_start": 0.003}),
        (CURVES["flow", "pressure_1"], {"pressure_1_flow_curve_05": 2e-11, "pressure_1_flow_curve_06": -1e-11}),
    ],
    ids=lambda item: item.name if isinstance(item, Effect) else "",
)
def test_what_pushes_by_itself_makes_what_simulations_show(
    made: Made, effect: Effect, changed: dict[str, float]
) -> None:
    how, motion, values = made
    plain = dict(values)
    if effect.name.endswith("curve"):
        plain |= {"pressure_1_flow_curve_share": 1.0, "pressure_1_flow_curve_low": 0.0}
        plain |= {"pressure_1_flow_curve_high": 5e6}
        how = replace(how, along=Along(how.along.plant.with_effects(effect), how.along.flow))
    varied = answering(*made)
    (told,) = varied.having(how, [{**plain, **changed}], plain)
    base, there = errors_of([Asked(how, motion, each) for each in (plain, {**plain, **changed})])
    assert 1.0 < np.linalg.norm(np.subtract(there, base)) < 300.0, "felt, and not much more"
    assert off(np.subtract(there, base), told) < NEARLY


@pytest.mark.parametrize("kind", ["plant", "parameters", "rates", "reading", "start"])
def test_what_does_not_push_but_remembers_nothing_makes_what_simulations_show(made: Made, kind: str) -> None:
    """A number of the plant's own or of an effect, whatever it changes."""
    how, motion, values = made
    ways = {
        "plant": {"valve_overlap": 2e-9, "coulomb_negative": values["coulomb"] * 1.0001},
        "parameters": {"friction_gradient": 1e-3, "droop_resistance": 1e5},
        "rates": {"air_fraction": 3e-5, "volume_share": 1e-4},
        "reading": {"position_ripple_cosine": 3e-7, "position_ripple_pitch": 0.003},
        "start": {"load_force": 0.1},
    }
    changed = {**values, **ways[kind]}
    (told,) = answering(*made).having(how, [changed], values)
    base, there = errors_of([Asked(how, motion, each) for each in (values, changed)])
    assert 1.0 < np.linalg.norm(np.subtract(there, base)) < 300.0, "felt, and not much more"
    assert off(np.subtract(there, base), told) < NEARLY


@pytest.mark.parametrize(
    "remembers",
    [
        {"backlash_width": 1e-6},
        {"backlash_width": 2e-4},
        {"memory_time": 0.02},
        {"position_sensor_lag": 5e-3},
        {"slip_level": 50.0, "slip_stiffness": 1e6},
    ],
    ids=["narrow", "wide", "memory", "lag", "slip"],
)
def test_beside_what_remembers_the_same_it_is_told_too(made: Made, remembers: dict[str, float]) -> None:
    """A flank that carries a sensor forgets what was before; between two flanks it is kept."""
    how, motion, plain = made
    values = {**plain, **remembers}
    varied = answering(how, motion, values)
    ways = [{"spring_stiffness": 20.0}, {"coulomb_negative": values["coulomb"] * 1.0001}, {"load_force": 0.1}]
    changed = [{**values, **way} for way in ways]
    base, *there = errors_of([Asked(how, motion, each) for each in (values, *changed)])
    for one, told in zip(there, varied.having(how, changed, values), strict=True):
        assert off(np.subtract(one, base), told) < NEARLY


def test_what_pushes_on_a_turning_axis_makes_what_simulations_show(tmp_path: Path) -> None:
    case = next(case for case in make_cases("tuning", [NONE]) if case.machine == "rotary")
    experiment = read_experiment(make(case, tmp_path))
    (motion,) = motions_of(experiment, read_records(experiment, "fit"))
    how, values = shooting_of(experiment, [motion], held=True), declared_values(experiment)
    assert how is not None
    how = how.with_tolerance(1e-9)
    varied = answering(how, motion, values)
    (name,) = effects("rad")["spring_load"].own_names
    unit = {**values, name: 1e-6 * how.scales.force}
    felt = np.linalg.norm(varied.having(how, [unit], values)[0])
    small = {**values, name: unit[name] / felt}
    (told,) = varied.having(how, [small], values)
    base, there = errors_of([Asked(how, motion, each) for each in (values, small)])
    assert off(np.subtract(there, base), told) < NEARLY


def test_many_that_push_are_told_near_one_and_what_remembers_is_simulated(
    made: Made, monkeypatch: pytest.MonkeyPatch
) -> None:
    how, motion, values = made
    simulated = list[Asked]()

    def counting(asked: Sequence[Asked]) -> list[list[np.ndarray]]:
        simulated.extend(asked)
        return errors_of(asked)

    monkeypatch.setattr(to_first_order, "errors_of", counting)
    many = [Asked(how, motion, {**values, "spring_stiffness": float(k)}) for k in range(1, to_first_order.WORTH + 1)]
    play = Asked(how, motion, {**values, "backlash_width": 1e-5})
    late = Asked(how, motion, {**values, "command_delay": 1e-5})
    told = errors_near(how, values, [*many, late, play])
    assert {play, late} <= {*simulated}
    assert not {*many} & {*simulated}
    assert off(errors_of([many[-1]])[0], told[-3]) < NEARLY
    np.testing.assert_array_equal(told[-1], errors_of([play])[0])


def test_what_starts_more_than_once_or_a_loop_leads_answers_nothing(made: Made) -> None:
    how, motion, values = made
    assert Varied.of(Asked(replace(how, length=1.0), motion, values)) is None
    assert Varied.of(Asked(how.led([motion], values, 50.0), motion, values)) is None


def test_what_is_not_as_first_order_tells_is_not_told(made: Made, monkeypatch: pytest.MonkeyPatch) -> None:
    how, motion, values = made
    monkeypatch.setattr(variations, "RIGHT", 0.0)
    assert Varied.of(Asked(how, motion, values)) is None


def test_sensors_that_show_otherwise_need_no_simulation_of_their_own(tmp_path: Path) -> None:
    """And are the same bits as if they had one."""
    how, (motion,), values = driven_shooting(tmp_path, 5e-6, 4.0)
    waves = {"position_ripple_cosine": 1e-5, "position_ripple_sine": -2e-6, "position_ripple_pitch": 0.003}
    assert {*waves} <= how.along.shown_alone
    assert not {"backlash_width", "pressure_1_offset", "position_sensor_lag"} & how.along.shown_alone
    asked = Asked(how, motion, {**values, **waves})
    assert asked.moving == Asked(how, motion, values)
    ((_, run),) = how.runs(motion, {**values, **waves})
    assert any(effect.name == "sensor_nonlinearity" for effect in possible(how.along.plant))
    for one, other in zip(errors_of([asked])[0], how.off_by(motion, [(0, run)]), strict=True):
        np.testing.assert_array_equal(one, other)
    led = how.led([motion], values, 50.0)
    led_asked = Asked(led, motion, {**values, **waves})
    assert led_asked.moving is led_asked, "a loop sees them"
