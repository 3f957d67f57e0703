"""Plants that may be met: samples of friction, payload, pressures and noise, the same for whoever is compared."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field

import numpy as np

from plants.axis import LINEAR, unit_along
from workbench.parameters.sets import nearby, parameter_path, read_deviations, read_parameters
from workbench.study.overrides import PlantSample, SensorSample, spread_names
from workbench.study.sensor_tables import CHANNEL_UNITS
from workbench.study.study import Case, Study
from workbench.study.uncertainty_schema import FactorTable, UncertaintyTable
from workbench.toml.reading import SchemaError
from workbench.toml.units import QuantityError, si

LAST_SEED = 2**31 - 1
"""Seeds of noise and curves are below it: what a study file and an int32 can hold."""

RUN_STREAM = 3
"""The stream of samples of `workbench run`: none of those on which gains are tuned or decisions made."""


@dataclass(frozen=True)
class Draws:
    """Machines that may be met, by their `numbers`, of plants whose positions are in `axis`."""

    table: UncertaintyTable
    numbers: Sequence[int]
    axis: str = LINEAR
    _known: dict[int, PlantSample] = field(default_factory=dict, repr=False, compare=False)

    def sample(self, number: int) -> PlantSample:
        """The machine of that number, made once: many cases are run on it."""
        if number not in self._known:
            self._known[number] = plant_sample(self.table, number, RUN_STREAM, self.axis)
        return self._known[number]


def draws_of(
    study: Study, cases: Sequence[Case], numbers: Sequence[int] | None = None, axis: str = LINEAR
) -> Draws | None:
    """The machines of these `numbers` (default: 1 to the study's number of draws); None where a study draws none.

    `cases` are those that stand for all of it.

    Raises:
        UserError: what [uncertainty] says does not serve the study's plants or sensors.
    """
    table = study.file.uncertainty
    if table is None or not table.draws:
        return None
    check_scales(study, cases)
    draws = Draws(table, numbers or range(1, table.draws + 1), axis)
    try:
        for parameters in {str(case.tables["plant"]["parameters"]) for case in cases} if table.friction else ():
            spread_names(parameters, read_deviations(parameter_path(parameters, study.path.parent)))
        draws.sample(draws.numbers[0])
    except SchemaError as mistake:
        raise study.error(mistake.key, mistake.message) from None
    return draws


def check_scales(study: Study, cases: Iterable[Case]) -> None:
    """Factors need parameters that there are; told where they stand, not where a draw puts them.

    Raises:
        UserError: a factor on a parameter that the plant of no case has.
    """
    if study.file.uncertainty is None:
        return
    tables = [case.tables["plant"] for case in cases]
    known = {name for table in tables for name in table.get("set", {})}
    for parameters in {str(table["parameters"]) for table in tables}:
        known |= set(read_parameters(parameter_path(parameters, study.path.parent)))
    for name in study.file.uncertainty.scale:
        if name not in known:
            raise study.error(("uncertainty", "scale", name), f"unknown parameter; {nearby(name, sorted(known))}")


def plant_sample(table: UncertaintyTable, number: int, stream: int = 0, axis: str = LINEAR) -> PlantSample:
    """The plant of draw `number`: each draw of a `stream` is the same plant for every case and controller.

    Factors are drawn uniformly, or so in their logarithm. Every channel takes as many random numbers, whichever of
    its errors a case bounds.

    Raises:
        SchemaError: a channel that there is not, or a noise of another unit.
    """
    generator = np.random.default_rng([table.seed, stream, number])
    seed = int(generator.integers(LAST_SEED))
    factors = {name: _factor(limits, generator.random()) for name, limits in table.scale.items()}
    noise = dict[str, float]()
    for channel, limits in table.noise.items():
        low, high = (_noise(channel, key, value, axis) for key, value in (("min", limits.min), ("max", limits.max)))
        noise[channel] = low + (high - low) * generator.random()
    sensors = dict[str, SensorSample]()
    for channel in CHANNEL_UNITS if table.calibration else ():
        offset, gain_error = generator.uniform(-1.0, 1.0, 2)
        sensors[channel] = SensorSample(float(offset), float(gain_error), int(generator.integers(LAST_SEED)))
    return PlantSample(seed, table.friction, factors, noise, sensors)


def _factor(factors: FactorTable, share: float) -> float:
    """The factor at a share (0 to 1) of its range."""
    if factors.scale == "log":
        return float(factors.min * (factors.max / factors.min) ** share)
    return factors.min + (factors.max - factors.min) * share


def _noise(channel: str, key: str, value: object, axis: str) -> float:
    if channel not in CHANNEL_UNITS:
        raise SchemaError(("uncertainty", "noise", channel), f"no such sensor; expected {', '.join(CHANNEL_UNITS)}")
    try:
        return si(value, unit_along(CHANNEL_UNITS[channel], axis))
    except QuantityError as error:
        raise SchemaError(("uncertainty", "noise", channel, key), str(error)) from None
