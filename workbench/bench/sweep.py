"""A slider as an axis: one figure of the loop over the values of a knob, point by point."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from typing import Any

from workbench.bench.knobs import Knob
from workbench.bench.loop import BenchLoop, Change
from workbench.bench.measured import MeasuredLoop
from workbench.bench.outcome import outcome_of
from workbench.errors import UserError
from workbench.parallel.workers import workers
from workbench.simulation.simulate import simulate
from workbench.study.resolve import resolve
from workbench.study.run_on import evaluated

POINTS = 200


def places(count: int = POINTS) -> list[float]:
    """Places of a slider, evenly from end to end."""
    return [number / (count - 1) for number in range(count)]


def swept(
    loop: BenchLoop, knob: Knob, values: Sequence[float], column: str, stopped: Callable[[], bool]
) -> Iterator[tuple[float, float | None]]:
    """Each value (SI) with the figure `column` (as on a straight axis) of the loop there, in their order.

    None where the figure does not apply, or the loop cannot be had with that value. No solver errors are found.
    """

    def point(value: float) -> tuple[float, float | None]:
        return value, None if stopped() else _figure(loop, knob.change(value), column)

    with workers() as executor:
        yield from executor.map(point, values)


def _figure(loop: BenchLoop, change: Change, column: str) -> float | None:
    if isinstance(loop, MeasuredLoop):
        return _beside_record(loop, change, column)
    tables: dict[str, Any] = loop.case.tables
    for key, value in change.items():
        tables = _laid(tables, key.split("."), value)
    try:
        resolved = resolve(loop.study, replace(loop.case, tables=tables))
    except UserError:
        return None
    figure = evaluated(resolved, simulate(resolved.setup), (column,))[column]
    return figure if isinstance(figure, float) else None


def _beside_record(loop: MeasuredLoop, change: Change, column: str) -> float | None:
    """The same of a plant that a record drives; its rms error is by how much its position is off the record."""
    turned = loop.changed(change)
    if not turned.serves:
        return None
    outcome = outcome_of(turned)
    figure = outcome.misfits.get("position") if column == "rms_error_m" else outcome.figures.get(column)
    return figure if isinstance(figure, float) else None


def _laid(table: dict[str, Any], keys: Sequence[str], value: object) -> dict[str, Any]:
    """A copy of nested tables with another value at the end of these keys."""
    first, *rest = keys
    return {**table, first: _laid(dict(table.get(first, {})), rest, value) if rest else value}
