"""A loop, described once: plant, controller, reference, belief, sensors. It is resolved as a case of a study is."""

import warnings
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from controllers.interface import Controller
from plants.interface import Plant
from workbench.api.controllers import ControllerChoice
from workbench.api.plain import Quantity, expect, plain_table
from workbench.api.references import ReferenceChoice
from workbench.simulation.references import ReferenceSignal
from workbench.simulation.simulate import Setup
from workbench.study.plan import plan
from workbench.study.reading import study_of
from workbench.study.resolve import Resolved
from workbench.study.study import Case
from workbench.study.study import Study as StudyContent

A_LOOP = "a loop; make one with wb.setup(...), or with study.setup(...) from a case of a study"
"""What is expected where something else than a loop is given."""

DURATION = "5 s"
"""Of a run where nothing is said: that of the thesis's simulations, four periods of their sine and a half."""


@dataclass(frozen=True, eq=False, repr=False)
class LoopSetup:
    """A loop that is ready to run: what `setup` and `Study.setup` return.

    `resolved` is the `case` of `study` as that runs it.

    Example:
        >>> loop = wb.setup("non_rotating", "owen2001_simulation", controller=wb.pid(kp=500))
        >>> loop
        LoopSetup(non_rotating, pid, no reference, 5 s)
        >>> loop.parameters.body.mass == loop.belief.body.mass
        True
    """

    resolved: Resolved
    study: StudyContent
    case: Case

    @property
    def axes(self) -> Mapping[str, object]:
        """The columns that tell it apart in its study."""
        return self.case.columns

    @property
    def simulation(self) -> Setup:
        """What the simulation takes: plant, parameters, loops, start, sensors, integrator."""
        return self.resolved.setup

    @property
    def plant(self) -> Plant:
        """The true plant: its equations, and the names and units of its states, inputs and signals."""
        return self.simulation.plant

    @property
    def parameters(self) -> Any:
        """The true parameters (SI), nested NamedTuples of the plant's `Parameters`."""
        return self.simulation.parameters

    @property
    def belief(self) -> Any:
        """What controllers believe them to be, of the same class."""
        return self.resolved.belief

    @property
    def controller(self) -> Controller:
        """The position controller."""
        return self.simulation.loop.controller

    @property
    def gains(self) -> Any:
        """What it was designed to be (SI)."""
        return self.simulation.loop.gains

    @property
    def reference(self) -> ReferenceSignal | None:
        """What the position is asked to do; None in open loop."""
        return self.simulation.reference

    def __repr__(self) -> str:
        axes = [f"{name} {value}" for name, value in self.axes.items()]
        held = ["no reference"] if self.resolved.signal is None else []
        parts = [self.plant.name, self.controller.name, *axes, *held, f"{self.simulation.duration:g} s"]
        return f"LoopSetup({', '.join(parts)})"


def setup(
    model: str | None = None,
    parameters: str | Path | None = None,
    *,
    controller: ControllerChoice,
    reference: ReferenceChoice | None = None,
    rpm: Quantity | None = None,
    duration: Quantity = DURATION,
    transient: Quantity | None = None,
    belief: str | Path | Mapping[str, object] | None = None,
    machine: str | None = None,
    scenario: str | None = None,
    sensors: Mapping[str, object] | None = None,
    plant: Mapping[str, object] | None = None,
    simulation: Mapping[str, object] | None = None,
    folder: str | Path = ".",
) -> LoopSetup:
    """Describe one loop. It is what a study of this one case would run, to the last digit.

    What is left out is as in a study file (docs/study_files.md): controllers believe the declared plant, a servo holds
    the rotation, sensors are ideal. What may be meant and seldom is, such as a reference beyond the stroke, is a
    warning.

    Args:
        model: of the plant: "by_rpm", "non_rotating", "rotating", "drive", or any that is registered.
        parameters: a named set, or the path of a parameter file.
        controller: such as `pid(kp=500)`.
        reference: such as `sine("30 mm", "0.9 Hz")`; a controller `open_loop` feeds it to the plant's input. Without
            one the loop holds its position, and there are no metrics of tracking.
        rpm: speed of rotation, in rpm.
        duration: s.
        transient: s at the start that is left out of the metrics; default 0.
        belief: parameters that controllers believe in, a set, a file, or the keys of [belief]; default the declared.
        machine: named changes of what is declared, and believed; as the axis of that name.
        scenario: named changes of the truth alone; as the axis of that name.
        sensors: the keys of [sensors], such as {"position": {"noise": "5 um"}}.
        plant: further keys of [plant], such as {"rotation": "ideal", "set": {"coulomb": "400 N"}}.
        simulation: further keys of [simulation], such as {"seed": 3, "sample_time": "0.5 ms"}.
        folder: where files are looked for.

    Raises:
        UserError: whatever is wrong, by the key of a study file.

    Example:
        >>> loop = wb.setup(
        ...     "rotating", "owen2001_simulation", rpm=460, controller=wb.pid(kp=500), reference=wb.sine("30 mm", 0.9)
        ... )
        >>> loop
        LoopSetup(rotating_helical, pid, rpm 460, 5 s)
        >>> wb.setup("rotating", "owen2001_simulation", controller=wb.pid(kpp=500))
        Traceback (most recent call last):
        workbench.errors.UserError: setup: controllers.pid.kpp: unknown key; did you mean "kp"?
    """
    expect(controller, ControllerChoice, "setup: controller", "a controller such as wb.pid(kp=500)")
    expect(reference, ReferenceChoice | None, "setup: reference", 'a reference such as wb.sine("30 mm", "0.9 Hz")')
    for name, table in {"plant": plant, "simulation": simulation}.items():
        expect(table, Mapping | None, f"setup: {name}", f"a dictionary of further keys of [{name}]")
    content = {
        "title": "setup",
        "plant": {"model": model, "parameters": parameters, **(plant or {})},
        "belief": {"parameters": belief} if isinstance(belief, str | Path) else belief,
        "controllers": {controller.type: controller},
        "references": None if reference is None else {reference.kind: reference},
        "sensors": sensors,
        "simulation": {"duration": duration, "transient": transient, **(simulation or {})},
        "axes": {
            axis: [value]
            for axis, value in {"rpm": rpm, "machine": machine, "scenario": scenario}.items()
            if value is not None
        },
    }
    planned = plan(study_of(plain_table(content, "setup"), "", Path(folder) / "setup"))
    for line in planned.warnings:
        warnings.warn(line, stacklevel=2)
    return LoopSetup(planned.resolved[0], planned.study, planned.cases[0])
