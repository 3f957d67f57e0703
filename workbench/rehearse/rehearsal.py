"""A study run twice: with its controllers as the program has them, and with their exported C in the loop."""

import itertools
import math
import time
from collections.abc import Callable, Mapping, Sequence
from contextlib import closing
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from workbench.parallel.chunks import enough, in_chunks
from workbench.rehearse.lockstep import Lockstep
from workbench.simulation.simulate import finer, simulate
from workbench.study.case_runs import compiled, figures_of
from workbench.study.plan import Plan
from workbench.study.resolve import Resolved
from workbench.study.study import Case, in_full

Figures = Mapping[str, float | str | None]
"""The figures of a case, by column."""

Progress = Callable[[int, int, str], None]
"""Called with the number of finished cases, of all cases, and one that has just finished, in words."""


class Compared(NamedTuple):
    """One figure of a case: as the study has it, and as rehearsed. None: it does not apply."""

    case: Mapping[str, object]
    column: str
    study: float | str | None
    rehearsed: float | str | None

    @property
    def printed(self) -> tuple[str, str]:
        """Both as results.csv has them."""
        return printed(self.study), printed(self.rehearsed)

    @property
    def equal(self) -> bool:
        """Whether they agree to the last digit that is printed."""
        return self.printed[0] == self.printed[1]

    @property
    def difference(self) -> float:
        """By how much they differ; infinite where one of them is no number and they are not the same."""
        if isinstance(self.study, float) and isinstance(self.rehearsed, float):
            return self.rehearsed - self.study
        return 0.0 if self.study == self.rehearsed else math.inf


def printed(value: float | str | None) -> str:
    """A figure as results.csv has it."""
    return f"{value:.10g}" if isinstance(value, float) else str(value or "")


@dataclass(frozen=True)
class Rehearsal:
    """What is done with some cases: each is run both ways. The C of their controllers is compiled before."""

    planned: Plan
    lockstep: Lockstep

    def __call__(self, indices: Sequence[int]) -> list[tuple[Figures, Figures]]:
        """The figures of cases, of the study and rehearsed; as many cases as take about a chunk's time."""
        began, found = time.perf_counter(), list[tuple[Figures, Figures]]()
        for index in indices:
            case, resolved = self.planned.cases[index], self.planned.resolved[index]
            other = replace(resolved, setup=self.lockstep.rehearsed(resolved.setup))
            found.append((_figures(case, resolved), _figures(case, other)))
            if enough(began):
                break
        return found


def rehearse(
    planned: Plan, folder: Path, *, jobs: int | None = None, progress: Progress | None = None
) -> list[Compared]:
    """Run every case of a study both ways; the C of its controllers is written into a folder and compiled there.

    Raises:
        UserError: a controller cannot be written as C, there is no compiler, or a mistake in a case.
    """
    lockstep = Lockstep(folder)
    for resolved in planned.declared:
        lockstep.rehearsed(resolved.setup)
    compiled(planned)
    count, found = len(planned.cases), dict[int, tuple[Figures, Figures]]()
    with closing(in_chunks(Rehearsal(planned, lockstep), range(count), jobs=jobs)) as chunks:
        for chunk in chunks:
            found.update(zip(chunk.places, chunk.results, strict=True))
            if progress is not None:
                progress(len(found), count, in_full(planned.cases.columns(chunk.places[-1])))
    return list(itertools.chain.from_iterable(_compared(planned, index, *found[index]) for index in range(count)))


def _figures(case: Case, resolved: Resolved) -> Figures:
    run = simulate(resolved.setup)
    return figures_of(resolved, run, finer(resolved.setup, run) if case.tells_solver_error else None)


def _compared(planned: Plan, index: int, own: Figures, other: Figures) -> list[Compared]:
    columns = planned.cases.columns(index)
    return [Compared(columns, column, own[column], other[column]) for column in own]
