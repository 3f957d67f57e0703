"""Sections: the tables of a study file that belong to a question of their own, such as [tune].

The package that answers the question declares the table and all that a study has to do with it, as one `Section`; here
it has a name and a place. Another package brings its own by an entry point of the group `GROUP`.
"""

import functools
import importlib
import sys
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass
from importlib.metadata import entry_points
from pathlib import Path
from typing import TYPE_CHECKING, Any, Generic, NamedTuple, TypeVar

import numpy as np
from pydantic import create_model

from workbench.errors import UserError
from workbench.study.resolve import Resolved
from workbench.study.schema import StudyFile
from workbench.study.study import Case, Study
from workbench.toml.reading import Key, Strict

if TYPE_CHECKING:
    import pandas as pd

T = TypeVar("T", bound=Strict)

GROUP = "friction_workbench.sections"

OURS = {
    "break_even": "workbench.study.report.break_even:BREAK_EVEN",
    "comparison": "workbench.compare.section:COMPARISON",
    "friction_curves": "workbench.friction_curves.section:FRICTION_CURVES",
    "tune": "workbench.tune.section:TUNE",
    "decide": "workbench.decide.section:DECIDE",
}
"""Where each section is declared. It is imported where a study has its table, and not before."""


@dataclass(frozen=True)
class Checked:
    """A study with its cases, what they resolve to, the axes that tell them apart, and the figures of its results.

    `key` is where the table stands that is checked. `chosen` raises UserError where a `where` at a key picks no case.
    """

    study: Study
    cases: Sequence[Case]
    resolved: Sequence[Resolved]
    axes: Sequence[str]
    figures: Sequence[str]
    chosen: Callable[[Key, Mapping[str, object]], object]
    key: Key = ()


@dataclass(frozen=True, eq=False)
class Overlay:
    """A measured curve that a figure of signals can draw under its own: at a speed of rotation (rpm), in SI."""

    rpm: float
    x: np.ndarray
    y: np.ndarray


@dataclass(frozen=True)
class Again:
    """Cases to be run once more, on so many draws that nothing was chosen on; `said` is who they are."""

    wanted: Sequence[Mapping[str, object]]
    draws: int
    said: str


class Said(NamedTuple):
    """What results say in sentences: the answer, the most wanted first, and what a reader must know of it; `tables`
    are those that belong to it, by name, where there are others that hold details.
    """

    answer: Sequence[str]
    notes: Sequence[str]
    tables: Sequence[str] = ()


@dataclass(frozen=True, kw_only=True)
class Section(Generic[T]):
    """A table of a study file, and what the study has to do with it; each function is handed the table first.

    Attributes:
        name: of the table.
        table: what may stand in it.
        several: whether it is an array of such tables, [[name]]; each function is handed one at a time.
        command: whose question it is. A study whose only question is not that of `run` has nothing to run.
        check: raises UserError for the first mistake that only the cases show.
        warnings: what may be meant, and seldom is.
        describe: in lines what the command would do; raises UserError for any mistake in it.
        overlays: measured curves for the study's figures.
        again: which cases are run once more, from the results and from those of earlier rounds; None: no more.
        tables: writes what is asked for of the results in a folder; returns the paths of Markdown tables.
        pages: the same, for pages with all that is on them; returns the pages.
        said: what the results in a folder say, in sentences.
    """

    name: str
    table: type[T]
    several: bool = False
    command: str = "run"
    check: Callable[[T, Checked], None] = lambda table, checked: None
    warnings: Callable[[T, Checked], Iterable[str]] = lambda table, checked: ()
    describe: Callable[[T, Study], Sequence[str]] = lambda table, study: ()
    overlays: Callable[[T, Study], Sequence[Overlay]] = lambda table, study: ()
    again: Callable[[T, "pd.DataFrame", "pd.DataFrame | None"], Again | None] = lambda table, searched, fresh: None
    tables: Callable[[T, Study, "pd.DataFrame", Path], list[Path]] = lambda table, study, frame, folder: []
    pages: Callable[[T, Study, "pd.DataFrame", Path], list[Path]] = lambda table, study, frame, folder: []
    said: Callable[[T, Study, "pd.DataFrame", Path], Said] = lambda table, study, frame, folder: Said((), ())


def places() -> dict[str, str]:
    """Where every section is declared, by the name of its table; ours cannot be taken by others."""
    return {**_others(tuple(sys.path)), **OURS}


@functools.cache
def _others(search_path: tuple[str, ...]) -> dict[str, str]:
    """Those of other packages: looking for them takes long."""
    return {point.name: point.value for point in entry_points(group=GROUP)}


def load(name: str) -> Section[Any]:
    """The section of that name.

    Raises:
        UserError: another package's, which cannot be used.
    """
    module, _, attribute = places()[name].partition(":")
    try:
        found = getattr(importlib.import_module(module), attribute)
    except (ImportError, AttributeError) as error:
        raise UserError(f"[{name}]: {places()[name]} cannot be used ({error}); mend or uninstall its package") from None
    if not isinstance(found, Section):
        raise UserError(f"[{name}]: {places()[name]} is a {type(found).__name__}, expected a Section")
    return found


def file_model(used: Collection[str]) -> type[StudyFile]:
    """What a study file may hold that has tables of these names: the study's own, and those of sections.

    A section that is not `used` is known by its name alone, so that a slip of the pen finds it.
    """
    return _with_tables(tuple((name, _content(load(name)) if name in used else None) for name in places()))


@functools.lru_cache(64)
def _with_tables(contents: Sequence[tuple[str, object]]) -> type[StudyFile]:
    """A study file with these tables, made once: that takes longer than reading one."""
    tables: dict[str, Any] = {name: (content, None) for name, content in contents}
    return create_model("StudyFile", __base__=StudyFile, **tables)


def _content(section: Section[T]) -> object:
    """What may stand under the name of a section."""
    return (list[section.table] if section.several else section.table) | None  # type: ignore[name-defined]


def sections_of(study: Study) -> list[tuple[Section[Any], Strict]]:
    """The sections of a study, each with its table."""
    return [(section, table) for section, table, _ in placed(study)]


def placed(study: Study) -> list[tuple[Section[Any], Strict, Key]]:
    """The sections of a study, each with its table, or with one of several, and where that stands."""
    contents = {name: getattr(study.file, name, None) for name in places()}
    found: list[tuple[Section[Any], Strict, Key]] = []
    for name, content in contents.items():
        if isinstance(content, list):
            found += [(load(name), table, (name, i)) for i, table in enumerate(content)]
        elif content is not None:
            found.append((load(name), content, (name,)))
    return found


def overlays_of(study: Study) -> list[Overlay]:
    """The measured curves that a study's figures can draw."""
    return [curve for section, table in sections_of(study) for curve in section.overlays(table, study)]


def other_command(study: Study) -> Section[Any] | None:
    """The section that is all a study asks: it has no motions of its own, and nothing for `run`."""
    if study.file.references or study.file.cases:
        return None
    return next((section for section, _ in sections_of(study) if section.command != "run"), None)
