"""What a study would run: its cases, checked to the last key. Nothing here simulates."""

import functools
import hashlib
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import overload

import numpy as np

from plants.axis import LINEAR
from plants.equation import EQUATION_FOLDERS, source_hash
from workbench.metrics.registry import columns
from workbench.study.cases import Cases
from workbench.study.checks.checks import Checks
from workbench.study.identity import led_to, spreads
from workbench.study.parameter_tables import ParameterReader
from workbench.study.resolve import Resolved, parse_case
from workbench.study.study import Case, Study, located
from workbench.study.uncertainty import draws_of
from workbench.study.unfold import MOST_CASES, unfold

PROGRAM_FOLDERS = (*EQUATION_FOLDERS, "workbench/metrics", "workbench/study")
"""Folders of the source files on which a row of results depends."""


MOST_CHECKED = 2000
"""Cases, draws not counted, up to which each is checked before anything runs; of more, so many that stand for all."""


@dataclass(frozen=True)
class Plan:
    """A study that has been checked to the last key: its `cases`, and of those that were `checked`, which are all
    unless there are very many, what they are on the machine as `declared`, not drawn.
    """

    study: Study
    cases: Cases
    checked: Sequence[Case]
    declared: Sequence[Resolved]
    warnings: Sequence[str] = ()

    @cached_property
    def resolved(self) -> "ResolvedCases":
        """What each case runs."""
        return ResolvedCases(self.study, self.cases, self.declared)

    @cached_property
    def axes(self) -> list[str]:
        """Columns that tell the cases apart."""
        return list(self.cases.axes)

    @property
    def columns(self) -> list[str]:
        """Columns of results.csv: the axes, the standard figures, the probes."""
        return [*self.axes, *columns(self.axis), *self.study.file.probes]

    @property
    def axis(self) -> str:
        """Unit of the positions of all its plants, "m" or "rad"."""
        return self.declared[0].setup.plant.axis if self.declared else LINEAR

    @cached_property
    def identity(self) -> dict[str, str]:
        """What results must agree in to be of the same study: the file, the numbers it leads to, all code."""
        return {
            "study": self.study.computed,
            **led_to(self.checked, self.declared),
            "draws": "{}" if self.cases.draws is None else spreads(self.study, self.checked, self.cases.draws),
            "content of its gain files": self._gain_files(),
            "version of the program": source_hash(PROGRAM_FOLDERS),
        }

    def _gain_files(self) -> str:
        """A hash of the gain files that the cases name, where not each case has been looked at; "" where each has."""
        if len(self.checked) == self.cases.bases:
            return ""
        content = hashlib.sha256()
        for path in self.cases.gain_files():
            content.update(path.read_bytes() if path.is_file() else b"")
        return content.hexdigest()

    @property
    def simulated_seconds(self) -> float:
        """Duration of all cases together (s); of very many, as far as those checked tell."""
        return sum(item.setup.duration for item in self.declared) * len(self.cases) / max(len(self.declared), 1)

    @property
    def seeds(self) -> list[int]:
        """The seeds of noise and friction of its cases; of very many, those of the cases checked."""
        draws = self.cases.draws
        if draws is not None:
            return sorted({draws.sample(number).seed for number in draws.numbers})
        return sorted({item.setup.seed for item in self.declared})


class ResolvedCases(Sequence[Resolved]):
    """What each case of a study runs, built when it is asked for, unless it was for the checks."""

    def __init__(self, study: Study, cases: Cases, declared: Sequence[Resolved] = ()) -> None:
        self._study, self._cases = study, cases
        self._read = ParameterReader()
        self._built = declared if len(declared) == len(cases) and cases.draws is None else ()

    def __reduce__(self) -> tuple[object, ...]:
        return ResolvedCases, (self._study, self._cases)

    def __len__(self) -> int:
        return len(self._cases)

    @overload
    def __getitem__(self, index: int) -> Resolved: ...
    @overload
    def __getitem__(self, index: slice) -> list[Resolved]: ...
    def __getitem__(self, index: int | slice) -> Resolved | list[Resolved]:
        """Raises UserError for a mistake in a case that was not among those checked."""
        if isinstance(index, slice):
            return [self[i] for i in range(*index.indices(len(self)))]
        return self._built[index] if self._built else parse_case(self._study, self._cases[index], self._read).resolve()


def plan(study: Study) -> Plan:
    """Unfold and check a study.

    Raises:
        UserError: the first mistake in any case that is checked, table or figure.
    """
    planned = _drawn(study, unfold(study))
    check_one_axis(study, planned)
    checks = Checks(planned.study, planned.checked, planned.declared, planned.cases, list(columns(planned.axis)))
    checks.all()
    return replace(planned, warnings=checks.warnings())


def check_one_axis(study: Study, planned: Plan) -> None:
    """Raise UserError where some plants go straight and others turn: results have one column for both."""
    for case, item in zip(planned.checked, planned.declared, strict=True):
        if item.setup.plant.axis != planned.axis:
            first, other = planned.declared[0].setup.plant.name, item.setup.plant.name
            message = f"{first} has positions in {planned.axis}, {other} in {item.setup.plant.axis}; make two studies"
            raise located(study, case, ("plant", "model"), message)


def again(planned: Plan, wanted: Sequence[Mapping[str, object]], draws: int) -> Plan:
    """Those cases of a plan that have one of the `wanted` sets of columns, on so many machines not yet drawn."""
    study, table = planned.study, planned.study.file.uncertainty
    cases = unfold(study)
    chosen = functools.reduce(np.union1d, [cases.where(where) for where in wanted])
    first = 1 + (table.draws if table is not None else 0)
    return _drawn(study, cases.among(chosen), range(first, first + draws))


def _drawn(study: Study, cases: Cases, numbers: range | None = None) -> Plan:
    """The plan of these cases on each machine, where the study draws any."""
    told = cases[:] if cases.bases <= MOST_CHECKED else [cases[place] for place in cases.telling(MOST_CHECKED)]
    read = ParameterReader()
    declared = [parse_case(study, case, read).resolve() for case in told]
    axis = declared[0].setup.plant.axis if declared else LINEAR
    drawn = cases.on(draws_of(study, told, numbers, axis))
    if (count := len(drawn)) > MOST_CASES:
        message = f"{drawn.repeats} draws make {count} cases, expected at most {MOST_CASES}"
        raise study.error(("uncertainty", "draws"), message)
    return Plan(study, drawn, [drawn.drawn(case) for case in told], declared)


def needed_trajectories(planned: Plan) -> set[int]:
    """Indices of the cases whose trajectories some figure of the study draws."""
    columns = planned.columns
    wanted = [
        curve.where
        for figure in planned.study.file.figures
        for panel in figure.panels
        if panel.x not in columns
        for curve in panel.curves
    ]
    return {int(place) for where in wanted for place in planned.cases.where(where)}
