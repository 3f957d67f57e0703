"""[sensors]: what may stand there, and the sensors that it becomes."""

from plants.axis import LINEAR, unit_along
from plants.equation import fields
from plants.interface import SENSORS, Measurement
from workbench.errors import spelled
from workbench.simulation.sensors import Channel, Sensors
from workbench.study.schema import ChannelTable, SensorsTable
from workbench.toml.reading import SchemaError
from workbench.toml.units import QuantityError, si

CHANNEL_UNITS = {item.name: item.unit for item in fields(Measurement) if item.name in SENSORS}
"""The unit (SI) of each sensor beside an axis that goes straight, by its name in [sensors]."""


def build_sensors(table: SensorsTable, axis: str = LINEAR) -> Sensors:
    """The sensors that a table describes, in SI; what it does not say is ideal.

    Raises:
        SchemaError: a setting of the wrong unit, or an impossible one.
    """
    channels = {}
    for name, straight in CHANNEL_UNITS.items():
        unit = unit_along(straight, axis)
        channel: ChannelTable = getattr(table, name)
        if not channel.model_fields_set:
            channels[name] = Channel()
            continue
        resolution = _value(channel, "resolution", name, unit)
        if channel.bits is not None:
            resolution = _value(channel, "range", name, unit) / 2**channel.bits
        travel = _value(channel, "calibration_travel", name, unit)
        if channel.calibration_error is not None and travel == 0.0:
            raise SchemaError(("sensors", name, "calibration_travel"), "got 0, expected a value above 0")
        channels[name] = Channel(
            _value(channel, "noise", name, unit),
            resolution,
            channel.anti_alias,
            _value(channel, "offset", name, unit, signed=True),
            channel.gain_error,
            _value(channel, "calibration_error", name, unit),
            travel,
            channel.calibration_seed,
        )
    return Sensors(channels, table.delay)


def _value(table: ChannelTable, name: str, channel: str, unit: str, *, signed: bool = False) -> float:
    """A setting of a sensor in SI, 0 where nothing is said."""
    value, key = getattr(table, name), ("sensors", channel, name)
    try:
        number = si(value or 0.0, unit)
    except QuantityError as error:
        raise SchemaError(key, str(error)) from None
    if number < 0.0 and not signed:
        raise SchemaError(key, f"got {spelled(value)}, expected a value that is not negative")
    return number
