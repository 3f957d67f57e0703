"""A loop on the bench: a study of one case, and what was changed in it since it was put there."""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from workbench.errors import UserError
from workbench.study.at_point import merged
from workbench.study.layers import LAYERS
from workbench.study.reading import study_of
from workbench.study.resolve import ParsedCase, Resolved, parse_case
from workbench.study.schema import OVERRIDES
from workbench.study.study import DRAW, Case, Study, named
from workbench.study.unfold import unfold

HELD = ("controllers.", "references.")
"""Axes of what the tables of a case hold already."""

CHOSEN = ("controller", "reference")
"""Axes that name one of them."""

Change = Mapping[str, object]
"""Values by dotted key of a study, such as "controllers.p.kp": each is an axis of one value."""


@dataclass(frozen=True)
class BenchLoop:
    """A study of one case as `content`, whose files are looked for in `folder`, with `changes` laid over it.

    A change is an axis of one value: laid over machine and scenario, it changes the truth and not what controllers
    believe, unless its key says so.
    """

    content: Mapping[str, Any]
    folder: Path
    changes: Change = field(default_factory=dict)

    def changed(self, change: Change) -> "BenchLoop":
        """The loop with further changes; a value of None takes one back."""
        together = {**self.changes, **change}
        return replace(self, changes={key: value for key, value in together.items() if value is not None})

    def with_table(self, axis: str, name: str, table: Mapping[str, object]) -> "BenchLoop":
        """The loop with another "controller" or "reference"; one that it has not yet gets this table."""
        section = f"{axis}s"
        known = self.content.get(section, {})
        content = {**self.content, section: {**known, name: known.get(name, dict(table))}}
        return replace(self, content=content).changed({axis: name})

    @property
    def as_study(self) -> dict[str, Any]:
        """The content of a study file that runs this loop and nothing else: controllers and references that it does
        not use are left out.
        """
        axes = {**self.content.get("axes", {}), **{key: [value] for key, value in self.changes.items()}}
        content = {**self.content, "axes": axes}
        for axis in CHOSEN:
            section = f"{axis}s"
            chosen = axes.get(axis, [next(iter(content.get(section, {})), None)])[0]
            content[section] = {name: table for name, table in content.get(section, {}).items() if name == chosen}
            axes = {key: value for key, value in axes.items() if not _of_another(key, section, chosen)}
            axes.pop(axis, None)
        return {name: table for name, table in {**content, "axes": axes}.items() if table}

    @cached_property
    def study(self) -> Study:
        """That study, as read.

        Raises:
            UserError: a change that no study takes.
        """
        return study_of(self.as_study, "", self.folder / "bench")

    @cached_property
    def case(self) -> Case:
        """Its only case.

        Raises:
            UserError: an axis that there is not.
        """
        return unfold(self.study)[0]

    @cached_property
    def parsed(self) -> ParsedCase:
        """The tables of its case, read.

        Raises:
            UserError: a value of the wrong unit or out of its range, an unknown name.
        """
        return parse_case(self.study, self.case)

    @cached_property
    def resolved(self) -> Resolved:
        """What it runs.

        Raises:
            UserError: values that do not serve the plant, or the controller.
        """
        return self.parsed.resolve()

    @property
    def serves(self) -> bool:
        """Whether it can be run."""
        try:
            _ = self.resolved
        except UserError:
            return False
        return True

    @property
    def controller_name(self) -> str:
        """The name of its controller in the study."""
        return named(self.case, "controller")

    @property
    def reference_name(self) -> str:
        """The name of its reference in the study, "" without one."""
        return named(self.case, "reference")


def _of_another(key: str, section: str, chosen: str | None) -> bool:
    """Whether a dotted key belongs to a table of `section` that is not the chosen one."""
    first, _, rest = key.partition(".")
    return first == section and rest.split(".")[0] != chosen


def _undotted(tables: Mapping[str, Any]) -> dict[str, Any]:
    """Tables by names without a dot, which divides the keys of a study."""
    return {name.replace(".", "_"): table for name, table in tables.items()}


def loop_of(study: Study, case: Case) -> BenchLoop:
    """A case of a study as a loop on the bench: without the study's other cases, its tables and its figures.

    Machine and scenario stay what they are, since they say what controllers believe; those of files, and the gains of
    gain files, come along, so that the study that is saved needs none of them.
    """
    file = study.file
    tables = {name: getattr(file, name) for name in OVERRIDES if name != "axes"}
    if case.name is not None:
        tables = merged(tables, {key: value for key, value in file.cases[case.name].items() if key != "axes"})
    tables |= {section: _undotted(case.tables[section]) for section in ("controllers", "references")}
    axes = {
        axis: [str(value).replace(".", "_") if axis in CHOSEN else value]
        for axis, value in case.axes.items()
        if axis != DRAW and not axis.startswith(HELD)
    }
    layers = {
        layer.section: {name: getattr(file, layer.section)[name] for name in axes.get(axis, [])}
        for axis, layer in LAYERS.items()
    }
    heading = {"title": file.title, "source": file.source}
    content = {**heading, **tables, **layers, "axes": axes}
    return BenchLoop({name: value for name, value in content.items() if value}, study.path.parent)
