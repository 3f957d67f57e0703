"""Bogacki's and Shampine's pair of order 3 with an embedded order 2: cheaper where an answer may be coarse."""

from workbench.simulation.integrators.interface import IntegrationMethod

BOGACKI_SHAMPINE = IntegrationMethod(
    name="bogacki_shampine",
    summary="error control, order 3",
    source="Bogacki and Shampine 1989",
    nodes=(1 / 2, 3 / 4, 1.0),
    stages=((1 / 2,), (0.0, 3 / 4), (2 / 9, 1 / 3, 4 / 9)),
    weights=(2 / 9, 1 / 3, 4 / 9, 0.0),
    errors=(-5 / 72, 1 / 12, 1 / 9, -1 / 8),
    order=3,
)
