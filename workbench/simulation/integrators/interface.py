"""What an integration method is: one object with the tableau of a Runge-Kutta scheme, explicit or linearly implicit."""

from dataclasses import dataclass

ROUNDING = 1e-12
"""By how much the sums of a tableau may be off."""


@dataclass(frozen=True)
class IntegrationMethod:
    """A Runge-Kutta scheme over a step h.

        k_1 = f(t, y),   k_i = f(t + c_i h, y + h sum over j < i of a_ij k_j),   y <- y + h sum of b_i k_i

    Without `errors` steps have one length. With them h sum of e_i k_i is the estimated error, which controls the
    length; the last stage is then taken at the end of the step, and its slope is the first of the next step.

    With `implicit` it is a Rosenbrock-Wanner scheme, whose stable steps no fast rate of the plant bounds: each slope
    solves a linear system with the Jacobian J of f at (t, y), by difference quotients,

        (I - h g J) (k_i + s_i) = f(t + c_i h, y + h sum over j < i of a_ij k_j) + g_i h df/dt + s_i

    with s_i = sum over j < i of g_ij k_j / g, g = g_ii and g_i = sum over j <= i of g_ij.

    Attributes:
        name: by which [simulation] method names it.
        summary: what it is, in words.
        source: who published it.
        nodes: c_i, from the second stage on.
        stages: a_ij, a row a stage from the second on.
        weights: b_i.
        errors: e_i, the weights less those of the embedded method; none for steps of one length.
        order: the estimated error falls as the step to this power; needed with `errors`.
        implicit: g_ij, a row a stage from the first on, each up to its g_ii, which are all the same; none of an
            explicit scheme.
    """

    name: str
    summary: str
    source: str
    nodes: tuple[float, ...]
    stages: tuple[tuple[float, ...], ...]
    weights: tuple[float, ...]
    errors: tuple[float, ...] = ()
    order: int = 0
    implicit: tuple[tuple[float, ...], ...] = ()

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
    if method.implicit:
        rows = [len(row) for row in method.implicit]
        if rows != list(range(1, method.count + 1)) or len({row[-1] for row in method.implicit}) != 1:
            raise ValueError("implicit: expected a row of i numbers for each stage i, all with the same last one")
    if not method.errors:
        return
    if len(method.errors) != method.count or abs(sum(method.errors)) > ROUNDING or method.order < 1:
        raise ValueError(f"errors: expected {method.count} numbers whose sum is 0, and the order of that error")
    if not method.implicit and (not method.stages or (*method.stages[-1], 0.0) != method.weights):
        raise ValueError("errors: expected a last stage at the end of the step, whose row is the weights")
