"""Machines that may be met: draws of friction, payload, pressures and noise, the same for whoever is compared.

A draw changes what a case says of its plant and sensors, as a scenario does; what controllers believe stays.
"""

import copy
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

from plants.equation import NEGATIVE, fields
from plants.interface import Measurement
from workbench.errors import nearest
from workbench.files import SchemaError
from workbench.identify.schema import FRICTION
from workbench.parameters import parameter_path, read_deviations, read_parameters
from workbench.study.document import Case, Study
from workbench.study.tune_schema import FactorTable, UncertaintyTable
from workbench.units import QuantityError, si

CHANNEL_UNITS = {item.name: item.unit for item in fields(Measurement)}

LAST_SEED = 2**31 - 1


def check_scales(study: Study) -> None:
    """Factors need parameters that there are; told where they stand, not where a draw puts them.

    Raises:
        UserError: a factor on a parameter that the study's plant has not.
    """
    if study.file.uncertainty is None:
        return
    path = parameter_path(str(study.file.plant["parameters"]), study.path.parent)
    known = {*read_parameters(path), *study.file.plant.get("set", {})}
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
    tables = copy.deepcopy(case.tables)
    tables.setdefault("simulation", {})["seed"] = int(generator.integers(LAST_SEED))
    plant = tables["plant"]
    if table.friction:
        names = _spread_names(str(plant["parameters"]), case)
        plant["spread"] = {**dict.fromkeys(names, table.friction), **plant.get("spread", {})}
    scale = dict(plant.get("scale", {}))
    for name, factors in table.scale.items():
        scale[name] = scale.get(name, 1.0) * _factor(factors, generator.random())
    plant["scale"] = scale
    for channel, limits in table.noise.items():
        low, high = (_noise(channel, key, value) for key, value in (("min", limits.min), ("max", limits.max)))
        sensor = tables.setdefault("sensors", {}).setdefault(channel, {})
        sensor["noise"] = low + (high - low) * generator.random()
    return replace(case, tables=tables)


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
