"""Every plant with every friction law and every controller: accepted or refused in a line, and what is accepted runs.

    make combinations            # all of them, checked and simulated

`pairwise` chooses so many that every pair of plant, law and controller is among them.
"""

import itertools
import json
import sys
import tempfile
from collections import Counter
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from thesis_actuator import OF_OTHERS, along

from controllers.interface import Reference
from controllers.registry import controllers
from plants.equation import from_array, leaves
from plants.interface import Plant
from plants.laws.interface import FrictionLaw
from plants.laws.lugre import LUGRE
from plants.laws.registry import LAWS
from plants.registry import plants
from workbench.errors import UserError
from workbench.parameters.sets import known_units, named_sets, read_parameters
from workbench.simulation.simulate import simulate
from workbench.study.plan import plan
from workbench.study.reading import study_of
from workbench.study.resolve import Resolved

LAW_SETTINGS = ("acceleration_feedback", "valve_inversion", "force_source")
"""What a compensator's setting `law` may be; "" is its default."""

AMPLITUDE = 2e-3
"""SI: of a position, or in open loop of a command."""

BRISTLES = ("helical", "isotropic", "anisotropic")


@dataclass(frozen=True)
class Machine:
    """A plant by the keys of [plant]; `bristle` of a rod that turns, "" where none does."""

    model: str
    bristle: str = ""
    rotation: str = "servo"

    @property
    def name(self) -> str:
        return " ".join(part for part in (self.model, self.bristle, self.rotation if self.bristle else "") if part)


@dataclass(frozen=True)
class Combination:
    """One of all: a machine, a friction law, a controller and the law by which its estimate acts."""

    machine: Machine
    friction: str
    controller: str
    law: str = ""

    @property
    def parts(self) -> tuple[str, str, str]:
        return self.machine.name, self.friction, f"{self.controller} {self.law}".strip()


def machines() -> Iterator[Machine]:
    """Every plant as it is, and with a rod that turns where it has one."""
    for plant in plants().values():
        yield Machine(plant.name)
        if plant.turned is not None:
            yield from (Machine(plant.name, bristle, how) for bristle in BRISTLES for how in ("servo", "ideal"))


def every() -> Iterator[Combination]:
    """All of them."""
    for machine, friction, (name, law) in itertools.product(machines(), LAWS.working(), acting()):
        yield Combination(machine, friction, name, law)


def acting() -> Iterator[tuple[str, str]]:
    """Every controller, by each law by which its estimate may act on a plant; "" of one that has none."""
    for name, controller in controllers().items():
        has_laws = "law" in controller.Settings._fields
        yield from ((name, law) for law in (LAW_SETTINGS if has_laws else ("",)))


def parameter_file(plant: Plant, folder: Path) -> Path:
    """A file of numbers that serve every plant of that axis, as they are: SI."""
    path = folder / f"all_{plant.axis}.toml"
    if not path.exists():
        values = along(plant, {**read_parameters(named_sets()["owen2001_experiment"]), **OF_OTHERS})
        values = {name: value for name, value in values.items() if name in known_units(plant.axis)}
        lines = ['title = "all"', 'source = "made up"']
        for name, value in values.items():
            number = json.dumps("inf") if np.isinf(value) else repr(float(value))
            lines += [f"[parameters.{name}]", f"value = {number}", 'source = "made up"']
        path.write_text("\n".join(lines), encoding="utf-8")
    return path


def resolved(one: Combination, folder: Path, duration: float) -> Resolved:
    """What `check` makes of it.

    Raises:
        UserError: it is refused.
    """
    plant = plants()[one.machine.model]
    table: dict[str, Any] = {
        "type": one.controller,
        **required(one.controller),
        **({"law": one.law} if one.law else {}),
    }
    turning = {"turned": "rod", "bristle": one.machine.bristle, "rotation": one.machine.rotation}
    given = named_turning(one.machine.model)
    data = {
        "title": "one of all",
        "plant": {
            "model": one.machine.model,
            "parameters": parameter_file(plant, folder).name,
            **({"friction": one.friction} if plant.refit is not None or one.friction != LUGRE.name else {}),
            **(turning if one.machine.bristle else given),
        },
        "controllers": {"one": table},
        "references": {"sine": {"kind": "sine", "amplitude": AMPLITUDE, "frequency": "1 Hz"}},
        "sensors": {"friction_gauge": True},
        "simulation": {"duration": duration},
        "axes": {
            "controller": ["one"],
            "reference": ["sine"],
            **({"rpm": [60.0]} if one.machine.bristle or given else {}),
        },
    }
    return plan(study_of(data, "", folder / "one.toml")).resolved[0]


def named_turning(model: str) -> dict[str, str]:
    """The keys of [plant] that a registered plant needs which turns by itself."""
    if plants()[model].rotary_command is None:
        return {}
    return {"rotation": "ideal" if model.endswith("_ideal") else "servo"}


def required(name: str) -> dict[str, float]:
    """Settings of a controller that have no default, and its gain."""
    settings = controllers()[name].Settings
    return {key: 100.0 for key in settings._fields if key not in settings._field_defaults}


@np.errstate(all="ignore")  # compiled code too divides by 0 where what comes of it is not chosen
def stepped(item: Resolved) -> np.ndarray:
    """States after three samples of the loop, by the equations as they stand in Python: nothing is compiled."""
    setup = item.setup
    plant, p, controller, gains = setup.plant, setup.parameters, setup.loop.controller, setup.loop.gains
    state, inputs, time = setup.state, setup.inputs, 0.0
    memory = controller.start(plant.measure(state, p), gains)
    for _ in range(3):
        motion = setup.reference(np.array([time])) if setup.reference is not None else ([0.0],) * 3
        wanted = Reference(*(float(values[0]) for values in motion))
        command, memory = controller.step(wanted, plant.measure(state, p), memory, gains, setup.sample_time)
        limit = plant.command_limit(p)
        realised = float(np.clip(command, -limit, limit))
        memory = controller.commit(realised, memory, gains, setup.sample_time)
        place = plant.input_index(plant.command)
        inputs = type(inputs)._make(realised if i == place else value for i, value in enumerate(inputs))
        numbers = np.array(list(leaves(state)), dtype=float)
        for _ in range(2):
            rates = np.array(list(leaves(plant.derivatives(time, state, inputs, p))), dtype=float)
            numbers = numbers + 1e-7 * rates
            state = from_array(plant.State, numbers.tolist())
        time += setup.sample_time
    return numbers


def admits(machine: Machine, law: FrictionLaw) -> bool:
    """Whether the machine can have a friction law."""
    plant = plants()[machine.model]
    plant = plant.with_turning_rod(machine.bristle) if machine.bristle else plant
    if plant.refit is None:
        return law is LUGRE  # the default, of which such a plant says nothing
    try:
        plant.with_friction(law)
    except ValueError:
        return False
    return True


def pairwise(machine: Machine, place: int) -> Iterator[Combination]:
    """Of the machine at a `place` among others: every controller, with the machine's laws in turn.

    Over all machines every pair of two of machine, law and controller is there: a law that meets a controller on one
    machine makes way for the next law on the machine after it.
    """
    known = [law.name for law in LAWS.working().values() if admits(machine, law)]
    for number, (name, law) in enumerate(acting()):
        yield Combination(machine, known[(place + number) % len(known)], name, law)


def main() -> int:
    """Check all, run what is accepted; prints counts, and what went wrong."""
    refused: Counter[str] = Counter()
    outcomes: Counter[str] = Counter()
    wrong: list[str] = []
    pool = list(every())
    with tempfile.TemporaryDirectory() as name:
        for number, one in enumerate(pool):
            label = " + ".join(one.parts)
            try:
                item = resolved(one, Path(name), 0.2)
            except UserError as error:
                text = str(error)
                refused[text.split(": ", 2)[-1]] += 1
                if "\n" in text:
                    wrong.append(f"{label}: refused in more than a line: {text}")
                continue
            except Exception as error:  # noqa: BLE001  what is looked for
                wrong.append(f"{label}: {type(error).__name__}: {error}")
                continue
            try:
                outcomes[simulate(item.setup).outcome] += 1
            except Exception as error:  # noqa: BLE001
                wrong.append(f"{label}: run: {type(error).__name__}: {error}")
            if number % 500 == 0:
                print(f"{number} of {len(pool)}", file=sys.stderr)
    accepted = sum(outcomes.values())
    print(f"{len(pool)} combinations: {accepted} accepted and run, {sum(refused.values())} refused in a line each")
    print(f"outcomes: {', '.join(f'{count} {outcome}' for outcome, count in outcomes.most_common())}")
    for text, count in refused.most_common():
        print(f"{count:6d} {text}")
    print(f"{len(wrong)} went wrong")
    for text in wrong:
        print(f"  {text}")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
