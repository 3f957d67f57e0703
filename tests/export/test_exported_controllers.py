"""Controllers as C against the same equations in Python: every one is written, some are compiled and replayed."""

import ctypes
from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any, NamedTuple

import numpy as np
import pytest
from combinations import Machine, required
from export_proof import COMMIT, MACHINES, PLACES, STEP, TURNING, resolved_setup, study_content

from controllers.compensation import LAWS, compensator
from controllers.ekf_compensation import ekf_compensator
from controllers.estimators import ESTIMATORS
from controllers.interface import Controller, Reference
from controllers.registry import controllers
from controllers.rotation_on_demand import SCHEDULED_ROTATION, SWITCHED_ROTATION
from controllers.speed_servo import SPEED_SERVO
from plants.equation import from_array, to_array
from plants.interface import Measurement
from workbench.errors import UserError
from workbench.export.controller import exported_loop
from workbench.export.recorded import recorded
from workbench.export.statements import SINGLE, statements
from workbench.export.structs import structs
from workbench.rehearse.lockstep import loaded
from workbench.simulation.setup import Loop, Setup

STEPS, LIMIT = 400, 10.0
TURNS = Machine("non_rotating", "anisotropic")


def loop_of(machine: Machine, name: str, folder: Path, law: str = "", **plant: Any) -> Setup:
    table = {"type": name, **required(name), **({"law": law} if law else {})}
    return resolved_setup(study_content(machine, table, folder, **plant), folder)


def every_controller() -> Iterator[Controller]:
    """Each that is registered, by each law, with measured pressures and without; and what turns the rod."""
    for name, controller in controllers().items():
        if name in ESTIMATORS:
            yield from (compensator(name, law, pressures) for law in LAWS for pressures in (True, False))
        elif name == "ekf":
            yield from (ekf_compensator(law) for law in LAWS if law != "force_source")
        else:
            yield controller
    yield from (SPEED_SERVO, *SCHEDULED_ROTATION.values(), *SWITCHED_ROTATION.values())


def test_every_controller_with_every_law_is_written() -> None:
    for controller in every_controller():
        found = recorded(controller, Measurement._fields)
        for function in (found.start, found.step, found.commit):
            lines = statements(found.recording, function, SINGLE)
            assert all(len(line) <= 130 for line in lines)
            assert not any("double" in line or " while (" in line for line in lines)
        assert set(found.start) >= {place for place in (*found.step, *found.commit) if place}
        assert all(path[0] in controller.State._fields for path in found.used.state)


def made_up_inputs(setup: Setup) -> tuple[np.ndarray, np.ndarray]:
    """References and readings that cross rest, reverse, and go beyond what the machine can do."""
    time = np.arange(STEPS) * setup.sample_time
    rng = np.random.default_rng(1)

    def noise(deviation: float) -> np.ndarray:
        return deviation * rng.standard_normal(STEPS)

    motion = 0.02 * np.sin(40.0 * time), 0.8 * np.cos(40.0 * time), -32.0 * np.sin(40.0 * time)
    shown = set(setup.plant.channels)
    scales = {"pressure_1": 1e6, "pressure_2": 1e6, "rotation_speed": 20.0, "motor_current": 3.0, "friction": 400.0}
    columns = [
        0.018 * np.sin(40.0 * time - 0.3) + noise(1e-5)
        if name == "position"
        else (
            scales[name] * (1.0 + np.sin(17.0 * time) + 0.01 * rng.standard_normal(STEPS))
            if name in shown
            else np.nan * time
        )
        for name in Measurement._fields
    ]
    return np.column_stack(motion), np.column_stack(columns)


def in_python(setup: Setup, loop: Loop, references: np.ndarray, readings: np.ndarray) -> np.ndarray:
    """Commands of the equations as they stand, limited; half way they start anew."""
    controller, gains, commands = loop.controller, loop.gains, []
    with np.errstate(all="ignore"):
        for i, (wanted, reading) in enumerate(zip(references, readings, strict=True)):
            seen = Measurement(*map(float, reading))
            if i in (0, STEPS // 2):
                state = controller.start(seen, gains)
            command, state = controller.step(Reference(*map(float, wanted)), seen, state, gains, setup.sample_time)
            commands.append(float(np.clip(command, -LIMIT, LIMIT)))
            state = controller.commit(commands[-1], state, gains, setup.sample_time)
            state = from_array(controller.State, to_array(state).tolist())
    return np.array(commands)


def in_c(setup: Setup, loop: Loop, folder: Path, references: np.ndarray, readings: np.ndarray) -> np.ndarray:
    """The same of their C."""
    controller = loaded(exported_loop(setup, loop, "own", "test", "double"), folder)
    step, commit = STEP(controller.addresses[0]), COMMIT(controller.addresses[1])
    gains, commands = to_array(loop.gains), np.empty(STEPS)
    for i in range(STEPS):
        if i in (0, STEPS // 2):
            state = to_array(controller.start(Measurement(*readings[i].tolist()), loop.gains))
        rows = [row.ctypes.data_as(PLACES) for row in (references[i], readings[i], state, gains)]
        commands[i] = np.clip(step(*rows, setup.sample_time), -LIMIT, LIMIT)
        commit(commands[i], *rows[2:], ctypes.c_double(setup.sample_time))
    return commands


@pytest.mark.parametrize(
    ("name", "law", "machine", "rotary"),
    [
        ("pid", "", MACHINES[0], False),
        ("dither", "", MACHINES[0], False),
        ("nonlinear_pi", "", MACHINES[0], False),
        ("lugre_adaptive", "valve_inversion", TURNS, False),
        ("friedland_park", "acceleration_feedback", TURNS, False),
        ("tafazoli", "force_source", Machine("drive_force"), False),
        ("ekf", "valve_inversion", TURNS, False),
        ("pid", "", TURNS, True),
    ],
)
def test_c_gives_the_commands_of_the_equations(
    name: str, law: str, machine: Machine, rotary: bool, tmp_path: Path
) -> None:
    setup = loop_of(machine, name, tmp_path, law)
    loop = setup.rotary if rotary else setup.loop
    assert loop is not None
    references, readings = made_up_inputs(setup)
    if rotary:
        references[:, 0] = setup.rotation_speed
    own = in_python(setup, loop, references, readings)
    assert np.all(np.isfinite(own))
    assert np.ptp(own) > 0.1
    np.testing.assert_allclose(
        in_c(setup, loop, tmp_path / "c", references, readings), own, rtol=0.0, atol=1e-10 * LIMIT
    )


@pytest.mark.parametrize("kind", ["scheduled", "switched"])
def test_c_of_rotation_on_demand(kind: str, tmp_path: Path) -> None:
    how = {"minimum_helical_speed": 0.5} if kind == "scheduled" else {"switch_speed": 0.3}
    setup = loop_of(Machine(TURNING[0]), "pid", tmp_path, rotation=kind, **how)
    assert setup.rotary is not None
    references, readings = made_up_inputs(setup)
    references[:, 0] = setup.rotation_speed
    own = in_python(setup, setup.rotary, references, readings)
    assert np.ptp(own) > 0.1
    found = in_c(setup, setup.rotary, tmp_path / "c", references, readings)
    np.testing.assert_allclose(found, own, rtol=0.0, atol=1e-10 * LIMIT)


def test_a_field_that_c_knows_as_its_own_word_is_told() -> None:
    class Gains(NamedTuple):
        register: Annotated[float, "V"]

    with pytest.raises(UserError, match=r"Gains\.register: C knows this word as its own; give the field another name"):
        structs(Gains, [("register",)], "gains", "p", "double", str, set())
