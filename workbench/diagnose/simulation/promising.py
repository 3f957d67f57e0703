"""Which effects are worth a whole fit to simulation error: what a first-order prediction says of each."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np

from plants.effects.interface import Scales
from plants.effects.registry import effects
from plants.equation import NEGATIVE
from workbench.diagnose.residuals.balance import Balance
from workbench.diagnose.residuals.fit import Fit, Search, fit
from workbench.diagnose.residuals.unknowns import Values, unknown
from workbench.diagnose.selection.selection import Candidate, extends
from workbench.parameters.sets import NEUTRAL

QUICK = Search(flat=1e-3, near=1e-4, most_steps=10)
"""When a fit ends by which effects are ranked: one that counts is worth several per cent of the error."""

TRIED = 3
"""Effects that are fitted whole in a round, of those that promise most."""

PROMISING = 0.1
"""Share of what is more than noise that a first-order prediction has to take away for that."""

NEXT_BEST = 0.4
"""The same as a part of what the best one promises."""

NEARLY_ALL = 0.9
"""The same from which only a candidate that promises as much is tried beside it."""

EXPLAINS = 0.5
"""Share of the squares beyond noise that an effect has to take away: the stronger one of two that are missing does."""

PRICE = 0.02
"""Share of what is more than noise that every further parameter has to promise."""

CHANGE = 0.02
"""Relative change of a parameter that has a value already, at which its worth is first looked at."""

SEEN, LARGER = 20.0, 5.0
"""Floors (rms) by which a change has to move a simulation, and times that a change is larger that does not. Most of
what it moves the plant's own parameters move as well, and contacts that break away a step sooner or later are noise in
what is left of it."""


class _Promise(NamedTuple):
    """What a first-order prediction says of an effect: the share beyond noise that it takes away, by which of its
    parameters, and where these begin.
    """

    share: float
    effect: str
    variant: tuple[str, ...]
    start: dict[str, float]


def promising(
    before: Fit, taken: Mapping[str, Sequence[str]], bounds: Mapping[str, tuple[float, float]]
) -> list[Candidate]:
    """The effects that promise most, fitted, from the best."""
    balance = before.balance
    columns: dict[str, np.ndarray] = {}
    promised = list[_Promise]()
    for name in balance.effects:
        effect = effects(balance.axis)[name]
        tried = []
        for variant in effect.variants:
            more = [name for name in variant if name not in before.names]
            if not more or (effect.name in taken and not extends(variant, before.names)):
                continue
            for name in more:
                if name not in columns:
                    columns[name] = _column(balance, before, name)
            left, sizes = _predicted(before, [columns[name] for name in more])
            share = _share(float(np.mean(before.residual**2)), left)
            start = {name: _reached(before, name, size, bounds) for name, size in zip(more, sizes, strict=True)}
            tried.append(_Promise(share, effect.name, variant, start))
        if tried:
            promised.append(max(tried, key=lambda promise: promise.share - PRICE * len(promise.variant)))
    promised.sort(key=lambda promise: -promise.share)
    fitted = list[Candidate]()
    for promise in promised[:TRIED]:
        done = any(explained(before, candidate.fit) > NEARLY_ALL for candidate in fitted)
        if promise.share > max(EXPLAINS if done else PROMISING, NEXT_BEST * promised[0].share):
            names = [*before.names, *promise.start]
            with_it = fit(balance, {**before.values, **promise.start}, names, bounds, QUICK)
            fitted.append(Candidate(promise.effect, promise.variant, with_it))
    return sorted(fitted, key=lambda candidate: candidate.score)


def _step(values: Values, name: str, scales: Scales) -> float:
    """The change of a parameter at which its worth is looked at."""
    searched = unknown(name, values, {}, scales)
    return CHANGE * searched.size if searched.logarithmic else searched.size


def _column(balance: Balance, before: Fit, name: str) -> np.ndarray:
    """What a change of one parameter does to the residual, to first order."""
    value, step = _value(before.values, name), _step(before.values, name, balance.scales)

    def change(times: float) -> np.ndarray:
        moved = balance.stacked({**before.values, name: value + times * step})
        return np.asarray(np.nan_to_num(moved, nan=1e6) - before.residual)

    small = change(1.0)
    return small if np.sqrt(np.mean(small**2)) > SEEN else change(LARGER) / LARGER


def _value(values: Values, name: str) -> float:
    return values.get(name, NEUTRAL.get(name, values.get(name.removesuffix(f"_{NEGATIVE}"), 0.0)))


def _predicted(before: Fit, columns: Sequence[np.ndarray]) -> tuple[float, np.ndarray]:
    """Mean square that a linear fit with further columns leaves, and the size of each column in it."""
    jacobian = np.column_stack([before.jacobian, *columns])
    step = np.linalg.lstsq(jacobian, -before.residual, rcond=1e-10)[0]
    return float(np.mean((before.residual + jacobian @ step) ** 2)), step[before.jacobian.shape[1] :]


def _reached(before: Fit, name: str, size: float, bounds: Mapping[str, tuple[float, float]]) -> float:
    """The value of a parameter that a prediction gives, within its bounds."""
    values, scales = before.values, before.balance.scales
    searched = unknown(name, values, bounds, scales)
    start = _value(values, name)
    value = start + size * _step(values, name, scales)
    if searched.logarithmic:
        return float(np.clip(value, 0.5 * start, 2.0 * start))
    return float(np.clip(value, searched.low * searched.size, searched.high * searched.size))


def _share(before: float, after: float) -> float:
    """Share of the mean squares beyond noise (1) that is taken away."""
    return (before - after) / max(before - 1.0, 1e-12)


def explained(before: Fit, after: Fit) -> float:
    """Share of the squares beyond noise that a fit takes away from another."""
    return _share(before.rms**2, after.rms**2)
