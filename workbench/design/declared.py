"""Hypotheses of an experiment without a diagnosis: the declared plant, and what it may lack at a size that is felt."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

import numpy as np

from plants.effects.interface import Effect
from plants.effects.registry import effects as registered
from plants.equation import NEGATIVE
from workbench.design.asked import Asked
from workbench.design.hypotheses import Hypothesis
from workbench.diagnose.readiness import declared_values
from workbench.diagnose.residuals.balances import allowed, effects_told, own_parameters
from workbench.diagnose.residuals.scales import Moved, scales_from
from workbench.diagnose.residuals.unknowns import VAGUE, Unknown, unknown
from workbench.errors import UserError, nearest
from workbench.parameters.sets import NEUTRAL
from workbench.records.experiment import Experiment

SIZES = 3.0
"""Standard deviation of what sizes an effect, in sizes that are felt, before any record."""

ACCELERATED = 10.0
"""1/s: of the largest speed, that machine is taken to be accelerated by [assumed]."""


def hypotheses_of(
    experiment: Experiment, asked: Asked, channels: Sequence[str], moved: tuple[float, float, float]
) -> list[Hypothesis]:
    """The declared plant with each of the effects that are asked about; `moved` are its way, speed and sample time.

    Raises:
        UserError: an effect that the plant cannot have, or that no channel shows.
    """
    values = declared_values(experiment)
    told = effects_told(experiment.plant, channels)
    for name in asked.between:
        if name != "none" and name not in told:
            raise UserError(
                f'"{name}": no effect that the channels of {experiment.path} could show; '
                f"{nearest(name, ['none', *told])}"
            )
    way, speed, sample_time = moved
    scales = scales_from(Moved(speed, way, ACCELERATED * speed, asked.duration, sample_time), values)
    balances = allowed(experiment.plant, experiment.flow, channels)
    own = [name for names in own_parameters(balances, experiment.free, values).values() for name in names]
    base = [unknown(name, values, experiment.bounds, scales) for name in dict.fromkeys([*own, *asked.identify])]
    known = [_precision(each, experiment.deviations) for each in base]
    found = []
    for name in asked.between or ("none",):
        if name == "none":
            found.append(Hypothesis((), values, base, np.diag(known)))
            continue
        effect = registered(experiment.plant.axis)[name]
        said = _asked_sizes(asked.sizes, effect.numbers)

        def shaped(share: float, of: Effect = effect, said: Mapping[str, float] = said) -> Hypothesis:
            """The effect with the values so far along the grids of what shapes it."""
            sized: dict[str, float] = {}
            for key in of.variants[-1]:
                number = of.numbers[key]
                if number.shapes:
                    place = min(int(share * len(number.grid)), len(number.grid) - 1)
                    sized[key] = number.grid[place] * number.scale(scales)
                elif number.size:
                    sized[key] = NEUTRAL.get(key, 0.0) + number.size * number.scale(scales)
                else:
                    sized[key] = _other_direction(key, values)
            sized |= said
            there = {**values, **sized}
            free = [unknown(key, there, experiment.bounds, scales) for key in sized if not of.numbers[key].shapes]
            precision = np.diag([*known, *([1.0 / SIZES**2] * len(free))])
            return Hypothesis((of.name,), there, [*base, *free], precision)

        middle, ends = shaped(0.5), [shaped(0.0), shaped(1.0)]
        found.append(replace(middle, others=tuple(one for one in ends if one.values != middle.values)))
    return found


def _asked_sizes(sizes: Mapping[str, float], known: Collection[str]) -> dict[str, float]:
    """Of an effect's numbers those that are asked for: a plain name sets both directions."""
    other = {f"{name}_{NEGATIVE}": value for name, value in sizes.items()}
    return {name: value for name, value in {**other, **sizes}.items() if name in known}


def _other_direction(name: str, values: Mapping[str, float]) -> float:
    """A parameter of the other direction that is felt: half more than that of the first."""
    return 1.5 * values.get(name.removesuffix(f"_{NEGATIVE}"), 0.0)


def _precision(of: Unknown, deviations: Mapping[str, float]) -> float:
    """Of an unknown as a search sees it: by its declared deviation, else within a factor."""
    if std := deviations.get(of.name):
        return float((abs(of.slope(of.place(of.start))) / std) ** 2)
    return 1.0 / VAGUE**2
