"""Whatever is true of a machine, what it is told to do follows from its sensors and from what is believed of it.

Every parameter of the truth is changed, one at a time, by a scenario. What a study then makes of the case must be the
same to the last bit: the inputs before any command, the wanted speed of rotation, feeds; and so must be every
command of every drive over the same record of the sensors.
"""

from pathlib import Path

import numpy as np
import pytest
from support import replayed_commands

from controllers.interface import Controller
from controllers.registry import controllers
from controllers.settings import settings_of
from plants.equation import fields, to_array
from plants.interface import Measurement, Plant
from plants.registry import plants
from workbench.parameters.sets import EITHER_SIGN, FLOW_SHARE
from workbench.simulation.simulate import Loop, Setup
from workbench.study.reading import read_study
from workbench.study.resolve import resolve
from workbench.study.unfold import unfold

PLANTS = {
    "rotating_helical": "owen2001_simulation",
    "rotating_isotropic": "owen2001_simulation",
    "rotating_anisotropic": "owen2001_experiment",
    "rotating_isotropic_ideal": "owen2001_simulation",
    "rotating_anisotropic_ideal": "owen2001_experiment",
    "non_rotating": "owen2001_experiment",
    "two_chamber": "owen2001_simulation",
    "drive_force": "owen2001_simulation",
}
ROTATIONS = {
    "motor_voltage": ("servo", "voltage", "scheduled"),
    "surface_speed": ("ideal", "scheduled"),
    None: ("servo",),
}
TURNED = [(name, rotation) for name in PLANTS for rotation in ROTATIONS[plants()[name].rotary_command]]

NEEDED = {"kp": 300.0}
"""Settings without a default; any other is 1."""

SAMPLES = 12


def table(name: str, controller: Controller) -> str:
    needed = [item.name for item in settings_of(controller.Settings).values() if item.default is None]
    return f'[controllers.{name}]\ntype = "{name}"\n' + "\n".join(f"{n} = {NEEDED.get(n, 1.0)}" for n in needed)


def changed_truths(plant: Plant, values: dict[str, float]) -> dict[str, str]:
    """A scenario for each parameter of the plant: 1.2 times its value; of 0 or none at all, a small one."""
    found = {"as_believed": ""}
    for item in fields(plant.Parameters):
        if item.name == FLOW_SHARE:
            found["flow"] = '[scenarios.flow.plant]\nflow = "chapter3"\n'
            continue
        value = values[item.name]
        other = 1.2 * value if np.isfinite(value) and value else (10.0 if item.name in EITHER_SIGN else 1e-3)
        alike = ("piston_area_1", "piston_area_2") if item.name.startswith("piston_area") else (item.name,)
        lines = "".join(f"{name} = {other!r}\n" for name in alike)
        found[item.name] = f"[scenarios.{item.name}.plant.set]\n{lines}"
    return found


def setups(folder: Path, plant: str, rotation: str, controller: str) -> dict[str, Setup]:
    """A case as each of the changed machines has it, by what is changed."""
    cls = plants()[plant]
    base = (
        f'title = "t"\n[plant]\nmodel = "{plant}"\nparameters = "{PLANTS[plant]}"\n'
        + (f'rotation = "{rotation}"\n' if cls.rotary_command else "")
        + f"[axes]\nrpm = [{25 if cls.rotary_command else 0}]\nscenario = [SCENARIOS]\n"
        + table(controller, controllers()[controller])
        + '\n[references.sine]\nkind = "sine"\n'
        f"amplitude = {1.0 if controller == 'open_loop' else 5e-3}\nfrequency = 1.0\n"
        '[simulation]\nduration = "1 s"\n'
        + ("[sensors]\nfriction_gauge = true\n" if controllers()[controller].gauge else "")
    )

    def resolved(scenarios: dict[str, str]) -> dict[str, Setup]:
        names = ", ".join(f'"{name}"' for name in scenarios)
        (folder / "study.toml").write_text(
            base.replace("SCENARIOS", names) + "[scenarios.as_believed]\n" + "".join(scenarios.values()),
            encoding="utf-8",
        )
        study = read_study(folder / "study.toml")
        return dict(zip(scenarios, (resolve(study, case).setup for case in unfold(study)), strict=True))

    believed = resolved({"as_believed": ""})["as_believed"]
    names = [item.name for item in fields(cls.Parameters)]
    return resolved(changed_truths(cls, dict(zip(names, to_array(believed.parameters).tolist(), strict=True))))


def record(setup: Setup) -> list[Measurement]:
    """Readings about those at the start, the same for every machine."""
    random = np.random.default_rng(3)
    size = np.array([1e-3, 1e5, 1e5, 0.5, 0.5, 10.0])
    first = np.nan_to_num(to_array(setup.plant.measure(setup.state, setup.parameters)))
    return [Measurement(*map(float, first + size * random.normal(size=size.size))) for _ in range(SAMPLES)]


def commands(
    loop: Loop | None, setup: Setup, readings: list[Measurement], wanted: list[tuple[float, float, float]]
) -> bytes:
    if loop is None:
        return b""
    return replayed_commands(loop, readings, wanted, setup.sample_time).tobytes()


def told(setup: Setup, readings: list[Measurement]) -> dict[str, bytes]:
    """All that a machine is given, over a record: bit by bit."""
    time = setup.sample_time * np.arange(SAMPLES)
    profile = np.zeros((3, SAMPLES)) if setup.reference is None else np.array(setup.reference(time))
    turning = [(setup.rotation_speed, 0.0, 0.0)] * SAMPLES
    return {
        "inputs": to_array(setup.inputs).tobytes(),
        "wanted speed": np.float64(setup.rotation_speed).tobytes(),
        "position loop": commands(setup.loop, setup, readings, [tuple(map(float, row)) for row in profile.T]),
        "rotary loop": commands(setup.rotary, setup, readings, turning),
        "feeds": b"".join(feed.input.encode() + feed.signal(time)[0].tobytes() for feed in setup.feeds),
    }


def check(machines: dict[str, Setup]) -> None:
    believed = machines.pop("as_believed")
    readings = record(believed)
    expected = told(believed, readings)
    assert any(expected.values())
    for changed, setup in machines.items():
        assert to_array(setup.parameters).tobytes() != to_array(believed.parameters).tobytes(), changed
        found = told(setup, readings)
        assert {what for what in expected if found[what] != expected[what]} == set(), changed


@pytest.mark.parametrize(("plant", "rotation"), TURNED)
def test_every_drive_of_every_plant(tmp_path: Path, plant: str, rotation: str) -> None:
    """Position loop and rotation, with each way of turning the rod."""
    machines = setups(tmp_path, plant, rotation, "pid")
    assert len(machines) >= len(fields(plants()[plant].Parameters))
    check(machines)


@pytest.mark.parametrize("controller", sorted(controllers()))
def test_every_controller(tmp_path: Path, controller: str) -> None:
    check(setups(tmp_path, "rotating_anisotropic", "servo", controller))
    check(setups(tmp_path, "non_rotating", "servo", controller))
