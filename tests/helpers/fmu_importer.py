"""An exported plant in an independent importer, FMPy, in closed loop with a controller of ours stepped in Python."""

import shutil
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

import fmpy
import numpy as np
from fmpy.fmi2 import FMU2Model, FMU2Slave
from fmpy.fmi3 import FMU3Model, FMU3Slave
from fmpy.sundials import CVodeSolver

from controllers.interface import Reference
from plants.equation import fields, leaves
from plants.interface import Measurement
from workbench.simulation.setup import Loop, Setup

KINDS = ("co-simulation", "model exchange")

CVODE_TOLERANCE = 1e-11


class Machine(Protocol):
    """An instance of an FMU."""

    def read(self, names: Sequence[str]) -> list[float]: ...
    def write(self, values: Mapping[str, float]) -> None: ...
    def advance(self, time: float, step: float) -> None: ...


class _Named:
    """What both kinds and both versions of FMI have in common: variables by name."""

    def __init__(self, instance: Any, references: Mapping[str, int], fmi: int) -> None:
        self.instance, self.references, self.fmi = instance, references, fmi
        self.get = instance.getReal if fmi == 2 else instance.getFloat64
        self.set = instance.setReal if fmi == 2 else instance.setFloat64

    def read(self, names: Sequence[str]) -> list[float]:
        return list(self.get([self.references[name] for name in names]))

    def write(self, values: Mapping[str, float]) -> None:
        self.set([self.references[name] for name in values], [*values.values()])


class Slave(_Named):
    """Co-simulation: the FMU's own solver."""

    def save(self) -> bytes:
        """The instance's state as bytes."""
        instance = self.instance
        take, serialize, free = (
            (instance.getFMUstate, instance.serializeFMUstate, instance.freeFMUstate)
            if self.fmi == 2
            else (instance.getFMUState, instance.serializeFMUState, instance.freeFMUState)
        )
        state = take()
        content: bytes = serialize(state)
        free(state)
        return content

    def restore(self, content: bytes) -> None:
        """The instance as it was."""
        instance = self.instance
        make, put, free = (
            (instance.deSerializeFMUstate, instance.setFMUstate, instance.freeFMUstate)
            if self.fmi == 2
            else (instance.deserializeFMUState, instance.setFMUState, instance.freeFMUState)
        )
        state = make(content)
        put(state)
        free(state)

    def advance(self, time: float, step: float) -> None:
        self.instance.doStep(currentCommunicationPoint=time, communicationStepSize=step)


class _Held:
    """Inputs that FMPy's solver need not set: they are held over a step."""

    def apply(self, time: float) -> None:
        pass


class _Exchanged(_Named):
    """Model exchange: FMPy's solver, CVode, begun anew at each sample, where an input jumps."""

    def __init__(self, instance: Any, references: Mapping[str, int], fmi: int, states: int) -> None:
        super().__init__(instance, references, fmi)
        rates = instance.getDerivatives if fmi == 2 else instance.getContinuousStateDerivatives
        nominals = instance.getNominalsOfContinuousStates
        self.solver = CVodeSolver(
            nx=states,
            nz=0,
            get_x=instance.getContinuousStates,
            set_x=instance.setContinuousStates,
            get_dx=rates,
            get_z=instance.getEventIndicators,
            get_nominals=nominals,
            set_time=instance.setTime,
            input=_Held(),
            startTime=0.0,
            relativeTolerance=CVODE_TOLERANCE,
            maxNumSteps=100_000,
        )

    def advance(self, time: float, step: float) -> None:
        self.solver.reset(time)
        self.solver.step(time, time + step)
        self.instance.setTime(time + step)


@contextmanager
def opened(path: Path, fmi: int, kind: str) -> Iterator[Any]:
    """An initialized instance of an FMU; `kind` is one of `KINDS`."""
    description, folder = fmpy.read_model_description(str(path)), fmpy.extract(str(path))
    try:
        exchange = kind == "model exchange"
        made = {(2, False): FMU2Slave, (2, True): FMU2Model, (3, False): FMU3Slave, (3, True): FMU3Model}[fmi, exchange]
        token = description.guid if fmi == 2 else description.instantiationToken
        interface = description.modelExchange if exchange else description.coSimulation
        instance = made(guid=token, unzipDirectory=folder, modelIdentifier=interface.modelIdentifier)
        instance.instantiate()
        if fmi == 2:
            instance.setupExperiment(startTime=0.0)
            instance.enterInitializationMode()
        else:
            instance.enterInitializationMode(startTime=0.0)
        instance.exitInitializationMode()
        references = {item.name: item.valueReference for item in description.modelVariables}
        if exchange:
            if fmi == 2:
                instance.newDiscreteStates()
            instance.enterContinuousTimeMode()
            states = len(description.derivatives)
            yield _Exchanged(instance, references, fmi, states)
        else:
            yield Slave(instance, references, fmi)
        instance.terminate()
        instance.freeInstance()
    finally:
        shutil.rmtree(folder)


class _Stepped:
    """A loop's controller and what it remembers."""

    def __init__(self, loop: Loop, reading: Measurement) -> None:
        self.controller, self.gains = loop.controller, loop.gains
        self.state = self.controller.start(reading, self.gains)

    def command(self, wanted: Reference, reading: Measurement, sample_time: float, limit: float) -> float:
        """The command, limited, and its consequence committed."""
        asked, self.state = self.controller.step(wanted, reading, self.state, self.gains, sample_time)
        realised = float(np.clip(asked, -limit, limit))
        self.state = self.controller.commit(realised, self.state, self.gains, sample_time)
        return realised


def closed_loop(machine: Machine, setup: Setup) -> np.ndarray:
    """Positions of the machine at the samples of a setup with ideal sensors; the controllers are stepped in Python."""
    plant, h = setup.plant, setup.sample_time
    shown = {name: f"measured_{name}" for name in plant.channels}
    names = [item.name for item in fields(plant.Inputs)]
    inputs = dict(zip(names, leaves(setup.inputs), strict=True))

    def reading() -> Measurement:
        values = dict(zip(shown, machine.read([*shown.values()]), strict=True))
        return Measurement(*(values.get(name, np.nan) for name in Measurement._fields))

    loops = {plant.command: (_Stepped(setup.loop, reading()), plant.command_limit(setup.parameters))}
    if setup.rotary is not None and plant.rotary_command:
        loops[plant.rotary_command] = (_Stepped(setup.rotary, reading()), plant.rotary_limit(setup.parameters))
    assert setup.reference is not None
    samples = round(setup.duration / h) + 1
    profile = np.column_stack(setup.reference(h * np.arange(samples)))
    positions = np.empty(samples)
    for k in range(samples):
        seen = reading()
        (positions[k],) = machine.read(["position"])
        for name, (loop, limit) in loops.items():
            wanted = Reference(*profile[k]) if name == plant.command else Reference(setup.rotation_speed, 0.0, 0.0)
            inputs[name] = loop.command(wanted, seen, h, limit)
        machine.write(inputs)
        machine.advance(k * h, h)
    return positions
