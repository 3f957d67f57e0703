"""The exported C of every controller against the program's own compiled equations, sample by sample.

    make export-proof            # all of them, on machines that turn and that do not, of oil, air and electricity

Each controller first runs a loop on its machine: sensors with noise, steps that saturate the amplifier. What it saw
there is then replayed, 20 000 samples with a restart in the middle, through its C and through the equations as the
program compiles them. Besides, the exported test program is compiled without a warning in both precisions and run.
"""

import ctypes
import itertools
import re
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from combinations import Machine, acting, named_turning, parameter_file, required
from plugin_site import site

from controllers.interface import Controller
from controllers.open_loop import OPEN_LOOP
from plants.equation import to_array
from plants.interface import Measurement
from plants.registry import plants
from workbench.errors import UserError
from workbench.export.c_controller import Exported
from workbench.export.controller import ControllerExport, exported_loop
from workbench.export.vector import BOUNDS, Replay, replay_of
from workbench.rehearse.lockstep import loaded
from workbench.simulation.compilation import controller_addresses
from workbench.simulation.setup import Loop, Setup
from workbench.simulation.simulate import simulate
from workbench.study.plan import plan
from workbench.study.reading import study_of

SAMPLES, SHORT = 20_000, 5_000
"""Of the replay, and of the test program's, which a C compiler reads."""
BOUND = 1e-10
"""Of the command's limit."""

MACHINES = (
    Machine("non_rotating"),
    Machine("non_rotating", "helical"),
    Machine("non_rotating", "anisotropic"),
    Machine("pneumatic_cylinder"),
    Machine("drive_force"),
    Machine("rotary_torque"),
)
ON_DEMAND = (
    {"rotation": "scheduled", "minimum_helical_speed": 0.05},
    {"rotation": "switched", "switch_speed": 0.03},
)
TURNING = ("rotating_helical", "rotating_helical_ideal")
"""Machines whose rotation on demand drives a motor, and the surface itself."""

NOISE = {"position": 13e-6, "pressure_1": 2e3, "pressure_2": 2e3, "rotation_speed": 0.05, "motor_current": 0.02}
"""Standard deviations, SI."""

SHARE = 0.5
"""Of the largest command of a run: the limit where the amplifier's own was not met."""

PLACES = ctypes.POINTER(ctypes.c_double)
STEP = ctypes.CFUNCTYPE(ctypes.c_double, PLACES, PLACES, PLACES, PLACES, ctypes.c_double)
COMMIT = ctypes.CFUNCTYPE(None, ctypes.c_double, PLACES, PLACES, ctypes.c_double)


class Subject(NamedTuple):
    """A controller to prove: in words, what runs it, and its loop there."""

    label: str
    machine: str
    setup: Setup
    loop: Loop


class Proof(NamedTuple):
    """What was found of one: samples, the share of them that were saturated, and the largest difference over the limit;
    of the test program what it says, in double and in single precision.
    """

    samples: int
    saturated: float
    difference: float
    double: str
    single: str


def study_content(machine: Machine, table: dict[str, Any], folder: Path, **plant: Any) -> dict[str, Any]:
    """A study of one loop: dwells of a second, too far apart for the amplifier; sensors with noise."""
    declared = plants()[machine.model]
    given = named_turning(machine.model)
    turning = {"turned": "rod", "bristle": machine.bristle, "rotation": machine.rotation} if machine.bristle else given
    return {
        "title": "proof",
        "plant": {
            "model": machine.model,
            "parameters": parameter_file(declared, folder).name,
            **turning,
            **plant,
        },
        "controllers": {"one": table},
        "references": {"steps": {"kind": "steps", "levels": [0.02, -0.02] * 10, "dwell": 1.0}},
        "sensors": {"friction_gauge": True, **{name: {"noise": noise} for name, noise in NOISE.items()}},
        "simulation": {"duration": SAMPLES * 1e-3},
        **({"axes": {"rpm": [60.0]}} if turning else {}),
    }


def subjects(folder: Path) -> Iterator[Subject]:
    """Every controller with every law, on each of `MACHINES` that takes it, and what turns their rods."""
    seen = set[tuple[Controller, tuple[str, ...]]]()
    for machine in MACHINES:
        for name, law in acting():
            table = {"type": name, **required(name), **({"law": law} if law else {})}
            if name == OPEN_LOOP.name:
                continue  # without feedback there is nothing to export: the command says so
            try:
                setup = resolved_setup(study_content(machine, table, folder), folder)
            except UserError:
                continue  # a law, or a controller, that the machine has no use for
            yield from _new(seen, Subject(f"{name} {law}".strip(), machine.name, setup, setup.loop))
            if setup.rotary is not None:
                yield from _new(seen, Subject("speed_servo", machine.name, setup, setup.rotary))
    for model, plant in itertools.product(TURNING, ON_DEMAND):
        content = study_content(Machine(model), {"type": "pid", "kp": 100.0}, folder, **plant)
        setup = resolved_setup(content, folder)
        assert setup.rotary is not None
        label = f"{setup.rotary.controller.name} {plant['rotation']}"
        yield from _new(seen, Subject(label, model, setup, setup.rotary))


def resolved_setup(content: dict[str, Any], folder: Path) -> Setup:
    """What the one case of a study runs.

    Raises:
        UserError: it is refused.
    """
    return plan(study_of(content, "", folder / "one.toml")).resolved[0].setup


def _new(seen: set[tuple[Controller, tuple[str, ...]]], subject: Subject) -> Iterator[Subject]:
    key = (subject.loop.controller, subject.setup.plant.channels)
    if key not in seen:
        seen.add(key)
        yield subject


def proof(subject: Subject, folder: Path) -> Proof:
    """Run its loop, replay what it saw, and run the exported test programs; all in a folder of its own."""
    setup, loop = subject.setup, subject.loop
    name = re.sub(r"\W", "_", loop.controller.name)
    exported = exported_loop(setup, loop, name, subject.label, "double")
    replay = replay_of(setup, simulate(setup), loop is setup.rotary)
    limit = proof_limit(exported, replay)
    own = replayed(loop.controller, loop, replay, limit, setup.sample_time)
    other = replayed(loaded(exported, folder / "lockstep"), loop, replay, limit, setup.sample_time)
    assert np.all(np.isfinite(own)), f"{subject.label}: the program's own commands are no numbers"
    assert np.all(np.isfinite(other)), f"{subject.label}: commands of the C are no numbers"
    single, short = replace(exported, precision="single"), Replay(replay.start, *(rows[:SHORT] for rows in replay[1:]))
    return Proof(
        own.size,
        float(np.mean(np.abs(own) >= limit)),
        float(np.max(np.abs(own - other))) / limit,
        tested(ControllerExport(exported, short, {}), folder / "double"),
        tested(ControllerExport(single, short, {}), folder / "single"),
    )


def proof_limit(exported: Exported, replay: Replay) -> float:
    """The limit of the replay: that of the amplifier where the run met it, else one that saturates."""
    largest = float(np.max(np.abs(replay.commands)))
    return exported.limit if largest >= exported.limit else SHARE * largest or 1.0


def replayed(controller: Controller, loop: Loop, replay: Replay, limit: float, sample_time: float) -> np.ndarray:
    """The commands that a controller gives, from what it saw; in the middle it starts anew with what it sees there.

    Of an equation and of its C alike: both are called as the simulation's loop calls them.
    """
    step_address, commit_address = controller_addresses(controller)
    step, commit = STEP(step_address), COMMIT(commit_address)
    gains, commands = to_array(loop.gains), np.empty(replay.commands.size)
    references, measurements = (np.ascontiguousarray(rows) for rows in (replay.references, replay.measurements))
    state = np.empty(0)
    for i in range(commands.size):
        if i in (0, commands.size // 2):
            seen = Measurement(*replay.start) if i == 0 else Measurement(*measurements[i].tolist())
            state = to_array(controller.start(seen, loop.gains))
        places = [array.ctypes.data_as(PLACES) for array in (references[i], measurements[i], state, gains)]
        commands[i] = np.clip(step(*places, sample_time), -limit, limit)
        commit(commands[i], *places[2:], sample_time)
    return commands


def tested(made: ControllerExport, folder: Path) -> str:
    """What `make test` says of an exported folder; a warning is an error."""
    made.write(folder)
    flags = "CFLAGS=-O2 -Werror -Wshadow -Wconversion -Wdouble-promotion"
    done = subprocess.run(["make", "-s", "-C", str(folder), "test", flags], capture_output=True, text=True, check=False)
    found = re.search(r"greatest difference (\S+) .*bound (\S+) .*: (\w+)$", done.stdout.strip())
    if found is None:
        complaints = [line for line in done.stderr.splitlines() if "error" in line] or [done.stdout.strip()]
        return f"FAILED: {complaints[0]}"
    return f"{float(found[1]) / float(found[2]) * BOUNDS[made.exported.precision]:.1e} {found[3]}"


def main() -> int:
    """Prove all, or those whose label holds a word that is given; prints a table."""
    words, failed = sys.argv[1:], 0
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        (folder / "plugins").mkdir()
        sys.path.insert(0, str(site(folder / "plugins")))
        print(f"{'controller':38} {'machine':28} samples saturated difference  test (double)  test (single)")
        for number, subject in enumerate(subjects(folder)):
            if words and not any(word in subject.label for word in words):
                continue
            found = proof(subject, folder / str(number))
            wrong = not found.difference <= BOUND or not found.double.endswith("equal")
            failed += wrong
            what = f"{subject.label:38} {subject.machine:28} {found.samples:7d} {found.saturated:8.1%}"
            came = f"{found.difference:11.1e}  {found.double:14} {found.single}{'  WRONG' if wrong else ''}"
            print(what, came, flush=True)
    print(f"{failed} wrong" if failed else f"all within {BOUND:g} of the limit")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())
