"""Methods that take steps of one length: of order 1, 2 and 4."""

from workbench.simulation.integrators.interface import IntegrationMethod

EULER = IntegrationMethod("euler", "fixed step, order 1", "Euler 1768", (), (), (1.0,))

HEUN = IntegrationMethod("heun", "fixed step, order 2", "Heun 1900", (1.0,), ((1.0,),), (0.5, 0.5))

RK4 = IntegrationMethod(
    "rk4",
    "fixed step, order 4",
    "Kutta 1901",
    (0.5, 0.5, 1.0),
    ((0.5,), (0.0, 0.5), (0.0, 0.0, 1.0)),
    (1 / 6, 1 / 3, 1 / 3, 1 / 6),
)
