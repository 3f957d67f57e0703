"""Hidden states that recorded inputs alone drive, where one of them drives another: in compiled code.

A spool of second order, a play before it, a delay before that: over a sample, in which the input is held,

    z <- z + h phi(h J) r,   phi(X) = (e^X - 1) / X,   J = dr/dz

is exact as long as their rates r are linear, and stable whatever a sample is to them (an exponential Rosenbrock-Euler
step; Hochbruck and Ostermann 2010). phi comes from the exponential of [[h J, h r], [0, 0]].
"""

from typing import Any

import numpy as np

from plants.compiled import address, inner
from workbench.simulation.compilation import call_derivatives

TERMS = 8
"""Of the exponential's series, for a matrix of norm 1/2 or less: exact to 1e-8."""

SETTLING = 20_000
"""Steps in which states come to rest under the first input, at most."""


@inner()
def slopes_between(
    derivatives: int,
    time: float,
    state: Any,
    inputs: Any,
    parameters: Any,
    driven: Any,
    nudges: Any,
    rates: Any,
    other: Any,
    slopes: Any,
) -> bool:
    """dr_i/dz_j of the `driven` states; whether one of them counts in the rate of another."""
    coupled = False
    for j in range(driven.size):
        state[driven[j]] += nudges[driven[j]]
        call_derivatives(derivatives, time, address(state), inputs, parameters, address(other))
        state[driven[j]] -= nudges[driven[j]]
        for i in range(driven.size):
            slopes[i, j] = (other[driven[i]] - rates[driven[i]]) / nudges[driven[j]]
            coupled = coupled or (i != j and slopes[i, j] != 0.0)
    return coupled


@inner()
def changes(slopes: Any, driven: Any, rates: Any, step: float, moved: Any) -> None:
    """h phi(h J) r of each: by how much they change in a step."""
    size = driven.size
    matrix, norm = np.zeros((size + 1, size + 1)), 0.0
    largest = 0.0
    for i in range(size):
        largest = max(largest, abs(step * rates[driven[i]]))
    if largest == 0.0:
        moved.fill(0.0)
        return
    for i in range(size):
        for j in range(size):
            matrix[i, j] = step * slopes[i, j]
        matrix[i, size] = step * rates[driven[i]] / largest  # so that no unit decides how often it is squared
        norm = max(norm, np.sum(np.abs(matrix[i])))
    halvings = max(int(np.ceil(np.log2(2.0 * norm))), 0) if norm > 0.0 else 0
    matrix /= 2.0**halvings
    power = np.eye(size + 1)
    whole = np.eye(size + 1)
    for term in range(1, TERMS + 1):
        power = power @ matrix / term
        whole += power
    for _ in range(halvings):
        whole = whole @ whole
    for i in range(size):
        moved[i] = largest * whole[i, size]


@inner()
def settle(
    derivatives: int, time: float, state: Any, inputs: Any, parameters: Any, driven: Any, nudges: Any, step: float
) -> None:
    """Let the `driven` states come to where the inputs hold them."""
    size = state.size
    rates, other = np.empty(size), np.empty(size)
    slopes, moved = np.empty((driven.size, driven.size)), np.empty(driven.size)
    for _ in range(SETTLING):
        call_derivatives(derivatives, time, address(state), inputs, parameters, address(rates))
        slopes_between(derivatives, time, state, inputs, parameters, driven, nudges, rates, other, slopes)
        changes(slopes, driven, rates, step, moved)
        rests = True
        for i in range(driven.size):
            state[driven[i]] += moved[i]
            rests = rests and abs(moved[i]) < 1e-9 * nudges[driven[i]]
        if rests:
            return
