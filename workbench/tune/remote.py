"""Scores of points that the workers of a cluster find, while the searches stay where the command runs."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

from plants.equation import source_hash
from workbench.parallel.cluster import Asked, check_version, connected
from workbench.study.study import Study
from workbench.tune.evaluator import Evaluator, evaluators_of
from workbench.tune.objective import Score
from workbench.tune.space import Point
from workbench.tune.trials import PROGRAM


@dataclass(frozen=True)
class Evaluators:
    """The evaluators of a tuning, as a worker makes them anew; its program has to be of this `version`."""

    study: Study
    names: Sequence[str]
    version: str

    def __call__(self, number: int, method: str, *arguments: Any) -> Any:
        """What a method of one of them says; raises UserError where the program is of another version."""
        return getattr(self._made[number], method)(*arguments)

    @cached_property
    def _made(self) -> list[Evaluator]:
        check_version(self.version, PROGRAM)
        return evaluators_of(self.study, self.names)


@dataclass(frozen=True, eq=False)
class RemoteEvaluator(Evaluator):
    """An evaluator that has its points scored elsewhere: `ask` is told what by, and of which point."""

    ask: Callable[..., Any] = field(kw_only=True)
    number: int = field(kw_only=True)

    def screened(self, point: Point) -> Score:
        """See `Evaluator`."""
        return self._answer("screened", point)

    def declared(self, point: Point) -> Score:
        """See `Evaluator`."""
        return self._answer("declared", point)

    def on_draws(self, point: Point) -> Score:
        """See `Evaluator`."""
        return self._answer("on_draws", point)

    def on_samples(self, point: Point, numbers: Iterable[int], stream: int) -> list[float]:
        """See `Evaluator`."""
        return self._answer("on_samples", point, list(numbers), stream)

    def hunting(self, point: Point, numbers: Iterable[int], stream: int) -> float:
        """See `Evaluator`."""
        return self._answer("hunting", point, list(numbers), stream)

    def _answer(self, method: str, *arguments: Any) -> Any:
        return self.ask(self.number, method, *arguments)


@contextmanager
def on_cluster(
    evaluators: Sequence[Evaluator], study: Study, names: Sequence[str], address: str | None
) -> Iterator[Sequence[Evaluator]]:
    """The same evaluators, whose points are scored by the workers of the dask scheduler at an address, if one is given.

    Raises:
        UserError: no scheduler answers there.
    """
    if address is None:
        yield evaluators
        return
    with connected(address) as client:
        ask = Asked(client, address, Evaluators(study, names, source_hash(PROGRAM)))
        yield [
            RemoteEvaluator(each.task, each.objective, ask=ask, number=number) for number, each in enumerate(evaluators)
        ]
