"""A recorded controller as the text of C files, and what is said of it there."""

import functools
import re
import textwrap
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined

from controllers.interface import Reference
from plants.interface import GAUGE, Measurement
from workbench.export.c_words import RESERVED
from workbench.export.operations import ADDED, CALLED, COMPARED, DIVIDED, HELPERS, MULTIPLIED
from workbench.export.recorded import GAINS, REALISED, SAMPLE_TIME, Function, RecordedController
from workbench.export.statements import (
    DOUBLE,
    INDENT,
    SINGLE,
    WIDTH,
    Precision,
    comment,
    counts,
    helpers_of,
    statements,
)
from workbench.export.structs import Struct, initializer, structs
from workbench.recording.symbols import INPUT, needed

TEMPLATES = Path(__file__).parent / "templates"

PRECISIONS = {"double": DOUBLE, "single": SINGLE}

COUNTED = (ADDED, MULTIPLIED, DIVIDED, COMPARED, CALLED)

TAKEN = ("gains", "state", "reference", "measurement", "settings", "study", "init", "step", "command", "commit")
"""What stands behind the controller's name already."""

LIMITING = Counter({ADDED: 2, COMPARED: 3})
"""What offset and limit take."""


@dataclass(frozen=True)
class Exported:
    """A controller to be written as C.

    Attributes:
        recorded: its equations.
        name: before every name in C.
        gains: its numbers, SI.
        sample_time: for which they are made (s).
        limit: of the command; infinite where nothing limits it.
        offset: what is added to the command before it is limited.
        command_unit: of the command, "V" or "N".
        unit: what a unit of the controller is called on its plant.
        turns: whether it is the speed of rotation that it controls.
        title: of the study, and which case.
        precision: "double" or "single".
    """

    recorded: RecordedController
    name: str
    gains: Any
    sample_time: float
    limit: float
    offset: float
    command_unit: str
    unit: Callable[[str], str]
    turns: bool
    title: str
    precision: str

    @property
    def numbers(self) -> Precision:
        """How its numbers are written."""
        return PRECISIONS[self.precision]

    @property
    def measured(self) -> list[tuple[str, str]]:
        """What has to be measured, each with its unit."""
        units = {member.name: member.note for member in self._structs()["measurement"][-1].members}
        return [(path[0], units[path[0]]) for path in self.recorded.used.measurement]

    @property
    def followed(self) -> list[tuple[str, str]]:
        """What it needs of the reference, each with its unit."""
        units = {member.name: member.note for member in self._structs()["reference"][-1].members}
        return [(path[0], units[path[0]]) for path in self.recorded.used.reference]

    @property
    def counted(self) -> dict[str, int]:
        """How much a call of its step computes, with offset and limit; of a choice both sides are counted."""
        found = counts(self.recorded.recording, self.recorded.step, self.recorded.commit) + LIMITING
        return {kind: found[kind] for kind in COUNTED}

    @property
    def operations(self) -> str:
        """The same in words."""
        return ", ".join(f"{count} {kind}" for kind, count in self.counted.items())

    def _structs(self) -> dict[str, list[Struct]]:
        used, controller = self.recorded.used, self.recorded.controller
        reference = {path[0]: self.unit(_REFERENCE[path[0]]) for path in used.reference}
        if self.turns:
            reference["position"] = "rad/s: the wanted speed of rotation"
        build = functools.partial(structs, prefix=self.name, number=self.numbers.type, taken=set(TAKEN))
        made = {
            "gains": build(controller.Gains, used.gains, "gains", unit=self.unit),
            "state": build(controller.State, used.state, "state", unit=self.unit),
            "reference": build(Reference, used.reference, "reference", unit=self.unit),
            "measurement": build(Measurement, used.measurement, "measurement", unit=self.unit),
        }
        wanted = made["reference"][-1]
        members = tuple(item._replace(note=reference.get(item.name, item.note)) for item in wanted.members)
        made["reference"] = [wanted._replace(summary="What is wanted at one instant.", members=members)]
        made["measurement"] = [made["measurement"][-1]._replace(summary="What is measured at that instant.")]
        return made

    def text(self, template: str, **more: object) -> str:
        """What a template makes of it."""
        used = self._structs()
        distinct = {struct.type: struct for kind in ("gains", "state") for struct in used[kind]}
        context = {
            "e": self,
            "name": self.name,
            "guard": f"{self.name.upper()}_H",
            "real": self.numbers.type,
            "f": self.numbers.suffix,
            "structs": [*distinct.values(), *used["reference"], *used["measurement"]],
            "number": self.numbers.number,
            "controller": self.recorded.controller,
            "gauged": GAUGE in (name for name, _ in self.measured),
            "boxed": boxed,
            **more,
        }
        return _environment().get_template(template).render(context)

    @property
    def helpers(self) -> list[str]:
        """The functions that math.h lacks and the controller needs."""
        functions = (self.recorded.start, self.recorded.step, self.recorded.commit)
        zero, one = self.numbers.number(0.0), self.numbers.number(1.0)
        names = helpers_of(self.recorded.recording, functions)
        return [HELPERS[name].format(real=self.numbers.type, zero=zero, one=one) for name in names]

    @property
    def values(self) -> list[str]:
        """The gains of the study, a line each."""
        return initializer(self.gains, self.recorded.used.gains, self.numbers, INDENT * 2)

    def body(self, function: Function, *given: str) -> list[str]:
        """The lines of a function with these arguments, of which it may use only some."""
        read = _read(self.recorded, function)
        lines = []
        uses = {
            "settings": any(text.startswith(GAINS) or text == SAMPLE_TIME for text in read),
            "reference": any(text.startswith("reference->") for text in read),
            "measurement": any(text.startswith("measurement->") for text in read),
            "realised": REALISED in read,
            "state": any(function) or any(text.startswith("before.") for text in read),
        }
        if any(text.startswith("before.") for text in read):
            lines.append(f"{INDENT}const {self.name}_state before = *state;")
        if any(text.startswith(GAINS) for text in read):
            lines.append(f"{INDENT}const {self.name}_gains *const gains = &settings->gains;")
        lines += [f"{INDENT}(void){name};" for name in given if not uses[name]]
        return [*lines, *statements(self.recorded.recording, function, self.numbers)]


_REFERENCE = {name: hint.__metadata__[0] for name, hint in Reference.__annotations__.items()}


def _read(recorded: RecordedController, function: Function) -> set[str]:
    instructions = (recorded.recording.instructions[i] for i in needed(recorded.recording, function.values()))
    return {item.text for item in instructions if item.operation == INPUT}


def c_name(name: str) -> str:
    """A name as C has names: signs that it does not take are underscores."""
    found = re.sub(r"\W", "_", name, flags=re.ASCII)
    return f"controller_{found}" if not found[:1].isalpha() or found in RESERVED else found


def boxed(text: str, indent: str = "") -> str:
    """A comment of C, on as many lines as it takes."""
    lines = textwrap.wrap(comment(text), WIDTH - len(indent) - 3, break_long_words=False)
    return f"\n{indent}   ".join(lines).join((f"{indent}/* ", " */"))


@functools.cache
def _environment() -> Environment:
    """Templates of C and Markdown, where nothing is escaped."""
    return Environment(
        loader=FileSystemLoader(TEMPLATES),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
