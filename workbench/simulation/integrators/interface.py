"""What an integration method is: one object with the tableau of an explicit Runge-Kutta scheme."""

from dataclasses import dataclass

ROUNDING = 1e-12
"""By how much the sums of a tableau may be off."""


@dataclass(frozen=True)
class IntegrationMethod:
    """An explicit Runge-Kutta scheme over a step h.

        k_1 = f(t, y),   k_i = f(t + c_i h, y + h sum over j < i of a_ij k_j),   y <- y + h sum of b_i k_i

    Without `errors` steps have one length. With them h sum of e_i k_i is the estimated error, which controls the
    length; the last stage is then taken at the end of the step, and its slope is the first of the next step.

    Attributes:
        name: by which [simulation] method names it.
        summary: what it is, in words.
        source: who published it.
        nodes: c_i, from the second stage on.
        stages: a_ij, a row a stage from the second on.
        weights: b_i.
        errors: e_i, the weights less those of the embedded method; none for steps of one length.
        order: the estimated error falls as the step to this power; needed with `errors`.
    """

    name: str
    summary: str
    source: str
    nodes: tuple[float, ...]
    stages: tuple[tuple[float, ...], ...]
    weights: tuple[float, ...]
    errors: tuple[float, ...] = ()
    order: int = 0

    @property
    def count(self) -> int:
        """Number of slopes of a step."""
        return len(self.stages) + 1


def check(method: IntegrationMethod) -> None:
    """Raise ValueError where the numbers make no method."""
    if len(method.nodes) != len(method.stages):
        raise ValueError(f"nodes: got {len(method.nodes)}, expected one for each of {len(method.stages)} stages")
    for i, (node, row) in enumerate(zip(method.nodes, method.stages, strict=True), start=1):
        if len(row) != i or not any(row) or abs(sum(row) - node) > ROUNDING:
            raise ValueError(f"stages: expected a row {i} of as many numbers, whose sum is its node {node:g}")
    if len(method.weights) != method.count or abs(sum(method.weights) - 1.0) > ROUNDING:
        raise ValueError(f"weights: expected {method.count} numbers whose sum is 1")
    if not method.errors:
        return
    if len(method.errors) != method.count or abs(sum(method.errors)) > ROUNDING or method.order < 1:
        raise ValueError(f"errors: expected {method.count} numbers whose sum is 0, and the order of that error")
    if not method.stages or (*method.stages[-1], 0.0) != method.weights:
        raise ValueError("errors: expected a last stage at the end of the step, whose row is the weights")
