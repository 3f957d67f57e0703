"""Rang's and Angermann's ROS34PW2: linearly implicit, of order 3 with an embedded order 2, for stiff plants.

It is L-stable and stiffly accurate, and a W-method: it keeps its order whatever stands for the Jacobian, so that
difference quotients across a kink of friction do no harm.
"""

from workbench.simulation.integrators.interface import IntegrationMethod

_G = 4.3586652150845900e-01
_WEIGHTS = (2.4212380706095346e-01, -1.2232505839045147e00, 1.5452602553351020e00, _G)
_EMBEDDED = (3.7810903145819369e-01, -9.6042292212423178e-02, 0.5, 2.1793326075422950e-01)

ROS34PW2 = IntegrationMethod(
    name="ros34pw2",
    summary="error control, order 3, linearly implicit: for stiff plants",
    source="Rang and Angermann 2005",
    nodes=(8.7173304301691801e-01, 8.4457060015369423e-01 - 1.1299064236484185e-01, 1.0),
    stages=(
        (8.7173304301691801e-01,),
        (8.4457060015369423e-01, -1.1299064236484185e-01),
        (0.0, 0.0, 1.0),
    ),
    weights=_WEIGHTS,
    errors=tuple(weight - other for weight, other in zip(_WEIGHTS, _EMBEDDED, strict=True)),
    order=3,
    implicit=(
        (_G,),
        (-8.7173304301691801e-01, _G),
        (-9.0338057013044082e-01, 5.4180672388095326e-02, _G),
        (2.4212380706095346e-01, -1.2232505839045147e00, 5.4526025533510214e-01, _G),
    ),
)
