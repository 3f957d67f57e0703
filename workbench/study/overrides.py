"""What a case is run with otherwise than its tables say: tuned settings and rotation, and a plant that may be met.

Typed, and in SI but for rpm: a search tries thousands of points of one case, whose tables are read once.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field

from plants.axis import unit_along
from plants.equation import NEGATIVE
from workbench.records.schema import FRICTION
from workbench.study.schema import CaseTables, ChannelTable, PlantTable, SensorsTable
from workbench.study.sensor_tables import CHANNEL_UNITS
from workbench.toml.quantities import rpm_si
from workbench.toml.reading import SchemaError
from workbench.toml.units import si


@dataclass(frozen=True)
class SensorSample:
    """Systematic errors of one sensor: shares (-1 to 1) of the offset and of the gain error that its table bounds, and
    the seed of the curve of its calibration error.
    """

    offset: float
    gain_error: float
    calibration_seed: int


@dataclass(frozen=True)
class PlantSample:
    """A plant that may be met, the same for whoever is compared; what controllers believe stays.

    `seed` is that of its noise and of its friction, which is spread by `friction` standard deviations of the parameter
    set. `factors` multiply parameters, beside what [plant.scale] says of them. `noise` is that of sensors (SI), and
    `sensors` are their systematic errors, both by channel.
    """

    seed: int
    friction: float
    factors: Mapping[str, float] = field(default_factory=dict)
    noise: Mapping[str, float] = field(default_factory=dict)
    sensors: Mapping[str, SensorSample] = field(default_factory=dict)


@dataclass(frozen=True)
class Overrides:
    """What goes before the tables of a case; what is None or not named is as they say.

    `settings` are the controller's (SI), `rpm` is the speed of rotation (rpm), `minimum_helical_speed` (m/s) is that of
    a scheduled rotation, `sample` the plant in place of the declared one.
    """

    settings: Mapping[str, float] = field(default_factory=dict)
    rpm: float | None = None
    minimum_helical_speed: float | None = None
    sample: PlantSample | None = None


DECLARED = Overrides()
"""Nothing otherwise than the tables say."""


def overridden(tables: CaseTables, overrides: Overrides, deviations: Mapping[str, float], axis: str) -> CaseTables:
    """The tables of a case with rotation and sample laid over them; `deviations` are those of its parameter set, and
    `axis` is that of its plant.

    Raises:
        SchemaError: a parameter set without standard deviations of friction, a helical speed of another rotation.
    """
    rotation = tables.rpm if overrides.rpm is None else rpm_si(overrides.rpm)
    plant = tables.plant
    if overrides.minimum_helical_speed is not None:
        if plant.rotation != "scheduled":
            raise SchemaError(("plant", "rotation"), 'minimum_helical_speed belongs to rotation = "scheduled"')
        plant = plant.model_copy(update={"minimum_helical_speed": overrides.minimum_helical_speed})
    changed: dict[str, object] = {"rpm": rotation, "plant": plant}
    if (sample := overrides.sample) is not None:
        changed["plant"] = _sampled_plant(plant, sample, deviations)
        changed["sensors"] = _sampled_sensors(tables.sensors, sample, axis)
        changed["simulation"] = tables.simulation.model_copy(update={"seed": sample.seed})
    return tables.model_copy(update=changed)


def _sampled_plant(plant: PlantTable, sample: PlantSample, deviations: Mapping[str, float]) -> PlantTable:
    factors = {name: plant.scale.get(name, 1.0) * factor for name, factor in sample.factors.items()}
    names = spread_names(plant.parameters, deviations) if sample.friction else []
    spread = {**dict.fromkeys(names, sample.friction), **plant.spread}
    return plant.model_copy(update={"scale": {**plant.scale, **factors}, "spread": spread})


def spread_names(parameters: str, deviations: Mapping[str, float]) -> list[str]:
    """Friction parameters of a set that have a standard deviation.

    Raises:
        SchemaError: none has.
    """
    names = [name for name in deviations if name.startswith(FRICTION) and not name.endswith(f"_{NEGATIVE}")]
    if not names:
        raise SchemaError(
            ("uncertainty", "friction"),
            f'"{parameters}" gives no standard deviation of friction; set friction = 0, or take another set',
        )
    return names


def _sampled_sensors(sensors: SensorsTable, sample: PlantSample, axis: str) -> SensorsTable:
    """Sensors with the sample's noise, and its shares of the systematic errors that they bound."""
    changed: dict[str, ChannelTable] = {}
    for channel, unit in CHANNEL_UNITS.items():
        table: ChannelTable = getattr(sensors, channel)
        values: dict[str, float] = {}
        if channel in sample.noise:
            values["noise"] = sample.noise[channel]
        errors = sample.sensors.get(channel)
        if errors is not None and (table.offset or table.gain_error or table.calibration_error):
            values["offset"] = errors.offset * si(table.offset, unit_along(unit, axis))
            values["gain_error"] = errors.gain_error * table.gain_error
            values["calibration_seed"] = errors.calibration_seed
        if values:
            changed[channel] = table.model_copy(update=values)
    return sensors.model_copy(update=changed)
