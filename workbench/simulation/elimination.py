"""Gauss's elimination of a linear system, written out as code over numbers or vectors of lanes."""

from collections.abc import Sequence
from typing import Any

from llvmlite import ir

from workbench.recording.lowering import constant


class Eliminated:
    """A system of which `rows` are the coefficients, brought to a triangle without pivots; it is solved for any number
    of right sides.
    """

    def __init__(self, builder: ir.IRBuilder, rows: Sequence[Sequence[Any]]) -> None:
        self._builder, self._rows, self._over = builder, [list(row) for row in rows], list[Any]()
        one = constant(rows[0][0].type, 1.0)
        for pivot, upper in enumerate(self._rows):
            self._over.append(builder.fdiv(one, upper[pivot]))
            for row in self._rows[pivot + 1 :]:
                row[pivot] = builder.fmul(row[pivot], self._over[pivot])
                for j in range(pivot + 1, len(row)):
                    row[j] = builder.fsub(row[j], builder.fmul(row[pivot], upper[j]))

    def solved(self, given: Sequence[Any]) -> list[Any]:
        """The unknowns of a right side."""
        builder, x, size = self._builder, list(given), len(given)
        for i, row in enumerate(self._rows):
            for j in range(i):
                x[i] = builder.fsub(x[i], builder.fmul(row[j], x[j]))
        for i in reversed(range(size)):
            for j in range(i + 1, size):
                x[i] = builder.fsub(x[i], builder.fmul(self._rows[i][j], x[j]))
            x[i] = builder.fmul(x[i], self._over[i])
        return x
