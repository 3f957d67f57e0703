"""Machines that may be met: draws of friction, payload, pressures and noise, the same for whoever is compared.

A draw changes what a case says of its plant and sensors, as a scenario does; what controllers believe stays.
"""

import copy
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from plants.equation import NEGATIVE, fields
from plants.interface import SENSORS, Measurement
from workbench.errors import nearest
from workbench.parameters.sets import parameter_path, read_deviations, read_parameters
from workbench.records.schema import FRICTION
from workbench.study.study import Case, Study
from workbench.study.uncertainty_schema import FactorTable, UncertaintyTable
from workbench.toml.reading import SchemaError
from workbench.toml.units import QuantityError, si

CHANNEL_UNITS = {item.name: item.unit for item in fields(Measurement) if item.name in SENSORS}

LAST_SEED = 2**31 - 1

DRAW = "draw"
"""The column that numbers the machines of a case."""

RUN_STREAM = 3
"""The stream of draws of `workbench run`: none of those on which gains are tuned or decisions made."""


def on_drawn_machines(study: Study, cases: Sequence[Case], numbers: Iterable[int] | None = None) -> list[Case]:
    """Each case on each machine of these `numbers` (default: 1 to the study's number of draws), in that order.

    The cases as they are where a study draws none. Results get a column `draw`; the first number tells solver errors.

    Raises:
        UserError: what [uncertainty] says does not serve the study's plants or sensors.
    """
    table = study.file.uncertainty
    if table is None or not table.draws:
        return list(cases)
    check_scales(study, cases)
    found: list[Case] = []
    numbered = list(numbers or range(1, table.draws + 1))
    for case in cases:
        for number in numbered:
            try:
                drawn = drawn_case(case, table, number, RUN_STREAM)
            except SchemaError as mistake:
                raise study.error(mistake.key, mistake.message) from None
            axes, first = {**case.axes, DRAW: number}, number == numbered[0]
            found.append(replace(drawn, index=len(found), axes=axes, tells_solver_error=first))
    return found


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
            raise study.error(("uncertainty", "scale", name), f"unknown parameter; {nearest(name, sorted(known))}")


def drawn_case(case: Case, table: UncertaintyTable, number: int, stream: int = 0) -> Case:
    """A case on the machine of draw `number`: each draw of a `stream` is the same machine for every controller.

    Its friction is drawn by the standard deviations of the parameter set times `table.friction`; factors are drawn
    uniformly, or so in their logarithm, and multiply what a scenario says already. The seed of its noise is its own.

    Raises:
        SchemaError: a channel that there is not, or a parameter set without standard deviations.
    """
    generator = np.random.default_rng([table.seed, stream, number])
    own = ("simulation", "plant", "sensors")  # all else is the case's, shared by its draws
    tables = {**case.tables, **{name: copy.deepcopy(case.tables.get(name, {})) for name in own}}
    tables["simulation"]["seed"] = int(generator.integers(LAST_SEED))
    plant, sensors = tables["plant"], tables["sensors"]
    if table.friction:
        names = _spread_names(str(plant["parameters"]), case)
        plant["spread"] = {**dict.fromkeys(names, table.friction), **plant.get("spread", {})}
    scale = dict(plant.get("scale", {}))
    for name, factors in table.scale.items():
        scale[name] = scale.get(name, 1.0) * _factor(factors, generator.random())
    plant["scale"] = scale
    for channel, limits in table.noise.items():
        low, high = (_noise(channel, key, value) for key, value in (("min", limits.min), ("max", limits.max)))
        sensor = sensors.setdefault(channel, {})
        sensor["noise"] = low + (high - low) * generator.random()
    if table.calibration:
        _draw_calibration(sensors, generator)
    return replace(case, tables=tables)


def _draw_calibration(sensors: dict[str, Any], generator: np.random.Generator) -> None:
    """Lay over sensors what a draw has of their systematic errors; every channel takes as many random numbers."""
    for channel, unit in CHANNEL_UNITS.items():
        sensor, shares = sensors.get(channel, {}), generator.uniform(-1.0, 1.0, 2)
        curve = int(generator.integers(LAST_SEED))
        if "offset" in sensor:
            sensor["offset"] = float(shares[0]) * si(sensor["offset"], unit)
        if "gain_error" in sensor:
            sensor["gain_error"] = float(shares[1]) * sensor["gain_error"]
        if "calibration_error" in sensor:
            sensor["calibration_seed"] = curve


def _factor(factors: FactorTable, share: float) -> float:
    """The factor at a share (0 to 1) of its range."""
    if factors.scale == "log":
        return float(factors.min * (factors.max / factors.min) ** share)
    return factors.min + (factors.max - factors.min) * share


def _noise(channel: str, key: str, value: Any) -> float:
    if channel not in CHANNEL_UNITS:
        raise SchemaError(("uncertainty", "noise", channel), f"no such sensor; expected {', '.join(CHANNEL_UNITS)}")
    try:
        return si(value, CHANNEL_UNITS[channel])
    except QuantityError as error:
        raise SchemaError(("uncertainty", "noise", channel, key), str(error)) from None


def _spread_names(parameters: str, case: Case) -> list[str]:
    """Friction parameters of a set that have a standard deviation."""
    deviations: Mapping[str, float] = read_deviations(parameter_path(parameters, case.folder))
    names = [name for name in deviations if name.startswith(FRICTION) and not name.endswith(f"_{NEGATIVE}")]
    if not names:
        raise SchemaError(
            ("uncertainty", "friction"),
            f'"{parameters}" gives no standard deviation of friction; set friction = 0, or take another set',
        )
    return names
