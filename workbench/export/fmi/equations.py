"""A plant's equations as C, recorded from the functions that the simulation compiles."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from plants.equation import fields, from_array, leaves, size_of
from plants.interface import Measurement, Plant
from workbench.export.c_words import VECTORS
from workbench.export.operations import HELPERS
from workbench.export.statements import DOUBLE, helpers_of, statements
from workbench.recording.symbols import INPUT, Recording, needed

TIME, STATES, INPUTS, PARAMETERS, RATES, OUTPUTS = VECTORS

DECLARED = {
    kind: (
        f"void plant_{kind}(double {TIME}, const double *{STATES}, const double *{INPUTS}, const double *{PARAMETERS}, "
        f"double *{kind})"
    )
    for kind in (RATES, OUTPUTS)
}
"""The C functions."""

MEASURED = "measured_"
"""What stands before the name of what a rig measures, as in the signals of a run."""


@dataclass(frozen=True)
class Output:
    """A number that follows from states, inputs and parameters."""

    name: str
    unit: str


@dataclass(frozen=True)
class Equations:
    """The rates of the states, and outputs behind them: their places in a recording."""

    recording: Recording
    rates: Sequence[int]
    outputs: Sequence[int]
    named: tuple[Output, ...]

    def depends(self, places: Iterable[int]) -> list[tuple[list[int], list[int]]]:
        """Of each of these: places of the states, and of the inputs, on which it depends."""
        return [(self._reads(STATES, place), self._reads(INPUTS, place)) for place in places]

    @property
    def code(self) -> str:
        """Both functions as C."""
        functions = {RATES: self.rates, OUTPUTS: self.outputs}
        results = {kind: {f"{kind}[{i}]": place for i, place in enumerate(of)} for kind, of in functions.items()}
        helpers = [HELPERS[name] for name in helpers_of(self.recording, tuple(results.values()))]
        parts = ['#include "model.h"\n', *(text.format(real="double", zero="0.0", one="1.0") for text in helpers)]
        for kind, function in results.items():
            read = {name for name in (TIME, STATES, INPUTS, PARAMETERS) if self._is_read(name, functions[kind])}
            unused = [f"    (void){name};" for name in (TIME, STATES, INPUTS, PARAMETERS) if name not in read]
            lines = [DECLARED[kind], "{", *unused, *statements(self.recording, function, DOUBLE), "}"]
            parts.append("\n".join(lines) + "\n")
        return "\n".join(parts)

    def _texts(self, places: Iterable[int]) -> set[str]:
        found = (self.recording.instructions[place] for place in needed(self.recording, places))
        return {instruction.text for instruction in found if instruction.operation == INPUT}

    def _is_read(self, name: str, places: Iterable[int]) -> bool:
        return any(text.partition("[")[0] == name for text in self._texts(places))

    def _reads(self, vector: str, place: int) -> list[int]:
        parts = (text.rstrip("]").partition("[") for text in self._texts([place]))
        return sorted(int(index) for name, _, index in parts if name == vector)


def equations_of(plant: Plant) -> Equations:
    """The equations of a plant; its outputs are its signals that are no states or inputs, and what a rig measures."""
    recording = Recording()

    def given(name: str, cls: type[NamedTuple]) -> Any:
        return from_array(cls, [recording.input(f"{name}[{i}]") for i in range(size_of(cls))])

    time = recording.input(TIME)
    state, inputs = given(STATES, plant.State), given(INPUTS, plant.Inputs)
    parameters = given(PARAMETERS, plant.Parameters)
    with recording.sources():
        rates = [*leaves(plant.derivatives(time, state, inputs, parameters))]
        signals = [*leaves(plant.signals(time, state, inputs, parameters))]
        readings = plant.measure(state, parameters)._asdict()
    known = {item.name for cls in (plant.State, plant.Inputs) for item in fields(cls)}
    found = {
        Output(item.name, item.unit): value
        for item, value in zip(fields(plant.Signals), signals, strict=True)
        if item.name not in known
    }
    units = {item.name: plant.unit_for(item.unit) for item in fields(Measurement)}
    found |= {Output(f"{MEASURED}{name}", units[name]): readings[name] for name in plant.channels}
    rate_places, output_places = (
        [recording.number_place(value) for value in values] for values in (rates, found.values())
    )
    return Equations(recording, rate_places, output_places, tuple(found))
